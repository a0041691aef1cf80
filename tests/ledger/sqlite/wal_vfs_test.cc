// The log's way to the disk, while other processes make the same log.
#include "ledger/sqlite/wal_vfs.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "support/temporary_folder.h"

namespace fleetpub::ledger {
namespace {

/// In place of open(2) in SQLite: another process makes the log just after it was not found.
int OpenTooEarly(const char* path, int flags, int mode) {
  const bool log_for_writing =
      std::string_view(path).ends_with("-wal") && (flags & O_ACCMODE) == O_RDWR;
  const bool missing = access(path, F_OK) != 0;
  if (log_for_writing && missing && (flags & O_CREAT) == 0) {
    std::ofstream(path).flush();
    errno = ENOENT;
    return -1;
  }
  return open(path, flags, mode);
}

TEST(LogVfs, ALogThatAppearsJustThenIsStillOpenedForWriting) {
  const testing::TemporaryFolder folder;
  std::ofstream(folder / "ledger.db").flush();  // the log takes its owner and mode from it
  // SQLite's names end with two zero bytes (sqlite3_filename).
  const std::string name = (folder / "ledger.db-wal").string() + std::string(2, '\0');
  sqlite3_vfs* vfs = sqlite3_vfs_find(LogVfs());
  ASSERT_NE(vfs, nullptr);
  std::vector<char> storage(static_cast<std::size_t>(vfs->szOsFile));
  auto* file = reinterpret_cast<sqlite3_file*>(storage.data());
  int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_WAL;
  const auto usual = vfs->xGetSystemCall(vfs, "open");
  vfs->xSetSystemCall(vfs, "open", reinterpret_cast<sqlite3_syscall_ptr>(OpenTooEarly));
  const int code = vfs->xOpen(vfs, name.c_str(), file, flags, &flags);
  vfs->xSetSystemCall(vfs, "open", usual);
  ASSERT_EQ(code, SQLITE_OK);
  EXPECT_EQ(flags & SQLITE_OPEN_READONLY, 0);
  file->pMethods->xClose(file);
}

}  // namespace
}  // namespace fleetpub::ledger
