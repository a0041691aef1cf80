// `fleetpub watch [PATTERN]`: the fleet, live. On a terminal redrawn in place; otherwise a line for
// each change.
#include <fmt/format.h>

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "app/targets.h"
#include "base/json.h"
#include "base/text.h"
#include "base/time.h"
#include "cli/environment.h"
#include "cli/listening.h"
#include "cli/output/fleet_browser.h"
#include "cli/output/fleet_table.h"
#include "cli/output/screen.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"

namespace fleetpub::cli {
namespace {

using app::Fleet;
using app::ListedRobot;
using std::chrono::seconds;
using std::chrono::steady_clock;

constexpr seconds kNotice{3};
constexpr seconds kLongestStill{1};  // ages grow while nothing happens

struct WatchOptions {
  FleetOptions fleet;
  FleetViewOptions view;
  std::optional<std::chrono::milliseconds> duration;
  std::string from;
};

class LineDisplay final : public app::FleetDisplay {
 public:
  LineDisplay(const app::Environment& environment, Output& output)
      : environment_(environment), output_(output) {}

  // Only what is shown counts: a robot repeats its state every few seconds.
  void Changed(const ListedRobot& robot) override {
    const bool json = output_.json();
    const std::string line = json ? FleetJson(robot) : FleetLine(robot, output_);
    const std::size_t sum = std::hash<std::string>{}(line);
    const auto [last, is_first] = sums_.try_emplace(robot.first, sum);
    if (!is_first && std::exchange(last->second, sum) == sum) return;
    if (is_first) app::WarnOfEscapedNames({&robot.first, 1}, output_);
    const auto now = environment_.Now();
    output_.Line(json ? fmt::format(R"({{"time":"{}",{}}})", base::FormatTimestamp(now), line)
                      : fmt::format("{}  {}", base::FormatLocal(now), line));
    if (!environment_.recording)
      Output::FlushNow();  // a signal may end us before the next Refresh()
  }

  void Lost(const Error& error) override { output_.Lost(error); }
  void ConnectedAgain() override { output_.ConnectedAgain(); }

  Result<bool> Refresh(const Fleet& fleet) override {
    if (fleet.directory().abridged() > 0 && !std::exchange(has_warned_, true)) {
      output_.Warn(app::AbridgedWarning(fleet.directory().abridged()));
    }
    if (auto ok = output_.Flush(); !ok) return Fail(std::move(ok.error()));
    return true;
  }

 private:
  const app::Environment& environment_;
  Output& output_;
  std::map<vda5050::RobotAddress, std::size_t> sums_;  // of the last line; the lines are long
  bool has_warned_ = false;
};

class ScreenDisplay final : public app::FleetDisplay {
 public:
  ScreenDisplay(std::string title, SortBy by, app::AskHook ask, Output& output)
      : title_(std::move(title)), by_(by), ask_(std::move(ask)), browser_(output) {}

  void Changed(const ListedRobot& robot) override {
    is_stale_ = true;
    const auto& [address, entry] = robot;
    Heard& heard = heard_[address];
    if (entry.state && std::exchange(heard.state, entry.state.get()) != entry.state.get()) {
      heard.at = steady_clock::now();
    }
  }
  void Lost(const Error& error) override {
    trouble_ = base::Printable(error.message) + ": connecting again";
    is_stale_ = true;
  }
  void ConnectedAgain() override {
    trouble_.clear();
    is_stale_ = true;
  }

  Result<bool> Refresh(const Fleet& fleet) override {
    for (int key = Screen::ReadKey(); key != kNoKey; key = Screen::ReadKey()) {
      is_stale_ = true;
      switch (browser_.Press(key)) {
        case FleetBrowser::Wish::kQuit:
          return false;
        case FleetBrowser::Wish::kAsk:
          notice_ = ask_(browser_.shown());
          noticed_ = steady_clock::now();
          break;
        case FleetBrowser::Wish::kNothing:
          break;
      }
    }
    const auto now = steady_clock::now();
    if (Screen::WasDisturbed() || is_stale_ || now >= drawn_ + kLongestStill) {
      Draw(fleet, now);
      is_stale_ = false;
      drawn_ = now;
    }
    return true;
  }

