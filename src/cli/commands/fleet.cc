// `fleetpub fleet [PATTERN]`: the robots known to the broker, and how they are.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "app/confirm_times.h"
#include "base/text.h"
#include "base/time.h"
#include "base/width.h"
#include "cli/environment.h"
#include "cli/listening.h"
#include "cli/output/fleet_metrics.h"
#include "cli/output/fleet_table.h"
#include "cli/output/screen.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "vda5050/model/robot_address.h"

namespace fleetpub::cli {
namespace {

using app::ListedRobot;

struct FleetTableOptions {
  FleetDiscoveryOptions fleet;
  FleetViewOptions view;
};

std::vector<const ListedRobot*> Sorted(const app::Fleet& fleet, SortBy by) {
  auto robots = fleet.robots();
  SortRobots(robots, by);
  return robots;
}

std::vector<Row> MakeRows(const std::vector<const ListedRobot*>& robots, base::WallTime now) {
  std::vector<Row> rows;
  rows.reserve(robots.size());
  for (const ListedRobot* robot : robots) rows.push_back(FleetRow(*robot, now));
  return rows;
}

void Show(const app::Fleet& fleet, const FleetTableOptions& o, base::WallTime now, Output& output) {
  if (output.json()) {
    for (const ListedRobot* robot : Sorted(fleet, o.view.sort.value_or(SortBy::kName))) {
      output.Line("{" + FleetJson(*robot) + "}");
    }
    return;
  }
  const auto robots = Sorted(fleet, o.view.sort.value_or(SortBy::kTrouble));
  if (!robots.empty()) PrintTable(FleetColumns(), MakeRows(robots, now), output);
}

// Of these robots at this broker. Without a ledger that can be read everything else is told.
std::optional<app::ConfirmTimes> FindConfirmTimes(const app::Fleet& fleet,
                                                  const app::Environment& environment,
                                                  const Context& context) {
  const auto brokers = ParseBrokers(context.options);
  if (environment.recording || !brokers) return std::nullopt;
  const auto is_wanted = [&](const ledger::Record& row) {
    const auto robot = vda5050::ParseRobotAddress(row.target);
    return robot && fleet.Shows(*robot) &&
           std::any_of(brokers->begin(), brokers->end(), [&](const mqtt::BrokerUrl& broker) {
             return broker.ToString() == row.broker;
           });
  };
  const auto ledger = environment.ledger(ledger::OpenMode::kReadOnly);
  auto times =
      ledger ? app::ReadConfirmTimes(**ledger, environment.Now(), is_wanted) : Fail(ledger.error());
  if (times) return *std::move(times);
  context.output.Warn("the times to confirm are left out: " + times.error().message);
  return std::nullopt;
}

// What is known so far, for a person who waits.
class FillingTable {
 public:
  FillingTable(SortBy by, Output& output) : by_(by), output_(output) {}

  [[nodiscard]] bool IsPossible() const {
    return output_.CanPass() && !output_.json() && Screen::IsPossible();
  }

  void Draw(const app::Fleet& fleet) {
    auto robots = Sorted(fleet, by_);
    const auto silent = std::count_if(robots.begin(), robots.end(), [](const ListedRobot* robot) {
      return robot->second.IsAlive() && !robot->second.HasSpoken();
    });
    const auto [rows, columns] = Screen::size();
    constexpr std::size_t kFrame = 3;  // the table's header, the last line, and the prompt before
    const std::size_t room = rows > kFrame ? rows - kFrame : 1;
    const std::size_t hidden = robots.size() - std::min(room, robots.size());
    robots.resize(robots.size() - hidden);
    const std::size_t width = columns - 1;
    const auto shown = MakeRows(robots, base::WallTime::clock::now());
    auto lines = TableLines(FleetColumns(), shown, width, output_, &widths_);
    const std::string more = hidden == 0 ? "" : fmt::format("{} more; ", hidden);
    const std::string left = fmt::format("{}waiting up to {} for {} (Ctrl-C ends)", more,
                                         base::FormatElapsed(fleet.targets().state_wait),
                                         base::Counted(silent, "state"));
    lines.push_back(output_.Toned(Tone::kDim, base::Shortened(width, left)));
    if (std::exchange(lines_, lines) != lines) output_.Pass(lines);
  }

 private:
  SortBy by_;
  Output& output_;
  std::vector<std::size_t> widths_;
  std::vector<std::string> lines_;
};

Result<ExitCode> RunFleet(const FleetTableOptions& o, const Context& context) {
  auto request = ParseFleetOptions(o.fleet);
  if (!request) return Fail(request.error());
  request->problems = o.view.problems;
  FillingTable filling(o.view.sort.value_or(SortBy::kTrouble), context.output);
  app::FleetHook progress;
  if (filling.IsPossible() && o.fleet.from.empty())
    progress = [&](const app::Fleet& fleet) { filling.Draw(fleet); };
  const auto environment = MakeEnvironment(context, o.fleet.from, delivery::Play::kLast);
  const auto fleet = app::DiscoverFleet(*std::move(request), environment, progress, context.output);
  context.output.ClearPassing();
  if (!fleet) return Fail(fleet.error());
  for (const ListedRobot* robot : fleet->robots()) {
    const auto& [address, entry] = *robot;
    if (entry.AlsoAt().empty()) continue;
    context.output.Warn(fmt::format("{} was found at two places: {}, which is shown, and {}",
                                    base::Printable(address.ToString()),
                                    base::Printable(entry.place), base::Printable(entry.AlsoAt())));
  }
  if (FindFormat(context.options.format) == Format::kOpenMetrics) {
    WriteFleetMetrics(fleet->robots(), environment.Now(),
                      FindConfirmTimes(*fleet, environment, context),
                      [](std::string_view text) { Print(stdout, text); });
    return ExitCode::kDone;
  }
  Show(*fleet, o, environment.Now(), context.output);
  TellRecording(environment, context.output);
  return ExitCode::kDone;
}

}  // namespace

Run DeclareFleet(OptionSet& set) {
  const auto options = std::make_shared<FleetTableOptions>();
  DeclareFleetDiscoveryOptions(set, options->fleet);
  DeclareFleetViewOptions(set, options->view);
  return [options](const Context& context) { return RunFleet(*options, context); };
}

}  // namespace fleetpub::cli
