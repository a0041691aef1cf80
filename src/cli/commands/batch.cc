// `fleetpub batch [FILE]`: commands in, results out, a JSON object per line each, over one
// connection. As a co-process it answers line by line; lines that are there together leave
// together.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "app/batch_input.h"
#include "app/dry_run.h"
#include "app/targets.h"
#include "base/line_reader.h"
#include "base/text.h"
#include "base/time.h"
#include "cli/environment.h"
#include "cli/listening.h"
#include "cli/options/sending_options.h"
#include "cli/options/soar_options.h"
#include "cli/options/vda_options.h"
#include "cli/options/wait_options.h"
#include "cli/output/exit_code.h"
#include "cli/output/stop_signal.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "delivery/send_all.h"
#include "mqtt/paho/paho_transport.h"

namespace fleetpub::cli {
namespace {

using message::Command;
using message::Report;
using std::chrono::steady_clock;

constexpr std::size_t kLargestBatch = 1'000;

struct Options {
  std::string file = "-";
  std::string reconnect = "60s";
  bool stop_on_error = false;
  std::string prefix = "soar";
  std::string source = "fleetpub";
  WaitingOptions waiting;
  SendingOptions sending;
  app::VdaOptions vda;
};

// What the options ask for.
struct Plan {
  app::LineDefaults defaults;
  delivery::WaitOptions wait;
  delivery::SendOptions send;
  delivery::RateLimiter rate;
  bool is_limited = false;
  std::chrono::milliseconds reconnect{};
  bool stop_on_error = false;

  [[nodiscard]] app::AfterBadLine after_bad_line() const {
    return stop_on_error ? app::AfterBadLine::kPause : app::AfterBadLine::kGoOn;
  }
  [[nodiscard]] bool ReadsAhead() const { return !stop_on_error && !is_limited; }
};

// Prints results and remembers the worst.
class BatchResults {
 public:
  explicit BatchResults(Output& output) : output_(output) {}

  // The report's reference is its line's.
  void Show(const message::Report& report) {
    const ExitCode code = CodeOf(report);
    worst_ = Worse(worst_, code);
    output_.JsonLine("{" + report.reference + R"(,"exitCode":)" +
                     std::to_string(static_cast<int>(code)) +
                     ReportJson(report).replace(0, 1, ","));
  }
  [[nodiscard]] ExitCode worst() const { return worst_; }

 private:
  Output& output_;
  ExitCode worst_ = ExitCode::kDone;
};

// What is to be said of lines before anything is sent.
void Tell(const app::LineGroup& group, BatchResults& results, Output& output) {
  for (const std::string& warning : group.warnings) output.Warn(warning);
  for (const Report& bad : group.bad) results.Show(bad);
}

class Batch {
 public:
  Batch(base::LineReader reader, Plan plan, const mqtt::ConnectOptions& connect,
        const Context& context)
      : plan_(std::move(plan)),
        connect_(connect),
        context_(context),
        results_(context.output),
        input_(std::move(reader), plan_.defaults, plan_.after_bad_line(),
               context.options.schema_directory) {}

  // Errors: nothing was sent.
  Result<ExitCode> Run() {
    auto ledger = OpenLedger(context_, ledger::OpenMode::kCreate);
    if (!ledger) return Fail(ledger.error());
    auto transport = mqtt::ConnectPaho(connect_);
    if (!transport) return Fail(transport.error());
    transport_ = std::move(*transport);
    if (!plan_.defaults.wait_for) {
      app::WarnOfSilentRefusals(connect_.version, plan_.send.qos, context_.output);
    }
    delivery::CommandSession session(transport_, **ledger, plan_.send, plan_.wait, HooksFor());
    while (!IsDone(session)) {
      if (MayRead(session)) SendWhatIsThere(session);
      LookForTheEnd(session);
      if (!IsDone(session)) Wait(session);
    }
    if (transport_ != nullptr) transport_->Disconnect();
    if (!session.trouble()) {
      context_.output.Warn(fmt::format("sent, but not every outcome is in the ledger: {}",
                                       session.trouble().error().message));
    }
    return End();
  }