 private:
  // When the last state came.
  struct Heard {
    const vda5050::LiveState* state = nullptr;
    std::optional<steady_clock::time_point> at;
  };

  void Draw(const Fleet& fleet, steady_clock::time_point now) {
    auto robots = fleet.robots();
    SortRobots(robots, by_);
    const auto silence = [&](const vda5050::RobotAddress& robot) {
      const auto heard = heard_.find(robot);
      const bool is_known = heard != heard_.end() && heard->second.at;
      return is_known ? std::optional<std::chrono::nanoseconds>(now - *heard->second.at)
                      : std::nullopt;
    };
    screen_.Draw(browser_.Lines(robots,
                                {.size = Screen::size(),
                                 .now = base::WallTime::clock::now(),
                                 .title = title_,
                                 .trouble = DescribeTrouble(fleet, robots)},
                                silence));
  }

  [[nodiscard]] std::string DescribeTrouble(const Fleet& fleet,
                                            const FleetBrowser::Robots& robots) const {
    if (!trouble_.empty()) return trouble_;
    if (steady_clock::now() < noticed_ + kNotice) return notice_;
    const std::size_t abridged = fleet.directory().abridged();
    if (abridged > 0) return app::AbridgedWarning(abridged);
    std::vector<vda5050::RobotAddress> names;
    names.reserve(robots.size());
    for (const ListedRobot* robot : robots) names.push_back(robot->first);
    return app::DescribeEscapedNames(names);
  }

  std::string title_;
  SortBy by_;
  app::AskHook ask_;
  FleetBrowser browser_;
  std::map<vda5050::RobotAddress, Heard> heard_;
  std::string trouble_;
  std::string notice_;
  steady_clock::time_point noticed_;
  bool is_stale_ = true;
  steady_clock::time_point drawn_;
  Screen screen_;
};

std::unique_ptr<app::FleetDisplay> MakeDisplay(const WatchOptions& o, const mqtt::BrokerUrl& broker,
                                               const Fleet& fleet, app::AskHook ask,
                                               const app::Environment& environment,
                                               const Context& context) {
  // A trace on standard error would run over the screen; a recording is over at once.
  if (environment.recording || context.output.json() || !context.options.debug.empty() ||
      !Screen::IsPossible()) {
    EndQuietlyOnSignals();
    return std::make_unique<LineDisplay>(environment, context.output);
  }
  return std::make_unique<ScreenDisplay>(fmt::format("{}   {}", broker.ToString(), fleet.name()),
                                         o.view.sort.value_or(SortBy::kTrouble), std::move(ask),
                                         context.output);
}

Result<ExitCode> RunWatch(const WatchOptions& o, const Context& context) {
  auto request = ParseFleetOptions(o.fleet);
  if (!request) return Fail(request.error());
  request->problems = o.view.problems;
  if (o.duration && !o.from.empty()) return Fail(NoTimeFrom("--for"));
  const auto environment = MakeEnvironment(context, o.from, delivery::Play::kAll);
  const auto watched = app::WatchFleet(
      *std::move(request), FindEnd(o.duration), environment,
      [&](const mqtt::BrokerUrl& broker, const Fleet& fleet, app::AskHook ask) {
        return MakeDisplay(o, broker, fleet, std::move(ask), environment, context);
      },
      context.output);
  if (!watched) return Fail(watched.error());
  TellRecording(environment, context.output);
  return ExitCode::kDone;
}

}  // namespace

Run DeclareWatch(OptionSet& set) {
  const auto options = std::make_shared<WatchOptions>();
  DeclareFleetOptions(set, options->fleet);
  DeclareFleetViewOptions(set, options->view);
  DeclareFrom(set, options->from);
  set.AddOption("--for", Duration(options->duration), "End after this time [on q or Ctrl-C]")
      .Group("Waiting");
  return [options](const Context& context) { return RunWatch(*options, context); };
}

}  // namespace fleetpub::cli
