// The options of everything that speaks VDA 5050: which version, how the robot's topics and header
// look.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/dialect_resolver.h"
#include "base/result.h"
#include "vda5050/messages/instant_actions.h"

namespace fleetpub::cli {

class OptionSet;

/// What one instant action may be given on the command line, besides its parameters.
struct InstantOptions {
  std::vector<std::string> assignments;  ///< `-P`
  std::optional<std::string> id;
  std::string descriptor;
  std::string blocking_type;
  std::optional<std::uint32_t> header_id;
  app::VdaOptions vda;
};

void DeclareVdaOptions(OptionSet& set, app::VdaOptions& options);
void DeclareInstantOptions(OptionSet& set, InstantOptions& options);

/// The action that the options describe, without an id when none was given. `targets` is how many
/// robots get it.
[[nodiscard]] Result<vda5050::InstantAction> BuildInstantAction(
    const InstantOptions& options, std::string_view type,
    std::vector<vda5050::Parameter> parameters, std::size_t targets);

}  // namespace fleetpub::cli
