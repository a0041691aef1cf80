// The ledger over PostgreSQL.
//
// What must hold (ledger.h), and what makes it hold:
//
// 1. No id twice, none backwards. One statement writes the topics' ids, each only in place of the
//    one that its writer took for the last (postgres_reservation.h). This rests on the rows of
//    header_ids alone, not on the topics' locks.
//
// 2. Nothing is sent that is not recorded. The same statement writes the rows and is a transaction
//    by itself; it is answered once the commit is on the server's disk (synchronous_commit, which a
//    session of ours never leaves off). When the answer does not come, nobody knows whether it was
//    committed: nothing is sent, and nothing reserved again; at worst there is a gap and a row that
//    says RECORDED.
//
// 3. Messages leave in the order of their ids. A topic's lock is an advisory lock of the *session*:
//    it outlives transactions, and ends with the connection, however its holder dies. While it is
//    held, no transaction is open: a sender that stalls keeps its topics, and keeps nobody from
//    others.
//
//      Lock ──locked, last ids read──▶ Reserve ──committed──▶ messages leave ──▶ unlock (posted)
//
//    A server that ends takes the locks with it, perhaps between Reserve and sending. StillHeld
//    tells: such a server says so, or closes the connection, before it gives the lock away. A host
//    that is cut off without a word loses its locks when the server gives it up, later than it
//    may still be sending (postgres_schema.cc).
//
// 4. A lost connection is replaced where nothing can be doubled: before locking, for reading, and
//    for outcomes, which are the same when written twice. Never between Lock and Reserve.
//
// A pool that hands its connections round by transaction (PgBouncer, pool_mode=transaction) breaks
// 3: lock and reservation come from two server processes, or two of us share one and get the same
// locks. So who locks writes its mark into the server's session and looks whose mark stands there:
// that of another is noticed and refused.
#include "ledger/postgres/postgres_ledger.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <thread>
#include <utility>

#include "base/time.h"
#include "base/uuid.h"
#include "ledger/header_ids.h"
#include "ledger/postgres/postgres_error.h"
#include "ledger/postgres/postgres_history.h"
#include "ledger/postgres/postgres_reservation.h"
#include "ledger/postgres/postgres_schema.h"
#include "ledger/postgres/postgres_session.h"
#include "ledger/postgres/postgres_url.h"

