// X: cancelling and pausing on the way.
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

constexpr milliseconds kUnderWay{200};  // so that it has left its node

// An order that is cancelled under way, and what comes after it.
struct Cancelled {
  CaseFinding cancel;
  CaseFinding update;
  CaseFinding next;
};

CaseFinding CheckCancelled(const TestOrder& order, const std::string& action, const Awaited& ended,
                           const std::string& id) {
  if (ended.found == nullptr) return Run::Missing(ended, "cancelOrder does not end");
  const RobotState& state = *ended.found->state;
  const std::vector<std::string> evidence = {ended.found->Evidence()};
  if (vda5050::FindActionState(state, id)->status != "FINISHED") {
    return Fault("cancelOrder is FAILED", evidence);
  }
  if (state.nodes_left.value_or(0) != 0 || state.edges_left.value_or(0) != 0) {
    return Fault("cancelOrder is FINISHED, and nodeStates or edgeStates are not empty", evidence);
  }
  if (state.driving.value_or(false))
    return Fault("cancelOrder is FINISHED while it drives", evidence);
  if (state.order_id != order.id) return Fault("orderId is not kept", evidence);
  if (!action.empty()) {
    const auto* waiting = vda5050::FindActionState(state, action);
    if (waiting == nullptr) return Fault("the order's actions have left actionStates", evidence);
    if (waiting->status != "FAILED") {
      return Fault("an action that was WAITING is " + vda5050::Shown(waiting->status), evidence);
    }
  }
  return Pass("it stands, the arrays are empty, the ids kept", evidence);
}

// It begins at the node that it was at last, with a deviation that reaches to where it stands, and at
// a node that no layout has. Without positions the node's name alone can be kept.
std::vector<TestOrder> NextOrders(Run& run, const TestOrder& before) {
  TestOrder last = Standing(run);
  TestOrder here = last;
  here.id = run.MakeId("conform");
  here.path.nodes = {Here(run)};
  const std::size_t index = run.last_state()->state->last_node_sequence_id.value_or(0) / 2;
  const bool is_known = index < before.path.nodes.size() &&
                        before.path.nodes[index].id == run.last_state()->state->last_node_id;
  if (!is_known || !before.path.nodes[index].position) return {last};
  if (!Takes(run, "order.nodes.nodePosition.allowedDeviationXY")) return {here};
  auto& node = last.path.nodes.front();
  node = before.path.nodes[index];
  node.actions.clear();
  node.position->theta.reset();
  Reach(run, node);
  return {last, here};
}

CaseFinding CheckNextOrders(Run& run, const TestOrder& before) {
  CaseFinding finding;
  for (const TestOrder& next : NextOrders(run, before)) {
    const auto taken = SendAndAwait(run, next);
    if (taken.found == nullptr) {
      const auto where = vda5050::Shown(next.path.nodes.front().id);
      if (!TakeStanding(run)) return Inconclusive("it takes no order of one node");
      return Run::Missing(taken, "no state shows the new order from " + where);
    }
    finding = Pass("it is taken", {taken.found->Evidence()});
  }
  return finding;
}

