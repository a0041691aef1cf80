// A batch: [ lock ─▶ stamp ─▶ record ─▶ publish ─▶ acknowledgements ─▶ unlock ].
//
// One critical section per topic: its lock is taken once the connection stands, ids and rows are
// made durable in one transaction, the messages are written, and the lock is let go, at QoS 1 and 2
// only after the broker's acknowledgement, so that messages arrive in the order of their ids.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "ledger/ledger.h"
#include "message/command.h"
#include "message/report.h"
#include "mqtt/transport.h"

namespace fleetpub::delivery {

struct SendOptions {
  mqtt::Qos qos = mqtt::Qos::kAtMostOnce;
  /// How long somebody else may hold a topic before we give up (ErrorKind::kLedger, nothing sent).
  std::chrono::milliseconds lock_timeout{5'000};
  /// How long the broker may take to accept or acknowledge a message.
  std::chrono::milliseconds acknowledge_timeout{10'000};
  /// So many commands share a lock, a transaction and a burst. A default broker queues 1,000
  /// messages for a client and drops the rest; an operator's own pause waits for one batch at most.
  std::size_t batch = 500;
  std::function<base::WallTime()> now = base::WallTime::clock::now;
};

/// Called with each message that has left, before its outcome is known: what an interrupted command
/// must tell.
using SentHook = std::function<void()>;

/// What became of a batch: a report per command, in order.
struct BatchResult {
  std::vector<message::Report> reports;
  /// The connection is of no further use.
  std::optional<Error> broken;
};

/// One batch on its way. Holds its topics from Open to Close, or until it is destroyed. The
/// transport, the ledger and the options must outlive it; the commands are needed by Open only.
class BatchPublisher {
 public:
  BatchPublisher(mqtt::Transport& transport, ledger::Ledger& ledger, const SendOptions& options)
      : transport_(transport), ledger_(ledger), options_(options) {}

  /// Locks, stamps, records and writes. Errors: nothing was sent, and no id was used.
  [[nodiscard]] Status Open(std::span<const message::Command> commands,
                            std::chrono::milliseconds lock_timeout, const SentHook& sent);

  /// Messages that have left and are not acknowledged yet; none at QoS 0.
  [[nodiscard]] std::size_t awaited() const { return awaited_.size(); }
  /// Until when the acknowledgements may come.
  [[nodiscard]] mqtt::Deadline deadline() const { return deadline_; }

  /// False when the message is not one of this batch.
  bool Take(const mqtt::Acknowledgement& acknowledgement);

  /// Lets the topics go. `reason` tells why acknowledgements that are still awaited will not come.
  [[nodiscard]] BatchResult Close(const Error& reason);
  [[nodiscard]] Error Silence() const;

 private:
  [[nodiscard]] Result<std::unique_ptr<ledger::TopicLock>> Lock(
      std::span<const message::Command> commands, std::chrono::milliseconds lock_timeout);
  void GiveUp(Error error);
  [[nodiscard]] Status Reserve(std::span<const message::Command> commands);
  void Publish(const SentHook& sent);
  void PublishEach(const SentHook& sent);
  void SetStatus(message::Report& report, message::CommandStatus status) const;
  void SetError(message::Report& report, const Error& error, std::string_view prefix) const;

  mqtt::Transport& transport_;
  ledger::Ledger& ledger_;
  const SendOptions& options_;
  std::unique_ptr<ledger::TopicLock> lock_;
  std::chrono::steady_clock::time_point started_;
  mqtt::Deadline deadline_;
  std::vector<message::Report> reports_;
  std::map<int, message::Report*> awaited_;  // by token
  std::optional<Error> broken_;
};

}  // namespace fleetpub::delivery
