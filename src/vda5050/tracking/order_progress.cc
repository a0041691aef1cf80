#include "vda5050/tracking/order_progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/json.h"
#include "base/text.h"

namespace fleetpub::vda5050 {
namespace {

using base::FindArray;
using base::StringMember;
using message::CommandStatus;
using message::Progress;
using Value = base::JsonValue;

std::string FormatPlace(const RobotState& state) {
  return fmt::format("{} {}", state.last_node_sequence_id.value_or(0), state.last_node_id);
}

std::string Joined(std::vector<std::string> parts) {
  std::erase(parts, "");
  return base::Join(parts, "; ");
}

}  // namespace

OrderProgress::OrderProgress(const Value& order, WaitFor wait_for)
    : id_(StringMember(order, "orderId")),
      update_id_(base::UintMember(order, "orderUpdateId").value_or(0)),
      wait_for_(wait_for) {
  const auto each = [&](std::string_view list, std::string_view id_key) {
    const Value* legs = FindArray(order, list);
    if (legs == nullptr) return;
    for (const Value& leg : legs->GetArray()) AddLeg(leg, id_key);
  };
  each("nodes", "nodeId");
  const auto nodes = parts_;
  const Value* list = FindArray(order, "nodes");
  if (list != nullptr && !list->Empty()) {
    const Value& last = (*list)[list->Size() - 1];
    last_node_ = StringMember(last, "nodeId");
    last_sequence_id_ = base::UintMember(last, "sequenceId").value_or(0);
    last_node_occurs_twice_ =
        std::count_if(nodes.begin(), nodes.end(), [&](const ErrorReference& part) {
          return part.key == "nodeId" && part.value == last_node_;
        }) > 1;
  }
  each("edges", "edgeId");
  is_one_place_ = list != nullptr && list->Size() == 1 && actions_.empty();
}

void OrderProgress::AddLeg(const Value& leg, std::string_view id_key) {
  parts_.push_back({std::string(id_key), std::string(StringMember(leg, id_key))});
  const Value* actions = FindArray(leg, "actions");
  if (actions == nullptr) return;
  for (const Value& action : actions->GetArray()) {
    actions_.push_back({.id = std::string(StringMember(action, "actionId")),
                        .type = std::string(StringMember(action, "actionType"))});
    parts_.push_back({"actionId", actions_.back().id});
  }
}

void OrderProgress::Before(const RobotState& state) {
  had_it_before_ = state.order_id == id_ && state.order_update_id.value_or(0) >= update_id_;
  if (!had_it_before_) place_without_ = FormatPlace(state);
}

std::optional<Progress> OrderProgress::Look(const RobotState& state) {
  const std::uint32_t update_id = state.order_update_id.value_or(0);
  if (state.order_id != id_ || update_id < update_id_) {
    if (is_taken_) return Conclude(state, false);
    place_without_ = FormatPlace(state);
    had_it_before_ = false;
    return std::nullopt;
  }
  // A later update may have been there before ours came, which the robot does not take then.
  if (update_id > update_id_ && !is_taken_ && !place_without_) {
    return Progress{.message = fmt::format(
                        "the robot has orderUpdateId {} of this order, which is later than ours, "
                        "{}: nothing shows that it has taken ours",
                        update_id, update_id_)};
  }
  is_taken_ = true;
  if (wait_for_ == WaitFor::kAccepted) {
    const bool is_done = !place_without_ && !is_one_place_ && IsAtLastNode(state);
    return message::Ended(CommandStatus::kAccepted,
                          had_it_before_ ? "the robot had this order before"
                          : is_done ? "the robot shows the order as done: it may have had it before"
                                    : "the robot has the order");
  }
  Record(state);
  return Conclude(state, true);
}

void OrderProgress::Record(const RobotState& state) {
  for (Action& action : actions_) {
    const ActionState* listed = FindActionState(state, action.id, action.type);
    const ActionState* other = listed == nullptr ? FindActionState(state, action.id) : nullptr;
    if (other != nullptr) action.other_type = other->type;
    if (listed == nullptr || IsTerminal(action.status)) continue;
    if (action.type.empty()) action.type = listed->type;
    const bool is_new = std::exchange(action.status, listed->status) != listed->status;
    action.result = listed->result;
    if (is_new) AddNews(action);
    if (!IsTerminal(action.status)) was_under_way_ = true;
  }
  if (state.nodes_left.value_or(0) + state.edges_left.value_or(0) > 0) was_under_way_ = true;
  if (state.last_node_sequence_id.value_or(0) != 0) keeps_sequence_ids_ = true;
  if (IsAtLastNode(state)) is_reached_ = true;
  AddPlace(state);
}

// Nodes have the even sequence ids, from 0 (1.1–2.1 §6.6, 3.0 §6.1).
void OrderProgress::AddPlace(const RobotState& state) {
  std::string place =
      fmt::format("{} ({} of {})", Shown(state.last_node_id),
                  state.last_node_sequence_id.value_or(0) / 2 + 1, last_sequence_id_ / 2 + 1);
  if (state.paused || state.driving) place += fmt::format("  {}", DescribeMotion(state));
  for (const Action& action : actions_) {
    if (action.status == "RUNNING" || action.status == "INITIALIZING") {
      place += fmt::format("  {} {}", Shown(action.type), action.status);
    }
  }
  if (place == place_) return;
  place_ = place;
  place_news_ = std::move(place);
}

void OrderProgress::AddNews(const Action& action) {
  const std::string result = action.result.empty() ? "" : ": " + Shown(action.result);
  const std::string name = fmt::format("action {} ({})", Shown(action.type), Shown(action.id));
  if (action.status == "FAILED") news_.push_back(fmt::format("{} failed{}", name, result));
  if (action.status == "RETRIABLE") {
    news_.push_back(
        fmt::format("{} is RETRIABLE{}: retry it with retry --actionId {}, give it up with "
                    "skipRetry, or help at the robot",
                    name, result, Shown(action.id)));
  }
}

// A robot that does not keep sequence ids says 0, or nothing.
bool OrderProgress::IsAtLastNode(const RobotState& state) const {
  const auto& left = state.nodes;
  const bool is_ahead = std::any_of(left.begin(), left.end(), [&](const NodeState& node) {
    return node.sequence_id == last_sequence_id_;
  });
  if (state.last_node_id != last_node_ || !state.nodes_left || is_ahead) return false;
  if (state.last_node_sequence_id == last_sequence_id_) return true;
  return !keeps_sequence_ids_ && !last_node_occurs_twice_ && left.empty();
}

// Whether this is more than what an order of the same id, done before, would look like.
bool OrderProgress::IsNew(const RobotState& state) const {
  if (was_open_ || is_one_place_) return true;
  return place_without_ && (*place_without_ != FormatPlace(state) || !actions_.empty());
}

Progress OrderProgress::Conclude(const RobotState& state, bool is_shown) {
  const bool is_ours = is_shown && state.order_update_id.value_or(0) == update_id_;
  const bool has_legs = state.nodes_left.value_or(1) + state.edges_left.value_or(1) > 0;
  const auto all_are = [&](const auto& test) {
    return std::all_of(actions_.begin(), actions_.end(), test);
  };
  const bool all_ended = all_are([](const Action& action) { return IsTerminal(action.status); });
  const bool none_runs = all_are(
      [](const Action& action) { return action.status.empty() || IsTerminal(action.status); });
  const bool none_failed = all_are([](const Action& action) { return action.status != "FAILED"; });
  // Some robots forget the order's id at its end.
  const bool is_cleared = !is_shown && state.order_id.empty();
  const bool is_reached = is_reached_ || (is_cleared && IsAtLastNode(state));
  const bool is_over = is_reached && all_ended && !(is_ours && has_legs);
  const bool is_new_failure = !none_failed && !had_it_before_;
  if (is_over && (is_shown || is_cleared) && (IsNew(state) || is_new_failure)) {
    return message::Ended(
        none_failed ? CommandStatus::kFinished : CommandStatus::kFailed,
        is_cleared ? Joined({"the robot has cleared its orderId", PlaceText(state), ActionText()})
                   : ActionText());
  }
  if (!is_shown) {
    const std::string now =
        state.order_id.empty() ? "" : fmt::format(", but order {}", Shown(state.order_id));
    return message::Ended(
        CommandStatus::kVanished,
        Joined({fmt::format("the robot no longer shows order {}{}", Shown(id_), now),
                PlaceText(state), ActionText()}));
  }
  was_open_ = was_open_ || !is_over;
  if (is_ours && was_under_way_ && !has_legs && none_runs && !is_reached) {
    return message::Ended(CommandStatus::kFailed, Joined({"the order ended before its last node",
                                                          PlaceText(state), ActionText()}));
  }
  const std::string how =
      is_over ? "the robot shows the order as done, but not that it was done since: it may have "
                "had it before"
      : has_legs || !none_runs
          ? fmt::format("under way: {} nodes to go", state.nodes_left.value_or(0))
          : "nothing to go, but not done";
  return {.seen = true, .message = Joined({how, PlaceText(state), ActionText()})};
}

// A sequence id that the robot does not keep is 0.
std::string OrderProgress::PlaceText(const RobotState& state) const {
  return fmt::format("its last node is {} ({}), the order's is {} ({})", Shown(state.last_node_id),
                     state.last_node_sequence_id.value_or(0), Shown(last_node_), last_sequence_id_);
}

// Of those that did not go well, or have not ended.
std::string OrderProgress::ActionText() const {
  std::vector<std::string> texts;
  for (const Action& action : actions_) {
    const std::string name = "action " + Shown(action.type.empty() ? action.id : action.type);
    if (action.status == "FINISHED") continue;
    std::string text = action.status == "FAILED" ? name + " failed"
                       : !action.status.empty()  ? name + " is " + Shown(action.status)
                       : action.other_type.empty()
                           ? name + " is not listed"
                           : fmt::format("the actionId of {} is listed as another action, {}",
                                         Shown(action.type), Shown(action.other_type));
    if (!action.result.empty()) text += ": " + Shown(action.result);
    texts.push_back(std::move(text));
  }
  constexpr std::size_t kEnough = 5;
  if (texts.size() > kEnough) {
    const std::size_t more = texts.size() - kEnough;
    texts.resize(kEnough);
    texts.push_back(fmt::format("{} more actions", more));
  }
  return base::Join(texts, "; ");
}

}  // namespace fleetpub::vda5050
