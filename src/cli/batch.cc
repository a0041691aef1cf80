// `fleetpub batch [FILE]`: commands in, results out, a JSON object per line each, over one
// connection. As a co-process it answers line by line; lines that are there together leave
// together.
#include <fmt/format.h>
#include <poll.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <memory>

#include "base/json.h"
#include "base/line_reader.h"
#include "base/text.h"
#include "base/time.h"
#include "cli/batch_line.h"
#include "cli/dry_run.h"
#include "cli/listening.h"
#include "cli/option_set.h"
#include "cli/sending.h"
#include "cli/soar_options.h"
#include "cli/stop_signal.h"
#include "cli/subcommand.h"
#include "cli/vda_options.h"
#include "cli/wait_options.h"
#include "dispatch/pace.h"
#include "dispatch/stream.h"
#include "mqtt/paho_transport.h"

namespace fleetpub::cli {
namespace {

using dispatch::Command;
using dispatch::Report;
using dispatch::Verdict;
using std::chrono::steady_clock;

// More text than that is not read before what there is has left.
constexpr std::size_t kGroupBytes = std::size_t{1024} * 1024;
// So many wait for their robots at once: more are not read.
constexpr std::size_t kMostWaiting = 10'000;

struct Options {
  std::string file = "-";
  std::string rate;
  std::string reconnect = "60s";
  bool stop_on_error = false;
  std::string prefix = "soar";
  std::string source = "fleetpub";
  WaitingOptions waiting;
  SendingOptions sending;
  VdaOptions vda;
};

// What the options ask for.
struct Plan {
  LineDefaults defaults;
  dispatch::WaitOptions wait;
  dispatch::SendOptions send;
  dispatch::Pace pace;
  std::chrono::milliseconds reconnect{};
  bool stop_on_error = false;
};

// Prints results and remembers the worst.
class Results {
 public:
  explicit Results(Output& output) : output_(output) {}

  void Show(const Report& report) {
    const ExitCode code = CodeOf(report);
    worst_ = Worse(worst_, code);
    output_.Line(fmt::format(R"({{{},"exitCode":{},{})", report.reference, static_cast<int>(code),
                             std::string_view(ReportJson(report)).substr(1)));
  }

  void ShowBad(std::string reference, const LineOrigin& origin, const Error& error) {
    Report report;
    report.reference = std::move(reference);
    report.target = origin.target;
    report.message = error.message;
    // Whatever is wrong with a line, the line is wrong; unless it could not even be read.
    const bool is_line = error.kind == ErrorKind::kInvalid || error.kind == ErrorKind::kUsage;
    report.verdict = is_line ? Verdict::kInvalid : Verdict::kError;
    report.error = is_line ? ErrorKind::kInvalid : error.kind;
    Show(report);
  }

  [[nodiscard]] ExitCode worst() const { return worst_; }

 private:
  Output& output_;
  ExitCode worst_ = ExitCode::kDone;
};

// The lines, made into commands as far as they are there.
class Input {
 public:
  Input(base::LineReader reader, const Plan& plan, const Context& context, Results& results)
      : reader_(std::move(reader)),
        plan_(plan),
        context_(context),
        results_(results),
        parser_(plan.defaults, context.options.schema_directory) {}

  // At most about so many commands, without waiting for any.
  std::vector<Command> Take(std::size_t most) {
    std::vector<Command> commands;
    std::size_t bytes = 0;
    while (!ended_ && commands.size() < most && bytes < kGroupBytes && reader_.Ready(kLongest)) {
      const auto line = reader_.Next(kLongest);
      if (line && !*line) {
        ended_ = true;
        break;
      }
      ++number_;
      if (line) bytes += (*line)->size();
      if (!TakeLine(line, commands) && plan_.stop_on_error) break;
    }
    return commands;
  }

  // Until there is something to read, be it the end.
  void Await() const {
    pollfd arrived{reader_.descriptor(), POLLIN, 0};
    poll(&arrived, 1, -1);
  }

