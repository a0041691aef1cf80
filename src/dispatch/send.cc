#include "dispatch/send.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace fleetpub::dispatch {
namespace {

using std::chrono::steady_clock;

ledger::Draft DraftOf(const Command& command, const std::string& broker, base::WallTime now) {
  const PayloadTemplate& payload = command.payload;
  return {.topic = command.topic,
          .target = command.target,
          .protocol = command.protocol,
          .version = command.version,
          .broker = broker,
          .actions = command.actions,
          .counted = payload.counted,
          .header_id = command.header_id,
          .before_id = payload.counted ? payload.before_id : payload.Render(0, now),
          .after_id = payload.counted
                          ? payload.before_time + base::FormatTimestamp(now) + payload.rest
                          : ""};
}

// One batch on its way; the members are filled from top to bottom.
class Batch {
 public:
  Batch(std::span<const Command> commands, mqtt::Transport& transport, ledger::Ledger& ledger,
        const SendOptions& options)
      : commands_(commands), transport_(transport), ledger_(ledger), options_(options) {
    for (const Command& command : commands_) reports_.push_back(ReportOn(command));
  }

  // Errors: nothing of this batch was sent.
  Status Run(const SentHook& sent) {
    started_ = steady_clock::now();
    for (const Command& command : commands_) {
      auto admitted = transport_.Admits(command.topic, command.payload.LargestSize(), options_.qos);
      if (!admitted) return admitted;
    }
    auto lock = Lock();
    if (!lock) return Fail(std::move(lock.error()));
    lock_ = lock->get();
    // The broker may have gone while somebody else held the topic.
    if (auto ready = transport_.AwaitReady(steady_clock::now() + options_.acknowledge_timeout);
        !ready) {
      return GiveUp(std::move(ready.error()));
    }
    if (auto reserved = Reserve(); !reserved) return reserved;
    Publish(sent);
    if (options_.qos != mqtt::Qos::kAtMostOnce) AwaitAcknowledgements();
    return {};
  }

  // Afterwards: a report per command, and the first trouble with the connection.
  [[nodiscard]] BatchResult Take() { return {std::move(reports_), std::move(broken_)}; }

 private:
  Result<std::unique_ptr<ledger::TopicLock>> Lock() {
    std::vector<std::string> topics;
    for (const Command& command : commands_) topics.push_back(command.topic);
    std::sort(topics.begin(), topics.end());
    topics.erase(std::unique(topics.begin(), topics.end()), topics.end());
    return ledger_.Lock(topics, started_ + options_.lock_timeout);
  }

  // Nothing was sent, and no id was used.
  Status GiveUp(Error error) {
    for (Report& report : reports_) SetError(report, error, "not sent: ");
    broken_ = std::move(error);
    return {};
  }

  Status Reserve() {
    const base::WallTime now = options_.now();
    const std::string broker = transport_.server().broker.ToString();
    for (const Command& command : commands_) drafts_.push_back(DraftOf(command, broker, now));
    auto reservations = ledger_.Reserve(drafts_);
    if (!reservations) return Fail(std::move(reservations.error()));
    reservations_ = std::move(*reservations);
    for (std::size_t i = 0; i < reports_.size(); ++i) {
      if (drafts_[i].counted) reports_[i].header_id = reservations_[i].header_id;
      reports_[i].ledger_row = reservations_[i].row;
      reports_[i].payload = ledger::PayloadOf(drafts_[i], reservations_[i].header_id);
    }
    return {};
  }

  void Publish(const SentHook& sent) {
    const auto deadline = steady_clock::now() + options_.acknowledge_timeout;
    // At QoS 1 and 2 a full window would wait for what is held back.
    const bool is_burst = options_.qos == mqtt::Qos::kAtMostOnce && reports_.size() > 1;
    if (is_burst) transport_.Cork(true);
    PublishEach(sent, deadline);
    if (is_burst) transport_.Cork(false);
  }

  void PublishEach(const SentHook& sent, mqtt::Deadline deadline) {
    for (Report& report : reports_) {
      if (broken_) {
        SetError(report, *broken_, "not sent: ");
        continue;
      }
      if (!lock_->StillHeld()) {
        SetError(report, {ErrorKind::kLedger, "the ledger ended the lock on the topic"},
                 "not sent: ");
        continue;
      }
      auto token = transport_.Publish({report.topic, report.payload, options_.qos}, deadline);
      if (!token) {
        broken_ = std::move(token.error());
        SetError(report, *broken_, "perhaps sent: ");
        continue;
      }
      if (sent) sent();
      if (options_.qos == mqtt::Qos::kAtMostOnce) {
        SetVerdict(report, Verdict::kSent);
      } else {
        awaited_[*token] = &report;
      }
    }
  }

