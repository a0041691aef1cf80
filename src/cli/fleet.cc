// `fleetpub fleet [PATTERN]`: the robots known to the broker, and how they are.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <limits>
#include <memory>

#include "base/text.h"
#include "base/time.h"
#include "cli/fleet_table.h"
#include "cli/listening.h"
#include "cli/subcommand.h"
#include "dispatch/collect.h"
#include "mqtt/paho_transport.h"

namespace fleetpub::cli {
namespace {

using std::chrono::steady_clock;
using vda5050::FleetView;
using vda5050::RobotView;

struct Options {
  FleetOptions fleet;
  std::string discover = "300";
  std::string state_wait = "2s";
};

struct Patience {
  dispatch::CollectOptions discover;
  std::chrono::milliseconds state_wait{};
};

Result<Patience> PatienceOf(const Options& o) {
  auto discover = DiscoverOf(o.discover);
  if (!discover) return Fail(std::move(discover.error()));
  const auto state_wait = base::ParseDuration(o.state_wait);
  if (!state_wait) return Fail(state_wait.error());
  return Patience{*discover, *state_wait};
}

void Deliver(const mqtt::Message& message, FleetView& view) {
  view.Deliver(message.topic, message.payload,
               message.retained ? vda5050::Origin::kRetained : vda5050::Origin::kLive);
}

// Online robots that have not said how they are.
std::size_t Silent(const FleetView& view) {
  const auto robots = view.robots();
  return static_cast<std::size_t>(
      std::count_if(robots.begin(), robots.end(),
                    [](const RobotView* robot) { return robot->IsOnline() && !robot->state; }));
}

// What is retained, and then what the robots say until all have spoken or time is up.
Status Gather(mqtt::Transport& transport, const Patience& patience, FleetView& view) {
  const auto filters = view.Filters();
  if (!filters) return Fail(filters.error());
  const auto end = steady_clock::now() + patience.state_wait;
  const auto messages =
      dispatch::Collect(transport, *filters, patience.discover, [](const auto&) { return false; });
  if (!messages) return Fail(messages.error());
  for (const mqtt::Message& message : *messages) Deliver(message, view);
  while (steady_clock::now() < end && Silent(view) > 0) {
    const auto message = transport.Receive(end);
    if (!message) return Fail(message.error());
    if (*message) Deliver(**message, view);
  }
  return {};
}

void Show(const FleetView& view, Output& output) {
  const auto robots = view.robots();
  if (output.json()) {
    for (const RobotView* robot : robots) output.Line("{" + FleetJson(*robot) + "}");
    return;
  }
  std::vector<Row> rows = {FleetHeader()};
  const auto now = base::WallTime::clock::now();
  for (const RobotView* robot : robots) rows.push_back(FleetRow(*robot, now));
  const auto lines = TableLines(rows, std::numeric_limits<std::size_t>::max(), output);
  output.PeopleLine(lines.front());
  for (const std::string& line : std::span(lines).subspan(1)) output.Line(line);
}

Error NoRobot(const std::string& broker, const std::string& pattern) {
  return {ErrorKind::kPreflight,
          fmt::format("{} knows no robot{}: none has left a connection message, and none sent a "
                      "state",
                      broker, pattern.empty() ? "" : " " + base::Printable(pattern))};
}

Result<ExitCode> RunFleet(const Options& o, const Context& context) {
  auto view = FleetViewOf(o.fleet);
  if (!view) return Fail(std::move(view.error()));
  const auto patience = PatienceOf(o);
  if (!patience) return Fail(patience.error());
  const auto connect = ConnectOptionsOf(context);
  if (!connect) return Fail(connect.error());
  const auto transport = mqtt::ConnectPaho(*connect);
  if (!transport) return Fail(transport.error());
  if (auto ok = Gather(**transport, *patience, *view); !ok) return Fail(std::move(ok.error()));
  const std::string broker = (*transport)->server().broker.ToString();
  (*transport)->Disconnect();
  if (view->size() == 0) return Fail(NoRobot(broker, o.fleet.pattern));
  Show(*view, context.output);
  if (const std::size_t silent = Silent(*view); silent > 0 && patience->state_wait.count() > 0) {
    context.output.Warn(
        fmt::format("{} of {} robots sent no state within {}; they repeat it at least every 30 s: "
                    "--state-wait 35s waits for it",
                    silent, view->size(), base::FormatElapsed(patience->state_wait)));
  }
  return ExitCode::kDone;
}

}  // namespace

Run DeclareFleet(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  DeclareFleetOptions(app, options->fleet);
  app.add_option("--state-wait", options->state_wait,
                 "How long to wait for the states of robots that are online [2s]")
      ->type_name("TIME")
      ->group("Waiting");
  app.add_option("--discover", options->discover,
                 "Silence in ms after which a retained message is not there [300]")
      ->type_name("MS")
      ->group("Waiting");
  return [options](const Context& context) { return RunFleet(*options, context); };
}

}  // namespace fleetpub::cli
