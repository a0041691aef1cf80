// A: the actions of an order.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "app/conformance/case.h"
#include "app/conformance/orders.h"
#include "base/text.h"

namespace fleetpub::app::conformance {
namespace {

using vda5050::RobotState;
using vda5050::Version;

constexpr const char* kNoAction = "its factsheet lists no harmless action for nodes";
constexpr seconds kLong{60};

std::string_view Status(const RobotState& state, const std::string& id) {
  const auto* action = vda5050::FindActionState(state, id);
  return action == nullptr ? std::string_view() : std::string_view(action->status);
}

bool Runs(std::string_view status) { return status == "RUNNING" || status == "INITIALIZING"; }
bool Began(std::string_view status) { return Runs(status) || vda5050::IsTerminal(status); }

// Two actions at the place where it stands, from taking them to their end.
struct Pair {
  std::string a;
  std::string b;
  std::vector<const Heard*> states;
  std::string refusal;
  bool has_hole = false;
};

Pair DoPair(Run& run, std::string_view first, std::string_view second) {
  Pair pair;
  TestOrder order = Standing(run);
  const auto a = HarmlessAction(run, "NODE", first);
  const auto b = HarmlessAction(run, "NODE", second);
  if (a.type.empty()) {
    pair.refusal = kNoAction;
    return pair;
  }
  pair.a = a.id;
  pair.b = b.id;
  order.path.nodes.front().actions = {a, b};
  const std::size_t mark = run.mark();
  if (SendAndAwait(run, order).found == nullptr) {
    pair.refusal = "it does not take an order with two actions";
    return pair;
  }
  const auto ended = run.AwaitSince(
      mark, run.Now(),
      [&](const RobotState& state) {
        return vda5050::IsTerminal(Status(state, pair.a)) &&
               vda5050::IsTerminal(Status(state, pair.b));
      },
      kLong);
  pair.states = run.StatesSince(mark);
  pair.has_hole = run.HasHole(mark);
  if (ended.found == nullptr) {
    pair.refusal = "the actions do not end";
    EndOrder(run);
  }
  return pair;
}

CaseFinding CheckHard(Run& run) {
  const Pair pair = DoPair(run, "SOFT", "HARD");
  if (!pair.refusal.empty()) return Inconclusive(pair.refusal);
  bool any = false;
  for (const Heard* one : pair.states) {
    const bool runs = Runs(Status(*one->state, pair.b));
    any = any || runs;
    if (runs && Runs(Status(*one->state, pair.a))) {
      return Fault("it runs beside another action", {one->Evidence()});
    }
    if (runs && one->state->driving.value_or(false)) {
      return Fault("it drives meanwhile", {one->Evidence()});
    }
  }
  return any ? Pass("alone, and standing") : Inconclusive("no state shows it RUNNING");
}

CaseFinding CheckSoft(Run& run) {
  const Pair pair = DoPair(run, "SOFT", "SOFT");
  if (!pair.refusal.empty()) return Inconclusive(pair.refusal);
  const Heard* waits = nullptr;
  for (const Heard* one : pair.states) {
    const auto a = Status(*one->state, pair.a);
    const auto b = Status(*one->state, pair.b);
    if (Runs(a) && Runs(b)) return Pass("both run", {one->Evidence()});
    if (Runs(a) && b == "WAITING") waits = one;
    const bool follows = vda5050::IsTerminal(a) && (b == "WAITING" || Runs(b));
    if (follows && waits != nullptr && !pair.has_hole) {
      return Fault("one waits until the other has ended", {waits->Evidence(), one->Evidence()});
    }
  }
  return Inconclusive("no state shows them RUNNING");
}

CaseFinding CheckArray(Run& run) {
  const Pair pair = DoPair(run, "SOFT", "HARD");
  if (!pair.refusal.empty()) return Inconclusive(pair.refusal);
  bool any = false;
  for (const Heard* one : pair.states) {
    const auto a = Status(*one->state, pair.a);
    const auto b = Status(*one->state, pair.b);
    any = any || (Runs(a) && b == "WAITING");
    if (a == "WAITING" && Began(b)) {
      return Fault("the second began before the first", {one->Evidence()});
    }
  }
  return any ? Pass("in their order") : Inconclusive("no state shows how they followed");
}

// ---- On the way ----

// A trip with an action in the middle.
struct ActionTrip {
  Trip trip;
  std::string action;
};

ActionTrip DriveWith(Run& run, std::string_view blocking_type, bool on_edge) {
  ActionTrip made;
  TestOrder order = AlongWay(run);
  const auto action = HarmlessAction(run, on_edge ? "EDGE" : "NODE", blocking_type);
  made.action = action.id;
  if (action.type.empty() || order.path.nodes.size() < 3) {
    made.trip.refusal = action.type.empty() ? kNoAction : "there is no way";
    return made;
  }
  if (on_edge) {
    order.path.edges.front().actions.push_back(action);
  } else {
    order.path.nodes[1].actions.push_back(action);
  }
  made.trip = Drive(run, std::move(order));
  return made;
}

// No state at rest between the first that drives and the last node.
CaseFinding CheckNoStop(Run& run, const ActionTrip& made) {
  if (!made.trip.refusal.empty()) return Inconclusive(made.trip.refusal);
  bool drives = false;
  bool ran = false;
  for (const Heard* one : run.StatesSince(made.trip.mark)) {
    const RobotState& state = *one->state;
    if (state.order_id != made.trip.order.id) continue;
    if (state.last_node_sequence_id.value_or(0) >= made.trip.order.LastSequenceId()) break;
    ran = ran || Began(Status(state, made.action));
    if (drives && state.last_node_sequence_id.value_or(0) >= 2 && !state.driving.value_or(true)) {
      return Fault("it stood on the way", {one->Evidence()});
    }
    drives = drives || state.driving.value_or(false);
  }
  if (const auto why = Unfinished(made.trip); !why.empty()) return Inconclusive(why);
  if (!ran) return Inconclusive("no state on the way shows the action");
  return drives ? Pass("it drove on") : Inconclusive("no state says that it drove");
}

CaseFinding CheckNone(Run& run) { return CheckNoStop(run, DriveWith(run, "NONE", false)); }
CaseFinding CheckSingle(Run& run) { return CheckNoStop(run, DriveWith(run, "SINGLE", false)); }

CaseFinding CheckEdgeAction(Run& run) {
  const ActionTrip made = DriveWith(run, "NONE", true);
  if (!made.trip.refusal.empty()) return Inconclusive(made.trip.refusal);
  for (const Heard* one : run.StatesSince(made.trip.mark)) {
    if (one->state->order_id != made.trip.order.id) continue;
    if (one->state->last_node_sequence_id.value_or(0) < 2) continue;
    const auto status = Status(*one->state, made.action);
    if (status.empty()) continue;
    if (vda5050::IsTerminal(status)) return Pass("it had ended", {one->Evidence()});
    return Fault("it runs on behind the edge", {one->Evidence()});
  }
  return Inconclusive("no state shows the edge's end");
}

using enum Version;
constexpr Level kDrive = Level::kDrive;
constexpr auto kCases = std::to_array<Case>({
    {"A01", kDrive, k110, k300, "6.2.2 / 6.12", "a NONE action on a passed node does not stop it",
     "", "drive on while it runs", CheckNone},
    {"A02", kDrive, k110, k300, "6.2.2, 6.6.2 / 6.12", "a HARD action runs alone, and standing", "",
     "wait until all before it have ended", CheckHard},
    {"A03", kDrive, k110, k300, "6.2.2 / 6.12", "SOFT actions run side by side", "",
     "begin all NONE and SOFT actions together", CheckSoft},
    {"A04", kDrive, k300, k300, "6.2.2", "a SINGLE action does not stop it", "",
     "it runs alone, and may drive", CheckSingle},
    {"A05", kDrive, k110, k300, "6.2.2 / 6.12", "actions begin in the order of the array", "",
     "do not sort by blockingType", CheckArray},
    {"A06", kDrive, k110, k300, "6.6.2", "an edge's action has ended at its end", "next state",
     "end it with the edge", CheckEdgeAction},
    {"A08", kDrive, k110, k300, "6.6.5 / 6.10",
     "a failing action is FAILED, an error names it, and the order is kept", "next state",
     "never give an order up by itself", nullptr},
    {"A09", kDrive, k300, k300, "6.6.9",
     "a retriable action is RETRIABLE; retry and skipRetry work", "next state",
     "wait for fleet control", nullptr},
});

}  // namespace

std::span<const Case> OrderActionCases() { return kCases; }

}  // namespace fleetpub::app::conformance
