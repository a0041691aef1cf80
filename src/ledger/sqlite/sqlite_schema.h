// The tables of a ledger file, and whether a file is one.
#pragma once

#include <chrono>
#include <filesystem>

#include "base/result.h"
#include "ledger/ledger.h"
#include "ledger/sqlite/sqlite_database.h"

namespace fleetpub::ledger {

enum class Journal {
  kWriteAhead,  ///< one wait for the disk per commit; needs memory shared by all users of the file
  kRollback,    ///< four waits; works between hosts as far as the file system's locks do
};

/// Makes a ledger where there is none, or an empty file, with the folders that it misses. It
/// appears complete or not at all; of several processes one makes it. Blocks for `busy_timeout` at
/// most.
[[nodiscard]] Status CreateLedger(const std::filesystem::path& path, Journal journal,
                                  std::chrono::milliseconds busy_timeout);

/// Reads, never writes. A file of another program, of a newer version, with other tables than ours,
/// a damaged one: ErrorKind::kLedger.
[[nodiscard]] Status Inspect(Database& database);

/// Version, rows and topics.
[[nodiscard]] Status CountTables(Database& database, LedgerInfo& info);

/// Keeps whatever journal the file has, except that with kRollback a write-ahead log is given up.
[[nodiscard]] Status ChooseJournal(Database& database, Journal journal);

}  // namespace fleetpub::ledger
