// `fleetpub batch [FILE]`: commands in, results out, a JSON object per line each, over one
// connection. As a co-process it answers line by line; lines that are there together leave
// together.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "app/run_batch.h"
#include "app/targets.h"
#include "base/json.h"
#include "base/line_reader.h"
#include "base/text.h"
#include "base/time.h"
#include "cli/environment.h"
#include "cli/options/report_options.h"
#include "cli/options/sending_options.h"
#include "cli/options/soar_options.h"
#include "cli/options/target_options.h"
#include "cli/options/vda_options.h"
#include "cli/options/wait_options.h"
#include "cli/output/exit_code.h"
#include "cli/output/interrupt.h"
#include "cli/output/stop_signal.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"

namespace fleetpub::cli {
namespace {

struct BatchOptions {
  std::string file = "-";
  std::chrono::milliseconds reconnect = std::chrono::seconds(60);
  bool stop_on_error = false;
  bool online = false;
  std::string prefix = "soar";
  std::string source = "fleetpub";
  WaitingOptions waiting;
  SendingOptions sending;
  app::VdaOptions vda;
  std::vector<std::string> reports;
};

// What became of a line's command, as a case.
TestResult MakeCase(const message::Report& report, ExitCode code, const base::JsonValue& line) {
  const bool was_left_out = report.status == message::CommandStatus::kOffline && !report.error;
  TestResult result{.group = report.target,
                    .id = fmt::format("line {} {}", line["line"].GetUint64(), report.target),
                    .says = report.topic.substr(report.topic.rfind('/') + 1),
                    .verdict = was_left_out              ? app::Verdict::kSkipped
                               : code == ExitCode::kDone ? app::Verdict::kPass
                                                         : app::Verdict::kFail,
                    .why = std::string(GetName(report.status)),
                    .details = {}};
  if (!report.actions.empty()) {
    std::vector<std::string> types;
    for (const auto& action : report.actions) types.push_back(action.type);
    result.says = base::Join(types, ", ");
  }
  if (!report.message.empty()) result.why += ": " + report.message;
  if (const auto* id = base::FindMember(line, "id")) {
    result.details.push_back("id " + base::ToJson(*id));
  }
  if (report.ledger_row > 0) {
    result.details.push_back(fmt::format("fleetpub history show {}", report.ledger_row));
  }
  return result;
}

// Prints results and remembers the worst. Once it has begun, the first Ctrl-C only stops the reading.
class BatchPrinter final : public app::BatchObserver {
 public:
  BatchPrinter(Output& output, bool keeps) : output_(output), keeps_(keeps) {}

  void Begin() override { stop_.emplace(); }
  void Sent() override { output_.SomethingWasSent(); }
  void Report(const message::Report& report) override {
    const ExitCode code = GetExitCode(report);
    worst_ = Worse(worst_, code);
    output_.JsonLine("{" + report.reference + R"(,"exitCode":)" +
                     std::to_string(static_cast<int>(code)) +
                     ReportJson(report).replace(0, 1, ","));
    if (!keeps_) return;
    if (const auto line = base::ParseJson("{" + report.reference + "}")) {
      cases_.emplace_back((*line)["line"].GetUint64(), MakeCase(report, code, *line));
    }
  }
  [[nodiscard]] Status Flush() override { return output_.Flush(); }
  [[nodiscard]] bool IsStopped() const override { return StopSignal::Received().has_value(); }
  [[nodiscard]] int stop_descriptor() const override { return stop_->descriptor(); }

