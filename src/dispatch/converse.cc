#include "dispatch/converse.h"

#include <algorithm>

#include "dispatch/stream.h"

namespace fleetpub::dispatch {

Status Converse(std::span<const Command> commands, std::unique_ptr<mqtt::Transport>& transport,
                const ConnectHook& connect, ledger::Ledger& ledger, const SendOptions& send,
                const WaitOptions& wait, const ReportSink& report, const SentHook& sent,
                Status& trouble) {
  Stream stream(transport, ledger, send, wait,
                {.report = report, .sent = sent, .connect = connect, .lost = {}, .again = {}});
  if (auto ok = stream.Subscribe(commands); !ok) return ok;
  while (!commands.empty()) {
    const std::size_t count = std::min(send.batch, commands.size());
    const auto left = stream.Send(commands.first(count));
    commands = commands.subspan(count);
    if (left) continue;
    ReportNotSent(commands, left.error(), report);
    break;
  }
  while (stream.waiting() > 0) stream.Listen(mqtt::Deadline::max());
  trouble = stream.trouble();
  return {};
}

}  // namespace fleetpub::dispatch
