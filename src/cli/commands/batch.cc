// `fleetpub batch [FILE]`: commands in, results out, a JSON object per line each, over one
// connection. As a co-process it answers line by line; lines that are there together leave
// together.
#include <fmt/format.h>

#include <memory>
#include <optional>

#include "app/run_batch.h"
#include "app/targets.h"
#include "base/line_reader.h"
#include "base/time.h"
#include "cli/environment.h"
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

struct Options {
  std::string file = "-";
  std::chrono::milliseconds reconnect = std::chrono::seconds(60);
  bool stop_on_error = false;
  bool online = false;
  std::string prefix = "soar";
  std::string source = "fleetpub";
  WaitingOptions waiting;
  SendingOptions sending;
  app::VdaOptions vda;
};

// Prints results and remembers the worst. Once it has begun, the first Ctrl-C only stops the reading.
class BatchPrinter final : public app::BatchObserver {
 public:
  explicit BatchPrinter(Output& output) : output_(output) {}

  void Begin() override { stop_.emplace(); }
  void Sent() override { output_.SomethingWasSent(); }
  void Report(const message::Report& report) override {
    const ExitCode code = GetExitCode(report);
    worst_ = Worse(worst_, code);
    output_.JsonLine("{" + report.reference + R"(,"exitCode":)" +
                     std::to_string(static_cast<int>(code)) +
                     ReportJson(report).replace(0, 1, ","));
  }
  [[nodiscard]] Status Flush() override { return output_.Flush(); }
  [[nodiscard]] bool IsStopped() const override { return StopSignal::Received().has_value(); }
  [[nodiscard]] int stop_descriptor() const override { return stop_->descriptor(); }

  [[nodiscard]] ExitCode worst() const { return worst_; }

 private:
  Output& output_;
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

Status ParseDefaults(const Options& options, const config::Config& config,
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

Result<app::BatchRequest> ParseBatchOptions(const Options& options, const config::Config& config) {
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

Result<ExitCode> RunBatch(const Options& options, const Context& context) {
  auto request = ParseBatchOptions(options, context.config);
  if (!request) return Fail(std::move(request.error()));
  context.output.Reads(options.file);
  auto lines = base::LineReader::Open(options.file);
  if (!lines) return Fail(std::move(lines.error()));
  const auto reconnect = request->reconnect;
  BatchPrinter printer(context.output);
  const auto end = app::RunBatch(*std::move(lines), *std::move(request),
                                 MakeEnvironment(context, reconnect), printer, context.output);
  if (!end) return Fail(end.error());
  if (end->reason != app::BatchStop::kEndOfInput && !end->all_read) {
    context.output.PrintError(
        {ErrorKind::kUnexpected,
         fmt::format("{}: {} message{} sent; nothing was sent from line {} on",
                     DescribeStop(end->reason, reconnect), end->sent,
                     end->sent == 1 ? " was" : "s were", end->last_line + 1)});
  }
  ExitCode code = printer.worst();
  if (const auto signal = StopSignal::Received()) code = Worse(code, *signal);
  return end->reason == app::BatchStop::kNoConnection ? Worse(code, ExitCode::kBroker) : code;
}

}  // namespace

Run DeclareBatch(OptionSet& set) {
  const auto options = std::make_shared<Options>();
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
  return [options](const Context& context) { return RunBatch(*options, context); };
}

}  // namespace fleetpub::cli
