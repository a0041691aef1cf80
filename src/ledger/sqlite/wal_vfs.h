// SQLite's own way to the disk (its VFS), but for one needless wait, and for traps.
//
// A ledger's folder may be a group's. Beside the ledger no link is followed and no FIFO waited for
// (ledger_files.h): a `-wal` that led to a file of ours would be written over. The ledger itself is
// opened under the name that we resolved. And nobody's journal is believed that names a journal
// above it, which SQLite would read and remove, wherever it is: ours never do.
//
// SQLite opens the write-ahead log with "create if missing", takes that for a new file each time,
// and syncs its folder with the first commit. On a disk that others use too, that costs each
// process as much as the commit itself. Here a log that exists is opened as what it is; one that is
// made new still has its folder synced. (sqlite.org/vfs.html; unixOpen and unixSync in os_unix.c)
#pragma once

namespace fleetpub::ledger {

/// Registers it, once per process, and returns its name for sqlite3_open_v2. Null: SQLite has no
/// VFS to build on, and its default may be tried. Any thread.
[[nodiscard]] const char* LogVfs();

}  // namespace fleetpub::ledger
