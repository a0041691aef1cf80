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
#include "delivery/converse.h"
#include "delivery/send.h"
#include "delivery/validate.h"
#include "mqtt/paho/paho_transport.h"

namespace fleetpub::cli {
namespace {

using message::Command;
using message::CommandStatus;
using message::Report;

Result<ExitCode> ShowOnly(const std::vector<Command>& commands, const Context& context) {
  auto dry_run = DryRun::Open(context);
  if (!dry_run) return Fail(std::move(dry_run.error()));
  for (const Command& command : commands) {
    const auto report = dry_run->Report(command);
    if (!report) return Fail(report.error());
    context.output.Debug(fmt::format("would be published to {}", base::Printable(command.topic)));
    context.output.JsonLine(context.output.json() ? ReportJson(*report) : report->payload);
  }
  return ExitCode::kDone;
}

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

namespace {

// Over the open connection; with `wait`, until every robot's word.
class Sender {
 public:
  Sender(Outgoing& outgoing, const mqtt::ConnectOptions& connect, mqtt::Qos qos,
         const Context& context)
      : outgoing_(outgoing), connect_(connect), context_(context), reporter_(context.output) {
    for (const Command& command : outgoing.commands) reporter_.Fit(command.target);
    options_.qos = qos;
    options_.acknowledge_timeout = connect.connect_timeout;
  }

  // Errors: nothing was sent.
  Result<ExitCode> Run() {
    auto ledger = OpenLedger(context_, ledger::OpenMode::kCreate);
    if (!ledger) return Fail(ledger.error());
    if (auto ok = Connect(); !ok) return Fail(ok.error());
    if (!outgoing_.wait) WarnOfSilentRefusals(connect_.version, options_.qos, context_.output);
    InterruptGuard::Begin(outgoing_.commands.size());
    Status trouble;
    const auto ran = outgoing_.wait ? Converse(**ledger, trouble) : Send(**ledger, trouble);
    if (transport_ != nullptr) transport_->Disconnect();
    if (!ran) return Fail(ran.error());
    if (!trouble) {
      context_.output.Warn(
          fmt::format("sent, but the outcome is not in the ledger: {}", trouble.error().message));
    }
    return reporter_.worst();
  }

 private:
  Status Connect() {
    auto transport = mqtt::ConnectPaho(connect_);
    if (!transport) return Fail(transport.error());
    transport_ = std::move(*transport);
    context_.output.Debug(fmt::format("connected to {}", transport_->server().broker.ToString()));
    return {};
  }

  Status Send(ledger::Ledger& ledger, Status& trouble) {
    trouble = delivery::Send(outgoing_.commands, *transport_, ledger, options_, sink_, sent_);
    return {};
  }

  Status Converse(ledger::Ledger& ledger, Status& trouble) {
    Output& output = context_.output;
    const delivery::SessionHooks hooks{
        .report = sink_,
        .sent = sent_,
        .connect = ConnectHookOf(connect_),
        .lost =
            [&output](const Error& error) { output.Warn(error.message + ": connecting again"); },
        .again = [&output] { output.Warn("connected again"); }};
    return delivery::Converse(outgoing_.commands, transport_, ledger, options_, *outgoing_.wait,
                              hooks, trouble);
  }

  Outgoing& outgoing_;
  std::unique_ptr<mqtt::Transport> transport_;
  const mqtt::ConnectOptions& connect_;
  const Context& context_;
  Reporter reporter_;
  InterruptGuard interrupt_;
  delivery::SendOptions options_;
  delivery::ReportSink sink_ = [this](const Report& report) {
    reporter_.Show(report);
    context_.output.FlushNow();
  };
  delivery::SentHook sent_ = [this] {
    InterruptGuard::CountSent();
    context_.output.SomethingWasSent();
  };
};

}  // namespace

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

Result<ExitCode> SendCommands(Outgoing outgoing, const SendingOptions& options,
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
  if (options.dry_run) return ShowOnly(commands, context);
  const auto connect = ConnectOptionsOf(context);
  if (!connect) return Fail(connect.error());
  auto code = Sender(outgoing, *connect, *qos, context).Run();
  if (!code) return Fail(NothingSent(commands, CommandStatus::kError, code.error(), context));
  return code;
}

}  // namespace fleetpub::cli
