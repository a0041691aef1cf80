#include "app/deliver.h"

#include <fmt/format.h>

#include <utility>

#include "app/dry_run.h"
#include "delivery/validate.h"

namespace fleetpub::app {
namespace {

using message::Command;
using message::CommandStatus;

Error ReportNothingSent(const std::vector<Command>& commands, CommandStatus status, Error error,
                        Observer& observer) {
  for (const Command& command : commands) {
    message::Report report = message::ReportOn(command);
    report.status = status;
    report.error = error.kind;
    report.message = "not sent: " + error.message;
    observer.NothingSent(report);
  }
  error.message = "nothing was sent: " + error.message;
  return error;
}

}  // namespace

void WarnOfSilentRefusals(mqtt::ProtocolVersion version, mqtt::Qos qos, Log& log) {
  if (version != mqtt::ProtocolVersion::k311 || qos == mqtt::Qos::kAtMostOnce) return;
  log.Warn(
      "over MQTT 3.1.1 a broker may acknowledge what its access list drops: with -V 5 it can say "
      "so, with --wait the robot does");
}

Result<std::vector<std::string>> ValidateCommand(const Command& command,
                                                 schema::Registry& registry) {
  const auto findings = delivery::Validate(command, registry);
  if (!findings) return Fail(findings.error());
  if (!findings->errors.empty()) {
    return Fail(ErrorKind::kInvalid,
                fmt::format("{}: {}", command.target, delivery::Describe(*findings)));
  }
  std::vector<std::string> warnings;
  for (const std::string& warning : command.warnings) {
    warnings.push_back(fmt::format("{}: {}", command.target, warning));
  }
  for (const auto& warning : findings->warnings) {
    warnings.push_back(fmt::format("{}: {}", command.target, warning.message));
  }
  return warnings;
}

Status Deliver(delivery::CommandSource& source, Link& link, ledger::Ledger& ledger,
               const SendSettings& settings, const std::optional<delivery::WaitOptions>& wait,
               Observer& observer, const delivery::ReportSink& ended) {
  const delivery::SendOptions send{.qos = settings.qos,
                                   .acknowledge_timeout = link.connection.timeout};
  if (!wait) WarnOfSilentRefusals(link.connection.version, settings.qos, observer);
  observer.WillSend(source.left());
  delivery::CommandSession session(link.transport, ledger, send,
                                   wait.value_or(delivery::WaitOptions()),
                                   {.report =
                                        [&](const message::Report& report) {
                                          observer.Report(report);
                                          if (ended) ended(report);
                                        },
                                    .sent = [&] { observer.Sent(); },
                                    .reconnect = MakeReconnectHooks(link.connection, observer),
                                    .news = [&](std::string_view line) { observer.Info(line); }});
  auto sent = delivery::SendAll(
      source, session,
      {.batch = send.batch,
       .rate = settings.rate,
       .waits = [&](const delivery::CommandSession& waiting) { observer.Waits(waiting); },
       .is_stopped = [&] { return observer.IsStopped(); },
       .stop_descriptor = [&] { return observer.stop_descriptor(); }});
  observer.Wait("");
  if (sent && !session.trouble()) {
    observer.Warn(fmt::format("sent, but the outcome is not in the ledger: {}",
                              session.trouble().error().message));
  }
  return sent;
}

Status SendBeside(std::span<const Command> commands, Link& link, ledger::Ledger& ledger,
                  const delivery::SendOptions& send, const delivery::WaitOptions& wait,
                  const delivery::ReportSink& report, Log& log) {
  delivery::CommandList list(commands, report);
  delivery::CommandSession session(link.transport, ledger, send, wait,
                                   {.report = report,
                                    .sent = {},
                                    .reconnect = MakeReconnectHooks(link.connection, log),
                                    .news = {}});
  return delivery::SendAll(list, session, {});
}

namespace {

// Errors: nothing was sent.
Status DeliverPrepared(const std::vector<Command>& commands, const SendSettings& settings,
                       const std::optional<delivery::WaitOptions>& wait,
                       const Environment& environment, Observer& observer) {
  auto ledger = environment.ledger(ledger::OpenMode::kCreate);
  if (!ledger) return Fail(std::move(ledger.error()));
  auto link = Connect(environment, observer);
  if (!link) return Fail(std::move(link.error()));
  delivery::CommandList list(commands,
                             [&](const message::Report& report) { observer.Report(report); });
  auto sent = Deliver(list, *link, **ledger, settings, wait, observer);
  if (link->transport != nullptr) link->transport->Disconnect();
  return sent;
}

}  // namespace

Status SendMessages(const std::vector<Command>& commands, const SendSettings& settings,
                    const std::optional<delivery::WaitOptions>& wait,
                    const Environment& environment, Observer& observer) {
  schema::Registry registry(environment.schema_directory);
  for (const Command& command : commands) {
    const auto warnings = ValidateCommand(command, registry);
    if (!warnings) {
      return Fail(ReportNothingSent(commands, CommandStatus::kInvalid, warnings.error(), observer));
    }
    for (const std::string& warning : *warnings) observer.Warn(warning);
  }
  std::vector<std::string> targets;
  targets.reserve(commands.size());
  for (const Command& command : commands) targets.push_back(command.target);
  observer.Chosen(targets);
  if (settings.dry_run) {
    delivery::CommandList list(commands);
    return ShowDryRun(list, environment, observer);
  }
  auto sent = DeliverPrepared(commands, settings, wait, environment, observer);
  if (sent) return sent;
  return Fail(
      ReportNothingSent(commands, CommandStatus::kError, std::move(sent.error()), observer));
}

}  // namespace fleetpub::app
