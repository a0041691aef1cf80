// Sending with the targets' answers: subscribe ─▶ [ stamp ─▶ record ─▶ publish ] ─▶ confirm ─▶
// record ─▶ report.
#pragma once

#include <memory>
#include <span>

#include "base/result.h"
#include "delivery/command_session.h"
#include "delivery/pending_commands.h"
#include "delivery/send.h"
#include "message/command.h"

namespace fleetpub::delivery {

/// Sends valid commands, each with a ResponseTracker, through a CommandSession, and waits for their
/// ends. Reports come as they are known.
///
/// All that is needed is subscribed, and acknowledged, before anything is published. A connection
/// that is lost while waiting is opened again and subscribed again until time is up; `transport` is
/// null when that did not succeed. Errors: the subscription failed, and nothing was sent. `trouble`
/// receives what changes no status: an outcome that could not be recorded.
[[nodiscard]] Status Converse(std::span<const message::Command> commands,
                              std::unique_ptr<mqtt::Transport>& transport, ledger::Ledger& ledger,
                              const SendOptions& send, const WaitOptions& wait,
                              const SessionHooks& hooks, Status& trouble);

}  // namespace fleetpub::delivery
