// D: driving, and updates of an order.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "app/conformance/case.h"
#include "app/conformance/orders.h"
#include "base/text.h"

namespace fleetpub::app::conformance {
namespace {

using base::FindArray;
using base::FindMember;
using vda5050::RobotState;
using vda5050::Version;
using Value = base::JsonValue;

constexpr double kSpeed = 0.3;  // m/s
constexpr double kTurn = 0.6;   // rad, at the end of the way
constexpr double kDistanceTolerance = 0.2;
constexpr double kAngleTolerance = 0.15;
constexpr double kDeviationTheta = 0.1;

const Trip& PlainTrip(Run& run) {
  return run.Once<Trip>("the plain trip", [&] {
    TestOrder order = AlongWay(run);
    if (order.path.nodes.size() < 3) return Drive(run, std::move(order));
    for (auto& edge : order.path.edges) {
      if (!edge.max_speed) edge.max_speed = kSpeed;
    }
    auto& last = order.path.nodes.back();
    const auto& first = order.path.nodes.front();
    if (last.position && first.position && !last.position->theta) {
      const double way =
          std::atan2(last.position->y - first.position->y, last.position->x - first.position->x);
      last.position->theta = std::remainder(way + kTurn, 2 * std::numbers::pi);
      last.position->deviation_theta = kDeviationTheta;
    }
    return Drive(run, std::move(order));
  });
}

std::vector<const Heard*> States(Run& run, const Trip& trip) {
  auto states = run.StatesSince(trip.mark);
  std::erase_if(states, [&](const Heard* one) {
    return one->state->order_id != trip.order.id ||
           (trip.end.found != nullptr && one->at > trip.end.found->at);
  });
  return states;
}

CaseFinding CheckDriving(Run& run) {
  const Trip& trip = PlainTrip(run);
  if (const auto why = Unfinished(trip); !why.empty()) return Inconclusive(why);
  const auto states = States(run, trip);
  const auto driven = std::find_if(states.begin(), states.end(), [](const Heard* one) {
    return one->state->driving.value_or(false);
  });
  if (driven == states.end()) {
    const bool has_hole = run.HasHole(trip.mark);
    if (has_hole) return Inconclusive("no state says that it drove, but states are missing");
    return Fault("driving was never true", {trip.end.found->Evidence()});
  }
  if (trip.end.found->state->driving.value_or(false)) {
    const auto rest = run.Await([](const RobotState& state) { return state.driving == false; });
    if (rest.found == nullptr) return Run::Missing(rest, "driving stays true at rest");
  }
  return Pass("true under way, false at rest", {(*driven)->Evidence()});
}

std::uint32_t FirstId(const Value& state, std::string_view list) {
  const Value* array = FindArray(state, list);
  if (array == nullptr || array->Empty()) return UINT32_MAX;
  return base::UintMember((*array)[0], "sequenceId").value_or(UINT32_MAX);
}

// Node by node, each with one state in which the edge that leads there is gone, too.
CaseFinding CheckReportedNodes(Run& run, const Trip& trip) {
  if (!trip.refusal.empty()) return Inconclusive(trip.refusal);
  const auto& nodes = trip.order.path.nodes;
  std::uint32_t last = 0;
  const auto states = States(run, trip);
  for (const Heard* one : states) {
    const RobotState& state = *one->state;
    const std::uint32_t sequence = state.last_node_sequence_id.value_or(0);
    const std::size_t index = sequence / 2;
    if (sequence < last) return Fault("lastNodeSequenceId runs backwards", {one->Evidence()});
    if (sequence > last + 2) {
      if (run.HasHole(trip.mark)) return Inconclusive("states are missing");
      return Fault("a node was passed without a state", {one->Evidence()});
    }
    // Until it says that it is at the first one, which is another case's.
    if (sequence == 0 && state.last_node_id != nodes.front().id) continue;
    if (index >= nodes.size() || state.last_node_id != nodes[index].id) {
      return Fault(fmt::format("lastNodeId is {} at sequenceId {}",
                               vda5050::Shown(state.last_node_id), sequence),
                   {one->Evidence()});
    }
    if (sequence > 0 && (FirstId(one->json, "edgeStates") < sequence ||
                         FirstId(one->json, "nodeStates") <= sequence)) {
      return Fault("node or edge are still listed when lastNodeSequenceId has them",
                   {one->Evidence()});
    }
    last = sequence;
  }
  if (const auto why = Unfinished(trip); !why.empty()) return Inconclusive(why);
  return Pass(base::Counted(nodes.size(), "node") + ", each in its turn");
}

CaseFinding CheckNodes(Run& run) { return CheckReportedNodes(run, PlainTrip(run)); }

// The first state of each node of the trip.
std::vector<std::pair<const Heard*, const vda5050::OrderNode*>> Arrivals(Run& run,
                                                                         const Trip& trip) {
  std::vector<std::pair<const Heard*, const vda5050::OrderNode*>> found;
  std::uint32_t last = 0;
  for (const Heard* one : States(run, trip)) {
    const std::uint32_t sequence = one->state->last_node_sequence_id.value_or(0);
    if (sequence == last || sequence / 2 >= trip.order.path.nodes.size()) continue;
    last = sequence;
    found.emplace_back(one, &trip.order.path.nodes[sequence / 2]);
  }
  return found;
}

CaseFinding CheckPlace(Run& run) {
  const Trip& trip = PlainTrip(run);
  if (!trip.refusal.empty()) return Inconclusive(trip.refusal);
  bool any = false;
  for (const auto& [one, node] : Arrivals(run, trip)) {
    const auto& at = one->state->position;
    if (!node->position || !at || !at->x || !at->y) continue;
    any = true;
    const double off = std::hypot(*at->x - node->position->x, *at->y - node->position->y);
    const double allowed = node->position->deviation_xy.value_or(0) + kDistanceTolerance;
    if (off > allowed) {
      return Fault(
          fmt::format("it reports node {} {:.2f} m away from it", vda5050::Shown(node->id), off),
          {one->Evidence()});
    }
  }
  return any ? Pass("each node within its deviation")
             : Inconclusive("no node with a position was reached");
}

CaseFinding CheckHeading(Run& run) {
  const std::string_view member = "order.nodes.nodePosition.theta";
  if (!Takes(run, member)) return Skipped("its factsheet does not list theta");
  const Trip& trip = PlainTrip(run);
  if (!trip.refusal.empty()) return Inconclusive(trip.refusal);
  bool any = false;
  for (const auto& [one, node] : Arrivals(run, trip)) {
    const auto& at = one->state->position;
    if (!node->position || !node->position->theta || !at || !at->theta) continue;
    if (std::abs(*at->theta) > std::numbers::pi + 0.001) {
      return Inconclusive("its theta is none", {one->Evidence()});
    }
    any = true;
    const double off =
        std::abs(std::remainder(*at->theta - *node->position->theta, 2 * std::numbers::pi));
    if (off > node->position->deviation_theta.value_or(0) + kAngleTolerance) {
      return Fault(
          fmt::format("it reports node {} turned by {:.2f} rad", vda5050::Shown(node->id), off),
          {one->Evidence()});
    }
  }
  return any ? Pass("within its deviation") : Inconclusive("no node with theta was reached");
}

CaseFinding CheckSpeed(Run& run) {
  if (!Takes(run, run.Is30() ? "order.edges.maximumSpeed" : "order.edges.maxSpeed")) {
    return Skipped("its factsheet does not list a greatest speed");
  }
  const Trip& trip = PlainTrip(run);
  if (!trip.refusal.empty()) return Inconclusive(trip.refusal);
  double limit = 0;
  for (const auto& edge : trip.order.path.edges)
    limit = std::max(limit, edge.max_speed.value_or(0));
  bool any = false;
  for (std::size_t i = trip.mark; i < run.heard().size(); ++i) {
    const Heard& one = run.heard()[i];
    if (trip.end.found != nullptr && one.at > trip.end.found->at) break;
    if (one.message.retained) continue;
    const Value* velocity = FindMember(one.json, "velocity");
    const Value* x = velocity == nullptr ? nullptr : FindMember(*velocity, "vx");
    const Value* y = velocity == nullptr ? nullptr : FindMember(*velocity, "vy");
    if (x == nullptr || !x->IsNumber()) continue;
    const double speed =
        std::hypot(x->GetDouble(), y != nullptr && y->IsNumber() ? y->GetDouble() : 0);
    if (speed > limit * 1.1) {
      return Fault(fmt::format("{:.2f} m/s, where {} is the most", speed, limit), {one.Evidence()});
    }
    any = any || speed > 0.01;
  }
  return any ? Pass(fmt::format("never above {} m/s", limit))
             : Inconclusive("nothing says how fast it drove");
}

// ---- Base and horizon ----

CaseFinding CheckEndOfBase(Run& run) {
  constexpr seconds kRest{10};
  constexpr seconds kWay{120};
  TestOrder order = AlongWay(run);
  if (order.path.nodes.size() < 3) return Inconclusive("there is no way");
  order.released = order.path.nodes.size() - 1;
  if (SendAndAwait(run, order).found == nullptr) return Inconclusive("it did not take the order");
  const auto sequence = order.LastSequenceId() - 2;
  const auto there = run.Await(
      [&](const RobotState& state) { return state.last_node_sequence_id.value_or(0) >= sequence; },
      kWay);
  if (there.found == nullptr) {
    EndOrder(run);
    return Inconclusive("it did not come to the end of its base");
  }
  run.Listen(kRest);
  run.Refresh();
  const Heard& last = *run.last_state();
  const RobotState& state = *last.state;
  auto finding = Pass("it stands, and lists the horizon", {last.Evidence()});
  if (state.last_node_sequence_id.value_or(0) > sequence) {
    finding = Fault("it drove into the horizon", {last.Evidence()});
  } else if (state.order_id != order.id) {
    finding = Inconclusive("it shows another order", {last.Evidence()});
  } else if (state.nodes.empty()) {
    finding = Fault("the horizon is not listed any more", {last.Evidence()});
  } else if (state.driving.value_or(false)) {
    finding = Fault("it does not stand", {last.Evidence()});
  }
  EndOrder(run);
  return finding;
}

// A horizon that becomes part of the base while it drives.
struct UpdatedTrip {
  Trip trip;
  Awaited driving;
  Awaited updated;
  std::size_t updated_mark = 0;
};

const UpdatedTrip& TripWithUpdate(Run& run) {
  return run.Once<UpdatedTrip>("the updated trip", [&] {
    UpdatedTrip made;
    Trip& trip = made.trip;
    trip.order = AlongWay(run);
    trip.mark = run.mark();
    TestOrder first = trip.order;
    first.released = first.path.nodes.empty() ? 0 : first.path.nodes.size() - 1;
    made.driving = SetOff(run, first);
    if (made.driving.found == nullptr) {
      trip.refusal = "it did not set off";
      EndOrder(run);
      return made;
    }
    TestOrder update = trip.order;
    const std::size_t stitch = update.path.nodes.size() - 2;
    update.path.nodes.erase(update.path.nodes.begin(),
                            update.path.nodes.begin() + static_cast<std::ptrdiff_t>(stitch));
    update.path.edges.erase(update.path.edges.begin(),
                            update.path.edges.begin() + static_cast<std::ptrdiff_t>(stitch));
    update.first_sequence_id = 2 * static_cast<std::uint32_t>(stitch);
    update.update_id = 1;
    made.updated_mark = run.mark();
    made.updated = SendAndAwait(run, update);
    trip.end = run.AwaitSince(
        made.updated_mark, run.Now(),
        [&](const RobotState& state) {
          return state.order_id == trip.order.id && IsIdle(state) &&
                 state.last_node_sequence_id == trip.order.LastSequenceId();
        },
        made.updated.found == nullptr ? seconds(1) : seconds(120));
    EndOrder(run);
    return made;
  });
}

CaseFinding CheckNewBase(Run& run) {
  const UpdatedTrip& made = TripWithUpdate(run);
  if (!made.trip.refusal.empty()) return Inconclusive(made.trip.refusal);
  if (made.updated.found == nullptr) return Inconclusive("it did not take the update");
  bool asked = false;
  for (const Heard* one : run.StatesSince(made.trip.mark)) {
    const RobotState& state = *one->state;
    if (state.order_id != made.trip.order.id || !state.new_base_request.value_or(false)) continue;
    asked = true;
    const bool has_horizon = std::any_of(state.nodes.begin(), state.nodes.end(),
                                         [](const auto& node) { return !node.released; });
    if (state.order_update_id == 1U && !has_horizon) {
      return Fault("newBaseRequest stays true after the update", {one->Evidence()});
    }
  }
  return asked ? Pass("true before the update, false after it")
               : Inconclusive("it never asked for a new base, which it need not");
}

CaseFinding CheckUpdate(Run& run) {
  const UpdatedTrip& made = TripWithUpdate(run);
  if (!made.trip.refusal.empty()) return Inconclusive(made.trip.refusal);
  if (made.updated.found == nullptr) {
    return Run::Missing(made.updated, "no state shows the update's orderUpdateId");
  }
  for (const Heard* one : run.StatesSince(made.updated_mark)) {
    const RobotState& state = *one->state;
    if (state.order_id != made.trip.order.id) break;
    const auto sequence = state.last_node_sequence_id.value_or(0);
    if (sequence >= made.trip.order.LastSequenceId()) break;
    const auto& before = *made.driving.found->state;
    if (sequence > before.last_node_sequence_id.value_or(0) && !state.driving.value_or(true)) {
      return Fault("it stopped, though the update came in time", {one->Evidence()});
    }
  }
  if (const auto why = Unfinished(made.trip); !why.empty()) return Inconclusive(why);
  return Pass("it drove on", {made.updated.found->Evidence()});
}

// ---- Updates of an order that it keeps where it stands ----

CaseFinding CheckReplaced(Run& run) {
  TestOrder order = Holding(run, "conform-old");
  if (!Hold(run, order)) return Inconclusive(kNoHorizon);
  order.path.nodes.back().id = "conform-new";
  order.update_id = 1;
  const auto updated = SendAndAwait(run, order);
  auto finding = Run::Missing(updated, "no state shows the update's orderUpdateId");
  if (updated.found != nullptr) {
    const auto& nodes = updated.found->state->nodes;
    const auto has = [&](std::string_view id) {
      return std::any_of(nodes.begin(), nodes.end(), [&](const auto& one) { return one.id == id; });
    };
    const std::vector<std::string> evidence = {updated.found->Evidence()};
    finding = has("conform-old")   ? Fault("the old horizon is still there", evidence)
              : has("conform-new") ? Pass("the new horizon took its place", evidence)
                                   : Fault("the new horizon is not there", evidence);
  }
  EndOrder(run);
  return finding;
}

CaseFinding CheckDeleted(Run& run) {
  TestOrder order = Holding(run);
  if (!Hold(run, order)) return Inconclusive(kNoHorizon);
  order.path.nodes.pop_back();
  order.path.edges.clear();
  order.update_id = 1;
  const auto updated = SendAndAwait(run, order);
  auto finding = Run::Missing(updated, "no state shows the update's orderUpdateId");
  if (updated.found != nullptr) {
    finding = IsIdle(*updated.found->state)
                  ? Pass("the horizon is gone", {updated.found->Evidence()})
                  : Fault("the horizon is still there", {updated.found->Evidence()});
  }
  EndOrder(run);
  return finding;
}

CaseFinding CheckStitch(Run& run) {
  TestOrder order = Holding(run);
  if (!Hold(run, order)) return Inconclusive(kNoHorizon);
  TestOrder other = order;
  other.update_id = 1;
  other.first_sequence_id = 2;
  other.path.nodes.front().id = "conform-elsewhere";
  auto finding = CheckRefusal(run, Write(run, other), {"orderUpdateError", "", ""});
  if (finding.verdict == Verdict::kPass && !HasOrder(*run.last_state()->state, order)) {
    finding = Fault("it is refused, but the order changed", {run.last_state()->Evidence()});
  }
  EndOrder(run);
  return finding;
}

CaseFinding CheckContinued(Run& run) {
  TestOrder order = Standing(run);
  if (SendAndAwait(run, order).found == nullptr) {
    return Inconclusive("it does not take an order of one node");
  }
  order.update_id = 1;
  const auto updated = SendAndAwait(run, order);
  if (updated.found == nullptr) {
    return Run::Missing(updated, "no state shows the update's orderUpdateId");
  }
  return Pass("it is taken", {updated.found->Evidence()});
}

// An order of one node whose action has ended; nothing: it has none.
std::optional<TestOrder> DoneWithAction(Run& run) {
  TestOrder order = Standing(run);
  const auto action = HarmlessAction(run, "NODE", "HARD");
  if (action.type.empty()) return std::nullopt;
  order.path.nodes.front().actions = {action};
  if (SendAndAwait(run, order).found == nullptr) return std::nullopt;
  if (IsIdle(*run.last_state()->state)) return order;
  const auto ended = run.Await(
      [&](const RobotState& state) { return state.order_id == order.id && IsIdle(state); },
      seconds(60));
  if (ended.found == nullptr) return std::nullopt;
  return order;
}

constexpr const char* kNoAction = "it does no harmless action at a node";

CaseFinding CheckRerun(Run& run) {
  auto order = DoneWithAction(run);
  if (!order) return Inconclusive(kNoAction);
  const std::string id = order->path.nodes.front().actions.front().id;
  order->update_id = 1;
  const std::size_t mark = run.mark();
  if (SendAndAwait(run, *order).found == nullptr) return Inconclusive("it takes no update");
  run.Listen(seconds(1));
  run.Refresh();
  for (const Heard* one : run.StatesSince(mark)) {
    std::size_t entries = 0;
    bool runs = false;
    for (const auto& action : one->state->action_states) {
      if (action.id != id) continue;
      ++entries;
      runs = runs || !vda5050::IsTerminal(action.status);
    }
    if (entries > 1) return Fault("its action is listed twice", {one->Evidence()});
    if (HasOrder(*one->state, *order) && runs) {
      return Fault("its action is done again", {one->Evidence()});
    }
  }
  return Pass("its action is not done again", {run.last_state()->Evidence()});
}

CaseFinding CheckExtraNode(Run& run) {
  auto order = DoneWithAction(run);
  if (!order) return Inconclusive(kNoAction);
  auto extra = order->path.nodes.front();
  extra.actions = {HarmlessAction(run, "NODE", "HARD")};
  const std::string id = extra.actions.front().id;
  order->path.nodes.push_back(extra);
  order->path.edges.push_back(Edge("conform-loop"));
  order->update_id = 1;
  const std::size_t mark = run.mark();
  run.SendOrder(Write(run, *order));
  const auto ended = run.AwaitSince(
      mark, run.Now(),
      [&](const RobotState& state) {
        const auto* action = vda5050::FindActionState(state, id);
        return action != nullptr && vda5050::IsTerminal(action->status);
      },
      seconds(60));
  EndOrder(run);
  if (ended.found == nullptr && !Unfinished(PlainTrip(run)).empty()) {
    return Inconclusive("it does not come to the end of any way");
  }
  if (ended.found == nullptr) return Run::Missing(ended, "the new action does not end");
  const auto* action = vda5050::FindActionState(*ended.found->state, id);
  return action->status == "FINISHED" ? Pass("the new action ran", {ended.found->Evidence()})
                                      : Fault("the new action failed", {ended.found->Evidence()});
}

// There, and back to the same node.
CaseFinding CheckLoop(Run& run) {
  TestOrder order = AlongWay(run);
  if (order.path.nodes.size() < 3) return Inconclusive("there is no way");
  if (!run.subject().way.there.nodes.empty()) return Skipped("the way is given: it may be one-way");
  auto& [nodes, edges] = order.path;
  nodes.resize(2);
  nodes.push_back(nodes.front());
  edges = {Edge("conform-1"), Edge("conform-2")};
  return CheckReportedNodes(run, Drive(run, std::move(order)));
}

using enum Version;
constexpr auto kDrivingCases = std::to_array<Case>({
    {"D01", Level::kDrive, k110, k300, "7.8 / 6.10", "driving is true under way and false at rest",
     "next state", "turning counts as driving, too", CheckDriving},
    {"D02", Level::kDrive, k110, k300, "6.6.2",
     "with each node one state has node and edge gone and lastNodeId and lastNodeSequenceId set",
     "next state", "change all of it in one state", CheckNodes},
    {"D03", Level::kDrive, k210, k300, "6.6.2", "a node is reported within its allowed deviation",
     "0.2 m more", "report it when it is reached, not before", CheckPlace},
    {"D04", Level::kDrive, k110, k300, "7.3 / 6.6",
     "a node with theta is reported when the heading is reached", "0.15 rad more",
     "turn first, then report", CheckHeading},
    {"D05", Level::kDrive, k110, k300, "7.3 / 6.6", "an edge's greatest speed is kept", "10 % more",
     "obey maxSpeed, from 3.0 maximumSpeed", CheckSpeed},
    {"D06", Level::kDrive, k110, k300, "6.1.2 / 6.6",
     "at the end of the base it stands, lists the horizon and does not enter it", "10 s",
     "enter released edges only", CheckEndOfBase},
    {"D07", Level::kDrive, k110, k300, "6.6.3 / 6.10", "newBaseRequest is false after the update",
     "next state", "clear it when an update is taken", CheckNewBase},
    {"D08", Level::kDrive, k110, k300, "6.1.2 / 6.6.2",
     "an update in time is taken, and it drives on without a stop", "next state",
     "extend the base while driving", CheckUpdate},
    {"D09", Level::kDrive, k110, k300, "6.1.2 / 6.6.2",
     "an update's horizon takes the old one's place", "next state",
     "clear the horizon before taking the update's", CheckReplaced},
    {"D10", Level::kDrive, k110, k300, "6.1.2 / 6.6.2",
     "an update of the decision point alone deletes the horizon", "next state",
     "an update may have one node", CheckDeleted},
    {"D11", Level::kDrive, k110, k300, "6.1.2 / 6.6.2",
     "an update that does not begin at the decision point is refused, the order goes on",
     "next state", "compare nodeId and sequenceId", CheckStitch},
    {"D12", Level::kDrive, k110, k300, "6.1.2 / 6.6.2", "an update after the order's end is taken",
     "next state", "keep orderId and lastNodeSequenceId after the end", CheckContinued},
    {"D13", Level::kDrive, k300, k300, "6.1.2",
     "actions that come again with the decision point are not done again", "",
     "compare their actionIds", CheckRerun},
    {"D14", Level::kDrive, k300, k300, "6.1.2",
     "a further node at the same place has its action done", "60 s",
     "take an edge that leads back to its own node", CheckExtraNode},
    {"D15", Level::kDrive, k110, k300, "7.3 / 6.6", "an order may come to the same node twice", "",
     "tell nodes apart by sequenceId, not by nodeId", CheckLoop},
});

}  // namespace

std::span<const Case> DrivingCases() { return kDrivingCases; }

}  // namespace fleetpub::app::conformance
