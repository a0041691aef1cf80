#include "app/order_update.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "base/text.h"
#include "message/command_status.h"

namespace fleetpub::app {
namespace {

using base::FindArray;
using base::StringMember;
using Value = base::JsonValue;

// So many orders of one robot are looked through for one.
constexpr int kOrdersRead = 500;

std::string WithReleased(const std::string& json, bool released) {
  base::JsonDocument leg = std::move(*base::ParseJson(json, {.exact = true}));
  leg["released"].SetBool(released);
  return base::ToJson(leg);
}

// Whether its nodes are those that the robot shows; what lies before the first was sent earlier.
bool HasNodesOf(const vda5050::RobotState& state, const SentOrder& order) {
  const Value* nodes = FindArray(order.message, "nodes");
  if (nodes == nullptr || nodes->Empty()) return false;
  std::map<std::uint32_t, std::string_view> ids;
  for (const Value& node : nodes->GetArray()) {
    ids.emplace(base::UintMember(node, "sequenceId").value_or(0), StringMember(node, "nodeId"));
  }
  return std::all_of(state.nodes.begin(), state.nodes.end(), [&](const vda5050::NodeState& node) {
    if (node.sequence_id < ids.begin()->first) return true;
    const auto sent = ids.find(node.sequence_id);
    return sent != ids.end() && sent->second == node.id;
  });
}

bool IsOrderActionOpen(const vda5050::ActionState& action) {
  return !vda5050::IsTerminal(action.status);
}

}  // namespace

std::uint32_t OrderHistory::highest_update_id() const {
  std::uint32_t highest = 0;
  for (const SentOrder& order : sent) highest = std::max(highest, order.update_id);
  return highest;
}

const SentOrder* OrderHistory::Find(const vda5050::RobotState& state) const {
  const std::uint32_t update_id = state.order_update_id.value_or(0);
  const auto found = std::find_if(sent.rbegin(), sent.rend(), [&](const SentOrder& order) {
    return order.update_id == update_id && HasNodesOf(state, order);
  });
  return found == sent.rend() ? nullptr : &*found;
}

Result<OrderHistory> ReadOrderHistory(ledger::Ledger& ledger, std::vector<std::string> brokers,
                                      const std::string& target, std::string_view order_id) {
  auto records = ledger.History(
      {.target = target, .action = "order", .brokers = brokers, .limit = kOrdersRead});
  if (!records) return Fail(std::move(records.error()));
  OrderHistory history{
      .order_id = std::string(order_id), .brokers = std::move(brokers), .sent = {}};
  for (const ledger::Record& record : *records) {
    if (record.actions.empty() || record.actions.front().id != order_id) continue;
    auto message = base::ParseJson(record.payload, {.exact = true});
    if (!message) continue;
    const std::uint32_t update_id = base::UintMember(*message, "orderUpdateId").value_or(0);
    history.sent.push_back(
        {.row = record.id,
         .update_id = update_id,
         .by = record.user + "@" + record.host,
         .at = record.recorded_at,
         .was_rejected = record.status == message::GetName(message::CommandStatus::kRejected),
         .message = *std::move(message)});
  }
  return history;
}

// Instant actions share the list up to 2.1 and do not count here: whoever waits for one may send an
// order meanwhile.
bool IsUnderWay(const vda5050::RobotState& state) {
  if (state.order_id.empty()) return false;
  if (state.nodes_left.value_or(0) + state.edges_left.value_or(0) > 0) return true;
  return state.has_instant_action_states &&
         std::any_of(state.action_states.begin(), state.action_states.end(), IsOrderActionOpen);
}

Result<CurrentOrder> CurrentOrder::Find(const OrderHistory& history,
                                        const vda5050::RobotState& state, std::string_view name) {
  const std::string id = vda5050::Shown(state.order_id);
  if (state.order_id.empty()) {
    return Fail(ErrorKind::kPreflight,
                fmt::format("{} has no order. try: fleetpub order {} NODE...", name, name));
  }
  const std::uint32_t update_id = state.order_update_id.value_or(0);
  const SentOrder* sent = history.Find(state);
  if (sent == nullptr) {
    const std::string over =
        history.brokers.empty() ? "" : " over " + base::Join(history.brokers, " or ");
    return Fail(
        ErrorKind::kPreflight,
        fmt::format("{} has order {} with orderUpdateId {}, which this ledger did not send{}, or "
                    "with other nodes: only who sent it can add to it. "
                    "try: fleetpub order replace {} NODE...",
                    name, id, update_id, over, name));
  }
  CurrentOrder order;
  order.id_ = state.order_id;
  order.zone_set_id_ = StringMember(sent->message, "zoneSetId");
  order.next_update_id_ = std::max(history.highest_update_id(), update_id) + 1;
  const Value* nodes = FindArray(sent->message, "nodes");
  const Value* edges = FindArray(sent->message, "edges");
  if (nodes == nullptr || edges == nullptr || nodes->Size() != edges->Size() + 1) {
    return Fail(
        ErrorKind::kPreflight,
        fmt::format("order {} of {} has another number of edges than its nodes have gaps: it "
                    "cannot be continued",
                    id, name));
  }
  rapidjson::SizeType decision = 0;
  while (decision + 1 < nodes->Size() && base::IsTrueMember((*nodes)[decision + 1], "released"))
    ++decision;
  const std::uint32_t decision_id = base::UintMember((*nodes)[decision], "sequenceId").value_or(0);
  const bool has_ended = !IsUnderWay(state);
  if (has_ended && state.last_node_sequence_id.value_or(decision_id) != decision_id) {
    return Fail(
        ErrorKind::kPreflight,
        fmt::format("order {} of {} ended at {}, not where its base ends: it was cancelled, or "
                    "cleared. try: fleetpub order {} NODE...",
                    id, name, vda5050::Shown(state.last_node_id), name));
  }
  for (rapidjson::SizeType i = decision; i < nodes->Size(); ++i) {
    order.nodes_.push_back(base::ToJson((*nodes)[i]));
    if (i + 1 < nodes->Size()) order.edges_.push_back(base::ToJson((*edges)[i]));
  }
  return order;
}

std::string CurrentOrder::last_node() const {
  return std::string(StringMember(*base::ParseJson(nodes_.back()), "nodeId"));
}

std::uint32_t CurrentOrder::last_sequence_id() const {
  return base::UintMember(*base::ParseJson(nodes_.back()), "sequenceId").value_or(0);
}

std::vector<std::string> CurrentOrder::horizon_nodes() const {
  std::vector<std::string> names;
  for (std::size_t i = 1; i < nodes_.size(); ++i) {
    names.emplace_back(StringMember(*base::ParseJson(nodes_[i]), "nodeId"));
  }
  return names;
}

void CurrentOrder::Append(std::vector<std::string> nodes, std::vector<std::string> edges) {
  std::move(nodes.begin(), nodes.end(), std::back_inserter(nodes_));
  std::move(edges.begin(), edges.end(), std::back_inserter(edges_));
}

// The decision point goes out as it was sent: a robot may compare.
base::JsonDocument CurrentOrder::MakeUpdate(std::size_t released) const {
  std::vector<std::string> nodes = {nodes_.front()};
  std::vector<std::string> edges;
  for (std::size_t i = 1; i < nodes_.size(); ++i) {
    nodes.push_back(WithReleased(nodes_[i], i <= released));
    edges.push_back(WithReleased(edges_[i - 1], i <= released));
  }
  return vda5050::MakeOrder(id_, next_update_id_, zone_set_id_, nodes, edges);
}

}  // namespace fleetpub::app
