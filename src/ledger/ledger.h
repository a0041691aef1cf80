// Header ids and the audit trail: what was sent, by whom, to which robot, with which outcome.
//
// Invariants, on every topic and over processes, crashes (`kill -9` at any moment), reboots and
// parallel use:
//   1. a header id is never given twice and never runs backwards (it wraps at 2^32);
//   2. Reserve returns only when ids and rows are durable: nothing is sent that is not recorded;
//   3. whoever holds a topic's lock is the only one who reserves and writes on that topic, so that
//      messages leave in the order of their ids.
// Gaps are allowed (a receiver reads them as a lost message); repeats are not.
//
// Threads: a Ledger belongs to one thread. Processes share the store, not the object.
// Errors: ErrorKind::kLedger with the ledger's place and how to repair it.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "message/command.h"

namespace fleetpub::ledger {

using Deadline = std::chrono::steady_clock::time_point;
using WallTime = std::chrono::system_clock::time_point;

using message::ActionRef;

/// A message about to be sent. The payload is `before_id` + decimal header id + `after_id`, or
/// `before_id` alone when the message is not counted (SoAR has no header ids).
struct Draft {
  std::string topic;   ///< the full MQTT topic: header ids are counted per topic
  std::string target;  ///< as people name it: `KIT/0001`
  std::string protocol;
  std::string version;
  std::string broker;  ///< never with credentials
  std::vector<ActionRef> actions;
  bool counted = true;
  /// Asked for outright; must lie above the topic's last one (any may follow 4294967295).
  std::optional<std::uint32_t> header_id;
  /// Must be the topic's next one: nobody has sent there since it was peeked at.
  std::optional<std::uint32_t> expected_header_id = {};
  std::string before_id;
  std::string after_id;
};

struct Reservation {
  std::int64_t row = 0;         ///< for RecordOutcomes; 0 when history is off
  std::uint32_t header_id = 0;  ///< 0 when the draft is not counted
};

/// What became of a recorded message. `status` is a status name of the manual ("SENT",
/// "FINISHED" …).
struct StatusUpdate {
  std::int64_t row = 0;
  std::string status;
  std::string detail;
};

/// A row of the audit trail.
struct Record {
  std::int64_t id = 0;
  WallTime recorded_at;
  std::optional<WallTime> outcome_at;
  std::string user;
  std::string host;
  std::string profile;
  std::string broker;
  std::string target;
  std::string protocol;
  std::string version;
  std::string topic;
  std::optional<std::uint32_t> header_id;
  std::vector<ActionRef> actions;
  std::string payload;
  /// "RECORDED" until an outcome is known: the process ended in between, and whether the message
  /// left is unknown.
  std::string status;
  std::string detail;
};

struct HistoryFilter {
  std::string target = {};  ///< exact; empty: all
  std::string action = {};  ///< an action type, exact; empty: all
  std::string status = {};
  std::string user = {};
  std::vector<std::string> brokers = {};   ///< one of these; empty: all
  std::optional<WallTime> since = {};      ///< from this moment
  std::optional<WallTime> until = {};      ///< before this moment
  std::optional<std::int64_t> below = {};  ///< only rows of a smaller number
  int limit = 50;                          ///< the newest so many, returned oldest first; 0: all
};

/// What there is, for who looks after it.
struct LedgerInfo {
  std::string kind;   ///< "SQLite", "PostgreSQL"
  std::string place;  ///< a path, or a URL without secrets
  int version = 0;    ///< of the tables; 0: there are none yet
  std::int64_t rows = 0;
  std::int64_t topics = 0;  ///< that have a header id
  std::int64_t bytes = 0;   ///< on the disk, with everything that belongs to it
};

/// Held from reserving to writing. Released by the destructor, and by the system when the process
/// dies. Independent of the Ledger that gave it. A forked child holds it too, until it ends or
/// starts another program.
///
/// A Ledger may give several. One that cannot (PostgreSQL) refuses the second at once.
class TopicLock {
 public:
  TopicLock() = default;
  TopicLock(const TopicLock&) = delete;
  TopicLock& operator=(const TopicLock&) = delete;
  virtual ~TopicLock() = default;

  /// False once the store has, or may have, taken it back: nothing more may be sent. Asks nobody,
  /// and is cheap enough to be called before each message.
  [[nodiscard]] virtual bool StillHeld() const { return true; }
};

class Ledger {
 public:
  Ledger() = default;
  Ledger(const Ledger&) = delete;
  Ledger& operator=(const Ledger&) = delete;
  virtual ~Ledger() = default;

  /// Locks all these topics (in an order of its own, so that two callers cannot wait for each
  /// other), or none. Blocks until the deadline at most, but tries each topic at least once. The
  /// error at the deadline names a topic that somebody else holds. Who locks a topic twice waits
  /// for himself.
  [[nodiscard]] virtual Result<std::unique_ptr<TopicLock>> Lock(std::span<const std::string> topics,
                                                                Deadline deadline) = 0;

  /// Gives each draft the next header id of its topic and records it, all in one durable
  /// transaction: all of them or none. The caller holds the topics' locks. Ids asked for outright
  /// at or below the last one are refused (ErrorKind::kUsage), naming the last.
  [[nodiscard]] virtual Result<std::vector<Reservation>> Reserve(std::span<const Draft> drafts) = 0;

  /// Outcomes of row 0 are passed over; a later one of the same row replaces the earlier. Does not
  /// wait for the disk: a power failure may take outcomes back, never ids or rows. Also keeps the
  /// store tidy: call it once per command even when history is off.
  [[nodiscard]] virtual Status RecordOutcomes(std::span<const StatusUpdate> outcomes) = 0;

  /// The id that Reserve would give this draft, or its refusal; reserves nothing and creates nothing.
  [[nodiscard]] virtual Result<std::uint32_t> Peek(const Draft& draft) = 0;
  [[nodiscard]] Result<std::uint32_t> PeekNext(std::string_view topic) {
    return Peek(Draft{.topic = std::string(topic)});
  }

  [[nodiscard]] virtual Result<std::vector<Record>> History(const HistoryFilter& filter) = 0;
  /// Nothing when there is no such row.
  [[nodiscard]] virtual Result<std::optional<Record>> Find(std::int64_t id) = 0;
  /// Removes rows recorded before this time, never the header ids. Returns how many.
  [[nodiscard]] virtual Result<std::int64_t> Prune(WallTime older_than) = 0;

  [[nodiscard]] virtual Result<LedgerInfo> Describe() = 0;
};

/// The payload of a draft with its id in place.
[[nodiscard]] std::string BuildPayload(const Draft& draft, std::uint32_t header_id);

}  // namespace fleetpub::ledger
