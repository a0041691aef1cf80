#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "schema/schema.h"
#include "schema/schema_files.h"
#include "schema/uri.h"

namespace fleetpub::schema {
namespace {

namespace fs = std::filesystem;

const Embedded* FindEmbedded(std::string_view name) {
  const auto all = EmbeddedSchemas();
  const auto it = std::find_if(all.begin(), all.end(),
                               [name](const Embedded& schema) { return schema.name == name; });
  return it == all.end() ? nullptr : &*it;
}

}  // namespace

Registry::Registry(const fs::path& directory) {
  if (directory.empty()) return;
  auto files = ScanSchemaFolder(directory);
  if (files) {
    files_ = std::move(*files);
  } else {
    scanned_ = Fail(std::move(files.error()));
  }
}

Result<std::string> Registry::Text(std::string_view name) const {
  if (!scanned_) return Fail(scanned_.error());
  if (const auto file = files_.find(name); file != files_.end()) {
    std::vector<fs::path> all;
    for (const auto& [known, path] : files_) all.push_back(path);
    return ReadSchemaFile(file->second, all);
  }
  if (const Embedded* embedded = FindEmbedded(name)) return std::string(embedded->text);
  std::vector<std::string_view> names;
  for (const auto& [known, path] : files_) names.push_back(known);
  for (const Embedded& embedded : EmbeddedSchemas()) names.push_back(embedded.name);
  const auto near = base::Nearest(name, names);
  return Fail(ErrorKind::kUsage,
              fmt::format("there is no schema {}; {}", base::Printable(name),
                          near ? fmt::format("did you mean {}?", *near)
                               : "`fleetpub schema list` shows those there are"));
}

Result<const Schema*> Registry::Find(std::string_view name) {
  if (const auto known = compiled_.find(name); known != compiled_.end()) return &known->second;
  const auto [document, pointer] = SplitFragment(name);
  const auto compile = [&, &document = document, &pointer = pointer]() -> Result<Schema> {
    const auto file = files_.find(document);
    const Embedded* embedded = file == files_.end() ? FindEmbedded(document) : nullptr;
    if (scanned_ && embedded != nullptr) return Schema::Compile(*embedded, pointer);
    const auto text = Text(document);
    if (!text) return Fail(text.error());
    return Schema::Compile(*text, file->second.string(), pointer);
  };
  auto schema = compile();
  if (!schema) return Fail(std::move(schema.error()));
  return &compiled_.emplace(std::string(name), std::move(*schema)).first->second;
}

std::string Registry::FindOrigin(std::string_view name) const {
  const auto file = files_.find(name);
  return file == files_.end() ? "built-in" : file->second.string();
}

std::vector<std::pair<std::string, std::string>> Registry::List() const {
  std::map<std::string, std::string> all;
  for (const Embedded& embedded : EmbeddedSchemas()) {
    all.emplace(embedded.name, "built-in");
  }
  for (const auto& [name, path] : files_) all.insert_or_assign(name, path.string());
  return {all.begin(), all.end()};
}

}  // namespace fleetpub::schema
