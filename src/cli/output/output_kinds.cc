#include "cli/output/output_kinds.h"

#include <algorithm>
#include <array>
#include <utility>

#include "base/json.h"
#include "base/text.h"
#include "schema/schema.h"
#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::cli {
namespace {

using Kind = std::pair<std::string_view, std::string_view>;

constexpr auto kKinds = std::to_array<Kind>({
    {"action", "result"},
    {"actions", "action"},
    {"batch", "result"},
    {"config check", "mistake"},
    {"config path", "file"},
    {"config profiles", "profile"},
    {"config show", "setting"},
    {"conform", "conformance"},
    {"doctor", "diagnosis"},
    {"explain", "explanation"},
    {"fleet", "robot"},
    {"history", "history"},
    {"history prune", "pruned"},
    {"history show", "history"},
    {"layout check", "finding"},
    {"layout route", "route"},
    {"layout show", "layout"},
    {"ledger migrate", "migration"},
    {"ledger status", "ledger"},
    {"order", "result"},
    {"order extend", "result"},
    {"order follow", "result"},
    {"order release", "result"},
    {"order replace", "result"},
    {"ping", "ping"},
    {"publish", "result"},
    {"record", "recording"},
    {"replay", "replay"},
    {"requests", "request"},
    {"respond", "result"},
    {"schema list", "schema"},
    {"show", "sheet"},
    {"soar acknowledge", "result"},
    {"soar mission-plan", "result"},
    {"soar observation", "result"},
    {"soar planning-configuration", "result"},
    {"soar platform-status", "result"},
    {"tail", "message"},
    {"test", "scenario"},
    {"validate", "validation"},
    {"watch", "robot"},
});

}  // namespace

std::string FindOutputSchema(std::string_view command, std::span<const std::string> arguments) {
  std::string_view kind;
  const auto* const found = std::find_if(kKinds.begin(), kKinds.end(), [&](const Kind& candidate) {
    return base::EqualsIgnoringCase(candidate.first, command);
  });
  if (found != kKinds.end()) {
    kind = found->second;
  } else if (vda5050::ActionCalled(command)) {
    kind = "result";
  }
  const bool is_live =
      std::any_of(arguments.begin(), arguments.end(), [](const std::string& argument) {
        return argument == "--live" || argument == "--from" || argument.starts_with("--from=");
      });
  if (kind == "validation" && is_live) kind = "violation";
  const auto has = [&](std::string_view option) {
    return std::find(arguments.begin(), arguments.end(), option) != arguments.end();
  };
  if (kind == "conformance" && has("--list")) kind = "case";
  if (kind == "scenario" && has("--check")) kind = "suite";
  return kind.empty() ? std::string() : "fleetpub/output/" + std::string(kind);
}

std::vector<std::string> ListMembers(std::string_view schema) {
  std::vector<std::string> names;
  const auto text = schema::Registry().Text(schema);
  const auto document = text ? base::ParseJson(*text) : Fail(text.error());
  const auto* const members = document ? base::FindMember(*document, "properties") : nullptr;
  if (members == nullptr) return names;
  for (const auto& member : members->GetObject()) names.emplace_back(base::ToView(member.name));
  return names;
}

}  // namespace fleetpub::cli
