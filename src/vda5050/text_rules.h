// The rules that stand in the specification's text and not in its schemas.
#pragma once

#include <vector>

#include "dispatch/command.h"
#include "vda5050/version.h"

namespace fleetpub::vda5050 {

/// Checks an instantActions message that already satisfies its schema: at least one action, no
/// actionId twice, each action one that this version allows as an instant action, its parameters of
/// the table's types and complete, theta within ±π. Warned about: keys and action types that nearly
/// are predefined ones, parameters that another version predefines, characters that the
/// specification does not recommend for ids (§6.1).
[[nodiscard]] std::vector<dispatch::TextFinding> CheckInstantActions(
    const rapidjson::Value& message, Version version);

}  // namespace fleetpub::vda5050
