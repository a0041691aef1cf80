#include "simulator/orders.h"

#include <fmt/format.h>

#include "base/json.h"
#include "base/text.h"

namespace fleetpub::simulator {
namespace {

using base::FindMember;
using base::StringMember;
using Value = base::JsonValue;

std::uint32_t ReadCount(const Value& object, std::string_view name) {
  const Value* number = FindMember(object, name);
  return number != nullptr && number->IsUint() ? number->GetUint() : 0;
}

bool IsReleased(const Value& leg) {
  const Value* released = FindMember(leg, "released");
  return released == nullptr || !released->IsBool() || released->GetBool();
}

void AddActions(const Value& leg, const ProtocolTerms& terms, std::vector<ActionState>& actions) {
  const Value* array = FindMember(leg, "actions");
  if (array == nullptr || !array->IsArray()) return;
  const std::string_view descriptor = terms.action_descriptor;
  for (const Value& action : array->GetArray()) {
    const std::string_view type = StringMember(action, "actionType");
    actions.push_back({std::string(StringMember(action, "actionId")), std::string(type),
                       std::string(StringMember(action, descriptor)),
                       type == "waitForTrigger" ? ActionStatus::kRunning : ActionStatus::kWaiting,
                       ""});
  }
}

struct Plan {
  std::vector<Leg> nodes;
  std::vector<Leg> edges;
  std::vector<ActionState> actions;
};

std::vector<Leg> ReadLegs(const Value& message, std::string_view list, std::string_view id,
                          const ProtocolTerms& terms, std::vector<ActionState>& actions) {
  std::vector<Leg> legs;
  const Value* array = FindMember(message, list);
  if (array == nullptr || !array->IsArray()) return legs;
  for (const Value& leg : array->GetArray()) {
    legs.push_back(
        {std::string(StringMember(leg, id)), ReadCount(leg, "sequenceId"), IsReleased(leg)});
    AddActions(leg, terms, actions);
  }
  return legs;
}

Plan ReadPlan(const Value& message, const ProtocolTerms& terms) {
  Plan plan;
  plan.nodes = ReadLegs(message, "nodes", "nodeId", terms, plan.actions);
  plan.edges = ReadLegs(message, "edges", "edgeId", terms, plan.actions);
  return plan;
}

}  // namespace

Order ExampleOrder() {
  return {"order-1",
          0,
          {{"node-1", 2, true}, {"node-2", 4, true}},
          {{"edge-1", 1, true}, {"edge-2", 3, true}}};
}

std::string AcceptOrder(const Value& message, RobotState& state, const ProtocolTerms& terms) {
  const std::string_view id = StringMember(message, "orderId");
  const std::uint32_t update = ReadCount(message, "orderUpdateId");
  if (id.empty()) return "orderId is missing";
  const bool same = id == state.order.id;
  if (!same && state.order.Active()) {
    return fmt::format("order {} is still active", base::Printable(state.order.id));
  }
  if (same && update <= state.order.update_id) {
    return fmt::format("orderUpdateId {} is not above {}", update, state.order.update_id);
  }
  Plan plan = ReadPlan(message, terms);
  if (plan.nodes.empty()) return "there must be at least one node";
  // It stands on the first node.
  state.last_node_id = plan.nodes.front().id;
  state.last_node_sequence_id = plan.nodes.front().sequence_id;
  plan.nodes.erase(plan.nodes.begin());
  state.order = {std::string(id), update, std::move(plan.nodes), std::move(plan.edges)};
  state.order_actions = std::move(plan.actions);
  if (!same && terms.OrderClearsInstantActions()) {
    std::erase_if(state.instant_actions,
                  [](const ActionState& action) { return IsEnded(action.status); });
  }
  return {};
}

void FinishOrder(RobotState& state) {
  if (!state.order.nodes.empty()) {
    state.last_node_id = state.order.nodes.back().id;
    state.last_node_sequence_id = state.order.nodes.back().sequence_id;
  }
  state.order.nodes.clear();
  state.order.edges.clear();
  for (ActionState& action : state.order_actions) {
    if (!IsEnded(action.status)) action.status = ActionStatus::kFinished;
  }
}

}  // namespace fleetpub::simulator
