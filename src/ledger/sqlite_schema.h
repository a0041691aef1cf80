// The tables of a ledger file, and whether a file is one.
#pragma once

#include "base/result.h"
#include "ledger/sqlite_database.h"

namespace fleetpub::ledger {

enum class FileState {
  kNew,     ///< an SQLite file with nothing in it, or no bytes at all
  kLedger,  ///< ours, with the tables of this version
};

enum class Journal {
  kWriteAhead,  ///< one wait for the disk per commit; needs memory shared by all users of the file
  kRollback,    ///< four waits; works between hosts as far as the file system's locks do
};

/// Reads, never writes. A file of another program, of a newer version, a damaged one:
/// ErrorKind::kLedger.
[[nodiscard]] Result<FileState> Inspect(Database& database);

/// The caller has excluded others. Interrupted at any point it leaves a file that is kNew or
/// kLedger.
[[nodiscard]] Status CreateTables(Database& database, Journal journal);

/// Whatever journal the file has, except that with kRollback a write-ahead log is given up.
[[nodiscard]] Status ChooseJournal(Database& database, Journal journal);

}  // namespace fleetpub::ledger
