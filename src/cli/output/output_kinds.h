// Which objects a command prints with -o json, and what describes them: the schemas in
// schemas/fleetpub/output.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fleetpub::cli {

/// The schema's name: `fleetpub/output/result`. Empty: the command prints none of its own.
[[nodiscard]] std::string FindOutputSchema(std::string_view command,
                                           std::span<const std::string> arguments);

/// The members that such an object may have, in their order.
[[nodiscard]] std::vector<std::string> ListMembers(std::string_view schema);

}  // namespace fleetpub::cli