  [[nodiscard]] ExitCode worst() const { return worst_; }
  // In the order of the lines.
  [[nodiscard]] std::vector<TestResult> TakeCases() {
    std::stable_sort(cases_.begin(), cases_.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<TestResult> cases;
    for (auto& [line, one] : cases_) cases.push_back(std::move(one));
    return cases;
  }

 private:
  Output& output_;
  bool keeps_;
  std::vector<std::pair<std::uint64_t, TestResult>> cases_;  // with their lines
  ExitCode worst_ = ExitCode::kDone;
  const InterruptGuard before_;
  std::optional<StopSignal> stop_;
};

std::string DescribeStop(app::BatchStop reason, std::chrono::milliseconds reconnect) {
  switch (reason) {
    case app::BatchStop::kStopped:
      return StopSignal::Received() == ExitCode::kInterrupted ? "interrupted" : "terminated";
    case app::BatchStop::kUnread:
      return "nobody reads the results";
    case app::BatchStop::kFirstError:
      return "stopped at the first error";
    case app::BatchStop::kNoConnection:
      return fmt::format("no connection within {}", base::FormatElapsed(reconnect));
    case app::BatchStop::kEndOfInput:
      break;
  }
  return "";
}

// Beside those of the results. Once everything was sent, it matters no more who reads.
ExitCode CodeOfEnd(const app::BatchEnd& end) {
  if (end.reason == app::BatchStop::kNoConnection) return ExitCode::kBroker;
  const bool is_unread = end.reason == app::BatchStop::kUnread && !end.all_read;
  return is_unread ? ExitCode::kLedger : ExitCode::kDone;
}

Status ParseDefaults(const BatchOptions& options, const config::Config& config,
                     app::BatchRequest& request) {
  auto resolver = app::DialectResolver::Make(options.vda, config);
  if (!resolver) return Fail(std::move(resolver.error()));
  request.topics = resolver->common().topics;
  request.defaults.address = [&config, resolver = *std::move(resolver)](
                                 std::string_view word) -> Result<app::AddressedRobot> {
    auto robot = app::ResolveRobot(std::string(word), config);
    if (!robot) return Fail(std::move(robot.error()));
    return resolver.Resolve(*std::move(robot));
  };
  WaitingOptions waiting_options = options.waiting;
  waiting_options.timeout.reset();  // it also holds for lines that wait on their own account
  const auto waiting = ParseWaitingOptions(waiting_options);
  if (!waiting) return Fail(waiting.error());
  request.defaults.wait_for = waiting->wait_for;
  request.defaults.check = waiting->check;
  request.defaults.online = options.online;
  request.discover = waiting->discover;
  request.defaults.names_end = options.waiting.wait_for.has_value();
  SoarOptions soar;
  soar.prefix = options.prefix;
  soar.source = options.source;
  auto sender = ParseSender(soar);
  if (!sender) return Fail(std::move(sender.error()));
  request.defaults.soar = std::move(*sender);
  return {};
}

Result<app::BatchRequest> ParseBatchOptions(const BatchOptions& options,
                                            const config::Config& config) {
  app::BatchRequest request{.stop_on_error = options.stop_on_error};
  if (auto ok = ParseDefaults(options, config, request); !ok) return Fail(std::move(ok.error()));
  request.wait.total = options.waiting.timeout;
  const auto settings = ParseSendingOptions(options.sending);
  if (!settings) return Fail(settings.error());
  if (options.online && settings->offline) {
    return Fail(ErrorKind::kUsage,
                "--offline asks no broker, and only the broker knows who is online: leave out "
                "--offline or --online");
  }
  request.settings = *settings;
  request.reconnect = options.reconnect;
  return request;
}

Result<ExitCode> RunBatch(const BatchOptions& options, const Context& context) {
  auto request = ParseBatchOptions(options, context.config);
  if (!request) return Fail(std::move(request.error()));
  const auto reports = ParseReportFiles(options.reports);
  if (!reports) return Fail(reports.error());
  TestReport report{.name = "fleetpub batch " + options.file,
                    .properties = {{"broker", FormatSite(context)}},
                    .started = base::WallTime::clock::now(),
                    .results = {}};
  context.output.Reads(options.file);
  auto lines = base::LineReader::Open(options.file);
  if (!lines) return Fail(std::move(lines.error()));
  const auto reconnect = request->reconnect;
  BatchPrinter printer(context.output, !reports->empty());
  const auto end = app::RunBatch(*std::move(lines), *std::move(request),
                                 MakeEnvironment(context, reconnect), printer, context.output);
  if (!end) return Fail(end.error());
  if (end->reason != app::BatchStop::kEndOfInput && !end->all_read) {
    const std::string how = fmt::format("{}: {} message{} sent; nothing was sent from line {} on",
                                        DescribeStop(end->reason, reconnect), end->sent,
                                        end->sent == 1 ? " was" : "s were", end->last_line + 1);
    context.output.PrintError({ErrorKind::kUnexpected, how});
    report.properties.emplace_back("ended early", how);
  }
  report.results = printer.TakeCases();
  if (auto written = WriteReports(*reports, std::move(report)); !written) {
    if (!context.output.something_was_sent()) return Fail(std::move(written.error()));
    context.output.Warn(written.error().message);
  }
  ExitCode code = Worse(printer.worst(), CodeOfEnd(*end));
  if (const auto signal = StopSignal::Received()) code = Worse(code, *signal);
  return code;
}

}  // namespace

Run DeclareBatch(OptionSet& set) {
  const auto options = std::make_shared<BatchOptions>();
  set.AddOption("file", options->file, "The commands, one per line; - or nothing: standard input")
      .Type("FILE");
  DeclareOnline(set, options->online);
  DeclareRate(set, options->sending);
  set.AddFlag("--stop-on-error", options->stop_on_error,
              "Read no further line once a result is an error")
      .Group("Sending");
  set.AddOption("--reconnect", Duration(options->reconnect),
                "How long to try to connect, also again when the connection is lost [60s]")
      .Group("Sending");
  DeclareSendingOptions(set, options->sending);
  DeclareOffline(set, options->sending);
  DeclareWaitOptions(set, options->waiting);
  DeclareCheckOptions(set, options->waiting);
  DeclareVdaOptions(set, options->vda);
  DeclarePrefix(set, options->prefix);
  DeclareSource(set, options->source);
  DeclareReport(set, options->reports);
  return [options](const Context& context) { return RunBatch(*options, context); };
}

}  // namespace fleetpub::cli
