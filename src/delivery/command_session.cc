#include "delivery/command_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/text.h"

namespace fleetpub::delivery {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

// So long a silence means that the answers to come take their time: more may be sent.
constexpr milliseconds kQuiet{20};
// A fleet that reports all the time is never silent.
constexpr milliseconds kLongestPause{500};
// Messages that are read before somebody else gets his turn.
constexpr int kTurn = 100;
// So many subscriptions may stay behind commands that have ended. mosquitto goes through all of a
// client's for each new one: without an end to them, the 100,000th robot costs it 100 µs alone.
constexpr std::size_t kMostIdle = 5'000;

}  // namespace

void ReportNotSent(std::span<const message::Command> commands, const Error& error,
                   const ReportSink& sink) {
  for (const message::Command& command : commands) {
    message::Report report = message::ReportOn(command);
    report.error = error.kind;
    report.message = "not sent: " + error.message;
    sink(report);
  }
}

CommandSession::CommandSession(std::unique_ptr<mqtt::Transport>& transport, ledger::Ledger& ledger,
                               const SendOptions& send, const WaitOptions& wait, SessionHooks hooks)
    : transport_(transport),
      ledger_(ledger),
      send_(send),
      resends_(wait.resend > 0),
      report_(std::move(hooks.report)),
      sent_(std::move(hooks.sent)),
      reconnector_(std::move(hooks.reconnect)),
      pending_(
          wait,
          [this](PendingCommands::Key key, message::Report ended) {
            again_.erase(key);
            if (lost() && ended.status == message::CommandStatus::kTimeout) {
              ended.message += "; the broker was out of reach at the end";
              if (!reconnector_.is_told()) ended.message += ": " + lost()->message;
            }
            ended_.push_back(std::move(ended));
          },
          hooks.news),
      news_(std::move(hooks.news)),
      pipeline_(ledger, send, sent_, [this](PublishPipeline::Key first_key, BatchResult result) {
        Done(first_key, std::move(result));
      }) {}

Status CommandSession::Subscribe(std::span<const message::Command> commands) {
  if (subscribed_.size() > pending_.topics() + kMostIdle) UnsubscribeIdle();
  std::vector<std::string> topics;
  for (const message::Command& command : commands) {
    if (command.tracker == nullptr) continue;
    for (std::string& topic : command.tracker->Topics()) {
      if (!subscribed_.contains(topic)) topics.push_back(std::move(topic));
    }
  }
  std::sort(topics.begin(), topics.end());
  topics.erase(std::unique(topics.begin(), topics.end()), topics.end());
  if (topics.empty()) return {};
  if (lost()) return Fail(*lost());
  return SubscribeNew(*transport_, std::move(topics));
}

// A connection that was lost shows itself again; a subscription that stays costs only time.
void CommandSession::UnsubscribeIdle() {
  if (lost()) return;
  std::vector<std::string> idle;
  std::erase_if(subscribed_, [&](const std::string& topic) {
    const bool is_idle = !pending_.Follows(topic);
    if (is_idle) idle.push_back(topic);
    return is_idle;
  });
  static_cast<void>(transport_->Unsubscribe(idle, steady_clock::now() + send_.acknowledge_timeout));
}

Status CommandSession::SubscribeNew(mqtt::Transport& transport, std::vector<std::string> topics) {
  if (topics.empty()) return {};
  auto subscribed = transport.Subscribe(topics, mqtt::kListeningQos,
                                        steady_clock::now() + send_.acknowledge_timeout);
  if (!subscribed) return subscribed;
  for (std::string& topic : topics) subscribed_.insert(std::move(topic));
  return {};
}

Status CommandSession::Send(std::span<const message::Command> commands, More more) {
  auto sent = Subscribe(commands);
  if (sent) {
    sent = SendBatch(commands, more);
  } else if (commands.size() > 1 && !lost()) {
    return SendOneByOne(commands);  // one robot's topics may be forbidden, another's not
  } else {
    ReportNotSent(commands, sent.error(), report_);
  }
  if (since_pause_ >= send_.batch) ReadUntilQuiet();
  TellEnded();
  return sent;
}

Status CommandSession::SendOneByOne(std::span<const message::Command> commands) {
  Status first;
  for (std::size_t i = 0; i < commands.size(); ++i) {
    auto sent = Send(commands.subspan(i, 1));
    if (!sent && first) first = std::move(sent);
  }
  return first;
}

Status CommandSession::SendBatch(std::span<const message::Command> commands, More more) {
  const PendingCommands::Key first_key = next_key_;
  next_key_ += commands.size();
  for (std::size_t i = 0; i < commands.size(); ++i) {
    if (!commands[i].tracker) continue;
    pending_.Track(first_key + i, commands[i].tracker);
    if (resends_) again_[first_key + i] = commands[i];
  }
  // What was retained or sent before our command must not be taken for an answer.
  while (!lost() && !subscribed_.empty() && ReadOne(steady_clock::now())) {
  }
  Status left;
  if (lost()) {
    left = Fail(*lost());
  } else if (!commands.empty()) {
    left = pipeline_.Send(*transport_, commands, first_key);
  }
  // An answer that is read while its command's batch is under way would be lost.
  const bool overlaps = more == More::kFollow && subscribed_.empty();
  if (!lost()) pipeline_.Await(*transport_, left && overlaps ? PublishPipeline::kMostUnderWay : 0);
  if (!left) {
    for (std::size_t i = 0; i < commands.size(); ++i) Forget(first_key + i);
    // One header id that was asked for, or one message that is too large, must not keep the others
    // from leaving.
    if (left.error().kind != ErrorKind::kLedger && commands.size() > 1 && !broken_) {
      return SendOneByOne(commands);
    }
    ReportNotSent(commands, left.error(), report_);
  }
  if (!broken_) return left;
  const Error why = *broken_;
  Lose(why);
  return Fail(why);
}

