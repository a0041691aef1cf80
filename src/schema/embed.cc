// A program of the build: writes a C++ source with every schema below a folder.
//   embed_schemas FOLDER OUTPUT
//
// Each schema is embedded complete, with a copy of the definitions that it refers to, and twice: as
// a person reads it, and as the validator parses it in each process that needs it, without what
// only describes and with OpenAPI translated. Both are without line breaks and indentation.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "base/file.h"
#include "base/json.h"
#include "schema/bundle.h"
#include "schema/openapi.h"
#include "schema/schema.h"

namespace fleetpub::schema {
namespace {

namespace fs = std::filesystem;
using Documents = std::map<std::string, base::JsonDocument>;  // by path below the folder

constexpr std::string_view kSource = R"source(// Made from the schemas folder by schema/embed.cc.
#include <array>

#include "schema/schema.h"

namespace fleetpub::schema {{
namespace {{

constexpr auto kSchemas = std::to_array<Embedded>({{
{}}});

}}  // namespace

std::span<const Embedded> EmbeddedSchemas() {{ return kSchemas; }}

}}  // namespace fleetpub::schema
)source";

// Without its ending; "" for what is no schema by itself.
std::string ParseName(std::string path) {
  constexpr std::array<std::string_view, 2> kEndings = {".schema.json", ".openapi.json"};
  const auto* ending = std::find_if(kEndings.begin(), kEndings.end(),
                                    [&path](std::string_view e) { return path.ends_with(e); });
  if (ending == kEndings.end() || path.ends_with("/definitions.schema.json")) return {};
  path.resize(path.size() - ending->size());
  return path;
}

Result<Documents> ReadAll(const fs::path& folder) {
  Documents documents;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() != ".json") continue;
    const auto text = base::ReadFile(entry.path());
    if (!text) return Fail(text.error());
    auto document = base::ParseJson(*text);
    if (!document) {
      return Fail(ErrorKind::kInvalid,
                  fmt::format("{}: {}", entry.path().string(), document.error().message));
    }
    documents.emplace(entry.path().lexically_relative(folder).generic_string(),
                      std::move(*document));
  }
  return documents;
}

// Drops texts that only describe, but for what a correction of ours is (schema/violations.cc tells of it); a member of that name under `properties` is a schema, no text.
void DropDescriptions(base::JsonValue& value) {
  if (value.IsArray()) {
    for (base::JsonValue& each : value.GetArray()) DropDescriptions(each);
  }
  if (!value.IsObject()) return;
  const bool is_corrected =
      base::StringMember(value, "$comment").find(kCorrected) != std::string_view::npos;
  for (const char* name : {"title", "description", "$comment"}) {
    if (is_corrected && std::string_view(name) == "$comment") continue;
    if (!base::StringMember(value, name).empty()) value.EraseMember(name);
  }
  const auto end = value.MemberEnd();
  for (auto member = value.MemberBegin(); member < end; ++member) {
    const std::string_view name = base::ToView(member->name);
    if (name != "const" && name != "enum") DropDescriptions(member->value);
  }
}

Result<std::string> MakeRules(base::JsonDocument& document) {
  if (IsOpenApi(document)) {
    if (auto done = TranslateOpenApi(document); !done) {
      return Fail(ErrorKind::kInvalid, std::move(done.error()));
    }
  }
  DropDescriptions(document);
  return base::ToJson(document);
}

Result<std::string> MakeSource(const fs::path& folder) {
  const auto documents = ReadAll(folder);
  if (!documents) return Fail(documents.error());
  std::string entries;
  for (const auto& [path, original] : *documents) {
    const std::string name = ParseName(path);
    if (name.empty()) continue;
    base::JsonDocument document;
    document.CopyFrom(original, document.GetAllocator());
    const auto done = Bundle(document, path, [&](std::string_view uri) -> const base::JsonValue* {
      const auto found = documents->find(std::string(uri));
      return found == documents->end() ? nullptr : &found->second;
    });
    if (!done) return Fail(ErrorKind::kInvalid, path + ": " + done.error().message);
    const std::string text = base::ToJson(document);
    const auto rules = MakeRules(document);
    if (!rules) return Fail(ErrorKind::kInvalid, path + ": " + rules.error().message);
    entries += fmt::format("    {{\"{}\",\n     R\"json({})json\",\n     R\"json({})json\"}},\n",
                           name, text, *rules);
  }
  return fmt::format(kSource, entries);
}

}  // namespace
}  // namespace fleetpub::schema

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const auto source = fleetpub::schema::MakeSource(argv[1]);
  if (!source) {
    fmt::print(stderr, "embed_schemas: {}\n", source.error().message);
    return 1;
  }
  return (std::ofstream(argv[2]) << *source).flush() ? 0 : 1;
}