namespace fleetpub::ledger {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

/// Between two attempts to connect.
constexpr milliseconds kPause{50};
/// The server's own answer to a wait that ends needs a moment.
constexpr milliseconds kGrace{2'000};
/// A whole history takes longer to read than a command may wait.
constexpr milliseconds kReading{60'000};
/// Without the topics' locks somebody may be faster; with them nobody is.
constexpr int kAttempts = 20;

// Whose session of the server this is: ours from now on, unless it is another's.
constexpr std::string_view kClaim =
    "SELECT coalesce(nullif(current_setting('fleetpub.holder', true), ''), "
    "set_config('fleetpub.holder', $1, false))";

// Takes what is free at once; waits for the rest until $2 milliseconds have passed since the
// beginning, a millisecond at least.
constexpr std::string_view kLock =
    "SELECT count(CASE WHEN pg_try_advisory_lock(key) THEN '' ELSE set_config('lock_timeout', "
    "greatest(1, $2::bigint - (extract(epoch FROM clock_timestamp() - statement_timestamp()) "
    "* 1000)::bigint)::text, true) || pg_advisory_lock(key)::text END), pg_backend_pid() "
    "FROM unnest($1::bigint[]) AS key WHERE current_setting('fleetpub.holder') = $3";

// The first of these that another session has, and who that is.
constexpr std::string_view kHolder =
    "SELECT wanted.place, coalesce(a.application_name, '') FROM pg_locks AS l "
    "JOIN unnest($1::bigint[]) WITH ORDINALITY AS wanted(key, place) "
    "ON l.classid::bigint = ((wanted.key >> 32) & 4294967295) "
    "AND l.objid::bigint = (wanted.key & 4294967295) AND l.objsubid = 1 "
    "LEFT JOIN pg_stat_activity AS a ON a.pid = l.pid WHERE l.locktype = 'advisory' AND l.granted "
    "AND l.database = (SELECT oid FROM pg_database WHERE datname = current_database()) "
    "AND l.pid <> pg_backend_pid() ORDER BY wanted.place LIMIT 1";

// A claim that was rolled back has left no mark, but perhaps locks.
constexpr std::string_view kUnlock =
    "SELECT pg_advisory_unlock_all(), set_config('fleetpub.holder', '', false) "
    "WHERE coalesce(current_setting('fleetpub.holder', true), '') IN ('', $1)";

Error PoolRefusal(const Session& session) {
  return {ErrorKind::kLedger,
          fmt::format("the ledger {} is reached through a pool that changes connections between "
                      "transactions: use one in session mode, or none",
                      session.place())};
}

/// From locking to unlocking.
struct BatchPublisher {
  BatchPublisher(std::shared_ptr<Session> connection, int server_process, std::string our_mark)
      : session(std::move(connection)), backend(server_process), mark(std::move(our_mark)) {}
  BatchPublisher(const BatchPublisher&) = delete;
  BatchPublisher& operator=(const BatchPublisher&) = delete;
  /// Nobody waits for the answer: the server does it before whatever comes next.
  ~BatchPublisher() { session->Post({kUnlock, {mark}}); }

  std::shared_ptr<Session> session;
  int backend;
  std::string mark;
  LastIds last_ids;  ///< of the locked topics
};

class HeldTopics : public TopicLock {
 public:
  explicit HeldTopics(std::shared_ptr<BatchPublisher> batch) : publisher_(std::move(batch)) {}
  [[nodiscard]] bool StillHeld() const override {
    return !publisher_->session->lost() && publisher_->session->IsQuiet();
  }

 private:
  std::shared_ptr<BatchPublisher> publisher_;
};

/// Everybody goes upwards: whoever waits holds only lower keys than the one that he waits for.
struct Keys {
  explicit Keys(std::span<const std::string> topics) {
    for (const std::string& topic : topics) all.emplace_back(LockKey(topic), topic);
    std::sort(all.begin(), all.end());
  }
  [[nodiscard]] std::string Array() const {
    ArrayText array;
    for (const auto& [key, topic] : all) array.Add(std::to_string(key));
    return array.Take();
  }
  std::vector<std::pair<std::int64_t, std::string_view>> all;
};

class PostgresLedger : public Ledger {
 public:
  PostgresLedger(PostgresOptions options, OpenMode mode)
      : options_(std::move(options)), mode_(mode) {
    session_options_.url = options_.url;
    session_options_.password = options_.password;
    session_options_.name = fmt::format("fleetpub {}@{}", options_.user, options_.host);
    session_options_.connect_timeout = options_.connect_timeout;
    session_options_.writable = mode == OpenMode::kCreate;
  }

  /// Once, before anything else.
  [[nodiscard]] Status Open();

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
  [[nodiscard]] Status Connect();
  [[nodiscard]] Deadline Patience() const { return steady_clock::now() + options_.patience; }

  /// Does it on a session that stands. When the session was lost under it, once more on a new one,
  /// and again until the deadline: only for what may be done twice.
  template <typename Work>
  auto Persist(Deadline deadline, Work work) -> decltype(work(std::declval<Session&>()));

  [[nodiscard]] Result<std::unique_ptr<TopicLock>> TryLock(std::span<const std::string> topics,
                                                           const Keys& keys, Deadline deadline);
  [[nodiscard]] Error Refusal(const Keys& keys, steady_clock::duration waited);
  [[nodiscard]] Status LearnLastIds(Session& session, std::span<const Draft> drafts,
                                    LastIds& last_ids) const;

  PostgresOptions options_;
  OpenMode mode_;
  SessionOptions session_options_;
  std::string mark_ = base::RandomUuid();  ///< who holds what
  std::shared_ptr<Session> session_;
  std::weak_ptr<BatchPublisher> publisher_;
  bool is_there_ = false;  // false: no tables yet, for reading
  /// Since when there is no connection: an outage is waited out once, not by every call.
  std::optional<steady_clock::time_point> lost_since_;
};

Status PostgresLedger::CheckWritable() const {
  if (mode_ == OpenMode::kCreate) return {};
  return Fail(ErrorKind::kLedger, "the ledger was opened for reading");
}

Status PostgresLedger::Connect() {
  auto session = Session::Connect(session_options_);
  if (!session) return Fail(std::move(session.error()));
  const Result<int> version = PrepareSession(**session, Patience());
  if (!version) return Fail(version.error());
  is_there_ = *version > 0;
  session_ = std::move(*session);
  return {};
}

Status PostgresLedger::Open() {
  if (Status connected = Connect(); !connected) return connected;
  if (is_there_ || mode_ == OpenMode::kReadOnly) return {};
  if (Status made = MigrateTables(*session_, Patience() + options_.patience); !made) return made;
  is_there_ = true;
  return {};
}

template <typename Work>
auto PostgresLedger::Persist(Deadline deadline, Work work)
    -> decltype(work(std::declval<Session&>())) {
  for (bool first = true;; first = false) {
    const bool stands = session_ && !session_->lost();
    Status connected = stands ? Status() : Connect();
    if (connected) {
      lost_since_.reset();
      auto done = work(*session_);
      if (done || !session_->lost()) return done;
      connected = Fail(std::move(done.error()));
      if (first && stands) continue;  // it was lost long ago, perhaps
    }
    const auto now = steady_clock::now();
    if (!lost_since_) lost_since_ = now;
    if (now >= std::min(deadline, *lost_since_ + options_.patience)) {
      return Fail(std::move(connected.error()));
    }
    std::this_thread::sleep_until(std::min(deadline, now + kPause));
  }
}

Result<std::unique_ptr<TopicLock>> PostgresLedger::Lock(std::span<const std::string> topics,
                                                        Deadline deadline) {
  if (Status writable = CheckWritable(); !writable) return Fail(writable.error());
  if (!publisher_.expired()) {
    return Fail(ErrorKind::kUnexpected, "topics are locked already, by this very command");
  }
  const Keys keys(topics);
  return Persist(deadline, [&](Session&) { return TryLock(topics, keys, deadline); });
}

Result<std::unique_ptr<TopicLock>> PostgresLedger::TryLock(std::span<const std::string> topics,
                                                           const Keys& keys, Deadline deadline) {
  const auto started = steady_clock::now();
  const auto wait = std::chrono::duration_cast<milliseconds>(deadline - started).count();
  const std::array<Query, 3> queries = {
      Query{kClaim, {mark_}},
      Query{kLock, {keys.Array(), std::to_string(std::max<milliseconds::rep>(wait, 1)), mark_}},
      ReadingLastIds(topics)};
  const auto rows = session_->Run(queries, std::max(deadline, started) + kGrace);
  if (!rows) {
    const bool held = session_->state() == sql_state::kLockNotAvailable;
    session_->Post({kUnlock, {mark_}});  // those that it had got
    return Fail(held ? Refusal(keys, steady_clock::now() - started) : rows.error());
  }
  if (rows->front().Text(0, 0) != mark_) return Fail(PoolRefusal(*session_));
  const int backend = static_cast<int>((*rows)[1].Integer(0, 1));
  auto batch = std::make_shared<BatchPublisher>(session_, backend, mark_);
  for (const std::string& topic : topics) batch->last_ids[topic];
  TakeLastIds(rows->back(), batch->last_ids);
  publisher_ = batch;
  return std::make_unique<HeldTopics>(std::move(batch));
}

Error PostgresLedger::Refusal(const Keys& keys, steady_clock::duration waited) {
  const auto rows = session_->Run(Query{kHolder, {keys.Array()}}, steady_clock::now() + kGrace);
  std::string what = "one of the topics";
  std::string who = "another fleetpub";
  if (rows && rows->count() > 0) {
    what =
        fmt::format("topic {}", keys.all[static_cast<std::size_t>(rows->Integer(0, 0)) - 1].second);
    if (const std::string name = rows->Text(0, 1); !name.empty()) {
      who = fmt::format("another fleetpub ({})", name);
    }
  }
  return {ErrorKind::kLedger,
          fmt::format("{} has held {} for {}: try again", who, what, base::FormatElapsed(waited))};
}

Status PostgresLedger::LearnLastIds(Session& session, std::span<const Draft> drafts,
                                    LastIds& last_ids) const {
  std::vector<std::string> unknown;
  for (const Draft& draft : drafts) {
    if (draft.counted && last_ids.try_emplace(draft.topic).second) unknown.push_back(draft.topic);
  }
  if (unknown.empty()) return {};
  const auto rows = session.Run(ReadingLastIds(unknown), Patience());
  if (!rows) return Fail(rows.error());
  TakeLastIds(*rows, last_ids);
  return {};
}

Result<std::vector<Reservation>> PostgresLedger::Reserve(std::span<const Draft> drafts) {
  if (Status writable = CheckWritable(); !writable) return Fail(writable.error());
  const std::shared_ptr<BatchPublisher> batch = publisher_.lock();
  const std::shared_ptr<Session> session = batch ? batch->session : session_;
  LastIds unlocked;
  LastIds& last_ids = batch ? batch->last_ids : unlocked;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (Status learnt = LearnLastIds(*session, drafts, last_ids); !learnt) {
      return Fail(std::move(learnt.error()));
    }
    Result<Plan> plan = MakePlan(drafts, last_ids, options_.start);
    if (!plan) return Fail(std::move(plan.error()));
    const auto written = WritePlan(*session, options_, drafts, *plan, last_ids, Patience());
    if (!written) return Fail(written.error());
    if (batch && written->backend != batch->backend) {
      return Fail(PoolRefusal(*session));
    }
    if (!written->taken) {
      last_ids.clear();
      continue;
    }
    for (auto& [topic, id] : plan->next) last_ids[topic] = id;
    std::vector<Reservation> reservations;
    reservations.reserve(drafts.size());
    for (std::size_t i = 0; i < drafts.size(); ++i) {
      reservations.push_back({written->rows.empty() ? 0 : written->rows[i], plan->ids[i]});
    }
    return reservations;
  }
  return Fail(ErrorKind::kLedger,
              fmt::format("somebody else counts the same topics in the ledger {} without locking "
                          "them: try again",
                          session->place()));
}

Status PostgresLedger::RecordOutcomes(std::span<const StatusUpdate> outcomes) {
  if (Status writable = CheckWritable(); !writable) return writable;
  return Persist(Patience(),
                 [&](Session& session) { return WriteOutcomes(session, outcomes, Patience()); });
}

Result<std::uint32_t> PostgresLedger::Peek(const Draft& draft) {
  const std::array<std::string, 1> topics = {draft.topic};
  return Persist(Patience(), [&](Session& session) -> Result<std::uint32_t> {
    LastIds last_ids{{topics.front(), std::nullopt}};
    if (is_there_) {
      const auto rows = session.Run(ReadingLastIds(topics), Patience());
      if (!rows) return Fail(rows.error());
      TakeLastIds(*rows, last_ids);
    }
    return ChooseId(draft, last_ids.begin()->second, options_.start);
  });
}

Result<std::vector<Record>> PostgresLedger::History(const HistoryFilter& filter) {
  if (!is_there_) return std::vector<Record>();
  return Persist(Patience(), [&](Session& session) {
    return ReadHistory(session, filter, steady_clock::now() + kReading);
  });
}

Result<std::optional<Record>> PostgresLedger::Find(std::int64_t id) {
  if (!is_there_) return std::optional<Record>();
  return Persist(Patience(), [&](Session& session) { return FindRecord(session, id, Patience()); });
}

Result<std::int64_t> PostgresLedger::Prune(WallTime older_than) {
  if (Status writable = CheckWritable(); !writable) return Fail(writable.error());
  return PruneHistory(*session_, older_than, kReading);
}

Result<LedgerInfo> PostgresLedger::Describe() {
  if (!is_there_) return LedgerInfo{.kind = "PostgreSQL", .place = session_->place()};
  return Persist(Patience(), [&](Session& session) {
    return DescribeTables(session, steady_clock::now() + kReading);
  });
}

}  // namespace

Result<std::unique_ptr<Ledger>> OpenPostgres(PostgresOptions options, OpenMode mode) {
  if (Status right = CheckPostgresUrl(options.url); !right) return Fail(std::move(right.error()));
  auto ledger = std::make_unique<PostgresLedger>(std::move(options), mode);
  if (Status opened = ledger->Open(); !opened) return Fail(std::move(opened.error()));
  return ledger;
}

}  // namespace fleetpub::ledger
