// O: whether orders are taken and refused as they should be. No conforming robot moves.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "app/conformance/case.h"
#include "app/conformance/orders.h"
#include "base/text.h"

namespace fleetpub::app::conformance {
namespace {

using vda5050::RobotError;
using vda5050::RobotState;
using vda5050::Version;

constexpr const char* kNoStanding = "it does not take an order of one node";

// What was shown of a new order of one node.
struct Taking {
  TestOrder order;
  std::size_t mark = 0;
  Awaited taken;
};

const Taking& FirstTaking(Run& run) {
  return run.Once<Taking>("the first standing order", [&] {
    Taking taking{.order = Standing(run), .mark = run.mark(), .taken = {}};
    taking.taken = SendAndAwait(run, taking.order);
    run.Once<bool>("takes standing orders", [&] { return taking.taken.found != nullptr; });
    run.Listen(seconds(1));
    return taking;
  });
}

CaseFinding CheckOneNode(Run& run) {
  const Taking& taking = FirstTaking(run);
  if (taking.taken.found == nullptr) {
    return Run::Missing(taking.taken, "no state shows its orderId and orderUpdateId");
  }
  return Pass("it is taken", {taking.taken.found->Evidence()});
}

CaseFinding CheckFirstNode(Run& run) {
  const Taking& taking = FirstTaking(run);
  if (taking.taken.found == nullptr) return Inconclusive(kNoStanding);
  const RobotState& state = *taking.taken.found->state;
  const std::vector<std::string> evidence = {taking.taken.found->Evidence()};
  if (state.last_node_id == taking.order.path.nodes.front().id &&
      state.last_node_sequence_id == 0U) {
    return Pass("lastNodeId and lastNodeSequenceId are its", evidence);
  }
  return Fault(
      fmt::format("lastNodeId is {}, lastNodeSequenceId {}", vda5050::Shown(state.last_node_id),
                  state.last_node_sequence_id.value_or(0)),
      evidence);
}

CaseFinding CheckNotListed(Run& run) {
  const Taking& taking = FirstTaking(run);
  if (taking.taken.found == nullptr) return Inconclusive(kNoStanding);
  for (const Heard* one : run.StatesSince(taking.mark)) {
    for (const auto& node : one->state->nodes) {
      if (one->state->order_id == taking.order.id && node.sequence_id == 0) {
        return Fault("the first node is in nodeStates", {one->Evidence()});
      }
    }
  }
  return Pass("it is not in nodeStates", {taking.taken.found->Evidence()});
}

CaseFinding CheckAction(Run& run) {
  constexpr seconds kLongAction{60};
  TestOrder order = Standing(run);
  const auto action = HarmlessAction(run, "NODE", "HARD");
  if (action.type.empty()) return Skipped("its factsheet lists no harmless action for nodes");
  order.path.nodes.front().actions = {action};
  const std::size_t mark = run.mark();
  const auto taken = SendAndAwait(run, order);
  if (taken.found == nullptr) return Inconclusive("it does not take an order with an action");
  const auto ended = run.AwaitSince(
      mark, run.Now(),
      [&](const RobotState& state) {
        const auto* one = vda5050::FindActionState(state, action.id);
        return state.order_id != order.id || (one != nullptr && one->status == "FINISHED");
      },
      kLongAction);
  if (ended.found == nullptr) return Run::Missing(ended, "the action does not end");
  run.Refresh();
  const RobotState& last = *run.last_state()->state;
  if (last.order_id != order.id) {
    return Fault("orderId is not kept at the end", {run.last_state()->Evidence()});
  }
  if (!IsIdle(last))
    return Fault("nodeStates or edgeStates are not empty", {run.last_state()->Evidence()});
  return Pass("it ran and ended", {ended.found->Evidence()});
}

CaseFinding CheckListed(Run& run) {
  TestOrder order = Holding(run);
  const auto action = HarmlessAction(run, "NODE", "HARD");
  if (!action.type.empty()) order.path.nodes.back().actions = {action};
  const auto taken = SendAndAwait(run, order);
  if (taken.found == nullptr) return Inconclusive("it does not take an order with a horizon");
  const RobotState& state = *taken.found->state;
  const auto* listed = vda5050::FindActionState(state, action.id);
  CaseFinding finding = Pass("they are listed", {taken.found->Evidence()});
  const bool has_node = std::any_of(state.nodes.begin(), state.nodes.end(), [&](const auto& node) {
    return node.id == order.path.nodes.back().id;
  });
  if (!has_node || state.edges_left.value_or(0) != 1) {
    finding = Fault("the horizon is not in nodeStates and edgeStates", {taken.found->Evidence()});
  } else if (!action.type.empty() && listed == nullptr) {
    finding = Fault("an action of the horizon is not in actionStates", {taken.found->Evidence()});
  } else if (!action.type.empty() && listed->status != "WAITING") {
    finding = Fault("an action of the horizon is " + vda5050::Shown(listed->status),
                    {taken.found->Evidence()});
  }
  EndOrder(run);
  return finding;
}

// ---- What comes again ----

CaseFinding CheckResend(Run& run) {
  const TestOrder order = Standing(run);
  if (SendAndAwait(run, order).found == nullptr) return Inconclusive(kNoStanding);
  const std::size_t errors = run.last_state()->state->errors.size();
  const std::size_t mark = run.mark();
  run.SendOrder(Write(run, order));
  run.Listen(seconds(1));
  run.Refresh();
  for (const Heard* one : run.StatesSince(mark)) {
    if (one->state->errors.size() > errors) {
      return Fault("it is an error: " + vda5050::Shown(one->state->errors.back().type),
                   {one->Evidence()});
    }
    if (!HasOrder(*one->state, order)) return Fault("the order changed", {one->Evidence()});
  }
  if (run.StatesSince(mark).empty()) return Inconclusive("no state came after it");
  return Pass("nothing changed", {run.last_state()->Evidence()});
}

CaseFinding CheckOtherContent(Run& run) {
  TestOrder order = Standing(run);
  if (SendAndAwait(run, order).found == nullptr) return Inconclusive(kNoStanding);
  order.path.nodes.front().id = "conform-other";
  return CheckRefusal(run, Write(run, order), {"", "", "SAME_ORDER_UPDATE_ID"});
}

// An order that has been updated once, and a message of the update before.
CaseFinding RefuseLower(Run& run, RobotError* error) {
  TestOrder order = Standing(run);
  if (SendAndAwait(run, order).found == nullptr) return Inconclusive(kNoStanding);
  order.update_id = 2;
  if (SendAndAwait(run, order).found == nullptr) return Inconclusive("it takes no update");
  order.update_id = 1;
  auto finding =
      CheckRefusal(run, Write(run, order),
                   {"orderUpdateError", "orderUpdateError", "OUTDATED_ORDER_UPDATE"}, error);
  if (finding.verdict == Verdict::kPass && run.last_state()->state->order_update_id != 2U) {
    return Fault("orderUpdateId changed", {run.last_state()->Evidence()});
  }
  return finding;
}

CaseFinding CheckLower(Run& run) { return RefuseLower(run, nullptr); }

CaseFinding CheckReferences(Run& run) {
  RobotError error;
  const auto refused = RefuseLower(run, &error);
  if (refused.verdict != Verdict::kPass) return Inconclusive("no error to look at: " + refused.why);
  for (const std::string_view key : {"orderId", "orderUpdateId"}) {
    if (std::none_of(error.references.begin(), error.references.end(),
                     [&](const auto& reference) { return reference.key == key; })) {
      return Fault(fmt::format("{} is not among its errorReferences", key), refused.evidence);
    }
  }
  return Pass("both are there", refused.evidence);
}

// ---- What is refused ----

// With a fresh order of one node before, so that no older error is there.
CaseFinding Refuse(
    Run& run, const TestOrder& order, const ErrorTypes& types,
    void (*spoil)(base::JsonDocument& order) = [](base::JsonDocument&) {},
    RobotError* error = nullptr) {
  if (!TakeStanding(run)) return Inconclusive(kNoStanding);
  base::JsonDocument message = Write(run, order);
  spoil(message);
  return CheckRefusal(run, message, types, error);
}

constexpr ErrorTypes kMalformed = {"validationError", "validationError", "VALIDATION_FAILURE"};

void DropUpdateId(base::JsonDocument& order) { order.RemoveMember("orderUpdateId"); }

TestOrder TwoNodes(Run& run) {
  TestOrder order = Holding(run);
  order.released = 2;
  return order;
}

CaseFinding CheckMember(Run& run) { return Refuse(run, Standing(run), kMalformed, DropUpdateId); }

CaseFinding CheckStays(Run& run) {
  RobotError error;
  const auto refused = Refuse(run, Standing(run), kMalformed, DropUpdateId, &error);
  if (refused.verdict != Verdict::kPass) return Inconclusive("no error to look at: " + refused.why);
  const auto has_it = [&](const RobotState& state) {
    return std::any_of(state.errors.begin(), state.errors.end(),
                       [&](const RobotError& one) { return one.type == error.type; });
  };
  for (int i = 0; i < 3; ++i) {
    run.Refresh();
    if (!has_it(*run.last_state()->state)) {
      return Fault("the error is gone before an order was taken", {run.last_state()->Evidence()});
    }
  }
  const auto taken = SendAndAwait(run, Standing(run));
  if (taken.found == nullptr) return Inconclusive(kNoStanding);
  run.Refresh();
  if (has_it(*run.last_state()->state)) {
    return Fault("the error stays when an order has been taken", {run.last_state()->Evidence()});
  }
  return Pass("it stays until an order is taken", {taken.found->Evidence()});
}

CaseFinding CheckEdges(Run& run) {
  return Refuse(run, TwoNodes(run), kMalformed,
                [](base::JsonDocument& order) { order["nodes"].PopBack(); });
}

// That sequenceIds have no gap, 3.0 is the first to say.
CaseFinding CheckSequence(Run& run) {
  TestOrder order = TwoNodes(run);
  order.path.nodes.push_back(Here(run, "conform-last"));
  order.path.edges.push_back(Edge("conform-edge-2"));
  order.released = 3;
  auto finding = Refuse(run, order, kMalformed, [](base::JsonDocument& message) {
    for (const char* list : {"edges", "nodes"}) {
      message[list][list[0] == 'n' ? 1 : 0]["released"].SetBool(false);
    }
  });
  if (finding.verdict != Verdict::kPass) finding.why = "a base behind the horizon: " + finding.why;
  if (finding.verdict != Verdict::kPass || !run.Is30()) return finding;
  finding = Refuse(run, TwoNodes(run), kMalformed, [](base::JsonDocument& message) {
    message["nodes"][1]["sequenceId"].SetUint(4);
  });
  if (finding.verdict != Verdict::kPass) finding.why = "a gap in sequenceIds: " + finding.why;
  return finding;
}

CaseFinding CheckAboveZero(Run& run) {
  TestOrder order = Standing(run);
  order.update_id = 1;
  return Refuse(run, order, {});
}

CaseFinding CheckUnknownAction(Run& run) {
  TestOrder order = Standing(run);
  order.path.nodes.front().actions = {{.type = "fleetpubConformanceTest",
                                       .id = run.MakeId("conform"),
                                       .descriptor = {},
                                       .blocking_type = "HARD",
                                       .parameters = {}}};
  return Refuse(run, order, {"orderError", "orderError", "INVALID_ORDER_ACTION"});
}

// A member of edges that its factsheet does not name.
struct Unsupported {
  std::string_view path;
  Version first;
  Version last;
  void (*add)(base::JsonDocument& order);
};

void AddText(base::JsonDocument& order, const char* name) {
  auto& pool = order.GetAllocator();
  order["edges"][0].AddMember(base::JsonValue(name, pool), base::JsonValue("left", pool), pool);
}
void AddNumber(base::JsonDocument& order, const char* name) {
  auto& pool = order.GetAllocator();
  order["edges"][0].AddMember(base::JsonValue(name, pool), base::JsonValue(3.0), pool);
}

using enum Version;
constexpr auto kUnsupported = std::to_array<Unsupported>({
    {"order.edges.direction", k200, k300,
     [](base::JsonDocument& order) { AddText(order, "direction"); }},
    {"order.edges.maxHeight", k200, k210,
     [](base::JsonDocument& order) { AddNumber(order, "maxHeight"); }},
    {"order.edges.maximumMobileRobotHeight", k300, k300,
     [](base::JsonDocument& order) { AddNumber(order, "maximumMobileRobotHeight"); }},
});

CaseFinding CheckUnsupported(Run& run) {
  const auto& sheet = run.subject().factsheet;
  if (!sheet || !sheet->has_optional_parameters) {
    return Skipped("no factsheet says which members it takes");
  }
  for (const Unsupported& one : kUnsupported) {
    if (run.version() < one.first || run.version() > one.last) continue;
    const auto& names = sheet->optional_parameters;
    if (std::any_of(names.begin(), names.end(),
                    [&](const auto& parameter) { return parameter.name == one.path; })) {
      continue;
    }
    return Refuse(run, TwoNodes(run), {"orderError", "orderError", "UNSUPPORTED_PARAMETER"},
                  one.add);
  }
  return Skipped("it takes all members that could be tried");
}

CaseFinding CheckFarStart(Run& run) {
  TestOrder order = Standing(run);
  auto& first = order.path.nodes.front();
  if (!first.position) return Skipped("the robot says no position");
  first.id = "conform-far";
  first.position->x += 100;
  return Refuse(run, order, {"noRouteError", "", "START_NODE_OUT_OF_RANGE"});
}

CaseFinding CheckUnknownMap(Run& run) {
  TestOrder order = TwoNodes(run);
  auto& last = order.path.nodes.back();
  if (!last.position) return Skipped("the robot says no position");
  last.position->map_id = "conform-unknown-map";
  return Refuse(run, order, {"", "", "UNKNOWN_MAP_ID"});
}

CaseFinding CheckBusy(Run& run) {
  if (!Hold(run, Holding(run))) return Inconclusive(kNoHorizon);
  // Not from the decision point: 1.1 has an order that begins there take the other's place.
  TestOrder other = Standing(run);
  other.path.nodes.front().id = "conform-other";
  auto finding =
      CheckRefusal(run, Write(run, other), {"orderUpdateError", "", "OTHER_ORDER_ACTIVE"});
  EndOrder(run);
  return finding;
}

constexpr auto kOrderCases = std::to_array<Case>({
    {"O01", Level::kDrive, k110, k300, "6.1.2 / 6.6.1",
     "an order of one node, where it stands, is taken", "next state",
     "an order has no edges when it has one node", CheckOneNode},
    {"O02", Level::kDrive, k110, k300, "6.1.1 / 6.6.1",
     "lastNodeId and lastNodeSequenceId are those of a new order's first node", "next state",
     "set both when the order is taken", CheckFirstNode},
    {"O03", Level::kDrive, k300, k300, "6.1.1",
     "the first node of a new order is not in nodeStates", "next state",
     "it is traversed when the order is taken", CheckNotListed},
    {"O04", Level::kDrive, k110, k300, "6.6.2, 6.1.2.1 / 6.6.2",
     "an action of the order runs and ends; then the arrays are empty, the ids kept", "60 s",
     "keep orderId and orderUpdateId until the next order", CheckAction},
    {"O05", Level::kDrive, k110, k300, "6.6.9 / 6.11",
     "a new order's nodes, edges and actions are all listed, those of the horizon too",
     "next state", "list the horizon's actions as WAITING", CheckListed},
    {"O06", Level::kDrive, k110, k300, "6.1.4.5 / 6.6.4.3",
     "an order that comes again is no error and changes nothing", "2 states",
     "compare orderId and orderUpdateId, and discard it", CheckResend},
    {"O07", Level::kDrive, k300, k300, "6.1.4.5",
     "the same ids with another content bring SAME_ORDER_UPDATE_ID", "next state",
     "compare the content", CheckOtherContent},
    {"O08", Level::kDrive, k110, k300, "6.1.4.4 / 6.6.4.3",
     "a lower orderUpdateId is refused, and the order goes on", "next state",
     "report orderUpdateError, from 3.0 OUTDATED_ORDER_UPDATE", CheckLower},
    {"O09", Level::kDrive, k110, k300, "6.1.4 / 6.6.4",
     "the error of a refused order is in every state until an order is taken", "3 states",
     "keep it until then", CheckStays},
    {"O10", Level::kDrive, k300, k300, "6.6.5.4",
     "the error of a refused update names orderId and orderUpdateId", "next state",
     "add both as errorReferences", CheckReferences},
    {"O11", Level::kDrive, k110, k300, "6.1.4.1 / 6.6.4",
     "an order without one of its members is refused", "next state",
     "report validationError, from 3.0 VALIDATION_FAILURE", CheckMember},
    {"O12", Level::kDrive, k110, k300, "6.1.1 / 6.6.1", "an order has one edge less than nodes",
     "next state", "count them", CheckEdges},
    {"O13", Level::kDrive, k110, k300, "6.1.1 / 6.6.1",
     "an order with a base behind its horizon, or from 3.0 a gap in its sequenceIds, is refused",
     "next state", "compare each node and edge with the one before", CheckSequence},
    {"O14", Level::kDrive, k300, k300, "6.1.2", "a new order begins with orderUpdateId 0",
     "next state", "refuse another one", CheckAboveZero},
    {"O15", Level::kDrive, k110, k300, "6.1.4.3 / 6.6.4.2",
     "an order with an unknown action is refused", "next state",
     "report orderError, from 3.0 INVALID_ORDER_ACTION", CheckUnknownAction},
    {"O16", Level::kDrive, k200, k300, "6.1.4.2 / 6.6.4.2",
     "an order with an optional member that it cannot use is refused", "next state",
     "report orderError, from 3.0 UNSUPPORTED_PARAMETER", CheckUnsupported},
    {"O17", Level::kDrive, k110, k300, "6.1.4.7 / 6.6.4",
     "an order that begins 100 m away is refused", "next state",
     "report noRouteError, from 3.0 START_NODE_OUT_OF_RANGE", CheckFarStart},
    {"O18", Level::kDrive, k210, k300, "6.1.4.10 / 6.7.1",
     "an order with an unknown map is refused", "next state",
     "look at every node's mapId before taking it", CheckUnknownMap},
    {"O19", Level::kDrive, k110, k300, "6.1.4.6 / 6.6.4",
     "another order is refused while one is active", "next state",
     "an order with a horizon is active also at the end of its base", CheckBusy},
    {"O20", Level::kDrive, k300, k300, "6.1.4.9",
     "an order in MANUAL brings MOBILE_ROBOT_NOT_AVAILABLE", "next state", "refuse it", nullptr},
});

}  // namespace

std::span<const Case> OrderCases() { return kOrderCases; }

}  // namespace fleetpub::app::conformance
