#include "delivery/publish_pipeline.h"

#include <algorithm>
#include <utility>

namespace fleetpub::delivery {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

PublishPipeline::PublishPipeline(ledger::Ledger& ledger, const SendOptions& options, SentHook sent,
                                 DoneHook done)
    : ledger_(ledger), options_(options), sent_(std::move(sent)), done_(std::move(done)) {}

Status PublishPipeline::Send(mqtt::Transport& transport, std::span<const message::Command> commands,
                             Key key) {
  if (!under_way_.empty()) {
    // What came meanwhile lets topics go. A lost connection shows itself again.
    static_cast<void>(Hear(transport, steady_clock::now(), 0));
    if (auto opened = Open(transport, commands, key, milliseconds(0)); opened) return opened;
    Await(transport, 0);
  }
  return Open(transport, commands, key, options_.lock_timeout);
}

Status PublishPipeline::Open(mqtt::Transport& transport, std::span<const message::Command> commands,
                             Key key, milliseconds lock_timeout) {
  BatchPublisher publisher(transport, ledger_, options_);
  if (auto opened = publisher.Open(commands, lock_timeout, sent_); !opened) return opened;
  under_way_.push_back({key, std::move(publisher)});
  return {};
}

void PublishPipeline::Await(mqtt::Transport& transport, std::size_t most) {
  while (!under_way_.empty()) {
    const BatchPublisher& first = under_way_.front().publisher;
    if (first.awaited() == 0) {
      CloseFirst({});
      continue;
    }
    if (under_way_.size() <= most) return;
    std::size_t left = 0;
    for (const UnderWay& each : under_way_) left += each.publisher.awaited();
    auto heard = Hear(transport, first.deadline(), left - first.awaited());
    if (heard && first.awaited() > 0 && steady_clock::now() >= first.deadline()) {
      heard = Fail(first.Silence());
    }
    while (!heard && !under_way_.empty()) CloseFirst(heard.error());
  }
}

Status PublishPipeline::Hear(mqtt::Transport& transport, mqtt::Deadline deadline,
                             std::size_t left) {
  const auto acknowledgements = transport.AwaitAcknowledgements(deadline, left);
  if (!acknowledgements) return Fail(acknowledgements.error());
  for (const mqtt::Acknowledgement& acknowledgement : *acknowledgements) {
    static_cast<void>(std::any_of(
        under_way_.begin(), under_way_.end(),
        [&acknowledgement](UnderWay& each) { return each.publisher.Take(acknowledgement); }));
  }
  return {};
}

void PublishPipeline::CloseFirst(const Error& reason) {
  UnderWay first = std::move(under_way_.front());
  under_way_.pop_front();
  done_(first.key, first.publisher.Close(reason));
}

}  // namespace fleetpub::delivery
