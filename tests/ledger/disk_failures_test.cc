// Disks without room, files without permission, media that nobody can write.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <cerrno>

#include "ledger/ledger_support.h"
#include "ledger/sqlite/sqlite_database.h"

namespace fleetpub::ledger {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

/// No file of this process may grow beyond: write(2) fails with EFBIG, as it would with ENOSPC.
void LimitFiles(rlim_t bytes) {
  signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  limit.rlim_cur = bytes;
  if (setrlimit(RLIMIT_FSIZE, &limit) != 0) throw std::runtime_error("setrlimit");
}

class DiskFailures : public ::testing::Test {
 protected:
  DiskFailures() {
    chmod(folder_.path().c_str(), 0755);
    const auto ledger = MustOpen(path_);
    for (int i = 0; i < 3; ++i) MustReserve(*ledger);
  }

  /// Everything readable for everybody, nothing writable.
  void Forbid() const {
    for (const auto& entry : fs::directory_iterator(folder_.path())) {
      chmod(entry.path().c_str(), 0444);
    }
    chmod(folder_.path().c_str(), 0555);
  }

  /// Copies the log into the file and removes it with its shared memory.
  void RemoveLog() const {
    {
      auto database = Database::Open(path_, Access::kReadWrite, milliseconds(100));
      if (!(*database)->Execute("SELECT count(*) FROM messages")) throw std::runtime_error("read");
      (*database)->Checkpoint(AfterCheckpoint::kNothingFollows);
    }
    fs::remove(path_.string() + "-wal");
    fs::remove(path_.string() + "-shm");
  }

  std::string NextAsOrdinaryUser() const {
    return AsOrdinaryUser([&]() -> std::string {
      const auto ledger = OpenSqlite(OptionsFor(path_), OpenMode::kReadOnly);
      if (!ledger) return ledger.error().message;
      const auto rows = (*ledger)->History({});
      const auto next = (*ledger)->PeekNext(MakeTopic(1));
      return next ? std::to_string(*next) + " after " + std::to_string(rows->size()) + " rows"
                  : next.error().message;
    });
  }

  ~DiskFailures() override { chmod(folder_.path().c_str(), 0755); }