  [[nodiscard]] bool ended() const { return ended_; }
  [[nodiscard]] bool Ready() { return reader_.Ready(kLongest); }
  [[nodiscard]] int descriptor() const { return reader_.descriptor(); }
  /// Of the last line that was taken.
  [[nodiscard]] std::size_t number() const { return number_; }

 private:
  static constexpr std::size_t kLongest = base::JsonLimits{}.bytes;

  // False: it was bad.
  bool TakeLine(const Result<std::optional<std::string_view>>& line,
                std::vector<Command>& commands) {
    LineOrigin origin;
    if (!line) {
      results_.ShowBad(ReferenceOf(origin), origin, line.error());
      return false;
    }
    if ((*line)->find_first_not_of(" \t\r") == std::string_view::npos) return true;
    auto parsed = parser_.Parse(**line, origin);
    if (!parsed) {
      results_.ShowBad(ReferenceOf(origin), origin, parsed.error());
      return false;
    }
    for (const std::string& warning : parsed->warnings) {
      context_.output.Warn(fmt::format("line {}: {}", number_, warning));
    }
    for (Command& command : parsed->commands) {
      command.reference = ReferenceOf(origin);
      commands.push_back(std::move(command));
    }
    return true;
  }

  [[nodiscard]] std::string ReferenceOf(const LineOrigin& origin) const {
    return origin.id.empty() ? fmt::format(R"("line":{})", number_)
                             : fmt::format(R"("line":{},"id":{})", number_, origin.id);
  }

  base::LineReader reader_;
  const Plan& plan_;
  const Context& context_;
  Results& results_;
  LineParser parser_;
  std::size_t number_ = 0;
  bool ended_ = false;
};

class Batch {
 public:
  Batch(base::LineReader reader, Plan plan, const mqtt::ConnectOptions& connect,
        const Context& context)
      : plan_(std::move(plan)),
        connect_(connect),
        context_(context),
        results_(context.output),
        input_(std::move(reader), plan_, context, results_) {}

  // Errors: nothing was sent.
  Result<ExitCode> Run() {
    auto ledger = OpenLedger(context_, ledger::OpenMode::kCreate);
    if (!ledger) return Fail(ledger.error());
    auto transport = mqtt::ConnectPaho(connect_);
    if (!transport) return Fail(transport.error());
    transport_ = std::move(*transport);
    dispatch::Stream stream(transport_, **ledger, plan_.send, plan_.wait, HooksFor());
    while (!IsDone(stream)) {
      // Before reading: what arrives behind a signal is not sent.
      LookForTheEnd(stream);
      if (MayRead(stream)) SendWhatIsThere(stream);
      LookForTheEnd(stream);
      if (!IsDone(stream)) Wait(stream);
    }
    if (transport_ != nullptr) transport_->Disconnect();
    if (!stream.trouble()) {
      context_.output.Warn(fmt::format("sent, but not every outcome is in the ledger: {}",
                                       stream.trouble().error().message));
    }
    return End();
  }

 private:
  dispatch::StreamHooks HooksFor() {
    return {.report = [this](const Report& report) { results_.Show(report); },
            .sent =
                [this] {
                  ++sent_;
                  context_.output.SomethingWasSent();
                },
            .connect = ConnectHookOf(connect_),
            .lost =
                [this](const Error& error) {
                  lost_at_ = steady_clock::now();
                  context_.output.Warn(error.message + ": connecting again");
                },
            .again = [this] { context_.output.Warn("connected again"); }};
  }

  [[nodiscard]] bool IsDone(const dispatch::Stream& stream) const {
    return (input_.ended() || !stopped_.empty()) && stream.waiting() == 0;
  }

  [[nodiscard]] bool MayRead(const dispatch::Stream& stream) const {
    return !input_.ended() && stopped_.empty() && !stream.lost() && stream.waiting() < kMostWaiting;
  }

