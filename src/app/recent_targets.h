// Which targets the ledger knows.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "app/environment.h"

namespace fleetpub::app {

/// The targets of the ledger's newest rows in this protocol (`vda5050`, `soar`), each once. None
/// when there is no ledger, or none that can be read.
[[nodiscard]] std::vector<std::string> FindRecentTargets(const LedgerHook& open,
                                                         std::string_view protocol);

}  // namespace fleetpub::app