  void AwaitAcknowledgements() {
    const auto deadline = steady_clock::now() + options_.acknowledge_timeout;
    auto acknowledgements = transport_.AwaitAcknowledgements(deadline);
    if (acknowledgements) {
      for (const mqtt::Acknowledgement& acknowledgement : *acknowledgements) {
        Settle(acknowledgement);
      }
    } else if (!broken_) {
      broken_ = std::move(acknowledgements.error());
    }
    const Error silence{ErrorKind::kBroker,
                        fmt::format("{} did not acknowledge within {}: it may or may not have the "
                                    "message",
                                    transport_.server().broker.ToString(),
                                    base::FormatElapsed(options_.acknowledge_timeout))};
    for (auto& [token, report] : awaited_) {
      SetError(*report, broken_ ? *broken_ : silence, "sent, but not acknowledged: ");
    }
    if (!awaited_.empty() && !broken_) broken_ = silence;
  }

  void Settle(const mqtt::Acknowledgement& acknowledgement) {
    const auto found = awaited_.find(acknowledgement.token);
    if (found == awaited_.end()) return;
    if (acknowledgement.Refused()) {
      SetError(*found->second,
               {ErrorKind::kBroker,
                fmt::format("{} refused the message: {}", transport_.server().broker.ToString(),
                            acknowledgement.reason)},
               "");
    } else {
      SetVerdict(*found->second, Verdict::kPublished);
    }
    awaited_.erase(found);
  }

  void SetVerdict(Report& report, Verdict verdict) const {
    report.verdict = verdict;
    report.elapsed = steady_clock::now() - started_;
  }

  void SetError(Report& report, const Error& error, std::string_view prefix) const {
    SetVerdict(report, Verdict::kError);
    report.error = error.kind;
    report.message = fmt::format("{}{}", prefix, error.message);
  }

  std::span<const Command> commands_;
  mqtt::Transport& transport_;
  ledger::Ledger& ledger_;
  const SendOptions& options_;
  const ledger::TopicLock* lock_ = nullptr;  // while Run runs
  steady_clock::time_point started_;
  std::vector<Report> reports_;
  std::vector<ledger::Draft> drafts_;
  std::vector<ledger::Reservation> reservations_;
  std::map<int, Report*> awaited_;
  std::optional<Error> broken_;
};

}  // namespace

Report ReportOn(const Command& command) {
  return {.reference = command.reference,
          .target = command.target,
          .protocol = command.protocol,
          .version = command.version,
          .version_assumed = command.version_assumed,
          .topic = command.topic,
          .actions = command.actions};
}

void ReportNotSent(std::span<const Command> commands, const Error& error, const ReportSink& sink) {
  for (const Command& command : commands) {
    Report report = ReportOn(command);
    report.error = error.kind;
    report.message = "not sent: " + error.message;
    sink(report);
  }
}

Status RecordOutcomes(std::span<const Report> reports, ledger::Ledger& ledger) {
  std::vector<ledger::Outcome> outcomes;
  outcomes.reserve(reports.size());
  for (const Report& report : reports) {
    if (report.ledger_row == 0) continue;  // it came to nothing before it was recorded
    outcomes.push_back({report.ledger_row, std::string(NameOf(report.verdict)), report.message});
  }
  return ledger.RecordOutcomes(outcomes);
}

Result<BatchResult> SendBatch(std::span<const Command> commands, mqtt::Transport& transport,
                              ledger::Ledger& ledger, const SendOptions& options,
                              const SentHook& sent) {
  Batch batch(commands, transport, ledger, options);
  if (auto ran = batch.Run(sent); !ran) return Fail(std::move(ran.error()));
  return batch.Take();
}

Status Send(std::span<const Command> commands, mqtt::Transport& transport, ledger::Ledger& ledger,
            const SendOptions& options, const ReportSink& report, const SentHook& sent) {
  Status trouble;
  while (!commands.empty()) {
    const std::size_t count = std::min(options.batch, commands.size());
    const auto batch = SendBatch(commands.first(count), transport, ledger, options, sent);
    if (!batch) {
      ReportNotSent(commands, batch.error(), report);
      return trouble;
    }
    commands = commands.subspan(count);
    if (auto recorded = RecordOutcomes(batch->reports, ledger); !recorded && trouble) {
      trouble = recorded;
    }
    for (const Report& done : batch->reports) report(done);
    if (batch->broken) {
      ReportNotSent(commands, *batch->broken, report);
      return trouble;
    }
  }
  return trouble;
}

}  // namespace fleetpub::dispatch
