// `fleetpub replay FILE`: says again what the robots of a recording said.
#include "simulator/replay.h"

#include <fmt/format.h>

#include <memory>
#include <vector>

#include "app/dialect_resolver.h"
#include "base/json.h"
#include "base/text.h"
#include "base/time.h"
#include "cli/environment.h"
#include "cli/listening.h"
#include "cli/output/consent.h"
#include "cli/output/interrupt.h"
#include "cli/output/stop_signal.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "mqtt/paho/paho_transport.h"

namespace fleetpub::cli {
namespace {

struct ReplayCommandOptions {
  std::string file;
  std::vector<std::string> maps;
  double speed = 1;
  bool restamp = false;
  bool commands = false;
  bool yes = false;
  bool keep = false;
  bool force = false;
  app::VdaOptions vda;
};

ValueKind SpeedKind(double& speed) {
  return {.type = "N",
          .store = internal::StoreOne(
              speed, [](std::string_view text) { return ParseBetween(text, 0.01, 10'000.0); }),
          .takes = [] { return std::string("a number from 0.01 to 10000"); }};
}

Result<simulator::ReplayOptions> ParseReplayOptions(const ReplayCommandOptions& o,
                                                    const Context& context) {
  if (o.file.empty()) {
    return Fail(ErrorKind::kUsage, "replay needs a recording. try: fleetpub replay shift.jsonl");
  }
  if (o.yes && !o.commands) {
    return Fail(ErrorKind::kUsage, "--yes belongs to --commands: only they need consent");
  }
  const auto dialect = app::ParseDialect(app::WithConfig(o.vda, context.config));
  if (!dialect) return Fail(dialect.error());
  simulator::ReplayOptions options{.file = o.file,
                                   .scheme = dialect->topics,
                                   .mappings = {},
                                   .speed = o.speed,
                                   .restamp = o.restamp,
                                   .commands = o.commands,
                                   .keep = o.keep,
                                   .force = o.force,
                                   .stopped = [] { return StopSignal::Received().has_value(); }};
  for (const std::string& text : o.maps) {
    auto mapping = simulator::ParseRobotMapping(text);
    if (!mapping) return Fail(std::move(mapping.error()));
    options.mappings.push_back(*std::move(mapping));
  }
  return options;
}

// Orders and actions move robots, whoever they were recorded of.
Status AgreeToCommands(const ReplayCommandOptions& o, const simulator::ReplayPlan& plan,
                       const Context& context) {
  if (!o.commands || plan.commands == 0 || o.yes) return {};
  const std::vector<vda5050::RobotAddress> robots(plan.robots.begin(), plan.robots.end());
  const std::string site = FormatSite(context);
  return AskForConsent(
      {.robots = robots, .set = o.file, .title = "old orders and instant actions", .site = site});
}

void ShowEnd(const simulator::Replayed& replayed, const simulator::ReplayPlan& plan,
             const ReplayCommandOptions& o, Output& output) {
  const std::uint64_t left_out = o.commands ? 0 : plan.commands;
  const double late = static_cast<double>(replayed.latest.count()) / 1e3;
  if (output.json()) {
    return output.Line(fmt::format(
        R"({{"file":{},"messages":{},"robots":{},"commandsLeftOut":{},"othersLeftOut":{},"latestMs":{:.3f},"stopped":{},"losses":{},"lostMs":{:.3f},"sentAgain":{}}})",
        base::JsonString(o.file), replayed.messages, plan.robots.size(), left_out, plan.others,
        late, replayed.was_stopped, replayed.losses,
        static_cast<double>(replayed.lost.count()) / 1e3, replayed.again));
  }
  if (replayed.again > 0) {
    output.Warn(
        fmt::format("{} sent a second time: the broker had not acknowledged it, or had not "
                    "kept it, and some may have heard it twice",
                    base::Counted(replayed.again, "message")));
  }
  output.PeopleLine(fmt::format("{} of {} sent{}", replayed.messages,
                                base::Counted(plan.messages, "message"),
                                o.keep ? "" : "; what was retained before is back"));
}

Result<ExitCode> RunReplay(const ReplayCommandOptions& o, const Context& context) {
  Output& output = context.output;
  const auto options = ParseReplayOptions(o, context);
  if (!options) return Fail(options.error());
  const auto plan = simulator::PlanReplay(*options);
  if (!plan) return Fail(plan.error());
  if (auto agreed = AgreeToCommands(o, *plan, context); !agreed) return Fail(agreed.error());
  if (plan->commands > 0 && !o.commands) {
    output.Info(fmt::format("left out: what robots were told, {} in all. --commands sends it, too",
                            base::Counted(plan->commands, "message")));
  }
  if (plan->others > 0) {
    output.Info(fmt::format("left out: {} of other robots or topics",
                            base::Counted(plan->others, "message")));
  }
  if (plan->faults.unreadable > 0) {
    output.Warn(fmt::format("{} lines could not be read, the first at {}", plan->faults.unreadable,
                            plan->faults.first));
  }
  auto connect = MakeConnectOptions(context);
  if (!connect) return Fail(std::move(connect.error()));
  const InterruptGuard interrupt;
  auto transport = mqtt::ConnectPahoAsRobot(*connect);
  if (!transport) return Fail(std::move(transport.error()));
  const StopSignal stop;
  output.Info(fmt::format(
      "replaying {} of {} in {} at {}; Ctrl-C ends it", base::Counted(plan->messages, "message"),
      base::Counted(plan->robots.size(), "robot"),
      base::FormatElapsed(
          std::chrono::duration_cast<std::chrono::nanoseconds>(plan->lasts / o.speed)),
      (*transport)->server().broker.ToString()));
  const simulator::ReplayHooks hooks = {
      .open = [&] { return mqtt::ConnectPahoAsRobot(*connect); },
      .lost = [&](const Error& error) { output.Lost(error); },
      .again =
          [&](std::chrono::microseconds lasted) {
            output.Warn(fmt::format("connected again: what follows comes {} later",
                                    base::FormatElapsed(lasted)));
          }};
  const auto replayed = simulator::Replay(*options, *plan, *std::move(transport), hooks);
  if (!replayed) return Fail(replayed.error());
  ShowEnd(*replayed, *plan, o, output);
  return StopSignal::Received().value_or(ExitCode::kDone);
}

}  // namespace

Run DeclareReplay(OptionSet& set) {
  constexpr const char* kReplay = "Replay";
  const auto options = std::make_shared<ReplayCommandOptions>();
  set.AddOption("file", options->file, "A recording").Type("FILE");
  set.AddOption("--speed", SpeedKind(options->speed), "So many times as fast [1]").Group(kReplay);
  set.AddOption("--map", options->maps,
                "Only this robot, as another: KIT/0001=TEST/0001, 'KIT/*=TEST/*'; repeatable")
      .Type("FROM=TO")
      .OneValueEach()
      .Group(kReplay);
  set.AddFlag("--restamp", options->restamp, "Headers count from 0 and are dated now")
      .Group(kReplay);
  set.AddFlag("--commands", options->commands,
              "Orders, instant actions, zone sets and responses, too: robots obey them")
      .Group(kReplay);
  set.AddFlag("--yes", options->yes, "Do not ask before --commands").Group(kReplay);
  set.AddFlag("--keep", options->keep, "Leave retained messages at the end").Group(kReplay);
  set.AddFlag("--force", options->force, "In the place of robots that are ONLINE").Group(kReplay);
  DeclareTopicOptions(set, options->vda);
  return [options](const Context& context) { return RunReplay(*options, context); };
}

}  // namespace fleetpub::cli
