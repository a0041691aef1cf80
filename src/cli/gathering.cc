#include "cli/gathering.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <set>

#include "base/text.h"
#include "base/time.h"
#include "cli/option_set.h"
#include "dispatch/collect.h"
#include "mqtt/paho_transport.h"

namespace fleetpub::cli {
namespace {

using std::chrono::steady_clock;
using vda5050::FleetView;
using vda5050::RobotAddress;
using vda5050::RobotView;

constexpr std::chrono::seconds kSubscribe{10};

struct Patience {
  dispatch::CollectOptions discover;
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
    if (robot->IsOnline() && !robot->state) silent.insert(robot->robot);
  }
  return silent;
}

// Takes in what comes until `end()`, which each message may move. `taken` hears of whom it was.
template <typename End, typename Taken>
Status Read(mqtt::Transport& transport, FleetView& view, const End& end, const Taken& taken) {
  for (auto until = end(); steady_clock::now() < until; until = end()) {
    const auto message = transport.Receive(until);
    if (!message) return Fail(message.error());
    if (!*message) continue;
    const auto origin = (*message)->retained ? vda5050::Origin::kRetained : vda5050::Origin::kLive;
    const RobotView* robot = view.Deliver((*message)->topic, (*message)->payload, origin);
    taken(origin, robot);
  }
  return {};
}

// What the broker has retained. Only that puts the end off: a busy fleet is never silent.
Status TakeRetained(mqtt::Transport& transport, const dispatch::CollectOptions& discover,
                    FleetView& view) {
  const auto start = steady_clock::now();
  auto quiet_at = start + discover.quiet;
  return Read(
      transport, view, [&] { return std::min(quiet_at, start + discover.most); },
      [&](vda5050::Origin origin, const RobotView* /*robot*/) {
        if (origin == vda5050::Origin::kRetained) quiet_at = steady_clock::now() + discover.quiet;
      });
}

// What the robots that are online say, until all have spoken; or, if none is known, until one does.
Status AwaitStates(mqtt::Transport& transport, mqtt::Deadline end, FleetView& view) {
  auto silent = Silent(view);
  const bool nobody = view.size() == 0;
  return Read(
      transport, view,
      [&] {
        const bool waits = nobody ? view.size() == 0 : !silent.empty();
        return waits ? end : mqtt::Deadline();
      },
      [&](vda5050::Origin /*origin*/, const RobotView* robot) {
        if (robot != nullptr && robot->state) silent.erase(robot->robot);
      });
}

Status Gather(mqtt::Transport& transport, const Patience& patience, FleetView& view) {
  const auto filters = view.Filters();
  if (!filters) return Fail(filters.error());
  const auto start = steady_clock::now();
  auto ok = transport.Subscribe(*filters, mqtt::kListeningQos, start + kSubscribe);
  if (ok) ok = TakeRetained(transport, patience.discover, view);
  if (ok) ok = AwaitStates(transport, start + patience.state_wait, view);
  return ok;
}

Error NoRobot(const std::string& broker, const std::string& pattern) {
  return {ErrorKind::kPreflight,
          fmt::format("{} knows no robot{}: none has left a connection message, and none sent a "
                      "state",
                      broker, pattern.empty() ? "" : " " + base::Printable(pattern))};
}

}  // namespace

void DeclareGatheringOptions(OptionSet& set, GatheringOptions& options) {
  DeclareFleetOptions(set, options.fleet);
  set.AddOption("--state-wait", options.state_wait,
                fmt::format("How long to wait for the states of robots that are online [{}]",
                            options.state_wait))
      ->type_name("TIME")
      ->group("Waiting");
  set.AddOption("--discover", options.discover,
                "Silence in ms after which a retained message is not there [300]")
      ->type_name("MS")
      ->group("Waiting");
}

Result<FleetView> GatherFleet(const GatheringOptions& o, const Context& context) {
  auto view = FleetViewOf(o.fleet, context);
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
  if (const std::size_t silent = Silent(*view).size();
      silent > 0 && patience->state_wait.count() > 0) {
    context.output.Warn(
        fmt::format("{} of {} robots sent no state within {}; they repeat it at least every 30 s: "
                    "--state-wait 35s waits for it",
                    silent, view->size(), base::FormatElapsed(patience->state_wait)));
  }
  return view;
}

}  // namespace fleetpub::cli
