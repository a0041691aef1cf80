#include "cli/gathering.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <set>

#include "app/targets.h"
#include "base/text.h"
#include "base/time.h"
#include "cli/parser/option_set.h"
#include "delivery/retained.h"
#include "mqtt/paho/paho_transport.h"

namespace fleetpub::cli {
namespace {

using std::chrono::steady_clock;
using vda5050::FleetView;
using vda5050::RobotAddress;
using vda5050::RobotView;

struct Patience {
  delivery::RetainedOptions discover;
  std::chrono::milliseconds state_wait{};
};

Result<Patience> PatienceOf(const GatheringOptions& o) {
  auto discover = DiscoverOf(o.discover);
  if (!discover) return Fail(std::move(discover.error()));
  const auto state_wait = base::ParseDuration(o.state_wait);
  if (!state_wait) return Fail(state_wait.error());
  return Patience{*discover, *state_wait};
}

// Online robots that have not said how they are.
std::set<RobotAddress> Silent(const FleetView& view) {
  std::set<RobotAddress> silent;
  for (const RobotView* robot : view.robots()) {
    if (robot->IsOnline() && !robot->HasSpoken()) silent.insert(robot->robot);
  }
  return silent;
}

const RobotView* Take(const mqtt::Message& message, FleetView& view) {
  const auto origin = message.retained ? vda5050::Origin::kRetained : vda5050::Origin::kLive;
  return view.Deliver(message.topic, message.payload, origin);
}

// What the robots that are online say, until all have spoken; or, if none is known, until one does.
Status AwaitStates(mqtt::Transport& transport, mqtt::Deadline end, FleetView& view) {
  auto silent = Silent(view);
  const bool nobody = view.size() == 0;
  while (steady_clock::now() < end && (nobody ? view.size() == 0 : !silent.empty())) {
    const auto message = transport.Receive(end);
    if (!message) return Fail(message.error());
    if (!*message) continue;
    const RobotView* robot = Take(**message, view);
    if (robot != nullptr && robot->HasSpoken()) silent.erase(robot->robot);
  }
  return {};
}

Status Gather(mqtt::Transport& transport, const Patience& patience, FleetView& view) {
  const auto filters = view.Filters();
  if (!filters) return Fail(filters.error());
  const auto start = steady_clock::now();
  auto ok = delivery::ReadAllRetained(
      transport, *filters, patience.discover,
      [&](const mqtt::Message& message) { Take(message, view); }, [&] { return view.size(); });
  if (ok) ok = AwaitStates(transport, start + patience.state_wait, view);
  return ok;
}

Error NoRobot(const std::string& broker, const FleetOptions& fleet) {
  return {ErrorKind::kPreflight,
          fmt::format("{} knows no robot{}: none has left a connection message, and none sent a "
                      "state",
                      broker, fleet.words.empty() ? "" : " " + NameOf(fleet))};
}

}  // namespace

void DeclareGatheringOptions(OptionSet& set, GatheringOptions& options) {
  DeclareFleetOptions(set, options.fleet);
  set.AddOption("--state-wait", options.state_wait,
                fmt::format("How long to wait for the states of robots that are online [{}]",
                            options.state_wait))
      .Type("TIME")
      .Group("Waiting");
  set.AddOption("--discover", options.discover,
                "Silence in ms after which a retained message is not there [300]")
      .Type("MS")
      .Group("Waiting");
}

Result<FleetView> GatherFleet(const GatheringOptions& o, const Context& context) {
  auto view = FleetViewOf(o.fleet, context);
  if (!view) return Fail(std::move(view.error()));
  auto patience = PatienceOf(o);
  if (!patience) return Fail(std::move(patience.error()));
  const auto connect = ConnectOptionsOf(context);
  if (!connect) return Fail(connect.error());
  patience->discover.subscribe = connect->connect_timeout;
  const auto transport = mqtt::ConnectPaho(*connect);
  if (!transport) return Fail(transport.error());
  if (auto ok = Gather(**transport, *patience, *view); !ok) return Fail(std::move(ok.error()));
  const std::string broker = (*transport)->server().broker.ToString();
  (*transport)->Disconnect();
  if (view->size() == 0) return Fail(NoRobot(broker, o.fleet));
  std::vector<RobotAddress> found;
  for (const RobotView* robot : view->robots()) found.push_back(robot->robot);
  app::WarnOfEscapedNames(found, context.output);
  if (view->abridged() > 0) context.output.Warn(AbridgedWarning(view->abridged()));
  if (const std::size_t silent = Silent(*view).size();
      silent > 0 && patience->state_wait.count() > 0) {
    context.output.Warn(fmt::format(
        "{} of {} robots sent no state within {}; they repeat it at least every 30 s{}", silent,
        view->size(), base::FormatElapsed(patience->state_wait),
        patience->state_wait < std::chrono::seconds(35) ? ": --state-wait 35s waits for it" : ""));
  }
  return view;
}

}  // namespace fleetpub::cli
