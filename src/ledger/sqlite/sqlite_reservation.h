// Giving header ids and writing rows: what a command does to a ledger file.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "ledger/ledger.h"
#include "ledger/sqlite/sqlite_database.h"
#include "ledger/sqlite/sqlite_ledger.h"

namespace fleetpub::ledger {

[[nodiscard]] Result<std::optional<std::uint32_t>> ReadLastId(Database& database,
                                                              std::string_view topic);

/// One transaction, for Ledger::Reserve.
[[nodiscard]] Result<std::vector<Reservation>> ReserveAll(Database& database,
                                                          const SqliteOptions& options,
                                                          std::span<const Draft> drafts);

/// One transaction. Outcomes of row 0 are passed over.
[[nodiscard]] Status WriteOutcomes(Database& database, std::span<const StatusUpdate> outcomes);

}  // namespace fleetpub::ledger
