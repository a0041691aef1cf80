// How a row stores its actions: `[{"type":"startPause","id":"…"}]`.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "ledger/ledger.h"

namespace fleetpub::ledger {

[[nodiscard]] std::string ActionsToJson(const std::vector<ActionRef>& actions);

/// Errors: ErrorKind::kLedger, naming the row.
[[nodiscard]] Result<std::vector<ActionRef>> ActionsFromJson(const std::string& text,
                                                             std::int64_t row);

}  // namespace fleetpub::ledger
