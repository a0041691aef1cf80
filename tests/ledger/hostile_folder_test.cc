// A colleague who may write in the ledger's folder, and into the ledger, and means harm: he can
// block it, but reaches no other file of ours and makes us run nothing.
#include <gmock/gmock.h>
#include <sqlite3.h>
#include <sys/stat.h>

#include <array>
#include <fstream>

#include "ledger/ledger_files.h"
#include "ledger/ledger_support.h"
#include "ledger/sqlite/sqlite_database.h"

namespace fleetpub::ledger {
namespace {

using std::chrono::seconds;
using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

std::string ReadWhole(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

constexpr const char* kPrecious = "not a ledger: leave it alone\n";

class HostileFolder : public ::testing::Test {
 protected:
  HostileFolder() {
    fs::create_directory(shared_);
    chmod(shared_.c_str(), 0770);
    const auto ledger = MustOpen(path_);
    for (int i = 0; i < 3; ++i) MustReserve(*ledger);
  }

  /// As another program, with no care for us.
  void RunSql(const std::string& sql) const {
    sqlite3* other = nullptr;
    ASSERT_EQ(sqlite3_open(path_.c_str(), &other), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(other, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
        << sqlite3_errmsg(other);
    sqlite3_close(other);  // the last one: the log goes into the file and is removed
  }
  /// The ledger is its file alone.
  void LeaveNoLog() const { RunSql("PRAGMA wal_checkpoint(TRUNCATE)"); }

  /// "" when a command could be recorded.
  [[nodiscard]] std::string ErrorOfCommand() const {
    const auto ledger = OpenSqlite(OptionsFor(path_), OpenMode::kCreate);
    if (!ledger) return ledger.error().message;
    const std::vector<std::string> topics = {MakeTopic(1)};
    const auto lock = (*ledger)->Lock(topics, In(milliseconds(50)));
    if (!lock) return lock.error().message;
    const Draft draft = DraftFor();
    const auto reserved = (*ledger)->Reserve(std::span(&draft, 1));
    return reserved ? "" : reserved.error().message;
  }
  [[nodiscard]] std::string ErrorOfLooking() const {
    const auto ledger = OpenSqlite(OptionsFor(path_), OpenMode::kReadOnly);
    if (!ledger) return ledger.error().message;
    const auto next = (*ledger)->PeekNext(MakeTopic(1));
    return next ? "" : next.error().message;
  }

  testing::TemporaryFolder folder_;
  fs::path shared_ = folder_ / "shared";
  fs::path path_ = shared_ / "ledger.db";
  fs::path victim_ = folder_.Write("victim", kPrecious);
};

TEST_F(HostileFolder, LinksBesideTheLedgerLeadNowhere) {
  for (const std::string end : {"-wal", "-shm", "-journal", ".locks"}) {
    LeaveNoLog();
    const fs::path trap = path_.string() + end;
    fs::remove(trap);
    fs::create_symlink(victim_, trap);
    EXPECT_THAT(ErrorOfCommand(), AllOf(HasSubstr(trap.string()), HasSubstr("link")));
    if (end != ".locks") {
      EXPECT_THAT(ErrorOfLooking(), HasSubstr(trap.string()));
    }
    EXPECT_EQ(ReadWhole(victim_), kPrecious) << end;
    fs::remove(trap);
    EXPECT_EQ(ErrorOfCommand(), "") << end;
  }
}

TEST_F(HostileFolder, LinksInTheWayOfANewLedgerLeadNowhere) {
  for (const char* end : {".new", ".new-wal", ".new-journal"}) {
    for (const char* part : {"", "-wal", "-shm", ".locks"}) fs::remove(path_.string() + part);
    fs::create_symlink(victim_, path_.string() + end);
    EXPECT_EQ(ErrorOfCommand(), "") << "it is removed, not followed";
    EXPECT_EQ(ReadWhole(victim_), kPrecious) << end;
  }
}

TEST_F(HostileFolder, TheLedgerIsNoLinkInAFolderOfOthers) {
  const auto elsewhere = folder_ / "ledger.db";
  fs::rename(path_, elsewhere);
  fs::create_symlink(elsewhere, path_);
  for (const mode_t mode : {0770U, 0757U, 01777U}) {
    chmod(shared_.c_str(), mode);
    EXPECT_THAT(ErrorOfCommand(), AllOf(HasSubstr(path_.string()), HasSubstr("not followed")));
    EXPECT_THAT(ErrorOfLooking(), HasSubstr("not followed"));
  }
  chmod(shared_.c_str(), 0755);
  EXPECT_EQ(ErrorOfCommand(), "") << "a link in a folder of one's own is followed";
  EXPECT_TRUE(fs::exists(elsewhere.string() + "-wal")) << "the other files are where it leads";
}

TEST_F(HostileFolder, NoPartOfItsPathIsALinkInAFolderOfOthers) {
  fs::create_directory(folder_ / "real");
  fs::create_directory_symlink(folder_ / "real", shared_ / "sub");
  fs::create_directory_symlink(shared_ / "sub", folder_ / "own");
  for (const fs::path& path : {shared_ / "sub" / "l.db", folder_ / "own" / "l.db"}) {
    EXPECT_THAT(ErrorOfOpening(path), HasSubstr("sub is a link")) << path;
  }
  fs::create_directory_symlink("real", folder_ / "mine");
  EXPECT_EQ(ErrorOfOpening(folder_ / "mine" / "../mine" / "l.db"), "");
  EXPECT_TRUE(fs::exists(folder_ / "real" / "l.db"));
}

TEST_F(HostileFolder, FifosAreNotWaitedFor) {
  chmod(folder_.path().c_str(), 0755);
  chmod(shared_.c_str(), 0777);
  LeaveNoLog();
  chmod(path_.c_str(), 0666);
  for (const std::string end : {"-wal", "-journal", ".locks"}) {
    const fs::path trap = path_.string() + end;
    fs::remove(trap);
    // Nobody may write into it: opened for reading, it would wait for a writer.
    ASSERT_EQ(mkfifo(trap.c_str(), 0444), 0);
    const std::string told = AsOrdinaryUser([&] {
      alarm(10);
      const std::string looking = ErrorOfLooking();
      return ErrorOfCommand() + "\n" + (end == ".locks" ? "" : looking);
    });
    EXPECT_THAT(told, HasSubstr(trap.string())) << end;
    fs::remove(trap);
  }
}

void Append(std::string& bytes, std::uint32_t number) {
  for (const int shift : {24, 16, 8, 0}) bytes += static_cast<char>((number >> shift) & 0xFFU);
}

// SQLite reads the journal that another one names above it, and removes it when it belongs to
// nothing. (sqlite.org/fileformat2.html §3, pager_delsuper in pager.c)
TEST_F(HostileFolder, AJournalThatNamesAnotherFileDoesNotRemoveIt) {
  LeaveNoLog();
  const std::string magic = "\xD9\xD5\x05\xF9\x20\xA1\x63\xD7";
  const std::string name = victim_.string();
  std::string journal = magic;
  const auto pages = static_cast<std::uint32_t>(fs::file_size(path_) / 1024);
  for (const std::uint32_t number : {0U, 0U, pages, 512U, 1024U}) Append(journal, number);
  journal.resize(512, '\0');
  Append(journal, 0x40000000U / 1024 + 1);
  journal += name;
  Append(journal, static_cast<std::uint32_t>(name.size()));
  std::uint32_t sum = 0;
  for (const char c : name) sum += static_cast<std::uint32_t>(static_cast<signed char>(c));
  Append(journal, sum);
  journal += magic;
  std::ofstream(path_.string() + "-journal", std::ios::binary) << journal;
  EXPECT_NE(ErrorOfCommand(), "");
  EXPECT_EQ(ReadWhole(victim_), kPrecious);
  fs::remove(path_.string() + "-journal");
  EXPECT_EQ(ErrorOfCommand(), "");
}

TEST_F(HostileFolder, TriggersDoNotRun) {
  RunSql(
      "CREATE TRIGGER t AFTER INSERT ON messages BEGIN DELETE FROM messages; "
      "UPDATE header_ids SET last = 0; END;"
      "CREATE TRIGGER u BEFORE UPDATE ON messages BEGIN SELECT raise(ABORT, 'no'); END");
  const auto ledger = MustOpen(path_);
  const Reservation fourth = MustReserve(*ledger);
  EXPECT_EQ(fourth.header_id, 3U);
  MustRecord(*ledger, {.row = fourth.row, .status = "SENT"});
  EXPECT_EQ(MustReserve(*ledger).header_id, 4U);
  EXPECT_EQ(ledger->History({})->size(), 5U);
}

TEST_F(HostileFolder, OtherTablesThanOursAreRefused) {
  LeaveNoLog();
  const std::string ledger = ReadWhole(path_);
  for (const char* sql :
       {"ALTER TABLE messages RENAME TO m; CREATE VIEW messages AS SELECT * FROM m",
        "DROP TABLE header_ids; CREATE VIEW header_ids AS WITH RECURSIVE c(topic, last) AS "
        "(VALUES('', 0) UNION ALL SELECT '', last + 1 FROM c) SELECT * FROM c",
        "ALTER TABLE messages ADD COLUMN more TEXT GENERATED ALWAYS AS (upper(payload))",
        "DROP TABLE header_ids; CREATE TABLE header_ids(topic TEXT PRIMARY KEY ON CONFLICT IGNORE, "
        "last INTEGER NOT NULL) WITHOUT ROWID",
        "DROP TABLE messages"}) {
    RunSql(sql);
    EXPECT_THAT(ErrorOfCommand(), HasSubstr("not those that fleetpub makes")) << sql;
    EXPECT_THAT(ErrorOfLooking(), HasSubstr("not those that fleetpub makes")) << sql;
    for (const char* end : {"-wal", "-shm"}) fs::remove(path_.string() + end);
    std::ofstream(path_, std::ios::binary) << ledger;
  }
  RunSql("CREATE TABLE notes(text); CREATE VIEW v AS SELECT target FROM messages");
  EXPECT_EQ(ErrorOfCommand(), "") << "what we do not use does no harm";
}

TEST_F(HostileFolder, NoStatementWritesTheSchema) {
  auto database = Database::Open(path_, Access::kReadWrite, milliseconds(100));
  ASSERT_TRUE(database);
  static_cast<void>((*database)->Execute("PRAGMA writable_schema=ON"));
  EXPECT_FALSE((*database)->Execute("UPDATE sqlite_schema SET sql = ''"));
}

TEST_F(HostileFolder, EveryStatementHasAnEnd) {
  constexpr const char* kEndless =
      "WITH RECURSIVE c(n) AS (VALUES(1) UNION ALL SELECT n + 1 FROM c) SELECT count(*) FROM c";
  auto database = Database::Open(path_, Access::kReadWrite, milliseconds(100));
  ASSERT_TRUE(database);
  (*database)->Allow(milliseconds(30));
  const Status ended = (*database)->Execute(kEndless);
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().kind, ErrorKind::kLedger);
  EXPECT_THAT(ended.error().message, AllOf(HasSubstr("too long"), HasSubstr("--ledger")));
  (*database)->Allow(seconds(10));
  EXPECT_TRUE((*database)->Execute("SELECT count(*) FROM messages"));
}

TEST_F(HostileFolder, ACallEndsHoweverOftenItWouldWait) {
  SqliteOptions options = OptionsFor(path_);
  options.busy_timeout = seconds(30);
  options.command_timeout = milliseconds(50);
  const auto ledger = MustOpen(options);
  auto other = Database::Open(path_, Access::kReadWrite, milliseconds(0));
  ASSERT_TRUE(other && (*other)->Execute("BEGIN IMMEDIATE"));
  const auto start = steady_clock::now();
  const Draft draft = DraftFor();
  const auto refused = ledger->Reserve(std::span(&draft, 1));
  EXPECT_LT(steady_clock::now() - start, seconds(10));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, AllOf(HasSubstr("locked"), HasSubstr("--ledger")));
  const StatusUpdate outcome{.row = 1, .status = "SENT"};
  EXPECT_FALSE(ledger->RecordOutcomes(std::span(&outcome, 1)));
}

TEST_F(HostileFolder, EveryCallOfTheLedgerHasItsLimit) {
  SqliteOptions options = OptionsFor(path_);
  auto ledger = MustOpen(options);
  ASSERT_TRUE(ledger->Reserve(std::vector<Draft>(2'000, DraftFor())));
  options.history_timeout = milliseconds(-1);
  ledger = MustOpen(options, OpenMode::kReadOnly);
  const auto history = ledger->History({.action = "never"});
  ASSERT_FALSE(history);
  EXPECT_THAT(history.error().message, HasSubstr("too long"));
}

}  // namespace
}  // namespace fleetpub::ledger
