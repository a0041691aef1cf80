// The audit trail's part of a ledger in PostgreSQL.
#pragma once

#include <optional>
#include <vector>

#include "base/result.h"
#include "ledger/ledger.h"
#include "ledger/postgres/postgres_session.h"

namespace fleetpub::ledger {

[[nodiscard]] Result<std::vector<Record>> ReadHistory(Session& session, const HistoryFilter& filter,
                                                      Deadline deadline);
[[nodiscard]] Result<std::optional<Record>> FindRecord(Session& session, std::int64_t id,
                                                       Deadline deadline);

/// In short transactions, each with `patience` for its answer.
[[nodiscard]] Result<std::int64_t> PruneHistory(Session& session, WallTime older_than,
                                                std::chrono::milliseconds patience);

}  // namespace fleetpub::ledger
