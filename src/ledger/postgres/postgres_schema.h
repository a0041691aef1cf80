// The tables of a ledger in PostgreSQL: schema `fleetpub`, tables `header_ids` and `messages`, and
// `ledger_version`, which says how they look.
#pragma once

#include <chrono>

#include "base/result.h"
#include "ledger/ledger.h"
#include "ledger/postgres/postgres_session.h"

namespace fleetpub::ledger {

/// Sets what a session of ours relies on, whatever server, database or role prefer: that a commit
/// waits for the disk, that each statement sees what was committed before it, that names mean
/// PostgreSQL's own functions. Returns the version of the tables; 0: there are none. Newer ones:
/// ErrorKind::kLedger.
[[nodiscard]] Result<int> PrepareSession(Session& session, Deadline deadline);

/// Makes the tables, or brings older ones up to date, in one transaction; of several processes one
/// does it. Leaves the session prepared.
[[nodiscard]] Status MigrateTables(Session& session, Deadline deadline);

/// Version, rows, topics and size, of tables that are there.
[[nodiscard]] Result<LedgerInfo> DescribeTables(Session& session, Deadline deadline);

/// Topics are locked under this number. Part of what all versions must agree on.
[[nodiscard]] std::int64_t LockKey(std::string_view topic);

}  // namespace fleetpub::ledger
