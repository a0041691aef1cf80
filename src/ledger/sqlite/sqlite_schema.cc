#include "ledger/sqlite/sqlite_schema.h"

#include <fmt/format.h>

#include <array>
#include <initializer_list>
#include <string>
#include <system_error>

#include "ledger/ledger_files.h"
#include "ledger/topic_locks.h"

namespace fleetpub::ledger {
namespace {

/// "FLPB". In the file's header (sqlite.org/fileformat2.html §1.3.16), where file(1) shows it too.
constexpr std::int64_t kApplicationId = 0x464C5042;
constexpr std::int64_t kVersion = 1;

// Small pages: a commit writes whole pages, and a command changes three. AUTOINCREMENT keeps the
// numbers of pruned rows from being given again. No index: one would be written with each command,
// and history is read rarely.
constexpr char kHeaderIds[] =
    "CREATE TABLE header_ids("
    "topic TEXT PRIMARY KEY, last INTEGER NOT NULL"
    ") WITHOUT ROWID";
constexpr char kMessages[] =
    "CREATE TABLE messages("
    "id INTEGER PRIMARY KEY AUTOINCREMENT, recorded_at INTEGER NOT NULL, outcome_at INTEGER, "
    "user TEXT NOT NULL, host TEXT NOT NULL, profile TEXT NOT NULL, broker TEXT NOT NULL, "
    "target TEXT NOT NULL, protocol TEXT NOT NULL, version TEXT NOT NULL, topic TEXT NOT NULL, "
    "header_id INTEGER, actions TEXT NOT NULL, payload TEXT NOT NULL, status TEXT NOT NULL, "
    "detail TEXT NOT NULL)";
constexpr std::array kCreate = {
    kHeaderIds,
    kMessages,
    "PRAGMA application_id=1179406402",
    "PRAGMA user_version=1",
};
static_assert(kApplicationId == 1179406402 && kVersion == 1, "as in kCreate");

Result<std::int64_t> AskNumber(Database& database, const char* sql) {
  Statement statement(database, sql);
  const Result<bool> row = statement.Step();
  if (!row) return Fail(row.error());
  return *row ? statement.Integer(0) : 0;
}

Status CreateTables(Database& database, Journal journal) {
  const char* choose =
      journal == Journal::kWriteAhead ? "PRAGMA journal_mode=WAL" : "PRAGMA journal_mode=PERSIST";
  for (const char* sql : {"PRAGMA page_size=1024", choose}) {
    if (Status done = database.Execute(sql); !done) return done;
  }
  Transaction transaction(database);
  if (Status begun = transaction.Begin(); !begun) return begun;
  for (const char* sql : kCreate) {
    if (Status done = database.Execute(sql); !done) return done;
  }
  if (Status done = transaction.Commit(); !done) return done;
  // A log that could not be copied is no error to SQLite: it answers 1 for busy.
  const Result<std::string> busy = database.Ask("PRAGMA wal_checkpoint(TRUNCATE)");
  if (!busy) return Fail(busy.error());
  if (*busy == "0") return {};
  return Fail(ErrorKind::kLedger, fmt::format("the new ledger {} could not be finished: try again",
                                              database.path().string()));
}

Status CreateDraft(const std::string& path, Journal journal, std::chrono::milliseconds timeout) {
  if (Status made = CreateEmptyFile(path); !made) return made;
  const auto database = Database::Open(path, Access::kReadWrite, timeout);
  if (!database) return Fail(database.error());
  return CreateTables(**database, journal);
}

/// SQLite would play it into the new file.
Status RefuseOrphanedLog(const std::filesystem::path& ledger) {
  const std::string path = ledger.string();
  if (GetFileSize(path + "-wal") == 0) return {};
  return Fail(ErrorKind::kLedger,
              fmt::format("the ledger {0} is gone or empty, but its log {0}-wal is there: put the "
                          "ledger back, or move the log aside as well; header ids go on where "
                          "{0}.locks says",
                          path));
}

void RemoveFiles(const std::string& path, std::initializer_list<const char*> ends) {
  std::error_code ignored;
  for (const char* end : ends) std::filesystem::remove(path + end, ignored);
}

// What else is in the file is not used. A view in place of a table, a virtual one, or one with
// other columns would be.
Status CheckTables(Database& database) {
  Statement statement(database,
                      "SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND "
                      "((name = 'header_ids' AND sql = ?1) OR (name = 'messages' AND sql = ?2))");
  const Result<bool> row = statement.Bind(1, kHeaderIds).Bind(2, kMessages).Step();
  if (!row) return Fail(row.error());
  if (statement.Integer(0) == 2) return {};
  return Fail(ErrorKind::kLedger,
              fmt::format("the tables of the ledger {} are not those that fleetpub makes: find out "
                          "who changed them, and name another ledger or move this one aside",
                          database.path().string()));
}

}  // namespace

Status CreateLedger(const std::filesystem::path& path, Journal journal,
                    std::chrono::milliseconds busy_timeout) {
  if (Status made = MakeFolders(path.parent_path()); !made) return made;
  const auto alone = LockCreation(path, std::chrono::steady_clock::now() + busy_timeout);
  if (!alone) return Fail(alone.error());
  const Result<bool> made_meanwhile = HasLedgerFile(path);
  if (!made_meanwhile) return Fail(made_meanwhile.error());
  if (*made_meanwhile) return {};
  if (Status alone_too = RefuseOrphanedLog(path); !alone_too) return alone_too;
  const std::string draft = path.string() + ".new";
  RemoveFiles(draft, {"", "-wal", "-shm", "-journal"});  // of one who was killed here
  Status made = CreateDraft(draft, journal, busy_timeout);
  RemoveFiles(draft, {"-wal", "-shm", "-journal"});
  if (made) return MoveFile(draft, path);
  RemoveFiles(draft, {""});
  return made;
}

Status Inspect(Database& database) {
  const Result<std::int64_t> application = AskNumber(database, "PRAGMA application_id");
  if (!application) return Fail(application.error());
  const Result<std::int64_t> version = AskNumber(database, "PRAGMA user_version");
  if (!version) return Fail(version.error());
  const std::string path = database.path().string();
  if (*application != kApplicationId) {
    return Fail(ErrorKind::kLedger,
                fmt::format("{} is a database of another program: name another ledger", path));
  }
  if (*version > kVersion) {
    return Fail(ErrorKind::kLedger,
                fmt::format("the ledger {} was written by a newer fleetpub: update this one", path),
                fmt::format("version {} of the file, {} known", *version, kVersion));
  }
  return CheckTables(database);
}

Status CountTables(Database& database, LedgerInfo& info) {
  Statement statement(database,
                      "SELECT user_version, (SELECT count(*) FROM messages), "
                      "(SELECT count(*) FROM header_ids) FROM pragma_user_version");
  const Result<bool> row = statement.Step();
  if (!row) return Fail(row.error());
  info.version = static_cast<int>(statement.Integer(0));
  info.rows = statement.Integer(1);
  info.topics = statement.Integer(2);
  return {};
}

Status ChooseJournal(Database& database, Journal journal) {
  const Result<std::string> mode = database.Ask(
      journal == Journal::kRollback ? "PRAGMA journal_mode=PERSIST" : "PRAGMA journal_mode");
  if (!mode) return Fail(mode.error());
  database.set_write_ahead(*mode == "wal");
  // DELETE, SQLite's default, can bring a finished journal back after a power failure, and an id
  // with it.
  if (*mode != "wal" && *mode != "persist") return database.Execute("PRAGMA journal_mode=PERSIST");
  return {};
}

}  // namespace fleetpub::ledger
