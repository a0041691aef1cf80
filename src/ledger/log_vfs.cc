#include "ledger/log_vfs.h"

#include <sqlite3.h>

namespace fleetpub::ledger {
namespace {

constexpr const char* kName = "fleetpub";

// pAppData is the VFS that ours is a copy of.
int Open(sqlite3_vfs* self, sqlite3_filename name, sqlite3_file* file, int flags, int* out_flags) {
  auto* system = static_cast<sqlite3_vfs*>(self->pAppData);
  constexpr int kNewLog = SQLITE_OPEN_WAL | SQLITE_OPEN_CREATE;
  if ((flags & kNewLog) == kNewLog) {
    const int code = system->xOpen(system, name, file, flags & ~SQLITE_OPEN_CREATE, out_flags);
    if (code == SQLITE_OK) return code;
  }
  return system->xOpen(system, name, file, flags, out_flags);
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
    return sqlite3_vfs_register(&own, 0);
  }();
  return registered == SQLITE_OK ? kName : nullptr;
}

}  // namespace fleetpub::ledger
