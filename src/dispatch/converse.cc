#include "dispatch/converse.h"

#include <algorithm>
#include <thread>

namespace fleetpub::dispatch {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

// After a batch, so long a silence means that the answers to come take their time: the next batch
// may go.
constexpr milliseconds kQuiet{20};
// Between attempts to connect again.
constexpr milliseconds kReconnectPause{200};

class Conversation {
 public:
  Conversation(std::span<const Command> commands, std::unique_ptr<mqtt::Transport>& transport,
               const ConnectHook& connect, ledger::Ledger& ledger, const SendOptions& send,
               const WaitOptions& wait, const ReportSink& report, const SentHook& sent)
      : commands_(commands),
        transport_(transport),
        connect_(connect),
        ledger_(ledger),
        send_(send),
        report_(report),
        sent_(sent),
        follower_(wait, [this](const Report& ended) { ended_.push_back(ended); }) {}

  Status Run() {
    for (std::size_t i = 0; i < commands_.size(); ++i) {
      follower_.Watch(i, commands_[i].confirmation.get());
    }
    if (auto ok = Subscribe(); !ok) return ok;
    for (std::size_t first = 0; first < commands_.size() && !broken_; first += send_.batch) {
      SendFrom(first, std::min(send_.batch, commands_.size() - first));
      ReadUntilQuiet();
    }
    while (follower_.waiting() > 0) {
      Read(follower_.NextLimit());
      SendAgain(follower_.Expire());
      Settle();
    }
    return {};
  }

  Status trouble() { return std::move(trouble_); }

 private:
  Status Subscribe() {
    const std::vector<std::string> topics = follower_.Topics();
    return transport_->Subscribe(topics, mqtt::kListeningQos,
                                 steady_clock::now() + send_.acknowledge_timeout);
  }

  // What was retained or sent before our command must not be taken for an answer.
  void SendFrom(std::size_t first, std::size_t count) {
    Read(steady_clock::now());
    const auto batch = commands_.subspan(first, count);
    auto result = SendBatch(batch, *transport_, ledger_, send_, sent_);
    if (!result) {
      broken_ = result.error();
      return ReportNotSent(commands_.subspan(first), *broken_, report_);
    }
    Note(RecordOutcomes(result->reports, ledger_));
    for (std::size_t i = 0; i < count; ++i) {
      Report& sent = result->reports[i];
      if (sent.error) {
        report_(sent);
      } else {
        sent.payload = {};  // the ledger has it; thousands that wait need not
        follower_.Published(first + i, std::move(sent));
      }
    }
    if (result->broken) {
      broken_ = std::move(result->broken);
      ReportNotSent(commands_.subspan(first + count), *broken_, report_);
    }
  }

  void SendAgain(const std::vector<std::size_t>& indices) {
    for (const std::size_t index : indices) {
      auto result = SendBatch(commands_.subspan(index, 1), *transport_, ledger_, send_, sent_);
      if (!result) continue;  // its time runs on, and ends as a timeout
      Note(RecordOutcomes(result->reports, ledger_));
      if (!result->reports.front().error) {
        follower_.Published(index, std::move(result->reports.front()));
      }
    }
  }

  void ReadUntilQuiet() {
    while (follower_.waiting() > 0) {
      if (!ReadOne(steady_clock::now() + kQuiet)) break;
    }
    Settle();
  }

  // Reads until the deadline, or until somebody's end is to be told.
  void Read(mqtt::Deadline deadline) {
    while (ended_.empty() && ReadOne(deadline)) {
    }
  }

  // False when nothing came.
  bool ReadOne(mqtt::Deadline deadline) {
    auto message = transport_->Receive(deadline);
    if (!message) {
      Reconnect(follower_.waiting() > 0 ? follower_.NextLimit() : deadline);
      return false;
    }
    if (!*message) return false;
    follower_.Deliver(**message);
    return true;
  }

  // The robots go on working while the broker is away: what they say afterwards still counts.
  void Reconnect(mqtt::Deadline deadline) {
    while (steady_clock::now() < deadline) {
      auto again = connect_(deadline);
      if (again) {
        transport_ = std::move(*again);
        if (Subscribe()) return;
      }
      std::this_thread::sleep_until(std::min(deadline, steady_clock::now() + kReconnectPause));
    }
  }

  // Records and tells the ends that are known by now.
  void Settle() {
    if (ended_.empty()) return;
    Note(RecordOutcomes(ended_, ledger_));
    for (const Report& ended : ended_) report_(ended);
    ended_.clear();
  }

  void Note(Status status) {
    if (!status && trouble_) trouble_ = std::move(status);
  }

  std::span<const Command> commands_;
  std::unique_ptr<mqtt::Transport>& transport_;
  const ConnectHook& connect_;
  ledger::Ledger& ledger_;
  const SendOptions& send_;
  const ReportSink& report_;
  const SentHook& sent_;
  Follower follower_;
  std::vector<Report> ended_;
  std::optional<Error> broken_;
  Status trouble_;
};

}  // namespace

Status Converse(std::span<const Command> commands, std::unique_ptr<mqtt::Transport>& transport,
                const ConnectHook& connect, ledger::Ledger& ledger, const SendOptions& send,
                const WaitOptions& wait, const ReportSink& report, const SentHook& sent,
                Status& trouble) {
  Conversation conversation(commands, transport, connect, ledger, send, wait, report, sent);
  auto ran = conversation.Run();
  trouble = conversation.trouble();
  return ran;
}

}  // namespace fleetpub::dispatch
