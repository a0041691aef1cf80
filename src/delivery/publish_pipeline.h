// Batches on their way, oldest first. While the broker's acknowledgements of one travel, the next
// can be made: at a distance a fleet costs little more than one batch's round trip.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <span>

#include "base/result.h"
#include "delivery/batch_publisher.h"

namespace fleetpub::delivery {

/// One thread at a time. The ledger must outlive it.
class PublishPipeline {
 public:
  using Key = std::uint64_t;
  /// Told what became of a batch, in the order of Send; its outcomes are not recorded yet.
  using DoneHook = std::function<void(Key key, BatchResult result)>;

  /// So many batches travel while the next is made: enough for 50 ms. More would keep others from
  /// their topics longer, and the kernel walks all locks for each new one.
  static constexpr std::size_t kMostUnderWay = 2;

  PublishPipeline(ledger::Ledger& ledger, const SendOptions& options, SentHook sent, DoneHook done);

  /// Opens a batch for these commands, under the caller's key. Errors: nothing of it was sent.
  /// A topic that is held, perhaps by a batch under way, is waited for only when none is under
  /// way any more: who holds topics waits for nobody's.
  [[nodiscard]] Status Send(mqtt::Transport& transport, std::span<const message::Command> commands,
                            Key key);

  /// Closes what is done, and waits until at most so many batches are under way. When the
  /// connection is lost or the broker silent, closes them all.
  void Await(mqtt::Transport& transport, std::size_t most);

 private:
  struct UnderWay {
    Key key;
    BatchPublisher publisher;
  };

  [[nodiscard]] Status Open(mqtt::Transport& transport, std::span<const message::Command> commands,
                            Key key, std::chrono::milliseconds lock_timeout);
  /// The reason why no more acknowledgements will come, if so.
  [[nodiscard]] Status Hear(mqtt::Transport& transport, mqtt::Deadline deadline, std::size_t left);
  void CloseFirst(const Error& reason);

  ledger::Ledger& ledger_;
  SendOptions options_;
  SentHook sent_;
  DoneHook done_;
  std::deque<UnderWay> under_way_;
};

}  // namespace fleetpub::delivery
