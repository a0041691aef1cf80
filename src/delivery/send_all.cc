#include "delivery/send_all.h"

#include <algorithm>
#include <chrono>

namespace fleetpub::delivery {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kStopInterval{100};  // while no connection tells of a stop

}  // namespace

Result<std::span<const message::Command>> CommandList::Next(std::size_t most) {
  const auto next = commands_.first(std::min(most, commands_.size()));
  commands_ = commands_.subspan(next.size());
  return next;
}

void CommandList::GiveUp(const Error& reason) {
  ReportNotSent(std::exchange(commands_, {}), reason, report_);
}

Status SendAll(CommandSource& source, CommandSession& session, SendAllOptions options) {
  const std::size_t all = source.left();
  const auto is_stopped = [&] { return options.is_stopped && options.is_stopped(); };
  while (source.left() > 0 || session.waiting() > 0) {
    if (is_stopped()) {
      source.GiveUp({ErrorKind::kUnconfirmed, "interrupted"});
      session.EndAll(message::CommandStatus::kInterrupted,
                     {ErrorKind::kUnconfirmed, "sent; no longer waiting"});
      break;
    }
    const auto now = steady_clock::now();
    const std::size_t room = kMostWaiting - std::min(kMostWaiting, session.waiting());
    const std::size_t most = std::min({options.batch, options.rate.Available(now), room});
    if (source.left() == 0 || most == 0) {
      const bool awaits_rate = source.left() > 0 && room > 0;
      auto deadline = awaits_rate ? options.rate.Next() : mqtt::Deadline::max();
      if (options.waits) options.waits(session);
      if (options.stop_descriptor) session.WakeOn({options.stop_descriptor()});
      if (options.is_stopped && session.lost()) deadline = std::min(deadline, now + kStopInterval);
      session.Listen(deadline);
      continue;
    }
    const bool is_first = source.left() == all;
    const auto commands = source.Next(most);
    if (!commands) {
      static_cast<void>(session.Send({}));  // what has left is told of
      return Fail(commands.error());
    }
    options.rate.Consume(commands->size(), now);
    const bool is_last = source.left() == 0;
    if (is_first && is_last) {  // else one target's topics may be forbidden
      if (auto ok = session.Subscribe(*commands); !ok) return ok;
    }
    using More = CommandSession::More;
    const bool follow = !is_last && options.rate.Available(now) > 0;
    const auto sent = session.Send(*commands, follow ? More::kFollow : More::kNone);
    if (!sent && session.lost()) source.GiveUp(sent.error());
  }
  return {};
}

}  // namespace fleetpub::delivery
