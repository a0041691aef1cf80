#include "support/described_output.h"

#include <gtest/gtest.h>

#include "base/json.h"
#include "cli/output/output_kinds.h"
#include "cli/parser/command_line.h"
#include "schema/schema.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

// What the line holds: a result of this kind, or what may stand beside it.
std::string ChooseSchema(const base::JsonValue& object, const std::string& kind) {
  for (const char* other : {"error", "summary"}) {
    if (object.MemberCount() == 1 && object.HasMember(other)) {
      return std::string("fleetpub/output/") + other;
    }
  }
  const bool is_live_summary = kind.ends_with("/violation") && object.HasMember("messages");
  return is_live_summary ? "fleetpub/output/live" : kind;
}

void ExpectDescribedLine(std::string_view line, const std::string& kind) {
  static schema::Registry registry;
  const auto object = base::ParseJson(line);
  if (!object || !object->IsObject()) return;  // help, or a line that was cut off
  const std::string name = ChooseSchema(*object, kind);
  const auto schema = registry.Find(name);
  ASSERT_TRUE(schema) << schema.error().message;
  for (const auto& [path, message] : (*schema)->Validate(*object)) {
    ADD_FAILURE() << name << ": " << path << ": " << message << "\n" << line;
  }
}

}  // namespace

void ExpectDescribed(const std::vector<std::string>& arguments, std::string_view output) {
  if (output.empty() || arguments.front() != Binary()) return;
  const std::vector<std::string> words(arguments.begin() + 1, arguments.end());
  cli::CommandLine call;
  static_cast<void>(call.Read(cli::OptionSet::Extent::kAll, words));
  const std::string kind = cli::FindOutputSchema(call.match.name, words);
  const bool is_json = call.options.format == "json" && call.options.fields.empty();
  if (output.starts_with(R"({"commands":)")) return;  // the help
  if (kind.empty() || !(is_json || call.match.name == "batch")) return;
  for (std::size_t end = 0; (end = output.find('\n')) != std::string_view::npos;) {
    ExpectDescribedLine(output.substr(0, end), kind);
    output.remove_prefix(end + 1);
  }
}

}  // namespace fleetpub::testing