 private:
  delivery::SessionHooks HooksFor() {
    return {.report = [this](const Report& report) { results_.Show(report); },
            .sent =
                [this] {
                  ++sent_;
                  context_.output.SomethingWasSent();
                },
            .connect = MakeConnectHook(connect_),
            .lost =
                [this](const Error& error) {
                  context_.output.Warn(error.message + ": connecting again");
                },
            .again = [this] { context_.output.Warn("connected again"); },
            .news = [this](std::string_view line) { context_.output.Info(line); }};
  }

  [[nodiscard]] bool IsDone(const delivery::CommandSession& session) const {
    return (input_.ended() || !stopped_.empty()) && session.waiting() == 0;
  }

  // What arrives behind a signal is not sent.
  [[nodiscard]] bool MayRead(const delivery::CommandSession& session) const {
    return !input_.ended() && stopped_.empty() && !StopSignal::Noted() && !session.lost() &&
           session.waiting() < delivery::kMostWaiting;
  }

  void SendWhatIsThere(delivery::CommandSession& session) {
    const auto allowed = plan_.rate.Available(steady_clock::now());
    const std::size_t most = std::min(allowed, plan_.send.batch);
    const app::LineGroup group = input_.Take(most);
    // While the ledger waits for the disk and the broker for us, the next lines are made ready.
    if (plan_.ReadsAhead() && group.commands.size() >= most) input_.ReadAhead(most);
    plan_.rate.Consume(group.commands.size(), steady_clock::now());
    Tell(group, results_, context_.output);
    // A line with many targets may make more than a batch holds.
    std::span<const Command> left = group.commands;
    while (!left.empty()) {
      const auto some = left.first(std::min(left.size(), plan_.send.batch));
      static_cast<void>(session.Send(some));  // the reports say it
      left = left.subspan(some.size());
    }
  }

  // Whatever forbids to go on.
  void LookForTheEnd(delivery::CommandSession& session) {
    const auto flushed = context_.output.Flush();
    if (!stopped_.empty()) return;
    if (!session.lost()) lost_at_ = steady_clock::now();  // at the latest
    if (const auto signal = StopSignal::Noted()) {
      stopped_ = *signal == ExitCode::kInterrupted ? "interrupted" : "terminated";
    } else if (!flushed) {
      stopped_ = "nobody reads the results";
    } else if (plan_.stop_on_error && results_.worst() != ExitCode::kDone) {
      stopped_ = "stopped at the first error";
    } else if (session.lost() && steady_clock::now() >= lost_at_ + plan_.reconnect) {
      stopped_ = fmt::format("no connection within {}", base::FormatElapsed(plan_.reconnect));
      gave_up_ = true;
      session.EndAll({ErrorKind::kBroker,
                      "sent, but the connection was lost before the robot answered: whether it "
                      "was done is not known"});
    }
  }

  void Wait(delivery::CommandSession& session) {
    auto deadline = mqtt::Deadline::max();
    std::vector<int> wake;
    if (!StopSignal::Noted()) wake.push_back(stop_.descriptor());
    if (session.lost() && stopped_.empty()) deadline = lost_at_ + plan_.reconnect;
    if (MayRead(session)) {
      const auto now = steady_clock::now();
      if (plan_.rate.Next() > now) {
        deadline = std::min(deadline, plan_.rate.Next());
      } else if (input_.Ready()) {
        deadline = now;
      } else {
        wake.push_back(input_.descriptor());
      }
    }
    session.WakeOn(std::move(wake));
    session.Listen(deadline);
  }

