// How long robots took to confirm what they were told, as the ledger has it.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "base/result.h"
#include "ledger/ledger.h"

namespace fleetpub::app {

/// In seconds, by the topic's name: `instantActions`, `order`.
using ConfirmTimes = std::map<std::string, std::vector<double>, std::less<>>;

/// Of the rows of the hour before `now`, but the newest 10,000 at most, those that robots confirmed
/// (FINISHED) and that are wanted. Errors: ErrorKind::kLedger.
[[nodiscard]] Result<ConfirmTimes> ReadConfirmTimes(
    ledger::Ledger& ledger, ledger::WallTime now,
    const std::function<bool(const ledger::Record& row)>& wanted);

}  // namespace fleetpub::app
