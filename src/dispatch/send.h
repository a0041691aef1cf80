// The second half of a command's way: [ stamp ─▶ record ─▶ publish ] ─▶ record the outcome ─▶
// report.
//
// The bracket is one critical section per topic: its lock is taken once the connection stands, ids
// and rows are made durable in one transaction, the messages are written, and the lock is let go,
// at QoS 1 and 2 only after the broker's acknowledgement, so that messages arrive in the order of
// their ids.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "base/time.h"
#include "dispatch/command.h"
#include "dispatch/report.h"
#include "ledger/ledger.h"
#include "mqtt/transport.h"

namespace fleetpub::dispatch {

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

/// Called with each report as it becomes known.
using ReportSink = std::function<void(const Report&)>;
/// Called with each message that has left, before its outcome is known: what an interrupted command
/// must tell.
using SentHook = std::function<void()>;

/// What became of a batch: a report per command, in order.
struct BatchResult {
  std::vector<Report> reports;
  /// The connection is of no further use.
  std::optional<Error> broken;
};

/// One batch through the bracket. Its outcomes are not recorded yet. Errors: nothing of it was
/// sent.
[[nodiscard]] Result<BatchResult> SendBatch(std::span<const Command> commands,
                                            mqtt::Transport& transport, ledger::Ledger& ledger,
                                            const SendOptions& options, const SentHook& sent);

/// Sends valid commands over an open connection. Every command gets a report, in order. When a
/// batch cannot be reserved or the connection is lost, its reports and those of the following say
/// so; nothing is sent twice. Returns the trouble after sending that changes no verdict (an outcome
/// that could not be recorded), if any.
[[nodiscard]] Status Send(std::span<const Command> commands, mqtt::Transport& transport,
                          ledger::Ledger& ledger, const SendOptions& options,
                          const ReportSink& report, const SentHook& sent = {});

/// Puts the reports' verdicts into the audit trail.
[[nodiscard]] Status RecordOutcomes(std::span<const Report> reports, ledger::Ledger& ledger);

/// Tells that nothing was sent to these, and why.
void ReportNotSent(std::span<const Command> commands, const Error& error, const ReportSink& sink);

/// A report with everything that the command already tells.
[[nodiscard]] Report ReportOn(const Command& command);

}  // namespace fleetpub::dispatch
