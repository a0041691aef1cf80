// `fleetpub watch [PATTERN]`: the fleet, live. On a terminal redrawn in place; otherwise a line for
// each change.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "app/targets.h"
#include "base/json.h"
#include "base/text.h"
#include "base/time.h"
#include "base/width.h"
#include "cli/environment.h"
#include "cli/listening.h"
#include "cli/output/fleet_table.h"
#include "cli/output/screen.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"

namespace fleetpub::cli {
namespace {

using std::chrono::seconds;
using std::chrono::steady_clock;
using vda5050::FleetView;
using vda5050::RobotView;

constexpr seconds kLongestStill{1};  // ages grow while nothing happens

struct Options {
  FleetOptions fleet;
  std::optional<std::chrono::milliseconds> duration;
};

class LineDisplay final : public app::FleetDisplay {
 public:
  explicit LineDisplay(Output& output) : output_(output) {}

  // Only what is shown counts: a robot repeats its state every few seconds.
  void Changed(const RobotView& robot) override {
    const bool json = output_.json();
    const std::string line = json ? FleetJson(robot) : FleetLine(robot, output_);
    const std::size_t sum = std::hash<std::string>{}(line);
    const auto [last, is_first] = sums_.try_emplace(robot.robot, sum);
    if (!is_first && std::exchange(last->second, sum) == sum) return;
    if (is_first) app::WarnOfEscapedNames({&robot.robot, 1}, output_);
    const auto now = base::WallTime::clock::now();
    output_.Line(json ? fmt::format(R"({{"time":"{}",{}}})", base::FormatTimestamp(now), line)
                      : fmt::format("{}  {}", base::FormatLocal(now), line));
    Output::FlushNow();  // a signal may end us before the next Refresh()
  }

  void Lost(const Error& error) override { output_.Lost(error); }
  void ConnectedAgain() override { output_.ConnectedAgain(); }

  Result<bool> Refresh(const FleetView& view) override {
    if (view.abridged() > 0 && !std::exchange(has_warned_, true)) {
      output_.Warn(app::AbridgedWarning(view.abridged()));
    }
    if (auto ok = output_.Flush(); !ok) return Fail(std::move(ok.error()));
    return true;
  }

 private:
  Output& output_;
  std::map<vda5050::RobotAddress, std::size_t> sums_;  // of the last line; the lines are long
  bool has_warned_ = false;
};

class ScreenDisplay final : public app::FleetDisplay {
 public:
  ScreenDisplay(std::string title, Output& output) : title_(std::move(title)), output_(output) {}

  void Changed(const RobotView& /*robot*/) override { is_stale_ = true; }
  void Lost(const Error& error) override {
    trouble_ = base::Printable(error.message) + ": connecting again";
    is_stale_ = true;
  }
  void ConnectedAgain() override {
    trouble_.clear();
    is_stale_ = true;
  }

  Result<bool> Refresh(const FleetView& view) override {
    for (char key = screen_.Key(); key != 0; key = screen_.Key()) {
      if (key == 'q' || key == 'Q') return false;
    }
    const auto now = steady_clock::now();
    if (screen_.WasDisturbed() || is_stale_ || now >= drawn_ + kLongestStill) {
      Draw(view);
      is_stale_ = false;
      drawn_ = now;
    }
    return true;
  }

 private:
  void Draw(const FleetView& view) {
    constexpr std::size_t kFrame = 3;  // title, trouble, the table's header
    const auto [rows, columns] = screen_.size();
    if (std::exchange(columns_, columns) != columns) widths_.clear();
    auto robots = view.robots();
    const std::size_t room = rows > kFrame ? rows - kFrame : 0;
    const std::size_t hidden = robots.size() > room ? robots.size() - room + 1 : 0;
    std::vector<Row> table;
    const auto now = base::WallTime::clock::now();
    const std::size_t shown = robots.size() - std::min(hidden, robots.size());
    for (std::size_t i = 0; i < shown; ++i) table.push_back(FleetRow(*robots[i], now));

    std::string trouble = trouble_;
    if (trouble.empty() && view.abridged() > 0) trouble = app::AbridgedWarning(view.abridged());
    if (trouble.empty()) {
      std::vector<vda5050::RobotAddress> names;
      names.reserve(robots.size());
      for (const RobotView* robot : robots) names.push_back(robot->robot);
      trouble = app::DescribeEscapedNames(names);
    }
    const auto line = [&, width = columns](Tone tone, std::string_view text) {
      return output_.Toned(tone, base::Shortened(width, text));
    };
    std::vector<std::string> lines = {line(Tone::kPlain, Title(robots, now)),
                                      line(Tone::kBad, trouble)};
    const auto body = TableLines(FleetColumns(), table, columns, output_, &widths_);
    lines.insert(lines.end(), body.begin(), body.end());
    if (hidden > 0) {
      lines.push_back(line(
          Tone::kDim,
          fmt::format("{} more are not shown: a larger window or fewer TARGETs help", hidden)));
    }
    lines.resize(std::min(lines.size(), rows));
    screen_.Draw(lines);
  }

  [[nodiscard]] std::string Title(const std::vector<const RobotView*>& robots,
                                  base::WallTime now) const {
    const auto online = std::count_if(robots.begin(), robots.end(),
                                      [](const RobotView* robot) { return robot->IsOnline(); });
    // What matters most comes first: a narrow window cuts the rest.
    return fmt::format("{} robot{}, {} online   q quits   {}   {}", robots.size(),
                       robots.size() == 1 ? "" : "s", online, base::FormatLocal(now), title_);
  }

  std::string title_;
  Output& output_;
  std::string trouble_;
  bool is_stale_ = true;
  std::size_t columns_ = 0;
  std::vector<std::size_t> widths_;  // of the table, which only grows until the window changes
  steady_clock::time_point drawn_;
  Screen screen_;
};

std::unique_ptr<app::FleetDisplay> MakeDisplay(const Options& o, const mqtt::BrokerUrl& broker,
                                               const Context& context) {
  // A trace on standard error would run over the screen.
  if (context.output.json() || !context.options.debug.empty() || !Screen::IsPossible()) {
    EndQuietlyOnSignals();
    return std::make_unique<LineDisplay>(context.output);
  }
  return std::make_unique<ScreenDisplay>(
      fmt::format("{}   {}", broker.ToString(), app::FormatFleetName(o.fleet.words)),
      context.output);
}

Result<ExitCode> RunWatch(const Options& o, const Context& context) {
  const auto watched = app::WatchFleet(
      {.words = o.fleet.words, .vda = o.fleet.vda}, FindEnd(o.duration), MakeEnvironment(context),
      [&](const mqtt::BrokerUrl& broker) { return MakeDisplay(o, broker, context); },
      context.output);
  if (!watched) return Fail(watched.error());
  return ExitCode::kDone;
}

}  // namespace

Run DeclareWatch(OptionSet& set) {
  const auto options = std::make_shared<Options>();
  DeclareFleetOptions(set, options->fleet);
  set.AddOption("--for", Duration(options->duration), "End after this time [on q or Ctrl-C]")
      .Group("Waiting");
  return [options](const Context& context) { return RunWatch(*options, context); };
}

}  // namespace fleetpub::cli
