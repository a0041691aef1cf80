// The second half of a command's way: batch (batch_publisher.h) ─▶ record the outcome ─▶ report.
#pragma once

#include <functional>
#include <span>

#include "base/result.h"
#include "delivery/batch_publisher.h"
#include "ledger/ledger.h"
#include "message/command.h"
#include "message/report.h"
#include "mqtt/transport.h"

namespace fleetpub::delivery {

/// Called with each report as it becomes known.
using ReportSink = std::function<void(const message::Report&)>;
/// Sends valid commands over an open connection. Every command gets a report, in order. When a
/// batch cannot be reserved or the connection is lost, its reports and those of the following say
/// so; nothing is sent twice. Returns the trouble after sending that changes no status (an outcome
/// that could not be recorded), if any.
[[nodiscard]] Status Send(std::span<const message::Command> commands, mqtt::Transport& transport,
                          ledger::Ledger& ledger, const SendOptions& options,
                          const ReportSink& report, const SentHook& sent = {});

/// Puts the reports' statuses into the audit trail.
[[nodiscard]] Status RecordOutcomes(std::span<const message::Report> reports,
                                    ledger::Ledger& ledger);

/// Tells that nothing was sent to these, and why.
void ReportNotSent(std::span<const message::Command> commands, const Error& error,
                   const ReportSink& sink);

}  // namespace fleetpub::delivery
