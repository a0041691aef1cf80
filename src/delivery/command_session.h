// A session: commands as they come ─▶ batches ─▶ the targets' answers ─▶ reports as they are
// known. Nothing of a command is kept once its report is out.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "base/result.h"
#include "delivery/pending_commands.h"
#include "delivery/publish_pipeline.h"
#include "delivery/reconnect.h"
#include "delivery/retained.h"
#include "message/command.h"
#include "message/report.h"

namespace fleetpub::delivery {

/// Called with each report as it becomes known.
using ReportSink = std::function<void(const message::Report&)>;

/// Tells that nothing was sent to these, and why.
void ReportNotSent(std::span<const message::Command> commands, const Error& error,
                   const ReportSink& sink);

struct SessionHooks {
  ReportSink report;
  SentHook sent;  ///< may be empty
  ReconnectHooks reconnect;
  /// See PendingCommands::NewsHook.
  PendingCommands::NewsHook news;
};

/// Sends and follows over one connection, which is opened again whenever it is lost. No command is
/// ever sent again for that. One thread at a time.
class CommandSession {
 public:
  /// `transport` is the open connection, and null while there is none. It and the ledger must
  /// outlive the session.
  CommandSession(std::unique_ptr<mqtt::Transport>& transport, ledger::Ledger& ledger,
                 const SendOptions& send, const WaitOptions& wait, SessionHooks hooks);

  /// Subscribes to what these commands' trackers need, and waits for the acknowledgement.
  [[nodiscard]] Status Subscribe(std::span<const message::Command> commands);

  /// Sends valid commands through one batch, SendOptions::batch at most. Each gets its report: at
  /// once when it has no tracker or did not leave, else when its end is known. Those with a
  /// tracker are subscribed to first. Then, if many were sent since the last pause, reads
  /// until the targets' answers have come: a broker drops what it has to queue for long. Errors:
  /// what kept some from leaving; their reports say it too.
  ///
  /// With More::kFollow the next Send comes at once: the batch may still wait for the broker's
  /// acknowledgements on return, and is told of by a later Send.
  enum class More : std::uint8_t { kNone, kFollow };
  Status Send(std::span<const message::Command> commands, More more = More::kNone);

  /// Reads answers until the deadline or until something else is to be done: a report was made, a
  /// descriptor of WakeOn() is readable, many messages have been read, the connection was lost.
  void Listen(mqtt::Deadline deadline);

  /// Takes in a message that somebody else has read from the connection.
  void Deliver(const mqtt::Message& message) { pending_.Deliver(message); }

  /// What is subscribed to. Who adds to it has subscribed over the connection, too; the session
  /// ends what no command needs when it has become much.
  [[nodiscard]] Subscribed& subscribed() { return subscribed_; }

  /// See mqtt::Transport::WakeOn.
  void WakeOn(std::vector<int> descriptors);

  /// Ends all waiting: nothing more will be heard.
  void EndAll(message::CommandStatus status, const Error& reason);

  [[nodiscard]] std::size_t waiting() const { return pending_.waiting(); }
  [[nodiscard]] Waiting DescribeWaiting() const { return pending_.DescribeWaiting(); }
  /// Why there is no connection at the moment.
  [[nodiscard]] const std::optional<Error>& lost() const { return reconnector_.lost(); }
  /// What changes no status: the first outcome that could not be recorded.
  [[nodiscard]] const Status& trouble() const { return trouble_; }

 private:
  Status SubscribeNew(mqtt::Transport& transport, std::vector<std::string> topics);
  void UnsubscribeIdle();
  Status SendOneByOne(std::span<const message::Command> commands);
  Status SendBatch(std::span<const message::Command> commands, More more);
  void Done(PendingCommands::Key first_key, BatchResult result);
  void Resolve(PendingCommands::Key key, message::Report report);
  void Forget(PendingCommands::Key key);
  void SendAgain(const std::vector<PendingCommands::Key>& keys);
  void ReadUntilQuiet();
  bool ReadOne(mqtt::Deadline deadline);
  void Lose(Error error);
  void TryAgain(mqtt::Deadline deadline);
  void TellEnded();
  void Record(std::span<const message::Report> reports);

  std::unique_ptr<mqtt::Transport>& transport_;
  ledger::Ledger& ledger_;
  SendOptions send_;
  bool resends_;
  ReportSink report_;
  SentHook sent_;
  Reconnector reconnector_;
  PendingCommands pending_;
  PendingCommands::NewsHook news_;
  PublishPipeline pipeline_;
  std::optional<Error> broken_;         // a batch tells that the connection is
  std::vector<message::Report> ended_;  // not told yet
  PendingCommands::Key next_key_ = 0;
  std::unordered_map<PendingCommands::Key, message::Command>
      again_;  // what may have to be sent again
  Subscribed subscribed_;
  std::size_t since_pause_ = 0;  // sent, with an answer expected
  std::vector<int> wake_;
  Status trouble_;
};

}  // namespace fleetpub::delivery
