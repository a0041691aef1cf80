// Sending with the targets' answers: subscribe ─▶ [ stamp ─▶ record ─▶ publish ] ─▶ confirm ─▶
// record ─▶ report.
#pragma once

#include <memory>
#include <span>

#include "base/result.h"
#include "dispatch/command.h"
#include "dispatch/connect_hook.h"
#include "dispatch/follow.h"
#include "dispatch/send.h"

namespace fleetpub::dispatch {

/// Sends valid commands, each with a Confirmation, and waits for their ends. Reports come as they
/// are known.
///
/// Subscribed, and acknowledged, is before anything is published. Between batches answers are read,
/// so that a broker with default limits drops none. A connection that is lost while waiting is
/// opened again and subscribed again until time is up; no command is ever sent again for that.
/// Errors: the subscription failed, and nothing was sent. `trouble` receives what changes no
/// verdict: an outcome that could not be recorded.
[[nodiscard]] Status Converse(std::span<const Command> commands,
                              std::unique_ptr<mqtt::Transport>& transport,
                              const ConnectHook& connect, ledger::Ledger& ledger,
                              const SendOptions& send, const WaitOptions& wait,
                              const ReportSink& report, const SentHook& sent, Status& trouble);

}  // namespace fleetpub::dispatch