const Cancelled& CancelledTrip(Run& run) {
  return run.Once<Cancelled>("the cancelled trip", [&] {
    Cancelled made;
    TestOrder order = AlongWay(run);
    if (order.path.nodes.size() >= 3) {
      const auto action = HarmlessAction(run, "NODE", "HARD");
      if (!action.type.empty()) order.path.nodes.back().actions.push_back(action);
    }
    auto driving = SetOff(run, order);
    if (driving.found == nullptr && !order.path.nodes.empty()) {
      // Perhaps it does not know the action, which no list says.
      EndOrder(run);
      order.id = run.MakeId("conform");
      order.path.nodes.back().actions.clear();
      driving = SetOff(run, order);
    }
    if (driving.found == nullptr) {
      made.cancel = made.update = made.next = Inconclusive("it did not set off");
      EndOrder(run);
      return made;
    }
    const auto& actions = order.path.nodes.back().actions;
    run.Listen(kUnderWay);
    const std::string id = run.Do("cancelOrder");
    const auto ended = run.Await(ShowsEnd(id), kCancel);
    made.cancel =
        CheckCancelled(order, actions.empty() ? std::string() : actions.back().id, ended, id);
    EndOrder(run);
    if (run.Is30()) {
      TestOrder update = order;
      update.path = {.nodes = {Here(run)}, .edges = {}};
      const auto sequence = run.last_state()->state->last_node_sequence_id.value_or(0);
      update.path.nodes.front().id = run.last_state()->state->last_node_id;
      update.first_sequence_id = sequence;
      update.update_id = 1;
      const bool keeps_id = run.last_state()->state->order_id == order.id;
      made.update = keeps_id ? CheckRefusal(run, Write(run, update),
                                            {"", "", "ORDER_UPDATE_FOLLOWING_CANCEL"})
                             : Inconclusive("it has forgotten the order");
    }
    made.next = made.cancel.verdict == Verdict::kPass ? CheckNextOrders(run, order)
                                                      : Inconclusive("it was not cancelled");
    EndOrder(run);
    (void)Drive(run, AlongWay(run));  // so that the next way is a whole one
    return made;
  });
}

CaseFinding CheckCancel(Run& run) { return CancelledTrip(run).cancel; }
CaseFinding CheckUpdate(Run& run) { return CancelledTrip(run).update; }
CaseFinding CheckNext(Run& run) { return CancelledTrip(run).next; }

CaseFinding CheckOtherId(Run& run) {
  const TestOrder order = Holding(run);
  if (!Hold(run, order)) return Inconclusive(kNoHorizon);
  const std::string id =
      run.Do("cancelOrder", {{"orderId", base::JsonString("conform-no-such-order")}});
  const auto ended = run.Await(ShowsEnd(id));
  auto finding = Run::Missing(ended, "cancelOrder does not end");
  if (ended.found != nullptr) {
    const RobotState& state = *ended.found->state;
    const bool failed = vda5050::FindActionState(state, id)->status == "FAILED";
    finding = !failed ? Fault("cancelOrder is FINISHED", {ended.found->Evidence()})
              : state.nodes.empty()
                  ? Fault("the order is gone", {ended.found->Evidence()})
                  : Pass("it is FAILED, the order goes on", {ended.found->Evidence()});
  }
  EndOrder(run);
  return finding;
}

CaseFinding CheckPause(Run& run) {
  constexpr seconds kPause{10};
  TestOrder order = AlongWay(run);
  const std::size_t mark = run.mark();
  if (SetOff(run, order).found == nullptr) {
    EndOrder(run);
    return Inconclusive("it did not set off");
  }
  const std::string pause = run.Do("startPause");
  const auto paused = run.Await(ShowsEnd(pause), kPause);
  CaseFinding finding = Run::Missing(paused, "startPause does not end");
  if (paused.found != nullptr) {
    run.Refresh();
    const Heard& last = *run.last_state();
    const RobotState& state = *last.state;
    finding = Pass("it stood, and drove on", {last.Evidence()});
    const auto is_there = [&](const RobotState& one) {
      return IsIdle(one) && one.last_node_sequence_id == order.LastSequenceId();
    };
    if (paused.found->state->nodes.empty() &&
        paused.found->state->last_node_sequence_id == order.LastSequenceId()) {
      finding = Inconclusive("it was at its end before it stood: the way is too short");
    } else if (is_there(state)) {
      finding = Fault("it drove on while it was paused", {last.Evidence()});
    } else if (state.nodes.empty() || state.order_id != order.id) {
      finding = Fault("the order is gone", {last.Evidence()});
    } else if (state.driving.value_or(false)) {
      finding = Fault("it drives while it is paused", {last.Evidence()});
    }
  }
  const std::string resume = run.Do("stopPause");
  (void)run.Await(ShowsEnd(resume), kPause);
  if (finding.verdict == Verdict::kPass) {
    const auto there = run.AwaitSince(
        mark, run.Now(),
        [&](const RobotState& state) {
          return (state.order_id == order.id || state.order_id.empty()) && IsIdle(state) &&
                 state.last_node_sequence_id == order.LastSequenceId();
        },
        kCancel);
    if (there.found == nullptr) {
      EndOrder(run);
      const bool drives = Unfinished(Drive(run, AlongWay(run))).empty();
      finding = drives ? Run::Missing(there, "it does not finish the order")
                       : Inconclusive("it does not come to the end of any way");
    }
  }
  EndOrder(run);
  return finding;
}

