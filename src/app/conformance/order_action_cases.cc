// A: the actions of an order.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

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

// The second one of a pair.
CaseFinding CheckAlone(const Pair& pair) {
  if (!pair.refusal.empty()) return Inconclusive(pair.refusal);
  bool any = false;
  for (const Heard* one : pair.states) {
    const bool runs = Runs(Status(*one->state, pair.b));
    any = any || runs;
    if (runs && Runs(Status(*one->state, pair.a))) {
      return Fault("it runs beside another action", {one->Evidence()});
    }
  }
  return any ? Pass("alone") : Inconclusive("no state shows it RUNNING");
}

CaseFinding CheckParallel(Run& run) {
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

// A trip with an action in the middle; `next`: of the edge behind that.
struct ActionTrip {
  Trip trip;
  std::string action;
};

ActionTrip DriveWith(Run& run, std::string_view blocking_type, bool on_edge,
                     const vda5050::InstantAction& next = {}) {
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
    if (!next.type.empty()) order.path.edges[1].actions.push_back(next);
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

CaseFinding CheckSingle(Run& run) {
  auto finding = CheckAlone(DoPair(run, "NONE", "SINGLE"));
  if (finding.verdict == Verdict::kPass) {
    finding = CheckNoStop(run, DriveWith(run, "SINGLE", false));
  }
  return finding;
}

// The action of a node in the middle holds the robot there, and what the next edge has to do waits.
CaseFinding CheckHeld(Run& run, const ActionTrip& made, const std::string& next) {
  if (!made.trip.refusal.empty()) return Inconclusive(made.trip.refusal);
  bool any = false;
  for (const Heard* one : run.StatesSince(made.trip.mark)) {
    const auto status = Status(*one->state, made.action);
    if (status.empty() || vda5050::IsTerminal(status)) continue;
    if (Runs(status) && one->state->driving.value_or(false)) {
      return Fault("it drives meanwhile", {one->Evidence()});
    }
    if (Began(Status(*one->state, next))) {
      return Fault("an action of the next edge begins before it has ended", {one->Evidence()});
    }
    any = any || Runs(status);
  }
  return any ? Pass("standing") : Inconclusive("no state shows it RUNNING on the way");
}

// A fault in either part is one; where the way shows nothing, what stood still counts.
CaseFinding AlsoHeld(Run& run, CaseFinding finding, std::string_view blocking_type) {
  if (finding.verdict != Verdict::kPass) return finding;
  const auto next = HarmlessAction(run, "EDGE", "NONE");
  auto held = CheckHeld(run, DriveWith(run, blocking_type, false, next), next.id);
  if (held.verdict == Verdict::kFail) return held;
  finding.why += held.verdict == Verdict::kPass ? ", and standing" : "; on the way: " + held.why;
  return finding;
}

CaseFinding CheckHard(Run& run) {
  return AlsoHeld(run, CheckAlone(DoPair(run, "SOFT", "HARD")), "HARD");
}
CaseFinding CheckSoft(Run& run) { return AlsoHeld(run, CheckParallel(run), "SOFT"); }

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

// ---- Loads ----

// What its factsheet calls its loads.
std::string FindLoadType(const Run& run) {
  const auto sheets = run.Of("factsheet");
  const auto* loads =
      sheets.empty() ? nullptr : base::FindMember(sheets.back()->json, "loadSpecification");
  const auto* sets = loads == nullptr ? nullptr : base::FindArray(*loads, "loadSets");
  const auto name =
      sets == nullptr || sets->Empty() ? "" : base::StringMember((*sets)[0], "loadType");
  return std::string(name.empty() ? "EPAL" : name);
}

// `pick` or `drop` with what it cannot do without; "" as its type: nobody here knows all of that.
vda5050::InstantAction LoadAction(Run& run, std::string type) {
  vda5050::InstantAction action{.type = std::move(type),
                                .id = run.MakeId("conform"),
                                .descriptor = {},
                                .blocking_type = "HARD",
                                .parameters = {}};
  const auto& sheet = run.subject().factsheet;
  const auto* listed = sheet ? vda5050::FindAction(*sheet, action.type) : nullptr;
  std::set<std::string> needed;
  if (!run.Is30()) needed = {"stationType", "loadType"};
  for (const auto& parameter :
       listed == nullptr ? std::vector<vda5050::FactsheetParameter>() : listed->parameters) {
    if (parameter.is_optional == false) needed.insert(parameter.key);
  }
  for (const std::string& key : needed) {
    if (key != "stationType" && key != "loadType") action.type.clear();
    const std::string value = key == "loadType" ? FindLoadType(run) : "floor";
    action.parameters.push_back({key, base::JsonString(value)});
  }
  return action;
}

// Has it done where the robot stands; then so many loads are on board.
CaseFinding CheckLoadAction(Run& run, const vda5050::InstantAction& action, std::size_t loads) {
  TestOrder order = Standing(run);
  order.path.nodes.front().actions = {action};
  const std::size_t mark = run.mark();
  if (SendAndAwait(run, order).found == nullptr) {
    return Inconclusive(fmt::format("it does not take an order with {}", action.type));
  }
  const auto ended = run.AwaitSince(
      mark, run.Now(),
      [&](const RobotState& state) { return vda5050::IsTerminal(Status(state, action.id)); },
      kLong);
  if (ended.found == nullptr || Status(*ended.found->state, action.id) != "FINISHED") {
    EndOrder(run);
    return Inconclusive(fmt::format("{} did not come to FINISHED", action.type));
  }
  // Some leave the array out while it is empty.
  const auto has_them = [&](const RobotState& state) {
    return (state.loads ? state.loads->size() : 0) == loads;
  };
  if (has_them(*ended.found->state)) return Pass("loads follow", {ended.found->Evidence()});
  const auto later = run.Await(has_them);
  if (later.found != nullptr) return Pass("loads follow", {later.found->Evidence()});
  if (!run.last_state()->state->loads) return Inconclusive("its states tell nothing of loads");
  return Run::Missing(later, fmt::format("{} is FINISHED, and loads do not change", action.type));
}

CaseFinding CheckLoads(Run& run) {
  if (run.last_state() == nullptr) return Inconclusive("no state came");
  const auto& loads = run.last_state()->state->loads;
  if (loads && !loads->empty()) return Skipped("it carries a load already");
  for (const char* type : {"pick", "drop"}) {
    if (!run.Knows(type, "NODE").value_or(true)) {
      return Skipped(fmt::format("its factsheet does not list {} for nodes", type));
    }
  }
  const auto pick = LoadAction(run, "pick");
  const auto drop = LoadAction(run, "drop");
  if (pick.type.empty() || drop.type.empty()) {
    return Skipped("its pick or drop needs a parameter that nobody here knows");
  }
  auto taken = CheckLoadAction(run, pick, 1);
  if (Status(*run.last_state()->state, pick.id) != "FINISHED") return taken;
  auto left = CheckLoadAction(run, drop, 0);
  const auto& last = run.last_state()->state->loads;
  run.Once<bool>(kLoaded, [] { return true; }) = last && !last->empty();
  return taken.verdict == Verdict::kPass ? left : taken;
}

using enum Version;
constexpr auto kOrderActionCases = std::to_array<Case>({
    {"A01", Level::kDrive, k110, k300, "6.2.2 / 6.12",
     "a NONE action on a passed node does not stop it", "", "drive on while it runs", CheckNone},
    {"A02", Level::kDrive, k110, k300, "6.2.2, 6.6.2 / 6.12",
     "a HARD action runs alone, and standing; the next edge's actions wait for it", "",
     "wait until all before it have ended", CheckHard},
    {"A03", Level::kDrive, k110, k300, "6.2.2 / 6.12",
     "SOFT actions run side by side, and standing", "", "begin all NONE and SOFT actions together",
     CheckSoft},
    {"A04", Level::kDrive, k300, k300, "6.2.2", "a SINGLE action runs alone, and does not stop it",
     "", "wait until all before it have ended, and drive", CheckSingle},
    {"A05", Level::kDrive, k110, k300, "6.2.2 / 6.12", "actions begin in the order of the array",
     "", "do not sort by blockingType", CheckArray},
    {"A06", Level::kDrive, k110, k300, "6.6.2", "an edge's action has ended at its end",
     "next state", "end it with the edge", CheckEdgeAction},
    {"A07", Level::kDrive, k110, k300, "6.2.3.2 / 6.8",
     "when pick is FINISHED loads has one more, after drop one less", "next state",
     "report loads with the action's end", CheckLoads},
    {"A08", Level::kDrive, k110, k300, "6.6.5 / 6.10",
     "a failing action is FAILED, an error names it, and the order is kept", "next state",
     "never give an order up by itself", nullptr},
    {"A09", Level::kDrive, k300, k300, "6.6.9",
     "a retriable action is RETRIABLE; retry and skipRetry work", "next state",
     "wait for fleet control", nullptr},
});

}  // namespace

std::span<const Case> OrderActionCases() { return kOrderActionCases; }

}  // namespace fleetpub::app::conformance
