// The ledger over SQLite.
//
// What must hold (ledger.h), and what makes it hold:
//
// 1. No id twice, none backwards. Reserve reads a topic's last id and writes the next in one
//    transaction that takes the write lock first (BEGIN IMMEDIATE): two processes cannot read the
//    same last id. This rests on SQLite alone, not on the topics' locks; without those, only the
//    order on the wire would be lost.
//
// 2. Nothing is sent that is not recorded. Reserve returns after its commit has reached the disk
//    (synchronous=FULL). Killed before, the transaction never was: no id is used. Killed after, the
//    row says RECORDED and there is a gap.
//
// 3. An outcome may be lost, the file never damaged. RecordOutcomes commits without waiting for the
//    disk (synchronous=NORMAL). In a write-ahead log that is safe: frames are chained by checksums
//    and synced before they reach the database file, so that after a power failure the log ends
//    early but never wrong, and never before a frame that a Reserve synced. In rollback mode it
//    would not be safe; there, outcomes are synced too.
//
// 4. A command waits for the disk only to reserve. With a rollback journal it would wait five times
//    in each of its two transactions and take three times as long (docs/benchmarks.md). The log's
//    usual price is its end: the last to close it copies it into the file. That is switched off,
//    and done when the log has grown (kLogFrames) and the message is out:
//
//      Reserve ──commit──▶ log grows ──RecordOutcomes──▶ Checkpoint ──commit──▶ log begins anew
//
//    The order matters: that a log was copied is known only as long as somebody has it open. One
//    that is copied, not begun anew and closed would grow without end. Who commits nothing after
//    the copy therefore cuts the log to nothing.
//
// 5. Between hosts the log would not do: it needs shared memory. On network file systems the file
//    keeps a rollback journal (PERSIST: the journal's end is synced, so that no finished one comes
//    back after a power failure).
//
// 6. A damaged log ends early without a word. HeaderIdCheckpoints know the ids that it takes with it.
//
// 7. POSIX locks die when *any* descriptor of the file is closed in the process. Nothing here opens
//    the ledger file but SQLite. A new one is made under another name and moved into place whole.
#include "ledger/sqlite/sqlite_ledger.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "ledger/header_id_checkpoints.h"
#include "ledger/header_ids.h"
#include "ledger/ledger_files.h"
#include "ledger/sqlite/sqlite_database.h"
#include "ledger/sqlite/sqlite_history.h"
#include "ledger/sqlite/sqlite_reservation.h"
#include "ledger/sqlite/sqlite_schema.h"
#include "ledger/topic_locks.h"

namespace fleetpub::ledger {
namespace {

/// A command writes four frames. Each open reads the log through (about 1 µs per frame), each copy
/// costs 0.4 ms.
constexpr int kLogFrames = 64;
/// Who stays has the log open: for him only the copies count, which wait for the disk twice. 1,000
/// rows write some 1,300 frames. He leaves a short log behind.
constexpr int kLogFramesOfABatch = 8192;
constexpr int kRoundsOfACommand = 8;

class SqliteLedger : public Ledger {
 public:
  /// Without a database: an empty ledger, for reading.
  SqliteLedger(SqliteOptions options, OpenMode mode, std::unique_ptr<Database> database)
      : options_(std::move(options)), mode_(mode), database_(std::move(database)) {}

  SqliteLedger(const SqliteLedger&) = delete;
  SqliteLedger& operator=(const SqliteLedger&) = delete;
  ~SqliteLedger() override {
    if (rounds_ > kRoundsOfACommand && database_->wal_frames() >= kLogFrames) {
      database_->Checkpoint(AfterCheckpoint::kNothingFollows);
    }
  }

  Result<std::unique_ptr<TopicLock>> Lock(std::span<const std::string> topics,
                                          Deadline deadline) override;
  Result<std::vector<Reservation>> Reserve(std::span<const Draft> drafts) override;
  Status RecordOutcomes(std::span<const StatusUpdate> outcomes) override;
  Result<std::uint32_t> Peek(const Draft& draft) override;
  Result<std::vector<Record>> History(const HistoryFilter& filter) override;
  Result<std::optional<Record>> Find(std::int64_t id) override;
  Result<std::int64_t> Prune(WallTime older_than) override;
  Result<LedgerInfo> Describe() override;

 private:
  [[nodiscard]] Status CheckWritable() const;

