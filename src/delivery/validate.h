// The first half of a command's way: is it a message that the specification allows? Needs neither
// broker nor ledger.
#pragma once

#include <string>
#include <vector>

#include "base/rapidjson.h"
#include "base/result.h"
#include "message/command.h"
#include "schema/schema.h"

namespace fleetpub::delivery {

struct Findings {
  /// Violations of the schema; when there are none, of the text's rules, whose messages speak for
  /// themselves.
  std::vector<schema::Violation> errors;
  std::vector<schema::Violation> warnings;
  bool satisfies_schema = true;
};

/// Makes what breaks no schema a warning, before those that are there.
void Soften(Findings& findings);
/// Makes every warning an error, for those who want nothing to object to.
void Harden(Findings& findings);

/// Checks a message against a schema and then, when it satisfies that, against the rules of the
/// text. Warns of members whose names are nearly ones that the schema knows.
[[nodiscard]] Findings Check(const base::JsonValue& message, const schema::Schema& schema,
                             const message::TextRules& rules);

/// Renders the command with a placeholder header and checks it. An invalid one costs no header id.
/// An Error: the schema itself cannot be had.
[[nodiscard]] Result<Findings> Validate(const message::Command& command,
                                        schema::Registry& registry);

/// What is wrong, in one line for a person: `/actions/0/blockingType: must be …; …`
[[nodiscard]] std::string Describe(const Findings& findings);

}  // namespace fleetpub::delivery
