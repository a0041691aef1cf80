// The ledger in one SQLite file, with the topics' locks in a second file beside it.
//
// `ledger.db` comes with `-wal` (the newest commits), `-shm` and `.locks`. They belong together: a
// copy of `ledger.db` alone misses the last commands. Backups:
// `sqlite3 ledger.db ".backup copy.db"`.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>

#include "base/result.h"
#include "ledger/ledger.h"
#include "ledger/options.h"

namespace fleetpub::ledger {

struct SqliteOptions : Options {
  std::filesystem::path path;
  /// How long another process may hold SQLite's own lock.
  std::chrono::milliseconds busy_timeout{5'000};
  /// How long one call may take in all: what a command needs, and what reads or tidies history.
  std::chrono::milliseconds command_timeout{15'000};
  std::chrono::milliseconds history_timeout{120'000};
};

/// New files are the user's own (0600, their folders 0700), except that in a folder which its group
/// may write in they are the group's as well (0660). Reading works on a read-only medium.
///
/// Whoever may write the folder or the file may block it, hide rows and repeat ids, but make us run
/// or open nothing else: links are not followed, triggers and views do not run, a ledger with
/// other tables than ours is refused, and each call ends.
///
/// May block for `busy_timeout`. Errors: ErrorKind::kLedger, with the file, the cause and the
/// remedy, when the file is damaged, another program's, written by a newer version, or cannot be
/// opened or written.
[[nodiscard]] Result<std::unique_ptr<Ledger>> OpenSqlite(SqliteOptions options, OpenMode mode);

/// `shared_folder`/ledger.db where that folder exists and this user may write in it, else
/// $XDG_STATE_HOME/fleetpub/ledger.db, else ~/.local/state/fleetpub/ledger.db.
/// Errors: ErrorKind::kLedger when the user has no home.
[[nodiscard]] Result<std::filesystem::path> DefaultLedgerPath(
    const std::filesystem::path& shared_folder = "/var/lib/fleetpub");

/// Several hosts may share this file: one such ledger cannot keep their ids apart reliably.
[[nodiscard]] bool OnNetworkFileSystem(const std::filesystem::path& path);

}  // namespace fleetpub::ledger