  SqliteOptions options_;
  OpenMode mode_;
  std::unique_ptr<Database> database_;
  int rounds_ = 0;  // how often outcomes were recorded
};

Status SqliteLedger::CheckWritable() const {
  if (mode_ == OpenMode::kCreate) return {};
  return Fail(ErrorKind::kUnexpected,
              fmt::format("the ledger {} was opened for reading only", options_.path.string()));
}

Result<std::unique_ptr<TopicLock>> SqliteLedger::Lock(std::span<const std::string> topics,
                                                      Deadline deadline) {
  if (Status writable = CheckWritable(); !writable) return Fail(writable.error());
  return LockTopics(database_->path(), topics, deadline);
}

Result<std::vector<Reservation>> SqliteLedger::Reserve(std::span<const Draft> drafts) {
  if (Status writable = CheckWritable(); !writable) return Fail(writable.error());
  database_->Allow(options_.command_timeout);
  return ReserveAll(*database_, options_, drafts);
}

Status SqliteLedger::RecordOutcomes(std::span<const StatusUpdate> outcomes) {
  if (Status writable = CheckWritable(); !writable) return writable;
  const bool any = std::any_of(outcomes.begin(), outcomes.end(),
                               [](const StatusUpdate& outcome) { return outcome.row != 0; });
  database_->Allow(options_.command_timeout);
  const int most = ++rounds_ > kRoundsOfACommand ? kLogFramesOfABatch : kLogFrames;
  if (database_->wal_frames() >= most) {
    database_->Checkpoint(any ? AfterCheckpoint::kCommitFollows : AfterCheckpoint::kNothingFollows);
  }
  return any ? WriteOutcomes(*database_, outcomes) : Status();
}

Result<std::uint32_t> SqliteLedger::Peek(const Draft& draft) {
  if (!database_) {
    return ChooseId(draft, HeaderIdCheckpoints(options_.path).Read(draft.topic), options_.start);
  }
  database_->Allow(options_.command_timeout);
  const Result<std::optional<std::uint32_t>> last = ReadLastId(*database_, draft.topic);
  if (!last) return Fail(last.error());
  return ChooseId(draft, *last, options_.start);
}

Result<std::vector<Record>> SqliteLedger::History(const HistoryFilter& filter) {
  if (!database_) return std::vector<Record>();
  database_->Allow(options_.history_timeout);
  return ReadHistory(*database_, filter);
}

Result<std::optional<Record>> SqliteLedger::Find(std::int64_t id) {
  if (!database_) return std::optional<Record>();
  database_->Allow(options_.history_timeout);
  return FindRecord(*database_, id);
}

Result<std::int64_t> SqliteLedger::Prune(WallTime older_than) {
  if (Status writable = CheckWritable(); !writable) return Fail(writable.error());
  return PruneHistory(*database_, older_than, options_.history_timeout);
}

Result<LedgerInfo> SqliteLedger::Describe() {
  LedgerInfo info{.kind = "SQLite", .place = options_.path.string()};
  if (!database_) return info;
  database_->Allow(options_.history_timeout);
  if (Status counted = CountTables(*database_, info); !counted) return Fail(counted.error());
  for (const char* end : {"", "-wal", "-shm", "-journal", ".locks"}) {
    info.bytes += static_cast<std::int64_t>(GetFileSize(options_.path.string() + end));
  }
  return info;
}

Result<std::unique_ptr<Database>> OpenForWriting(const SqliteOptions& options) {
  const Result<bool> exists = HasLedgerFile(options.path);
  if (!exists) return Fail(exists.error());
  const Journal journal =
      OnNetworkFileSystem(options.path) ? Journal::kRollback : Journal::kWriteAhead;
  if (!*exists) {
    Status created = CreateLedger(options.path, journal, options.busy_timeout);
    if (!created) return Fail(created.error());
  }
  auto database = Database::Open(options.path, Access::kReadWrite, options.busy_timeout);
  if (!database) return database;
  (*database)->Allow(options.command_timeout);
  if (Status ours = Inspect(**database); !ours) return Fail(ours.error());
  if (Status chosen = ChooseJournal(**database, journal); !chosen) return Fail(chosen.error());
  return database;
}

/// SQLite reads a write-ahead log only with shared memory beside it, which it makes if it may.
/// Where it may not, there is nothing to share as long as the log is empty.
Result<std::unique_ptr<Database>> OpenUnshared(const SqliteOptions& options, const Error& refusal) {
  const std::string path = options.path.string();
  if (GetFileSize(path + "-wal") == 0) {
    return Database::Open(options.path, Access::kImmutable, options.busy_timeout);
  }
  return Fail(ErrorKind::kLedger,
              fmt::format("reading {0}-wal takes write permission in its folder: get it, or copy "
                          "{0} and {0}-wal to a folder of your own",
                          path),
              refusal.detail);
}

/// Null: there is nothing to read yet.
Result<std::unique_ptr<Database>> OpenForReading(const SqliteOptions& options) {
  const Result<bool> exists = HasLedgerFile(options.path);
  if (!exists) return Fail(exists.error());
  if (!*exists) return std::unique_ptr<Database>();
  auto database = Database::Open(options.path, Access::kReadOnly, options.busy_timeout);
  if (!database) return database;
  (*database)->Allow(options.command_timeout);
  Status ours = Inspect(**database);
  const bool unshared = !ours && (*database)->LacksSharedMemory();
  if (unshared && FindIrregularFile(options.path).empty()) {
    database = OpenUnshared(options, ours.error());
    if (!database) return database;
    (*database)->Allow(options.command_timeout);
    ours = Inspect(**database);
  }
  if (!ours) return Fail(ours.error());
  return database;
}

}  // namespace

Result<std::unique_ptr<Ledger>> OpenSqlite(SqliteOptions options, OpenMode mode) {
  Result<std::filesystem::path> path = ResolveLinks(options.path);
  if (!path) return Fail(std::move(path.error()));
  options.path = *std::move(path);
  auto database = mode == OpenMode::kCreate ? OpenForWriting(options) : OpenForReading(options);
  if (!database) return Fail(std::move(database.error()));
  return std::make_unique<SqliteLedger>(std::move(options), mode, std::move(*database));
}

}  // namespace fleetpub::ledger