  void SendWhatIsThere(dispatch::Stream& stream) {
    const auto allowed = plan_.pace.Allowance(steady_clock::now());
    const auto commands = input_.Take(std::min(allowed, plan_.send.batch));
    plan_.pace.Took(commands.size(), steady_clock::now());
    // A line with many targets may make more than a bracket holds.
    std::span<const Command> left = commands;
    while (!left.empty()) {
      const auto some = left.first(std::min(left.size(), plan_.send.batch));
      static_cast<void>(stream.Send(some));  // the reports say it
      left = left.subspan(some.size());
    }
  }

  // Whatever forbids to go on.
  void LookForTheEnd(dispatch::Stream& stream) {
    const auto flushed = context_.output.Flush();
    if (!stopped_.empty()) return;
    if (const auto signal = StopSignal::Noted()) {
      stopped_ = *signal == ExitCode::kInterrupted ? "interrupted" : "terminated";
    } else if (!flushed) {
      stopped_ = "nobody reads the results";
    } else if (plan_.stop_on_error && results_.worst() != ExitCode::kDone) {
      stopped_ = "stopped at the first error";
    } else if (stream.lost() && steady_clock::now() >= lost_at_ + plan_.reconnect) {
      stopped_ = fmt::format("no connection within {}", base::FormatElapsed(plan_.reconnect));
      gave_up_ = true;
      stream.EndAll({ErrorKind::kBroker,
                     "sent, but the connection was lost before the robot answered: whether it "
                     "was done is not known"});
    }
  }

  void Wait(dispatch::Stream& stream) {
    auto deadline = mqtt::Deadline::max();
    std::vector<int> wake;
    if (!StopSignal::Noted()) wake.push_back(stop_.descriptor());
    if (stream.lost() && stopped_.empty()) deadline = lost_at_ + plan_.reconnect;
    if (MayRead(stream)) {
      const auto now = steady_clock::now();
      if (plan_.pace.Next() > now) {
        deadline = std::min(deadline, plan_.pace.Next());
      } else if (input_.Ready()) {
        deadline = now;
      } else {
        wake.push_back(input_.descriptor());
      }
    }
    stream.WakeOn(std::move(wake));
    stream.Listen(deadline);
  }

  Result<ExitCode> End() {
    ExitCode code = results_.worst();
    if (const auto signal = StopSignal::Noted()) code = Worse(code, *signal);
    if (gave_up_) code = Worse(code, ExitCode::kBroker);
    if (!stopped_.empty() && !input_.ended()) {
      context_.output.Complain(
          {ErrorKind::kUnexpected,
           fmt::format("{}: {} message{} sent; nothing was sent from line "
                       "{} on",
                       stopped_, sent_, sent_ == 1 ? " was" : "s were", input_.number() + 1)});
    }
    return code;
  }

  Plan plan_;
  const mqtt::ConnectOptions& connect_;
  const Context& context_;
  Results results_;
  Input input_;
  StopSignal stop_;
  std::unique_ptr<mqtt::Transport> transport_;
  std::size_t sent_ = 0;
  steady_clock::time_point lost_at_{};
  bool gave_up_ = false;
  std::string stopped_;  // why nothing more is read; empty: it goes on
};

Result<ExitCode> ShowOnly(base::LineReader reader, const Plan& plan, const Context& context) {
  Results results(context.output);
  Input input(std::move(reader), plan, context, results);
  auto dry_run = DryRun::Open(context);
  if (!dry_run) return Fail(std::move(dry_run.error()));
  while (!input.ended() && !(plan.stop_on_error && results.worst() != ExitCode::kDone)) {
    input.Await();
    for (const Command& command : input.Take(plan.send.batch)) {
      const auto report = dry_run->Report(command);
      if (report) {
        results.Show(*report);
      } else {
        results.ShowBad(command.reference, {.id = {}, .target = command.target}, report.error());
      }
    }
    if (auto flushed = context.output.Flush(); !flushed) return Fail(std::move(flushed.error()));
  }
  return results.worst();
}

Result<dispatch::Pace> PaceOf(const std::string& text) {
  if (text.empty()) return dispatch::Pace();
  double rate = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), rate);
  constexpr double kSlowest = 1e-3;
  constexpr double kFastest = 1e6;
  if (error == std::errc() && end == text.data() + text.size() && rate >= kSlowest &&
      rate <= kFastest) {
    return dispatch::Pace(rate);
  }
  return Fail(ErrorKind::kUsage, fmt::format("--rate takes messages per second, from 0.001 to "
                                             "1000000, not '{}'",
                                             base::Printable(text)));
}