  testing::TemporaryFolder folder_;
  fs::path path_ = folder_ / "ledger.db";
};

TEST_F(DiskFailures, AFullDiskReservesNothing) {
  const std::string said = InProcess([&]() -> std::string {
    const auto ledger = MustOpen(path_);
    LimitFiles(fs::file_size(path_.string() + "-wal") + 100'000);
    Draft draft = DraftFor();
    draft.after_id = std::string(1'000'000, 'x');
    const auto refused = ledger->Reserve(std::span(&draft, 1));
    LimitFiles(RLIM_INFINITY);
    if (refused || refused.error().kind != ErrorKind::kLedger) return "reserved";
    return refused.error().message + " then " + std::to_string(MustReserve(*ledger).header_id);
  });
  EXPECT_THAT(said, AllOf(HasSubstr("no room"), HasSubstr(path_.string()), HasSubstr("then 3")));
}

TEST_F(DiskFailures, AFullDiskAtTheBeginningSaysSo) {
  EXPECT_THAT(InProcess([&]() -> std::string {
                LimitFiles(0);
                return ErrorOfOpening(folder_ / "new.db");
              }),
              HasSubstr("no room"));
  // And leaves nothing behind that would be in the way later.
  EXPECT_EQ(MustReserve(*MustOpen(folder_ / "new.db")).header_id, 0U);
}

TEST_F(DiskFailures, AFileWithoutWritePermissionIsRefused) {
  Forbid();
  EXPECT_THAT(AsOrdinaryUser([&] { return ErrorOfOpening(path_); }),
              AllOf(HasSubstr("cannot be written"), HasSubstr("permission")));
}

TEST_F(DiskFailures, AFolderWithoutWritePermissionIsRefused) {
  Forbid();
  EXPECT_THAT(AsOrdinaryUser([&] { return ErrorOfOpening(folder_ / "new.db"); }),
              AllOf(HasSubstr("new.db"), HasSubstr("Permission denied")));
}

TEST_F(DiskFailures, AFileWithoutReadPermissionIsRefused) {
  chmod(path_.c_str(), geteuid() == 0 ? 0600 : 0);
  for (const OpenMode mode : {OpenMode::kCreate, OpenMode::kReadOnly}) {
    EXPECT_THAT(AsOrdinaryUser([&] { return ErrorOfOpening(path_, mode); }),
                HasSubstr("Permission denied"));
  }
}

TEST_F(DiskFailures, AMediumThatNobodyCanWriteIsRead) {
  Forbid();
  EXPECT_EQ(NextAsOrdinaryUser(), "3 after 3 rows");
}

TEST_F(DiskFailures, AMediumThatNobodyCanWriteIsReadWithoutALog) {
  RemoveLog();
  Forbid();
  EXPECT_EQ(NextAsOrdinaryUser(), "3 after 3 rows");
}

TEST_F(DiskFailures, ALogThatCannotBeReadIsNotPassedOver) {
  fs::remove(path_.string() + "-shm");
  Forbid();
  EXPECT_THAT(NextAsOrdinaryUser(), AllOf(HasSubstr("-wal"), HasSubstr("writ")));
}

TEST_F(DiskFailures, AnInterruptedRollbackNeedsSomebodyWhoMayWrite) {
  RemoveLog();
  const char* many_rows =
      "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 2000) "
      "INSERT INTO header_ids SELECT 't' || i, i FROM n";
  const std::string said = InProcess([&]() -> std::string {
    auto database = Database::Open(path_, Access::kReadWrite, milliseconds(100));
    Database& file = **database;
    for (const char* sql : {"PRAGMA journal_mode=DELETE", "PRAGMA cache_size=1",
                            "PRAGMA cache_spill=1", "BEGIN IMMEDIATE", many_rows}) {
      const Status done = file.Execute(sql);
      if (!done) return done.error().message + done.error().detail;
    }
    _exit(0);
  });
  ASSERT_EQ(said, "");
  ASSERT_TRUE(fs::exists(path_.string() + "-journal"));
  Forbid();
  EXPECT_THAT(NextAsOrdinaryUser(), HasSubstr("writ"));
  chmod(folder_.path().c_str(), 0755);
  for (const auto& entry : fs::directory_iterator(folder_.path())) {
    chmod(entry.path().c_str(), 0600);
  }
  EXPECT_EQ(MustReserve(*MustOpen(path_)).header_id, 3U);
}

/// As if another process were copying every log (sqlite.org/walformat.html §2.3: byte 121).
class LogsBeingCopied {
 public:
  LogsBeingCopied() { Set(&LogsBeingCopied::Fcntl); }
  LogsBeingCopied(const LogsBeingCopied&) = delete;
  LogsBeingCopied& operator=(const LogsBeingCopied&) = delete;
  ~LogsBeingCopied() { Set(nullptr); }

 private:
  static void Set(int (*call)(int, int, struct flock*)) {
    sqlite3_vfs* vfs = sqlite3_vfs_find(nullptr);
    vfs->xSetSystemCall(vfs, "fcntl", reinterpret_cast<sqlite3_syscall_ptr>(call));
  }
  static int Fcntl(int file, int command, struct flock* range) {
    if (command == F_SETLK && range->l_type == F_WRLCK && range->l_start == 121 &&
        range->l_len == 1) {
      errno = EAGAIN;
      return -1;
    }
    return fcntl(file, command, range);
  }
};

// SQLite calls a log that could not be copied no error: the new ledger was moved into place empty.
TEST(NewLedger, WhoseLogCannotBeCopiedIsNotMovedIntoPlace) {
  const testing::TemporaryFolder folder;
  SqliteOptions options = OptionsFor(folder / "ledger.db");
  options.busy_timeout = milliseconds(2);
  {
    const LogsBeingCopied hurt;
    const auto ledger = OpenSqlite(options, OpenMode::kCreate);
    ASSERT_FALSE(ledger);
    EXPECT_THAT(ledger.error().message, HasSubstr("could not be finished"));
  }
  EXPECT_EQ(MustReserve(*MustOpen(options.path)).header_id, 0U);
}

TEST(ReadingOnly, MakesNothing) {
  const testing::TemporaryFolder folder;
  const auto ledger = MustOpen(folder / "a" / "ledger.db", OpenMode::kReadOnly);
  EXPECT_EQ(ledger->PeekNext(MakeTopic(1)), 0U);
  EXPECT_TRUE(ledger->History({})->empty());
  EXPECT_EQ(*ledger->Find(1), std::nullopt);
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(ReadingOnly, TakesAnEmptyFileForAnEmptyLedger) {
  const testing::TemporaryFolder folder;
  folder.Write("ledger.db", "");
  EXPECT_EQ(MustOpen(folder / "ledger.db", OpenMode::kReadOnly)->PeekNext("t"), 0U);
  EXPECT_TRUE(fs::is_empty(folder / "ledger.db"));
}

TEST(ReadingOnly, BeginsWhereTheLedgerWouldBegin) {
  const testing::TemporaryFolder folder;
  SqliteOptions options = OptionsFor(folder / "ledger.db");
  options.start = HeaderIdStart::kEpoch;
  EXPECT_GE(*MustOpen(options, OpenMode::kReadOnly)->PeekNext("t"),
            static_cast<std::uint32_t>(time(nullptr)) - 2);
}

TEST(ReadingOnly, RefusesToWrite) {
  const testing::TemporaryFolder folder;
  const fs::path path = folder / "ledger.db";
  MustReserve(*MustOpen(path));
  const auto ledger = MustOpen(path, OpenMode::kReadOnly);
  const std::string topic = MakeTopic(1);
  const Draft draft = DraftFor();
  const StatusUpdate outcome{1, "SENT", ""};
  EXPECT_FALSE(ledger->Lock(std::span(&topic, 1), In(milliseconds(0))));
  EXPECT_FALSE(ledger->Reserve(std::span(&draft, 1)));
  EXPECT_FALSE(ledger->RecordOutcomes(std::span(&outcome, 1)));
  EXPECT_FALSE(ledger->Prune(std::chrono::system_clock::now()));
  EXPECT_EQ(ledger->PeekNext(topic), 1U);
}

}  // namespace
}  // namespace fleetpub::ledger