CaseFinding CheckActionsKept(Run& run) {
  const std::string id = run.Do("stopPause");
  if (run.Await(ShowsEnd(id)).found == nullptr) return Inconclusive("stopPause did not end");
  run.Refresh();
  if (vda5050::FindActionState(*run.last_state()->state, id) == nullptr) {
    return Inconclusive("it is gone before there is an order");
  }
  const auto taken = SendAndAwait(run, Standing(run));
  if (taken.found == nullptr) return Inconclusive("it does not take an order of one node");
  run.Refresh();
  const Heard& last = *run.last_state();
  if (vda5050::FindActionState(*last.state, id) != nullptr) {
    return Pass("it stays", {last.Evidence()});
  }
  return Fault("an ended instant action is gone with the new order", {taken.found->Evidence()});
}

CaseFinding CheckDropped(Run& run) {
  const std::string id = run.Do("stopPause");
  if (run.Await(ShowsEnd(id)).found == nullptr) return Inconclusive("stopPause did not end");
  const auto taken = SendAndAwait(run, Standing(run));
  if (taken.found == nullptr) return Inconclusive("it does not take an order of one node");
  if (vda5050::FindActionState(*taken.found->state, id) == nullptr) {
    return Pass("it is gone", {taken.found->Evidence()});
  }
  return Fault("an ended instant action is still there", {taken.found->Evidence()});
}

using enum Version;
constexpr auto kEndingCases = std::to_array<Case>({
    {"X01", Level::kDrive, k110, k300, "6.1.3 / 6.6.3",
     "cancelOrder under way: it stands, the arrays are empty, the ids and actions kept, then it is "
     "FINISHED",
     "120 s", "report FINISHED last", CheckCancel},
    {"X03", Level::kDrive, k300, k300, "6.1.3.1",
     "an update of a cancelled order brings ORDER_UPDATE_FOLLOWING_CANCEL", "next state",
     "remember that the order was cancelled", CheckUpdate},
    {"X02", Level::kDrive, k110, k300, "6.1.3.1 / 6.6.3",
     "after that it takes new orders from its last node, by its deviation, and from where it "
     "stands",
     "next state", "keep the deviation, and take a node that no layout has", CheckNext},
    {"X04", Level::kDrive, k300, k300, "6.1.3.2",
     "cancelOrder with another orderId is FAILED, and the order goes on", "next state",
     "compare the orderId, when there is one", CheckOtherId},
    {"X05", Level::kDrive, k110, k300, "6.2.3 / 6.8",
     "a pause under way stops it and keeps the order; stopPause has it finished", "10 s",
     "stop, and keep nodeStates and edgeStates", CheckPause},
    {"X06", Level::kDrive, k110, k210, "6.10.6",
     "a new order drops ended instant actions from the state", "next state",
     "clear actionStates of what has ended", CheckDropped},
    {"I13", Level::kDrive, k300, k300, "7.8", "ended instant actions outlast a new order",
     "next state", "keep them until clearInstantActions", CheckActionsKept},
    {"X07", Level::kDrive, k110, k300, "6.6.7 / 6.10", "who switches to MANUAL clears the order",
     "next state", "clear it with the state that reports the mode", nullptr},
    {"X08", Level::kDrive, k110, k300, "4.1 / 6.2",
     "without a connection it finishes its base, and sends a state on return", "",
     "stop at the end of the base only", nullptr},
});

}  // namespace

std::span<const Case> EndingCases() { return kEndingCases; }

}  // namespace fleetpub::app::conformance
