// The first half of a command's way: is it a message that the specification allows? Needs neither
// broker nor ledger.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/rapidjson.h"
#include "base/result.h"
#include "dispatch/command.h"
#include "schema/schema.h"

namespace fleetpub::dispatch {

struct Findings {
  std::vector<schema::Violation> errors;
  std::vector<schema::Violation> warnings;
};

/// Checks a message against a schema and then, when it satisfies that, against the rules of the
/// text.
[[nodiscard]] Findings Check(const rapidjson::Value& message, const schema::Schema& schema,
                             const TextRules& rules);

/// Renders the command with a placeholder header and checks it. An invalid one costs no header id.
/// An Error: the schema itself cannot be had.
[[nodiscard]] Result<Findings> Validate(const Command& command, schema::Registry& registry);

/// `/actions/0/blockingType: must be …; …`, one line for a person.
[[nodiscard]] std::string Describe(std::span<const schema::Violation> violations);

}  // namespace fleetpub::dispatch
