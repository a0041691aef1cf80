// The audit trail's part of a ledger file.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "ledger/ledger.h"
#include "ledger/sqlite/sqlite_database.h"

namespace fleetpub::ledger {

/// How times are stored: microseconds since 1970.
[[nodiscard]] std::int64_t ToMicros(WallTime time);

[[nodiscard]] Result<std::vector<Record>> ReadHistory(Database& database,
                                                      const HistoryFilter& filter);
[[nodiscard]] Result<std::optional<Record>> FindRecord(Database& database, std::int64_t id);

/// In short transactions, each with `time_each`, so that no command waits long. The file gives
/// space back when half of it is free.
[[nodiscard]] Result<std::int64_t> PruneHistory(Database& database, WallTime older_than,
                                                std::chrono::milliseconds time_each);

}  // namespace fleetpub::ledger
