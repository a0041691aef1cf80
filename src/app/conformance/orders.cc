#include "app/conformance/orders.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/text.h"

namespace fleetpub::app::conformance {
namespace {

using vda5050::OrderEdge;
using vda5050::OrderNode;
using vda5050::RobotError;
using vda5050::RobotState;
using vda5050::Shown;

constexpr double kDeviation = 0.5;  // m: how exactly it has to stand
constexpr seconds kTrip{120};       // for one way

bool IsSame(const RobotError& a, const RobotError& b) {
  return a.type == b.type && a.level == b.level && a.description == b.description &&
         std::equal(
             a.references.begin(), a.references.end(), b.references.begin(), b.references.end(),
             [](const auto& x, const auto& y) { return x.key == y.key && x.value == y.value; });
}

std::vector<RobotError> NewErrors(const RobotState& state, const std::vector<RobotError>& before) {
  std::vector<RobotError> found;
  for (const RobotError& error : state.errors) {
    const bool is_old = std::any_of(before.begin(), before.end(),
                                    [&](const RobotError& old) { return IsSame(error, old); });
    if (!is_old) found.push_back(error);
  }
  return found;
}

// From where it stands; nothing: one of them is not known.
std::optional<double> Distance(const Run& run, const OrderNode& node) {
  const auto here = Here(run).position;
  if (!node.position || !here) return std::nullopt;
  return std::hypot(node.position->x - here->x, node.position->y - here->y);
}

}  // namespace

base::JsonDocument Write(const Run& run, const TestOrder& order) {
  const auto& factsheet = run.subject().factsheet;
  vda5050::OrderWriter writer(run.version(), factsheet ? &*factsheet : nullptr);
  std::vector<std::string> nodes;
  std::vector<std::string> edges;
  const auto& path = order.path;
  for (std::size_t i = 0; i < path.nodes.size(); ++i) {
    const auto sequence = order.first_sequence_id + 2 * static_cast<std::uint32_t>(i);
    if (i > 0) {
      edges.push_back(writer.WriteEdge(path.edges[i - 1], sequence - 1, i < order.released,
                                       path.nodes[i - 1].id, path.nodes[i].id));
    }
    nodes.push_back(writer.WriteNode(path.nodes[i], sequence, i < order.released));
  }
  return vda5050::MakeOrder(order.id, order.update_id, "", nodes, edges);
}

bool Takes(const Run& run, std::string_view member) {
  const auto& sheet = run.subject().factsheet;
  if (!sheet || !sheet->has_optional_parameters) return true;
  return std::any_of(sheet->optional_parameters.begin(), sheet->optional_parameters.end(),
                     [&](const auto& one) { return one.name == member; });
}

OrderNode Here(const Run& run, std::string id) {
  OrderNode node{.id = std::move(id), .description = {}, .position = {}, .actions = {}};
  const Heard* last = run.last_state();
  if (last == nullptr) return node;
  const auto& position = last->state->position;
  if (position && position->x && position->y) {
    node.position = {.x = *position->x,
                     .y = *position->y,
                     .theta = {},
                     .map_id = position->map_id,
                     .deviation_xy = kDeviation,
                     .deviation_theta = {}};
  } else {
    node.id = base::NonEmptyOr(last->state->last_node_id, node.id);
  }
  return node;
}

OrderEdge Edge(std::string id) {
  OrderEdge edge;
  edge.id = std::move(id);
  return edge;
}

// On a way of named nodes it keeps the name of the one it was at: its next order begins there.
TestOrder Standing(Run& run) {
  OrderNode node = Here(run);
  const bool is_named = !run.subject().way.there.nodes.empty() && run.last_state() != nullptr;
  if (is_named) node.id = base::NonEmptyOr(run.last_state()->state->last_node_id, node.id);
  return {.id = run.MakeId("conform"), .path = {.nodes = {std::move(node)}, .edges = {}}};
}

void Reach(const Run& run, OrderNode& node) {
  const double off = Distance(run, node).value_or(0);
  if (off <= kDeviation) return;
  node.position->deviation_xy = std::max(node.position->deviation_xy.value_or(0), off + kDeviation);
}

TestOrder Holding(Run& run, const std::string& next) {
  TestOrder order = Standing(run);
  order.path.nodes.push_back(Here(run, next));
  order.path.edges.push_back(Edge("conform-edge"));
  order.released = 1;
  return order;
}

vda5050::InstantAction HarmlessAction(Run& run, std::string_view scope,
                                      std::string_view blocking_type) {
  vda5050::InstantAction action{.type = {},
                                .id = run.MakeId("conform"),
                                .descriptor = {},
                                .blocking_type = std::string(blocking_type),
                                .parameters = {}};
  const bool has_list = run.subject().factsheet.has_value();
  const auto known = run.Knows("detectObject", scope);
  if (known.value_or(!has_list)) action.type = "detectObject";
  return action;
}

bool HasOrder(const RobotState& state, const TestOrder& order) {
  return state.order_id == order.id && state.order_update_id.value_or(0) == order.update_id;
}

bool IsIdle(const RobotState& state) {
  return state.nodes_left.value_or(0) == 0 && state.edges_left.value_or(0) == 0 &&
         std::all_of(state.action_states.begin(), state.action_states.end(),
                     [](const auto& action) { return vda5050::IsTerminal(action.status); });
}

Awaited SendAndAwait(Run& run, const TestOrder& order) {
  const TimePoint from = run.Now();
  const std::size_t mark = run.mark();
  run.SendOrder(Write(run, order));
  return run.AwaitSince(
      mark, from, [&](const RobotState& state) { return HasOrder(state, order); }, kNextState);
}

// Those that refuse it once refuse it always.
bool TakeStanding(Run& run) {
  bool& takes = run.Once<bool>("takes standing orders", [] { return true; });
  if (!takes) return false;
  takes = SendAndAwait(run, Standing(run)).found != nullptr;
  return takes;
}

bool Hold(Run& run, const TestOrder& order) {
  if (SendAndAwait(run, order).found != nullptr) {
    run.Refresh();
    if (HasOrder(*run.last_state()->state, order) && !run.last_state()->state->nodes.empty()) {
      return true;
    }
  }
  EndOrder(run);
  return false;
}

void EndOrder(Run& run) {
  if (run.last_state() == nullptr || IsIdle(*run.last_state()->state)) return;
  run.Do("cancelOrder");
  if (run.Await(IsIdle, kCancel).found == nullptr) {
    run.Abort("it does not give up its order");
  }
}

CaseFinding CheckRefusal(Run& run, const base::JsonDocument& order, const ErrorTypes& types,
                         RobotError* told) {
  const std::string id(base::StringMember(order, "orderId"));
  const auto update_id = base::UintMember(order, "orderUpdateId");
  if (run.last_state() == nullptr) return Inconclusive("no state came");
  const std::vector<RobotError> before = run.last_state()->state->errors;
  const auto has_it = [&](const RobotState& state) {
    return !id.empty() && state.order_id == id &&
           (!update_id || state.order_update_id == update_id);
  };
  const bool had_it = has_it(*run.last_state()->state);
  const auto is_taken = [&](const RobotState& state) { return !had_it && has_it(state); };
  const std::size_t mark = run.mark();
  const TimePoint from = run.Now();
  run.SendOrder(order, Run::Intent::kWrong);
  const auto awaited = run.AwaitSince(
      mark, from,
      [&](const RobotState& state) { return is_taken(state) || !NewErrors(state, before).empty(); },
      kNextState);
  if (awaited.found == nullptr) return Run::Missing(awaited, "no error says that it is refused");
  if (is_taken(*awaited.found->state)) {
    auto finding = Fault("the robot took it", {awaited.found->Evidence()});
    EndOrder(run);
    return finding;
  }
  const auto errors = NewErrors(*awaited.found->state, before);
  const std::string_view wanted = run.Is30()                                ? types.from_30
                                  : run.version() == vda5050::Version::k210 ? types.in_21
                                                                            : types.up_to_20;
  const auto found = std::find_if(errors.begin(), errors.end(), [&](const RobotError& error) {
    return wanted.empty() || error.type == wanted;
  });
  if (found == errors.end()) {
    return Fault(fmt::format("the error is {}, not {}", Shown(errors.front().type), wanted),
                 {awaited.found->Evidence()});
  }
  if (told != nullptr) *told = *found;
  return Pass("it is refused with " + Shown(found->type), {awaited.found->Evidence()});
}

// ---- Driving ----

namespace {

struct Ends {
  vda5050::OrderPosition a;
  vda5050::OrderPosition b;
};

TestOrder AlongHeading(Run& run) {
  TestOrder order{.id = run.MakeId("conform"), .path = {}};
  const OrderNode here = Here(run, "conform-0");
  if (!here.position) return order;
  const Ends& ends = run.Once<Ends>("the ends of the way", [&] {
    const double theta = run.last_state()->state->position->theta.value_or(0);
    Ends made{*here.position, *here.position};
    made.b.x += run.subject().way.distance * std::cos(theta);
    made.b.y += run.subject().way.distance * std::sin(theta);
    return made;
  });
  const auto from = [&](const vda5050::OrderPosition& end) {
    return std::hypot(end.x - here.position->x, end.y - here.position->y);
  };
  const bool is_there = from(ends.a) > from(ends.b);
  OrderNode end{.id = is_there ? "conform-a" : "conform-b",
                .description = {},
                .position = is_there ? ends.a : ends.b,
                .actions = {}};
  OrderNode middle = end;
  middle.id = "conform-m";
  middle.position->x = (here.position->x + end.position->x) / 2;
  middle.position->y = (here.position->y + end.position->y) / 2;
  order.path.nodes = {here, middle, end};
  order.path.edges = {Edge("conform-1"), Edge("conform-2")};
  return order;
}

}  // namespace

TestOrder AlongWay(Run& run) {
  const Way& way = run.subject().way;
  if (run.last_state() == nullptr) return {};
  if (way.there.nodes.empty()) return AlongHeading(run);
  const OrderNode& front = way.there.nodes.front();
  const OrderNode& end = way.there.nodes.back();
  const auto to_front = Distance(run, front);
  const auto to_end = Distance(run, end);
  const bool is_at_end =
      to_front && to_end ? *to_end < *to_front : run.last_state()->state->last_node_id == end.id;
  TestOrder order{.id = run.MakeId("conform"),
                  .path = is_at_end && !way.back.nodes.empty() ? way.back : way.there};
  Reach(run, order.path.nodes.front());  // it may have been called off beside it
  return order;
}

Trip Drive(Run& run, TestOrder order) {
  Trip trip{.order = std::move(order), .mark = run.mark(), .end = {}, .refusal = {}};
  if (trip.order.path.nodes.size() < 3) {
    trip.refusal = "there is no way: the robot says no position, or the nodes are too few";
    return trip;
  }
  const auto taken = SendAndAwait(run, trip.order);
  if (taken.found == nullptr) {
    trip.refusal = "the robot did not take the order";
    return trip;
  }
  trip.end = run.AwaitSince(
      trip.mark, run.Now(),
      [&](const RobotState& state) {
        return state.order_id == trip.order.id && IsIdle(state) &&
               state.last_node_sequence_id == trip.order.LastSequenceId();
      },
      kTrip);
  if (trip.end.found == nullptr) EndOrder(run);
  return trip;
}

Awaited SetOff(Run& run, const TestOrder& order) {
  if (order.path.nodes.size() < 3) return {};
  const std::size_t mark = run.mark();
  if (SendAndAwait(run, order).found == nullptr) return {};
  return run.AwaitSince(
      mark, run.Now(),
      [&](const RobotState& state) {
        return state.order_id == order.id && state.driving.value_or(false);
      },
      kNextState);
}

std::string Unfinished(const Trip& trip) {
  if (!trip.refusal.empty()) return trip.refusal;
  return trip.end.found == nullptr ? "the robot did not come to the end of the way" : "";
}

}  // namespace fleetpub::app::conformance
