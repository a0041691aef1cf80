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

using app::ListedRobot;

void Show(const app::Fleet& fleet, Output& output) {
  const auto robots = fleet.robots();
  if (output.json()) {
    for (const ListedRobot* robot : robots) output.Line("{" + FleetJson(*robot) + "}");
    return;
  }
  std::vector<Row> rows;
  const auto now = base::WallTime::clock::now();
  rows.reserve(robots.size());
  for (const ListedRobot* robot : robots) rows.push_back(FleetRow(*robot, now));
  PrintTable(FleetColumns(), rows, output);
}

Result<ExitCode> RunFleet(const FleetDiscoveryOptions& options, const Context& context) {
  auto request = ParseFleetOptions(options);
  if (!request) return Fail(request.error());
  const auto fleet =
      app::DiscoverFleet(*std::move(request), MakeEnvironment(context), {}, context.output);
  if (!fleet) return Fail(fleet.error());
  for (const ListedRobot* robot : fleet->robots()) {
    const auto& [address, entry] = *robot;
    if (entry.AlsoAt().empty()) continue;
    context.output.Warn(fmt::format("{} is found twice: at {}, which is shown, and at {}",
                                    base::Printable(address.ToString()),
                                    base::Printable(entry.place), base::Printable(entry.AlsoAt())));
  }
  Show(*fleet, context.output);
  return ExitCode::kDone;
}

}  // namespace

Run DeclareFleet(OptionSet& set) {
  const auto options = std::make_shared<FleetDiscoveryOptions>();
  DeclareFleetDiscoveryOptions(set, *options);
  return [options](const Context& context) { return RunFleet(*options, context); };
}

}  // namespace fleetpub::cli
