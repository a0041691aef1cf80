// Which header id comes next on a topic: the same in every ledger.
#pragma once

#include <cstdint>
#include <optional>

#include "base/result.h"
#include "ledger/ledger.h"
#include "ledger/options.h"

namespace fleetpub::ledger {

/// The draft's id: the one behind `last`, the first one of a topic that has none, or the one that
/// the draft asks for. Errors: ErrorKind::kUsage when that one is at or below the last, kPreflight
/// when another one is next than the one expected. After a wrap every id lies above the last one.
[[nodiscard]] Result<std::uint32_t> ChooseId(const Draft& draft, std::optional<std::uint32_t> last,
                                             HeaderIdStart start);

}  // namespace fleetpub::ledger
