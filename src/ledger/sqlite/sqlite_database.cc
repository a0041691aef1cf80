#include "ledger/sqlite/sqlite_database.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <cerrno>
#include <thread>

#include "ledger/backoff.h"
#include "ledger/sqlite/sqlite_error.h"
#include "ledger/sqlite/wal_vfs.h"

namespace fleetpub::ledger {
namespace {

constexpr int kLongestValue = 128 << 20;  // twice the largest message that is read from a file
constexpr int kStepsPerGlance = 10'000;   // of SQLite's virtual machine: a millisecond or less

/// SQLite's URI form (sqlite.org/uri.html): only there can a file be called immutable.
std::string ImmutableUri(const std::string& path) {
  std::string uri = path.starts_with('/') ? "file://" : "file:";
  for (const char c : path) {
    if (c == '%' || c == '?' || c == '#') {
      uri += fmt::format("%{:02X}", static_cast<unsigned char>(c));
    } else {
      uri += c;
    }
  }
  return uri + "?immutable=1";
}

int FlagsFor(Access access) {
  const int common = SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE;
  if (access == Access::kReadWrite) return common | SQLITE_OPEN_READWRITE;
  if (access == Access::kReadOnly) return common | SQLITE_OPEN_READONLY;
  return common | SQLITE_OPEN_READONLY | SQLITE_OPEN_URI;
}

}  // namespace

Result<std::unique_ptr<Database>> Database::Open(const std::filesystem::path& path, Access access,
                                                 std::chrono::milliseconds busy_timeout) {
  std::unique_ptr<Database> database(new Database(path, busy_timeout));
  const std::string name =
      access == Access::kImmutable ? ImmutableUri(path.string()) : path.string();
  const int code = sqlite3_open_v2(name.c_str(), &database->db_, FlagsFor(access), LogVfs());
  if (code != SQLITE_OK) return Fail(database->Explain(code));
  if (access == Access::kReadWrite && sqlite3_db_readonly(database->db_, "main") == 1) {
    return Fail(database->Explain(SQLITE_READONLY));
  }
  database->Configure();
  return database;
}

void Database::Configure() {
  // Whoever may write the file may put into it what runs when we read or write (sqlite.org/
  // security.html).
  sqlite3_db_config(db_, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  for (const int option : {SQLITE_DBCONFIG_TRUSTED_SCHEMA, SQLITE_DBCONFIG_ENABLE_TRIGGER,
                           SQLITE_DBCONFIG_ENABLE_VIEW}) {
    sqlite3_db_config(db_, option, 0, nullptr);
  }
  sqlite3_limit(db_, SQLITE_LIMIT_LENGTH, kLongestValue);
  sqlite3_progress_handler(db_, kStepsPerGlance, &Database::OnProgress, this);
  sqlite3_busy_handler(db_, &Database::OnBusy, this);
  // Closing would otherwise copy the log into the file, with two more waits for the disk, on every
  // command.
  sqlite3_db_config(db_, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  sqlite3_wal_hook(db_, &Database::OnCommit, this);  // also replaces SQLite's own checkpointing
}

Database::~Database() { sqlite3_close_v2(db_); }

int Database::OnBusy(void* self, int count) {
  auto& database = *static_cast<Database*>(self);
  const auto now = std::chrono::steady_clock::now();
  if (count == 0) database.busy_since_ = now;
  if (now - database.busy_since_ >= database.busy_timeout_ || now >= database.deadline_) return 0;
  std::this_thread::sleep_for(BackoffFor(count));
  return 1;
}

int Database::OnProgress(void* self) {
  return std::chrono::steady_clock::now() >= static_cast<Database*>(self)->deadline_ ? 1 : 0;
}

int Database::OnCommit(void* self, sqlite3* /*db*/, const char* /*schema*/, int frames) {
  static_cast<Database*>(self)->wal_frames_ = frames;
  return SQLITE_OK;
}

Status Database::Execute(const char* sql) { return Statement(*this, sql).Run(); }

Result<std::string> Database::Ask(const char* sql) {
  Statement statement(*this, sql);
  const Result<bool> row = statement.Step();
  if (!row) return Fail(row.error());
  return *row ? statement.Text(0) : std::string();
}

Status Database::SetDurability(Durability durability) {
  if (!write_ahead_) durability = Durability::kFull;
  if (durability == durability_) return {};
  const char* sql =
      durability == Durability::kFull ? "PRAGMA synchronous=FULL" : "PRAGMA synchronous=NORMAL";
  Status set = Execute(sql);
  if (set) durability_ = durability;
  return set;
}

void Database::Checkpoint(AfterCheckpoint after) {
  const bool cut = after == AfterCheckpoint::kNothingFollows;
  sqlite3_busy_handler(db_, nullptr, nullptr);
  sqlite3_wal_checkpoint_v2(
      db_, nullptr, cut ? SQLITE_CHECKPOINT_TRUNCATE : SQLITE_CHECKPOINT_PASSIVE, nullptr, nullptr);
  sqlite3_busy_handler(db_, &Database::OnBusy, this);
  wal_frames_ = 0;
}

std::filesystem::path Database::path() const {
  const char* name = sqlite3_db_filename(db_, "main");
  return name == nullptr ? path_ : std::filesystem::path(name);
}

std::int64_t Database::LastRowId() const { return sqlite3_last_insert_rowid(db_); }

std::int64_t Database::Changes() const { return sqlite3_changes64(db_); }

bool Database::LacksSharedMemory() const {
  const int code = sqlite3_extended_errcode(db_);
  return (code & 0xFF) == SQLITE_CANTOPEN || code == SQLITE_READONLY_CANTINIT ||
         code == SQLITE_READONLY_DIRECTORY;
}

Error Database::Explain(int code) const {
  // SQLite forgets the system's reason when a commit fails; errno still has it (Step).
  const int reason = db_ == nullptr ? 0 : sqlite3_system_errno(db_);
  return ExplainSqlite({.code = code,
                        .system_error = reason == 0 ? errno : reason,
                        .text = db_ == nullptr ? sqlite3_errstr(code) : sqlite3_errmsg(db_),
                        .path = path_,
                        .busy_timeout = busy_timeout_});
}

Statement::Statement(Database& database, std::string_view sql) : database_(database) {
  KeepError(sqlite3_prepare_v2(database.db_, sql.data(), static_cast<int>(sql.size()), &statement_,
                               nullptr));
}

Statement::~Statement() { sqlite3_finalize(statement_); }

void Statement::KeepError(int code) {
  if (failure_ == SQLITE_OK) failure_ = code;
}

Statement& Statement::Bind(int index, std::int64_t value) {
  KeepError(sqlite3_bind_int64(statement_, index, value));
  return *this;
}

Statement& Statement::Bind(int index, std::string_view text) {
  // An empty view may have no address, and SQLite would take that for NULL.
  const char* data = text.empty() ? "" : text.data();
  KeepError(sqlite3_bind_text64(statement_, index, data, text.size(), SQLITE_STATIC, SQLITE_UTF8));
  return *this;
}

Statement& Statement::BindNull(int index) {
  KeepError(sqlite3_bind_null(statement_, index));
  return *this;
}

Result<bool> Statement::Step() {
  if (failure_ != SQLITE_OK) return Fail(database_.Explain(failure_));
  errno = 0;
  const int code = sqlite3_step(statement_);
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  return Fail(database_.Explain(code));
}

Status Statement::Run() {
  Result<bool> row = Step();
  while (row && *row) row = Step();
  if (!row) return Fail(std::move(row.error()));
  Reset();
  return {};
}

void Statement::Reset() { sqlite3_reset(statement_); }

std::int64_t Statement::Integer(int column) const {
  return sqlite3_column_int64(statement_, column);
}

std::string Statement::Text(int column) const {
  const auto* text = static_cast<const char*>(sqlite3_column_blob(statement_, column));
  const int size = sqlite3_column_bytes(statement_, column);
  return text == nullptr ? std::string() : std::string(text, static_cast<std::size_t>(size));
}

bool Statement::IsNull(int column) const {
  return sqlite3_column_type(statement_, column) == SQLITE_NULL;
}

std::string_view SqliteVersion() { return sqlite3_libversion(); }

Transaction::~Transaction() {
  // After a full disk SQLite has rolled back by itself, and this fails harmlessly.
  if (open_) static_cast<void>(database_.Execute("ROLLBACK"));
}

Status Transaction::Begin() {
  Status begun = database_.Execute("BEGIN IMMEDIATE");
  open_ = begun.has_value();
  return begun;
}

Status Transaction::Commit() {
  Status committed = database_.Execute("COMMIT");
  if (committed) open_ = false;
  return committed;
}

}  // namespace fleetpub::ledger
