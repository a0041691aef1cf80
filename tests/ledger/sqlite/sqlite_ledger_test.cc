// A ledger's files: made, kept small, and refused when they are not right.
#include "ledger/sqlite/sqlite_ledger.h"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/syscall.h>

#include <atomic>
#include <fstream>

#include "ledger/ledger_support.h"
#include "ledger/sqlite/sqlite_database.h"
#include "ledger/sqlite/sqlite_schema.h"

namespace {
std::atomic<int> waits_for_disk = 0;
}

/// In place of the C library's, for SQLite too: counts.
extern "C" int fdatasync(int fd) {
  ++waits_for_disk;
  return static_cast<int>(syscall(SYS_fdatasync, fd));
}

namespace fleetpub::ledger {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;
namespace fs = std::filesystem;

int GetMode(const fs::path& path) {
  struct stat info {};
  return stat(path.c_str(), &info) == 0 ? static_cast<int>(info.st_mode & 0777) : -1;
}

std::vector<std::string> NamesIn(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    names.push_back(entry.path().filename().string());
  }
  return names;
}

std::string ReadWhole(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void RunSql(const fs::path& path, const char* sql) {
  auto database = Database::Open(path, Access::kReadWrite, milliseconds(1'000));
  if (!database || !(*database)->Execute(sql)) throw std::runtime_error(sql);
}

class SqliteFile : public ::testing::Test {
 protected:
  /// Some ids and rows, everything closed.
  void Fill(int messages = 20) const {
    const auto ledger = MustOpen(path_);
    for (int i = 0; i < messages; ++i) MustReserve(*ledger);
  }

  /// Everything is in the file itself.
  void EmptyLog() const {
    auto database = Database::Open(path_, Access::kReadWrite, milliseconds(1'000));
    ASSERT_TRUE((*database)->Execute("SELECT count(*) FROM messages"));
    (*database)->Checkpoint(AfterCheckpoint::kNothingFollows);
    ASSERT_EQ(fs::file_size(path_.string() + "-wal"), 0U);
  }

  testing::TemporaryFolder folder_;
  fs::path path_ = folder_ / "ledger.db";
};

TEST_F(SqliteFile, IsTheUsersOwnWithItsFolders) {
  const fs::path path = folder_ / "a" / "b" / "ledger.db";
  MustReserve(*MustOpen(path));
  EXPECT_EQ(GetMode(folder_ / "a"), 0700);
  EXPECT_EQ(GetMode(path.parent_path()), 0700);
  for (const std::string& name : NamesIn(path.parent_path())) {
    EXPECT_EQ(GetMode(path.parent_path() / name), 0600) << name;
  }
}

TEST_F(SqliteFile, BelongsToTheGroupInAFolderThatDoes) {
  const mode_t umask_before = umask(077);
  fs::create_directory(folder_ / "shared");
  chmod((folder_ / "shared").c_str(), 02770);
  const auto ledger = MustOpen(folder_ / "shared" / "ledger.db");
  const std::string topic = MakeTopic(1);
  EXPECT_TRUE(ledger->Lock(std::span(&topic, 1), In(milliseconds(100))));
  MustReserve(*ledger);
  umask(umask_before);
  const auto names = NamesIn(folder_ / "shared");
  EXPECT_THAT(names, UnorderedElementsAre("ledger.db", "ledger.db-wal", "ledger.db-shm",
                                          "ledger.db.locks"));
  for (const std::string& name : names) EXPECT_EQ(GetMode(folder_ / "shared" / name), 0660) << name;
}

TEST_F(SqliteFile, MayBeEmptyAtFirst) {
  folder_.Write("ledger.db", "");
  EXPECT_EQ(MustReserve(*MustOpen(path_)).header_id, 0U);
}

TEST_F(SqliteFile, IsMadeInTheCurrentFolderToo) {
  EXPECT_EQ(InProcess([&]() -> std::string {
              fs::current_path(folder_.path());
              return ErrorOfOpening("here.db");
            }),
            "");
  EXPECT_TRUE(fs::exists(folder_ / "here.db"));
}

TEST_F(SqliteFile, OfANewerVersionIsRefused) {
  Fill();
  RunSql(path_, "PRAGMA user_version=2");
  EXPECT_THAT(ErrorOfOpening(path_), AllOf(HasSubstr("newer fleetpub"), HasSubstr("ledger.db")));
  EXPECT_THAT(ErrorOfOpening(path_, OpenMode::kReadOnly), HasSubstr("newer fleetpub"));
}

TEST_F(SqliteFile, OfAnotherProgramIsRefusedUnchanged) {
  folder_.Write("ledger.db", "");
  RunSql(path_, "CREATE TABLE songs(title)");
  const std::string before = ReadWhole(path_);
  EXPECT_THAT(ErrorOfOpening(path_), HasSubstr("another program"));
  EXPECT_THAT(ErrorOfOpening(path_, OpenMode::kReadOnly), HasSubstr("another program"));
  EXPECT_EQ(ReadWhole(path_), before);
  EXPECT_THAT(NamesIn(folder_.path()), UnorderedElementsAre("ledger.db"));
}

TEST_F(SqliteFile, ThatIsNoneSaysHowToRepairIt) {
  folder_.Write("ledger.db", std::string(5'000, 'x'));
  EXPECT_THAT(ErrorOfOpening(path_), AllOf(HasSubstr(path_.string()), HasSubstr(".recover"),
                                           HasSubstr("aside"), HasSubstr("ledger.db.locks")));
  EXPECT_THAT(ErrorOfOpening(path_, OpenMode::kReadOnly), HasSubstr(".recover"));
  EXPECT_EQ(ReadWhole(path_), std::string(5'000, 'x'));
}

TEST_F(SqliteFile, ThatWasCutShortIsRefused) {
  Fill();
  EmptyLog();
  fs::resize_file(path_, fs::file_size(path_) / 2);
  EXPECT_THAT(ErrorOfOpening(path_), HasSubstr("damaged"));
}

TEST_F(SqliteFile, WithDamageInsideReservesNothing) {
  Fill();
  EmptyLog();
  std::fstream file(path_, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(1'024);
  file << std::string(fs::file_size(path_) - 1'024, 'x');
  file.close();
  const auto ledger = OpenSqlite(OptionsFor(path_), OpenMode::kCreate);
  ASSERT_TRUE(ledger);
  const Draft draft = DraftFor();
  const auto refused = (*ledger)->Reserve(std::span(&draft, 1));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::kLedger);
  EXPECT_THAT(refused.error().message, HasSubstr(".recover"));
  EXPECT_FALSE((*ledger)->PeekNext(MakeTopic(1)));
  EXPECT_FALSE((*ledger)->History({}));
}

TEST_F(SqliteFile, MustBeAFile) {
  EXPECT_THAT(ErrorOfOpening(folder_.path()), HasSubstr("is a folder"));
  EXPECT_THAT(ErrorOfOpening("/dev/full"), HasSubstr("no regular file"));
  EXPECT_THAT(ErrorOfOpening(folder_.path(), OpenMode::kReadOnly), HasSubstr("is a folder"));
}

TEST_F(SqliteFile, CannotLieBelowAFile) {
  folder_.Write("file", "");
  for (const OpenMode mode : {OpenMode::kCreate, OpenMode::kReadOnly}) {
    EXPECT_THAT(ErrorOfOpening(folder_ / "file" / "ledger.db", mode), HasSubstr("Not a directory"));
  }
}

TEST_F(SqliteFile, CannotBeALinkThatLeadsInACircle) {
  fs::create_symlink(path_, folder_ / "other.db");
  fs::create_symlink(folder_ / "other.db", path_);
  EXPECT_THAT(ErrorOfOpening(path_), HasSubstr("Too many levels of symbolic links"));
}

TEST_F(SqliteFile, IsALedgerFromTheBeginningEvenWithoutItsLog) {
  MustOpen(path_);
  fs::remove(path_.string() + "-wal");
  fs::remove(path_.string() + "-shm");
  RunSql(path_, "SELECT last FROM header_ids");
}

TEST_F(SqliteFile, HeldTooLongByAnotherProcessReservesNothing) {
  Fill(1);
  SqliteOptions options = OptionsFor(path_);
  options.busy_timeout = milliseconds(50);
  const auto ledger = MustOpen(options);
  auto other = Database::Open(path_, Access::kReadWrite, milliseconds(0));
  ASSERT_TRUE(other && (*other)->Execute("BEGIN IMMEDIATE"));
  const auto start = steady_clock::now();
  const Draft draft = DraftFor();
  const auto refused = ledger->Reserve(std::span(&draft, 1));
  EXPECT_GE(steady_clock::now() - start, milliseconds(50));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::kLedger);
  EXPECT_THAT(refused.error().message, AllOf(HasSubstr("locked for 50 ms"), HasSubstr("fuser")));
  ASSERT_TRUE((*other)->Execute("ROLLBACK"));
  EXPECT_EQ(MustReserve(*ledger).header_id, 1U);
}

TEST_F(SqliteFile, IsNotHeldByAReader) {
  Fill(3);
  auto reader = Database::Open(path_, Access::kReadOnly, milliseconds(0));
  ASSERT_TRUE(reader);
  Statement reading(**reader, "SELECT id FROM messages");
  ASSERT_TRUE(*reading.Step());
  EXPECT_EQ(MustReserve(*MustOpen(path_)).header_id, 3U);
}

TEST_F(SqliteFile, StaysSmallBesideItsLog) {
  for (const bool keep_history : {true, false}) {
    SqliteOptions options = OptionsFor(folder_ / (keep_history ? "rows.db" : "ids.db"));
    options.keep_history = keep_history;
    for (int command = 0; command < 120; ++command) {
      const auto ledger = MustOpen(options);
      MustRecord(*ledger, {MustReserve(*ledger).row, "SENT", ""});
    }
    EXPECT_LT(fs::file_size(options.path.string() + "-wal"), 100'000U) << options.path;
  }
}

TEST_F(SqliteFile, NeedsNoClosing) {
  // A one-shot command ends with _exit.
  for (int command = 0; command < 30; ++command) {
    EXPECT_EQ(InProcess([&] { return std::to_string(MustReserve(*MustOpen(path_)).header_id); }),
              std::to_string(command));
  }
}

TEST_F(SqliteFile, LosesAnOutcomeToAPowerFailureButNoReservation) {
  const fs::path log = path_.string() + "-wal";
  const auto ledger = MustOpen(path_);
  const Reservation sent = MustReserve(*ledger);
  const auto synced = fs::file_size(log);
  MustRecord(*ledger, {sent.row, "FINISHED", ""});
  ASSERT_GT(fs::file_size(log), synced);
  const fs::path after = folder_ / "after.db";
  fs::copy_file(path_, after);
  std::string content = ReadWhole(log);
  for (std::size_t at = synced; at < content.size(); ++at) content[at] = 'x';
  folder_.Write("after.db-wal", content);
  const auto recovered = MustOpen(after);
  EXPECT_EQ(recovered->Find(sent.row)->value().status, "RECORDED");
  EXPECT_EQ(MustReserve(*recovered).header_id, sent.header_id + 1);
}

TEST_F(SqliteFile, WaitsForTheDiskToReserveButNotForAnOutcome) {
  Fill(1);
  const auto ledger = MustOpen(path_);
  waits_for_disk = 0;
  const Reservation first = MustReserve(*ledger);
  EXPECT_GT(waits_for_disk, 0);
  MustRecord(*ledger, {first.row, "SENT", ""});
  waits_for_disk = 0;
  MustRecord(*ledger, {first.row, "FINISHED", ""});
  EXPECT_EQ(waits_for_disk, 0);
  MustReserve(*ledger);
  EXPECT_EQ(waits_for_disk, 1);
}

TEST_F(SqliteFile, InRollbackModeWaitsForAnOutcomeAsForAReservation) {
  Fill(1);
  RunSql(path_, "PRAGMA journal_mode=DELETE");
  const auto ledger = MustOpen(path_);
  waits_for_disk = 0;
  const Reservation reserved = MustReserve(*ledger);
  const int waits = waits_for_disk.exchange(0);
  MustRecord(*ledger, {reserved.row, "SENT", ""});
  EXPECT_EQ(waits_for_disk, waits);
}

TEST_F(SqliteFile, InRollbackModeKeepsItsMode) {
  Fill(1);
  RunSql(path_, "PRAGMA journal_mode=DELETE");
  const auto ledger = MustOpen(path_);
  const Reservation reserved = MustReserve(*ledger);
  EXPECT_EQ(reserved.header_id, 1U);
  MustRecord(*ledger, {reserved.row, "SENT", ""});
  EXPECT_GT(fs::file_size(path_.string() + "-journal"), 0U);  // PERSIST
  EXPECT_FALSE(fs::exists(path_.string() + "-wal"));
}

// As on a network file system, which a test cannot have.
TEST_F(SqliteFile, WithoutALogIsMadeAndKeptSo) {
  ASSERT_TRUE(CreateLedger(path_, Journal::kRollback, milliseconds(100)));
  Fill(2);
  EXPECT_FALSE(fs::exists(path_.string() + "-wal"));
  EXPECT_EQ(MustOpen(path_, OpenMode::kReadOnly)->PeekNext(MakeTopic(1)), 2U);
}

TEST_F(SqliteFile, WithALogGivesItUpWhereHostsShareTheFile) {
  Fill(2);
  {
    auto database = Database::Open(path_, Access::kReadWrite, milliseconds(100));
    ASSERT_TRUE(ChooseJournal(**database, Journal::kRollback));
  }
  EXPECT_FALSE(fs::exists(path_.string() + "-wal"));
  EXPECT_EQ(MustReserve(*MustOpen(path_)).header_id, 2U);
}

TEST_F(SqliteFile, GivesSpaceBackWhenPruned) {
  const auto ledger = MustOpen(path_);
  Draft draft = DraftFor();
  draft.after_id = std::string(2'000, 'x');
  const std::vector<Draft> drafts(2'500, draft);
  ASSERT_TRUE(ledger->Reserve(drafts));
  MustRecord(*ledger, {1, "SENT", ""});
  EXPECT_GT(fs::file_size(path_), 5'000'000U);
  EXPECT_EQ(ledger->Prune(std::chrono::system_clock::now() + std::chrono::hours(1)), 2'500);
  EXPECT_LT(fs::file_size(path_), 100'000U);
  EXPECT_EQ(fs::file_size(path_.string() + "-wal"), 0U);
  EXPECT_EQ(MustReserve(*ledger).header_id, 2'500U);
}

TEST(DefaultLedgerPath, IsTheSharedFolderWhereThereIsOne) {
  const testing::TemporaryFolder shared;
  EXPECT_EQ(DefaultLedgerPath(shared.path()), shared / "ledger.db");
}

TEST(DefaultLedgerPath, IsTheUsersStateFolderOtherwise) {
  const auto path_with = [](const char* state, const char* home) {
    return InProcess([&]() -> std::string {
      setenv("XDG_STATE_HOME", state, 1);
      setenv("HOME", home, 1);
      const auto path = DefaultLedgerPath("/no/such/folder");
      return path ? path->string() : path.error().message;
    });
  };
  EXPECT_EQ(path_with("/state", "/home/u"), "/state/fleetpub/ledger.db");
  EXPECT_EQ(path_with("", "/home/u"), "/home/u/.local/state/fleetpub/ledger.db");
  EXPECT_EQ(path_with("relative", "/home/u"), "/home/u/.local/state/fleetpub/ledger.db");
  EXPECT_THAT(path_with("", "relative"), HasSubstr("no home folder"));
}

TEST(DefaultLedgerPath, PassesOverASharedFolderThatIsNotThisUsers) {
  const testing::TemporaryFolder shared;
  chmod(shared.path().c_str(), 0755);
  if (geteuid() != 0) chmod(shared.path().c_str(), 0555);
  EXPECT_EQ(AsOrdinaryUser([&]() -> std::string {
              setenv("XDG_STATE_HOME", "/state", 1);
              return DefaultLedgerPath(shared.path())->string();
            }),
            "/state/fleetpub/ledger.db");
}

TEST(NetworkFileSystem, IsToldFromALocalOne) {
  const testing::TemporaryFolder folder;
  EXPECT_FALSE(OnNetworkFileSystem(folder / "not-yet.db"));
  EXPECT_FALSE(OnNetworkFileSystem("/no/such/folder/ledger.db"));
}

}  // namespace
}  // namespace fleetpub::ledger
