#include "cli/sending.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>

#include "base/text.h"
#include "cli/interrupt.h"
#include "cli/output.h"
#include "dispatch/send.h"
#include "dispatch/validate.h"
#include "mqtt/paho_transport.h"

namespace fleetpub::cli {
namespace {

using dispatch::Command;
using dispatch::Report;
using dispatch::Verdict;

// Prints reports as they come and remembers the worst.
class Reporter {
 public:
  Reporter(const std::vector<Command>& commands, const Context& context) : context_(context) {
    for (const Command& command : commands) width_ = std::max(width_, command.target.size());
  }

  void Show(const Report& report) {
    worst_ = Worse(worst_, CodeOf(report));
    Output& output = context_.output;
    if (output.json()) {
      output.Line(ReportJson(report));
    } else if (report.error) {
      output.Line(ReportText(report, width_, output));
    } else {
      output.PeopleLine(ReportText(report, width_, output));
    }
  }

  [[nodiscard]] ExitCode worst() const { return worst_; }

 private:
  const Context& context_;
  std::size_t width_ = 0;
  ExitCode worst_ = ExitCode::kDone;
};

// When nothing at all was sent, a person reads one sentence, a script an object per target.
Error NothingSent(const std::vector<Command>& commands, Verdict verdict, Error error,
                  const Context& context) {
  if (context.output.json()) {
    for (const Command& command : commands) {
      Report report = dispatch::ReportOn(command);
      report.verdict = verdict;
      report.error = error.kind;
      report.message = error.message;
      context.output.Line(ReportJson(report));
    }
  }
  error.message = "nothing was sent: " + error.message;
  return error;
}

// Errors: the message of the first invalid command, with its target.
Status ValidateAll(const std::vector<Command>& commands, const Context& context) {
  schema::Registry registry(context.options.schema_directory);
  for (const Command& command : commands) {
    const auto findings = dispatch::Validate(command, registry);
    if (!findings) return Fail(findings.error());
    for (const std::string& warning : command.warnings) {
      context.output.Warn(fmt::format("{}: {}", command.target, warning));
    }
    for (const auto& warning : findings->warnings) {
      context.output.Warn(fmt::format("{}: {}", command.target, warning.message));
    }
    if (!findings->errors.empty()) {
      return Fail(ErrorKind::kInvalid,
                  fmt::format("{}: {}", command.target, dispatch::Describe(*findings)));
    }
  }
  return {};
}

Result<std::uint32_t> NextId(const Command& command, ledger::Ledger& ledger,
                             std::map<std::string, std::uint32_t>& next_ids) {
  auto found = next_ids.find(command.topic);
  if (found == next_ids.end()) {
    const auto next = ledger.PeekNext(command.topic);
    if (!next) return next;
    found = next_ids.emplace(command.topic, *next).first;
  }
  if (!command.header_id) return found->second++;
  if (*command.header_id < found->second) {
    return Fail(ErrorKind::kUsage,
                fmt::format("--header-id {} is not above the last one on {}: the next is {}",
                            *command.header_id, command.topic, found->second));
  }
  found->second = *command.header_id + 1;
  return *command.header_id;
}

Result<ExitCode> DryRun(const std::vector<Command>& commands, const Context& context) {
  const auto ledger = OpenLedger(context, ledger::OpenMode::kReadOnly);
  if (!ledger) return Fail(ledger.error());
  std::map<std::string, std::uint32_t> next_ids;
  for (const Command& command : commands) {
    Report report = dispatch::ReportOn(command);
    report.verdict = Verdict::kDryRun;
    if (command.payload.counted) {
      const auto id = NextId(command, **ledger, next_ids);
      if (!id) return Fail(id.error());
      report.header_id = *id;
    }
    report.payload =
        command.payload.Render(report.header_id.value_or(0), base::WallTime::clock::now());
    context.output.Note(fmt::format("would be published to {}", command.topic));
    context.output.Line(context.output.json() ? ReportJson(report) : report.payload);
  }
  return ExitCode::kDone;
}

Result<mqtt::Qos> QosOf(const std::string& text) {
  if (text == "0") return mqtt::Qos::kAtMostOnce;
  if (text == "1") return mqtt::Qos::kAtLeastOnce;
  if (text == "2") return mqtt::Qos::kExactlyOnce;
  return Fail(ErrorKind::kUsage,
              fmt::format("--qos takes 0, 1 or 2, not '{}'", base::Printable(text)));
}

Result<ExitCode> SendOverMqtt(const std::vector<Command>& commands,
                              const mqtt::ConnectOptions& connect, mqtt::Qos qos,
                              const Context& context) {
  InterruptGuard interrupt(commands.size());
  const auto ledger = OpenLedger(context, ledger::OpenMode::kCreate);
  if (!ledger) return Fail(ledger.error());
  const auto transport = mqtt::ConnectPaho(connect);
  if (!transport) return Fail(transport.error());
  context.output.Note(fmt::format("connected to {}", (*transport)->server().broker.ToString()));

  Reporter reporter(commands, context);
  dispatch::SendOptions options;
  options.qos = qos;
  options.acknowledge_timeout = connect.connect_timeout;
  const auto ended = dispatch::Send(
      commands, **transport, **ledger, options,
      [&](const Report& report) { reporter.Show(report); },
      [&] {
        interrupt.CountSent();
        context.output.SomethingWasSent();
      });
  (*transport)->Disconnect();
  if (!ended) {
    context.output.Warn(
        fmt::format("sent, but the outcome is not in the ledger: {}", ended.error().message));
  }
  return reporter.worst();
}

}  // namespace

void DeclareSendingOptions(CLI::App& app, SendingOptions& options) {
  constexpr const char* kSending = "Sending";
  app.add_flag("-n,--dry-run", options.dry_run,
               "Print the message that would be sent; send nothing, use no header id")
      ->group(kSending);
  app.add_option("-q,--qos", options.qos,
                 "0: handed to the network; 1, 2: acknowledged by the broker [0]")
      ->type_name("QOS")
      ->envname("FLEETPUB_QOS")
      ->group(kSending);
}

Result<ExitCode> SendCommands(const std::vector<Command>& commands, const SendingOptions& options,
                              const Context& context) {
  const auto qos = QosOf(options.qos);
  if (!qos) return Fail(qos.error());
  if (auto valid = ValidateAll(commands, context); !valid) {
    return Fail(NothingSent(commands, Verdict::kInvalid, valid.error(), context));
  }
  if (options.dry_run) return DryRun(commands, context);
  const auto connect = ConnectOptionsOf(context);
  if (!connect) return Fail(connect.error());
  auto code = SendOverMqtt(commands, *connect, *qos, context);
  if (!code) return Fail(NothingSent(commands, Verdict::kError, code.error(), context));
  return code;
}

}  // namespace fleetpub::cli
