// `fleetpub fleet [PATTERN]`: the robots known to the broker, and how they are.
#include <fmt/format.h>

#include <memory>

#include "base/text.h"
#include "base/time.h"
#include "cli/environment.h"
#include "cli/listening.h"
#include "cli/output/fleet_table.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"

namespace fleetpub::cli {
namespace {

using vda5050::FleetView;
using vda5050::RobotView;

void Show(const FleetView& view, Output& output) {
  const auto robots = view.robots();
  if (output.json()) {
    for (const RobotView* robot : robots) output.Line("{" + FleetJson(*robot) + "}");
    return;
  }
  std::vector<Row> rows;
  const auto now = base::WallTime::clock::now();
  rows.reserve(robots.size());
  for (const RobotView* robot : robots) rows.push_back(FleetRow(*robot, now));
  PrintTable(FleetColumns(), rows, output);
}

struct Options {
  FleetDiscoveryOptions discovery;
  bool ask = false;
};

Result<ExitCode> RunFleet(const Options& options, const Context& context) {
  auto request = MakeFleetRequest(options.discovery);
  request.ask = options.ask;
  const auto view = app::DiscoverFleet(request, MakeEnvironment(context), context.output);
  if (!view) return Fail(view.error());
  for (const RobotView* robot : view->robots()) {
    if (robot->also_at.empty()) continue;
    context.output.Warn(fmt::format("{} is found twice: at {}, which is shown, and at {}",
                                    base::Printable(robot->robot.ToString()),
                                    base::Printable(robot->place),
                                    base::Printable(robot->also_at)));
  }
  Show(*view, context.output);
  return ExitCode::kDone;
}

}  // namespace

Run DeclareFleet(OptionSet& set) {
  const auto options = std::make_shared<Options>();
  DeclareFleetDiscoveryOptions(set, options->discovery);
  set.AddFlag("--ask", options->ask,
              "Send a stateRequest to robots that are online: their states come at once")
      .Group("Waiting");
  return [options](const Context& context) { return RunFleet(*options, context); };
}

}  // namespace fleetpub::cli
