#include "cli/sending.h"

#include <fmt/format.h>

#include <charconv>

#include "base/text.h"
#include "cli/listening.h"
#include "cli/output/dry_run.h"
#include "cli/output/interrupt.h"
#include "cli/output/output.h"
#include "cli/output/reporter.h"
#include "cli/parser/option_set.h"
#include "delivery/validate.h"
#include "mqtt/paho/paho_transport.h"

namespace fleetpub::cli {
namespace {

using message::Command;
using message::CommandStatus;
using message::Report;

}  // namespace

Result<mqtt::Qos> QosOf(const std::string& text) {
  if (text == "0") return mqtt::Qos::kAtMostOnce;
  if (text == "1") return mqtt::Qos::kAtLeastOnce;
  if (text == "2") return mqtt::Qos::kExactlyOnce;
  return Fail(ErrorKind::kUsage,
              fmt::format("--qos takes 0, 1 or 2, not '{}'", base::Printable(text)));
}

Result<delivery::RateLimiter> ParseRate(const std::string& text) {
  if (text.empty()) return delivery::RateLimiter();
  double rate = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), rate);
  constexpr double kSlowest = 1e-3;
  constexpr double kFastest = 1e6;
  if (error == std::errc() && end == text.data() + text.size() && rate >= kSlowest &&
      rate <= kFastest) {
    return delivery::RateLimiter(rate);
  }
  return Fail(ErrorKind::kUsage, fmt::format("--rate takes messages per second, from 0.001 to "
                                             "1000000, not '{}'",
                                             base::Printable(text)));
}

Result<std::unique_ptr<mqtt::Transport>> Connect(const mqtt::ConnectOptions& options,
                                                 Output& output) {
  auto transport = mqtt::ConnectPaho(options);
  if (transport) {
    output.Debug(fmt::format("connected to {}", (*transport)->server().broker.ToString()));
  }
  return transport;
}

Status Deliver(delivery::CommandSource& source, std::unique_ptr<mqtt::Transport>& transport,
               ledger::Ledger& ledger, const Delivery& delivery, Output& output) {
  if (!delivery.wait) {
    WarnOfSilentRefusals(delivery.connect.version, delivery.send.qos, output);
  }
  InterruptGuard::Begin(source.left());
  std::function<void(const Error&)> lost;
  if (delivery.wait) {
    lost = [&output](const Error& error) { output.Warn(error.message + ": connecting again"); };
  }
  delivery::CommandSession session(transport, ledger, delivery.send,
                                   delivery.wait.value_or(delivery::WaitOptions()),
                                   {.report = delivery.report,
                                    .sent =
                                        [&output] {
                                          InterruptGuard::CountSent();
                                          output.SomethingWasSent();
                                        },
                                    .connect = ConnectHookOf(delivery.connect),
                                    .lost = lost,
                                    .again = [&output] { output.Warn("connected again"); }});
  auto sent = delivery::SendAll(
      source, session,
      {.batch = delivery.send.batch, .rate = delivery.rate, .tick = delivery.tick});
  if (transport != nullptr) transport->Disconnect();
  if (sent && !session.trouble()) {
    output.Warn(fmt::format("sent, but the outcome is not in the ledger: {}",
                            session.trouble().error().message));
  }
  return sent;
}

// When nothing at all was sent, a person reads one sentence, a script an object per target.
Error NothingSent(const std::vector<Command>& commands, CommandStatus status, Error error,
                  const Context& context) {
  if (context.output.json()) {
    for (const Command& command : commands) {
      Report report = message::ReportOn(command);
      report.status = status;
      report.error = error.kind;
      report.message = "not sent: " + error.message;
      context.output.Line(ReportJson(report));
    }
  }
  error.message = "nothing was sent: " + error.message;
  return error;
}

void WarnOfSilentRefusals(mqtt::ProtocolVersion version, mqtt::Qos qos, Output& output) {
  if (version != mqtt::ProtocolVersion::k311 || qos == mqtt::Qos::kAtMostOnce) return;
  output.Warn(
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

void DeclareSendingOptions(OptionSet& set, SendingOptions& options) {
  constexpr const char* kSending = "Sending";
  set.AddFlag("-n,--dry-run", options.dry_run,
              "Print the message that would be sent; send nothing, use no header id")
      .Group(kSending);
  DeclareQos(set, options.qos);
}

void DeclareManyOptions(OptionSet& set, SendingOptions& options) {
  set.AddFlag("--yes", options.yes, "Send to many robots without asking").Group("Sending");
  DeclareRate(set, options);
}

void DeclareRate(OptionSet& set, SendingOptions& options) {
  set.AddOption("--rate", options.rate, "At most so many messages per second [no limit]")
      .Type("N")
      .Group("Sending");
}

void DeclareQos(OptionSet& set, std::string& qos) {
  set.bindings().Bind("qos",
                      set.AddOption("-q,--qos", qos,
                                    "0: handed to the network; 1, 2: acknowledged by the broker "
                                    "[0]")
                          .Type("QOS")
                          .Variable("FLEETPUB_QOS")
                          .Group("Sending"),
                      &qos);
}

namespace {

// Errors: nothing was sent.
Result<ExitCode> SendValid(const Outgoing& outgoing, mqtt::Qos qos, const Context& context) {
  const auto connect = ConnectOptionsOf(context);
  if (!connect) return Fail(connect.error());
  const InterruptGuard interrupt;
  Reporter reporter(context.output);
  for (const Command& command : outgoing.commands) reporter.Fit(command.target);
  auto ledger = OpenLedger(context, ledger::OpenMode::kCreate);
  if (!ledger) return Fail(ledger.error());
  auto transport = Connect(*connect, context.output);
  if (!transport) return Fail(transport.error());
  const Delivery delivery{.connect = *connect,
                          .send = {.qos = qos, .acknowledge_timeout = connect->connect_timeout},
                          .wait = outgoing.wait,
                          .rate = {},
                          .report =
                              [&](const Report& report) {
                                reporter.Show(report);
                                Output::FlushNow();
                              },
                          .tick = {}};
  delivery::CommandList list(outgoing.commands, delivery.report);
  auto sent = Deliver(list, *transport, **ledger, delivery, context.output);
  if (!sent) return Fail(std::move(sent.error()));
  return reporter.worst();
}

}  // namespace

Result<ExitCode> SendCommands(const Outgoing& outgoing, const SendingOptions& options,
                              const Context& context) {
  const auto qos = QosOf(options.qos);
  if (!qos) return Fail(qos.error());
  const std::vector<Command>& commands = outgoing.commands;
  schema::Registry registry(context.options.schema_directory);
  for (const Command& command : commands) {
    const auto warnings = ValidateCommand(command, registry);
    if (!warnings) {
      return Fail(NothingSent(commands, CommandStatus::kInvalid, warnings.error(), context));
    }
    for (const std::string& warning : *warnings) context.output.Warn(warning);
  }
  if (options.dry_run) {
    delivery::CommandList list(commands);
    if (auto ok = ShowDryRun(list, context); !ok) return Fail(std::move(ok.error()));
    return ExitCode::kDone;
  }
  auto code = SendValid(outgoing, *qos, context);
  if (!code) return Fail(NothingSent(commands, CommandStatus::kError, code.error(), context));
  return code;
}

}  // namespace fleetpub::cli
