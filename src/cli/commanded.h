// Whom the ledger knows.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cli/options/global_options.h"

namespace fleetpub::cli {

/// The targets of the ledger's newest rows in this protocol (`vda5050`, `soar`), each once. None
/// when there is no ledger, or none that can be read.
[[nodiscard]] std::vector<std::string> RecentTargets(const Context& context,
                                                     std::string_view protocol);

}  // namespace fleetpub::cli
