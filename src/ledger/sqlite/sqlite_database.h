// SQLite's C interface, thinly: one connection, its statements and its transactions. Knows nothing
// of ledgers but how to tell a person what SQLite's codes mean for one.
//
// A Database and what is made from it belong to one thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "base/result.h"

struct sqlite3;
struct sqlite3_stmt;

namespace fleetpub::ledger {

enum class Access {
  kReadWrite,  ///< the file must exist
  kReadOnly,
  kImmutable,  ///< read without locks and without shared memory: for a medium that nobody can write
};

/// What a commit waits for. Neither can damage the file, whatever happens.
enum class Durability {
  kFull,    ///< the commit is on the disk
  kNormal,  ///< WAL only: a power failure may take the last commits back, a crash of the process
            ///< cannot
};

enum class AfterCheckpoint {
  kCommitFollows,   ///< of this connection: it will write the log from its beginning
  kNothingFollows,  ///< the log is cut to nothing
};

/// Of the library that the program runs with.
[[nodiscard]] std::string_view SqliteVersion();

class Database {
 public:
  /// The path's links are resolved (ResolveLinks). What the file itself brings runs as little as it
  /// can: no triggers, no views, no functions with side effects.
  [[nodiscard]] static Result<std::unique_ptr<Database>> Open(
      const std::filesystem::path& path, Access access, std::chrono::milliseconds busy_timeout);
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;
  ~Database();

  /// From now on statements may take so long in all, waiting and working; then they fail. Before
  /// the first call there is no limit.
  void Allow(std::chrono::milliseconds time) {
    deadline_ = std::chrono::steady_clock::now() + time;
  }

  [[nodiscard]] Status Execute(const char* sql);
  /// The first column of the first row, "" when there is none.
  [[nodiscard]] Result<std::string> Ask(const char* sql);

  /// In rollback mode always kFull: there, less could damage the file.
  [[nodiscard]] Status SetDurability(Durability durability);
  void set_write_ahead(bool on) { write_ahead_ = on; }

  /// Frames in the write-ahead log after this connection's last commit; 0 before the first.
  [[nodiscard]] int wal_frames() const { return wal_frames_; }
  /// Copies the log into the file, as far as can be done without waiting for anybody.
  void Checkpoint(AfterCheckpoint after);

  /// The file, links resolved.
  [[nodiscard]] std::filesystem::path path() const;
  [[nodiscard]] std::int64_t LastRowId() const;
  /// Rows that the last statement changed.
  [[nodiscard]] std::int64_t Changes() const;
  /// The last call failed because what is shared between readers of a log could not be opened or
  /// made.
  [[nodiscard]] bool LacksSharedMemory() const;
  /// What a person should know about this code of SQLite's.
  [[nodiscard]] Error Explain(int code) const;

 private:
  friend class Statement;
  explicit Database(std::filesystem::path path, std::chrono::milliseconds busy_timeout)
      : path_(std::move(path)), busy_timeout_(busy_timeout) {}
  void Configure();
  static int OnBusy(void* self, int count);
  static int OnProgress(void* self);
  static int OnCommit(void* self, sqlite3* db, const char* schema, int frames);

  std::filesystem::path path_;
  std::chrono::milliseconds busy_timeout_;
  std::chrono::steady_clock::time_point busy_since_ = {};
  std::chrono::steady_clock::time_point deadline_ = std::chrono::steady_clock::time_point::max();
  sqlite3* db_ = nullptr;
  int wal_frames_ = 0;
  bool write_ahead_ = false;
  Durability durability_ = Durability::kNormal;
};

/// A prepared statement. Texts are bound without a copy: they must live until the next Step or Run.
/// What goes wrong in preparing or binding, Step and Run report.
class Statement {
 public:
  Statement(Database& database, std::string_view sql);
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;
  ~Statement();

  Statement& Bind(int index, std::int64_t value);
  Statement& Bind(int index, std::string_view text);
  Statement& BindNull(int index);

  /// True: there is a row to read. False: done.
  [[nodiscard]] Result<bool> Step();
  /// Steps to the end and makes the statement ready for its next use.
  [[nodiscard]] Status Run();
  void Reset();

  [[nodiscard]] std::int64_t Integer(int column) const;
  [[nodiscard]] std::string Text(int column) const;
  [[nodiscard]] bool IsNull(int column) const;

 private:
  void KeepError(int code);

  Database& database_;
  sqlite3_stmt* statement_ = nullptr;
  int failure_ = 0;
};

/// Takes the write lock when begun, rolls back unless committed.
class Transaction {
 public:
  explicit Transaction(Database& database) : database_(database) {}
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  ~Transaction();

  [[nodiscard]] Status Begin();
  [[nodiscard]] Status Commit();

 private:
  Database& database_;
  bool open_ = false;
};

}  // namespace fleetpub::ledger
