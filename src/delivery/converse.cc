#include "delivery/converse.h"

#include <algorithm>

namespace fleetpub::delivery {

Status Converse(std::span<const message::Command> commands,
                std::unique_ptr<mqtt::Transport>& transport, ledger::Ledger& ledger,
                const SendOptions& send, const WaitOptions& wait, const SessionHooks& hooks,
                Status& trouble) {
  CommandSession stream(transport, ledger, send, wait, hooks);
  if (auto ok = stream.Subscribe(commands); !ok) return ok;
  while (!commands.empty()) {
    const std::size_t count = std::min(send.batch, commands.size());
    const auto left = stream.Send(commands.first(count));
    commands = commands.subspan(count);
    if (left) continue;
    ReportNotSent(commands, left.error(), hooks.report);
    break;
  }
  while (stream.waiting() > 0) stream.Listen(mqtt::Deadline::max());
  trouble = stream.trouble();
  return {};
}

}  // namespace fleetpub::delivery
