#include "delivery/validate.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "base/json.h"

namespace fleetpub::delivery {

void Soften(Findings& findings) {
  if (!findings.satisfies_schema) return;
  std::move(findings.warnings.begin(), findings.warnings.end(),
            std::back_inserter(findings.errors));
  findings.warnings = std::exchange(findings.errors, {});
}

void Harden(Findings& findings) {
  std::move(findings.warnings.begin(), findings.warnings.end(),
            std::back_inserter(findings.errors));
  findings.warnings.clear();
}

Findings Check(const base::JsonValue& message, const schema::Schema& schema,
               const message::TextRules& rules) {
  Findings findings;
  findings.errors = schema.Validate(message);
  findings.warnings = schema.FindMisspellings(message);
  findings.satisfies_schema = findings.errors.empty();
  if (!findings.satisfies_schema || !rules) return findings;
  for (message::TextFinding& finding : rules(message)) {
    auto& list = finding.is_error ? findings.errors : findings.warnings;
    list.push_back(std::move(finding.violation));
  }
  return findings;
}

Result<Findings> Validate(const message::Command& command, schema::Registry& registry) {
  const auto schema = registry.Find(command.schema);
  if (!schema) return Fail(schema.error());
  auto message = base::ParseJson(
      command.payload.Render(command.header_id.value_or(0), base::WallTime::clock::now()));
  if (!message) return Fail(std::move(message.error()));
  // Validated under the member's own name, sent under the one that the robot expects.
  const auto& [quirk, proper] = command.renamed_member;
  base::RenameMember(*message, quirk, proper);
  return Check(*message, **schema, command.text_rules);
}

std::string Describe(const Findings& findings) {
  std::string text;
  for (const auto& [path, message] : findings.errors) {
    if (!text.empty()) text += "; ";
    const bool needs_place = !findings.satisfies_schema && !path.empty();
    text += needs_place ? fmt::format("{}: {}", path, message) : message;
  }
  return text;
}

}  // namespace fleetpub::delivery
