#include "delivery/batch_publisher.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

namespace fleetpub::delivery {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

ledger::Draft MakeDraft(const message::Command& command, const std::string& broker,
                        base::WallTime now) {
  const message::PayloadTemplate& payload = command.payload;
  return {.topic = command.topic,
          .target = command.target,
          .protocol = command.protocol,
          .version = command.version,
          .broker = broker,
          .actions = command.actions,
          .counted = payload.counted,
          .header_id = command.header_id,
          .expected_header_id = command.expected_header_id,
          .before_id = payload.counted ? payload.before_id : payload.Render(0, now),
          .after_id = payload.counted
                          ? payload.before_time + base::FormatTimestamp(now) + payload.rest
                          : ""};
}

}  // namespace

Status BatchPublisher::Open(std::span<const message::Command> commands, milliseconds lock_timeout,
                            const SentHook& sent) {
  started_ = steady_clock::now();
  for (const message::Command& command : commands) {
    auto admitted = transport_.Admits(command.topic, command.payload.LargestSize(), options_.qos);
    if (!admitted) return admitted;
  }
  auto lock = Lock(commands, lock_timeout);
  if (!lock) return Fail(std::move(lock.error()));
  lock_ = std::move(*lock);
  reports_.reserve(commands.size());
  for (const message::Command& command : commands) reports_.push_back(message::ReportOn(command));
  // The broker may have gone while somebody else held the topic.
  if (auto ready = transport_.AwaitReady(steady_clock::now() + options_.acknowledge_timeout);
      !ready) {
    GiveUp(std::move(ready.error()));
    return {};
  }
  if (auto reserved = Reserve(commands); !reserved) return reserved;
  Publish(sent);
  deadline_ = steady_clock::now() + options_.acknowledge_timeout;
  return {};
}

Result<std::unique_ptr<ledger::TopicLock>> BatchPublisher::Lock(
    std::span<const message::Command> commands, milliseconds lock_timeout) {
  std::vector<std::string> topics;
  topics.reserve(commands.size());
  for (const message::Command& command : commands) topics.push_back(command.topic);
  std::sort(topics.begin(), topics.end());
  topics.erase(std::unique(topics.begin(), topics.end()), topics.end());
  return ledger_.Lock(topics, started_ + lock_timeout);
}

// Nothing was sent, and no id was used.
void BatchPublisher::GiveUp(Error error) {
  for (message::Report& report : reports_) SetError(report, error, "not sent: ");
  broken_ = std::move(error);
}

Status BatchPublisher::Reserve(std::span<const message::Command> commands) {
  const base::WallTime now = options_.now();
  const std::string broker = transport_.server().broker.ToString();
  std::vector<ledger::Draft> drafts;
  drafts.reserve(commands.size());
  for (const message::Command& command : commands)
    drafts.push_back(MakeDraft(command, broker, now));
  const auto reservations = ledger_.Reserve(drafts);
  if (!reservations) return Fail(reservations.error());
  for (std::size_t i = 0; i < reports_.size(); ++i) {
    const ledger::Reservation& reservation = (*reservations)[i];
    if (drafts[i].counted) reports_[i].header_id = reservation.header_id;
    reports_[i].ledger_row = reservation.row;
    reports_[i].payload = ledger::BuildPayload(drafts[i], reservation.header_id);
  }
  return {};
}

void BatchPublisher::Publish(const SentHook& sent) {
  const bool is_burst = reports_.size() > 1;
  if (is_burst) transport_.Cork(true);
  PublishEach(sent);
  if (is_burst) transport_.Cork(false);
}

void BatchPublisher::PublishEach(const SentHook& sent) {
  for (message::Report& report : reports_) {
    if (broken_) {
      SetError(report, *broken_, "not sent: ");
      continue;
    }
    if (!lock_->StillHeld()) {
      SetError(report, {ErrorKind::kLedger, "the ledger ended the lock on the topic"},
               "not sent: ");
      continue;
    }
    // While the window is full, each acknowledgement makes room: the limit is of a single one.
    const auto deadline = steady_clock::now() + options_.acknowledge_timeout;
    auto token = transport_.Publish({report.topic, report.payload, options_.qos}, deadline);
    if (!token) {
      broken_ = std::move(token.error());
      SetError(report, *broken_, "perhaps sent: ");
      report.unacknowledged = true;
      continue;
    }
    if (sent) sent();
    if (options_.qos == mqtt::Qos::kAtMostOnce) {
      SetStatus(report, message::CommandStatus::kSent);
    } else {
      awaited_[*token] = &report;
    }
  }
}

bool BatchPublisher::Take(const mqtt::Acknowledgement& acknowledgement) {
  const auto found = awaited_.find(acknowledgement.token);
  if (found == awaited_.end()) return false;
  if (acknowledgement.Refused()) {
    SetError(*found->second,
             {ErrorKind::kBroker,
              fmt::format("{} refused the message, it was not delivered: {}",
                          transport_.server().broker.ToString(), acknowledgement.reason)},
             "");
  } else {
    SetStatus(*found->second, message::CommandStatus::kPublished);
  }
  awaited_.erase(found);
  deadline_ = steady_clock::now() + options_.acknowledge_timeout;
  return true;
}

Error BatchPublisher::Silence() const {
  return {ErrorKind::kBroker,
          fmt::format("{} did not acknowledge within {}: it may or may not have the message",
                      transport_.server().broker.ToString(),
                      base::FormatElapsed(options_.acknowledge_timeout))};
}

BatchResult BatchPublisher::Close(const Error& reason) {
  if (!awaited_.empty() && !broken_) broken_ = reason;
  for (const auto& [token, report] : std::exchange(awaited_, {})) {
    SetError(*report, *broken_, "sent, but not acknowledged: ");
    report->unacknowledged = true;
  }
  lock_.reset();
  return {std::move(reports_), std::move(broken_)};
}

void BatchPublisher::SetStatus(message::Report& report, message::CommandStatus status) const {
  report.status = status;
  report.elapsed = steady_clock::now() - started_;
}

void BatchPublisher::SetError(message::Report& report, const Error& error,
                              std::string_view prefix) const {
  SetStatus(report, message::CommandStatus::kError);
  report.error = error.kind;
  report.message = fmt::format("{}{}", prefix, error.message);
}

}  // namespace fleetpub::delivery
