#include "ledger/sqlite/wal_vfs.h"

#include <sqlite3.h>

#include <string_view>

#include "ledger/ledger_files.h"

namespace fleetpub::ledger {
namespace {

constexpr const char* kName = "fleetpub";

int OpenForSqlite(const char* path, int flags, int mode) {
  return OpenRegular(path, flags, static_cast<mode_t>(mode));
}

// pAppData is the VFS that ours is a copy of.
int Open(sqlite3_vfs* self, sqlite3_filename name, sqlite3_file* file, int flags, int* out_flags) {
  auto* system = static_cast<sqlite3_vfs*>(self->pAppData);
  file->pMethods = nullptr;  // nothing to close
  if ((flags & SQLITE_OPEN_SUPER_JOURNAL) != 0) return SQLITE_CANTOPEN;
  constexpr int kNewLog = SQLITE_OPEN_WAL | SQLITE_OPEN_CREATE;
  if ((flags & kNewLog) == kNewLog) {
    int opened = 0;
    const int code = system->xOpen(system, name, file, flags & ~SQLITE_OPEN_CREATE, &opened);
    if (code == SQLITE_OK && (opened & SQLITE_OPEN_READONLY) == 0) {
      if (out_flags != nullptr) *out_flags = opened;
      return code;
    }
    // A log that another process makes just after it was not found is opened for reading only.
    if (code == SQLITE_OK) file->pMethods->xClose(file);
  }
  return system->xOpen(system, name, file, flags, out_flags);
}

// SQLite would follow links.
int FullName(sqlite3_vfs* self, const char* name, int room, char* out) {
  const std::string_view text(name);
  if (text.starts_with('/') && text.size() < static_cast<std::size_t>(room)) {
    out[text.copy(out, text.size())] = '\0';
    return SQLITE_OK;
  }
  auto* system = static_cast<sqlite3_vfs*>(self->pAppData);
  return system->xFullPathname(system, name, room, out);
}

}  // namespace

const char* LogVfs() {
  static const int registered = [] {
    sqlite3_vfs* system = sqlite3_vfs_find(nullptr);
    if (system == nullptr) return SQLITE_ERROR;
    static sqlite3_vfs own;  // SQLite keeps the address
    own = *system;
    own.pNext = nullptr;
    own.zName = kName;
    own.pAppData = system;
    own.xOpen = Open;
    own.xFullPathname = FullName;
    const auto open = reinterpret_cast<sqlite3_syscall_ptr>(OpenForSqlite);
    if (system->xSetSystemCall(system, "open", open) != SQLITE_OK) return SQLITE_ERROR;
    return sqlite3_vfs_register(&own, 0);
  }();
  return registered == SQLITE_OK ? kName : nullptr;
}

}  // namespace fleetpub::ledger