void CommandSession::Done(PendingCommands::Key first_key, BatchResult result) {
  Record(result.reports);
  for (std::size_t i = 0; i < result.reports.size(); ++i) {
    Resolve(first_key + i, std::move(result.reports[i]));
  }
  if (result.broken) broken_ = std::move(result.broken);
}

// A command has left, or not. Whose acknowledgement was lost with the connection may still do its
// work: its target will say so.
void CommandSession::Resolve(PendingCommands::Key key, message::Report report) {
  if ((report.error && !report.unacknowledged) || !pending_.IsTracked(key)) {
    Forget(key);
    return report_(report);
  }
  report.payload = {};  // the ledger has it; thousands that wait need not
  ++since_pause_;
  pending_.Published(key, std::move(report));
}

void CommandSession::Forget(PendingCommands::Key key) {
  pending_.Forget(key);
  again_.erase(key);
}

// Whose repetition does not leave is waited for on: his time runs, and ends as a timeout.
void CommandSession::SendAgain(const std::vector<PendingCommands::Key>& keys) {
  PublishPipeline pipeline(ledger_, send_, sent_,
                           [this](PublishPipeline::Key key, BatchResult result) {
                             Record(result.reports);
                             message::Report& report = result.reports.front();
                             if (!report.error) pending_.Published(key, std::move(report));
                             if (result.broken) broken_ = std::move(result.broken);
                           });
  for (const PendingCommands::Key key : keys) {
    const auto command = again_.find(key);
    if (lost() || command == again_.end()) continue;
    message::Command sent = command->second;
    sent.expected_header_id.reset();  // that was the first one's
    if (auto other = std::exchange(command->second.other_way, std::nullopt)) {
      sent.payload = std::move(other->payload);
      if (news_) news_(fmt::format("{}: {}", base::Printable(sent.target), other->note));
    }
    static_cast<void>(pipeline.Send(*transport_, std::span(&sent, 1), key));
    pipeline.Await(*transport_, 0);
    if (broken_) Lose(Error(*broken_));
  }
}

void CommandSession::Listen(mqtt::Deadline deadline) {
  const auto limit = std::min(deadline, pending_.NextLimit());
  for (int i = 0; i < kTurn; ++i) {
    // Who has ended is told soon, but with those that end at the same time.
    if (!ReadOne(ended_.empty() ? limit : steady_clock::now())) break;
  }
  SendAgain(pending_.Expire());
  TellEnded();
}

void CommandSession::ReadUntilQuiet() {
  since_pause_ = 0;
  if (lost()) return;
  transport_->WakeOn({});
  const auto most = steady_clock::now() + kLongestPause;
  while (pending_.waiting() > 0 && steady_clock::now() < most) {
    if (!ReadOne(steady_clock::now() + kQuiet)) break;
  }
  if (!lost()) transport_->WakeOn(wake_);
}

// False when nothing came.
bool CommandSession::ReadOne(mqtt::Deadline deadline) {
  if (lost()) {
    TryAgain(deadline);
    return false;
  }
  auto message = transport_->Receive(deadline);
  if (!message) {
    Lose(std::move(message.error()));
    return false;
  }
  if (!*message) return false;
  pending_.Deliver(**message);
  return true;
}

void CommandSession::Lose(Error error) {
  if (lost()) return;
  pipeline_.Await(*transport_, 0);  // at once: nothing more comes
  broken_.reset();
  transport_.reset();
  reconnector_.Lose(std::move(error));
}

// The targets go on working while the broker cannot be reached: what they say afterwards still counts.
void CommandSession::TryAgain(mqtt::Deadline deadline) {
  transport_ =
      reconnector_.TryAgain(deadline, pending_.NextLimit(), [this](mqtt::Transport& opened) {
        subscribed_.clear();
        return SubscribeNew(opened, pending_.Topics());
      });
  if (transport_ != nullptr) transport_->WakeOn(wake_);
}

void CommandSession::WakeOn(std::vector<int> descriptors) {
  if (descriptors == wake_) return;
  wake_ = std::move(descriptors);
  if (!lost()) transport_->WakeOn(wake_);
}

void CommandSession::EndAll(message::CommandStatus status, const Error& reason) {
  pending_.EndAll(status, reason);
  TellEnded();
}

// Records and tells the ends that are known by now.
void CommandSession::TellEnded() {
  if (ended_.empty()) return;
  Record(ended_);
  for (const message::Report& ended : std::exchange(ended_, {})) report_(ended);
}

// Puts the reports' statuses into the audit trail.
void CommandSession::Record(std::span<const message::Report> reports) {
  std::vector<ledger::StatusUpdate> outcomes;
  outcomes.reserve(reports.size());
  for (const message::Report& report : reports) {
    if (report.ledger_row == 0) continue;  // it came to nothing before it was recorded
    outcomes.push_back({report.ledger_row, std::string(GetName(report.status)), report.message});
  }
  auto recorded = ledger_.RecordOutcomes(outcomes);
  if (!recorded && trouble_) trouble_ = std::move(recorded);
}

}  // namespace fleetpub::delivery