  Result<ExitCode> End() {
    ExitCode code = results_.worst();
    if (const auto signal = StopSignal::Noted()) code = Worse(code, *signal);
    if (gave_up_) code = Worse(code, ExitCode::kBroker);
    if (!stopped_.empty() && !input_.ended()) {
      context_.output.PrintError(
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
  BatchResults results_;
  app::BatchInput input_;
  StopSignal stop_;
  std::unique_ptr<mqtt::Transport> transport_;
  std::size_t sent_ = 0;
  steady_clock::time_point lost_at_{};
  bool gave_up_ = false;
  std::string stopped_;  // why nothing more is read; empty: it goes on
};

Result<ExitCode> ShowOnly(base::LineReader reader, const Plan& plan, const Context& context) {
  BatchResults results(context.output);
  app::BatchInput input(std::move(reader), plan.defaults, plan.after_bad_line(),
                        context.options.schema_directory);
  auto dry_run = app::DryRun::Open(MakeEnvironment(context).ledger);
  if (!dry_run) return Fail(std::move(dry_run.error()));
  while (!input.ended() && !(plan.stop_on_error && results.worst() != ExitCode::kDone)) {
    input.Await();
    const app::LineGroup group = input.Take(plan.send.batch);
    Tell(group, results, context.output);
    for (const Command& command : group.commands) {
      const auto report = dry_run->Report(command);
      if (report) {
        results.Show(*report);
      } else {
        results.Show(app::BadLineReport(command.reference, {.id = {}, .target = command.target},
                                        report.error()));
      }
    }
    if (auto flushed = context.output.Flush(); !flushed) return Fail(std::move(flushed.error()));
  }
  return results.worst();
}

Result<Plan> PlanOf(const Options& options, const config::Config& config) {
  Plan plan;
  if (options.vda.IsAutomatic()) {
    return Fail(ErrorKind::kUsage,
                "batch does not ask robots for their version: name it with --vda, or with vda in "
                "each line");
  }
  auto resolver = app::DialectResolver::For(options.vda, config);
  if (!resolver) return Fail(std::move(resolver.error()));
  plan.defaults.address = [&config, resolver = *std::move(resolver)](
                              std::string_view word) -> Result<app::AddressedRobot> {
    auto robot = app::ResolveRobot(std::string(word), config);
    if (!robot) return Fail(std::move(robot.error()));
    return resolver.Named(*std::move(robot));
  };
  WaitingOptions waiting_options = options.waiting;
  waiting_options.timeout.clear();  // it also holds for lines that wait on their own account
  const auto waiting = ParseWaitingOptions(waiting_options);
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
  const auto settings = ParseSendingOptions(options.sending);
  if (!settings) return Fail(settings.error());
  plan.send.qos = settings->qos;
  // Each batch waits for the disk once. While nobody waits for a robot's answer, and no
  // acknowledgement comes, it may be as large as what a default broker queues.
  if (settings->qos == mqtt::Qos::kAtMostOnce && !plan.defaults.wait_for)
    plan.send.batch = kLargestBatch;
  plan.rate = settings->rate;
  plan.is_limited = !options.sending.rate.empty();
  const auto reconnect = base::ParseDuration(options.reconnect);
  if (!reconnect) return Fail(reconnect.error());
  plan.reconnect = *reconnect;
  plan.stop_on_error = options.stop_on_error;
  return plan;
}

Result<ExitCode> RunBatch(const Options& options, const Context& context) {
  auto plan = PlanOf(options, context.config);
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
      .Type("FILE");
  DeclareRate(set, options->sending);
  set.AddFlag("--stop-on-error", options->stop_on_error,
              "Read no further line once a result is an error")
      .Group("Sending");
  set.AddOption("--reconnect", options->reconnect,
                "How long to try to connect again when the connection is lost [60s]")
      .Type("TIME")
      .Group("Sending");
  DeclareSendingOptions(set, options->sending);
  DeclareWaitOptions(set, options->waiting);
  DeclareVdaOptions(set, options->vda);
  DeclarePrefix(set, options->prefix);
  DeclareSource(set, options->source);
  return [options](const Context& context) { return RunBatch(*options, context); };
}

}  // namespace fleetpub::cli