Result<Plan> PlanOf(const Options& options) {
  Plan plan;
  if (options.vda.IsAutomatic()) {
    return Fail(ErrorKind::kUsage,
                "batch does not ask robots for their version: name it with --vda, or with vda in "
                "each line");
  }
  auto dialect = DialectOf(options.vda);
  if (!dialect) return Fail(std::move(dialect.error()));
  plan.defaults.dialect = std::move(*dialect);
  WaitingOptions waiting_options = options.waiting;
  waiting_options.timeout.clear();  // it also holds for lines that wait on their own account
  const auto waiting = WaitingOf(waiting_options);
  if (!waiting) return Fail(waiting.error());
  plan.defaults.wait_for = waiting->wait_for;
  plan.defaults.names_end = !options.waiting.wait_for.empty();
  if (!options.waiting.timeout.empty()) {
    const auto total = base::ParseDuration(options.waiting.timeout);
    if (!total) return Fail(total.error());
    plan.wait.total = *total;
  }
  SoarOptions soar;
  soar.prefix = options.prefix;
  soar.source = options.source;
  auto sender = SenderOf(soar);
  if (!sender) return Fail(std::move(sender.error()));
  plan.defaults.soar = std::move(*sender);
  const auto qos = QosOf(options.sending.qos);
  if (!qos) return Fail(qos.error());
  plan.send.qos = *qos;
  const auto pace = PaceOf(options.rate);
  if (!pace) return Fail(pace.error());
  plan.pace = *pace;
  const auto reconnect = base::ParseDuration(options.reconnect);
  if (!reconnect) return Fail(reconnect.error());
  plan.reconnect = *reconnect;
  plan.stop_on_error = options.stop_on_error;
  return plan;
}

Result<ExitCode> RunBatch(const Options& options, const Context& context) {
  auto plan = PlanOf(options);
  if (!plan) return Fail(std::move(plan.error()));
  auto reader = base::LineReader::Open(options.file);
  if (!reader) return Fail(std::move(reader.error()));
  if (options.sending.dry_run) return ShowOnly(std::move(*reader), *plan, context);
  const auto connect = ConnectOptionsOf(context);
  if (!connect) return Fail(connect.error());
  plan->send.acknowledge_timeout = connect->connect_timeout;
  auto code = Batch(std::move(*reader), std::move(*plan), *connect, context).Run();
  if (!code) code.error().message = "nothing was sent: " + code.error().message;
  return code;
}

}  // namespace

Run DeclareBatch(OptionSet& set) {
  const auto options = std::make_shared<Options>();
  set.AddOption("file", options->file, "The commands, one per line; - or nothing: standard input")
      ->type_name("FILE");
  set.AddOption("--rate", options->rate, "At most so many messages per second [no limit]")
      ->type_name("N")
      ->group("Sending");
  set.AddFlag("--stop-on-error", options->stop_on_error,
              "Read no further line once a result is an error")
      ->group("Sending");
  set.AddOption("--reconnect", options->reconnect,
                "How long to try to connect again when the connection is lost [60s]")
      ->type_name("TIME")
      ->group("Sending");
  DeclareSendingOptions(set, options->sending);
  DeclareWaitOptions(set, options->waiting);
  DeclareVdaOptions(set, options->vda);
  DeclarePrefix(set, options->prefix);
  DeclareSource(set, options->source);
  return [options](const Context& context) { return RunBatch(*options, context); };
}

}  // namespace fleetpub::cli
