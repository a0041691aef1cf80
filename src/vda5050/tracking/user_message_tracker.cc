// Follows what was published from a file until the robot's state shows it. One class for what has
// one id (an order, a zone set, a response), one for several actions.
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/json.h"
#include "base/text.h"
#include "vda5050/messages/user_message.h"
#include "vda5050/reports/robot_errors.h"
#include "vda5050/reports/robot_messages.h"
#include "vda5050/tracking/reception.h"

namespace fleetpub::vda5050 {
namespace {

using base::FindArray;
using base::FindMember;
using base::StringMember;
using message::CommandStatus;
using message::Progress;
using Value = base::JsonValue;

// What was sent, and how a state shows it.
struct Item {
  std::string topic;
  std::string id_key;
  std::string id;
  std::optional<std::uint32_t> update_id;
  /// What this state says of it; nothing: it does not show it.
  std::function<std::optional<Progress>(const RobotState&)> look;
};

class ItemTracker final : public message::ResponseTracker {
 public:
  ItemTracker(Item item, Reception reception, std::string state_topic, std::string connection_topic)
      : item_(std::move(item)),
        reception_(std::move(reception)),
        state_topic_(std::move(state_topic)),
        connection_topic_(std::move(connection_topic)) {
    Tell();
  }

  [[nodiscard]] std::vector<std::string> Topics() const override {
    return {state_topic_, connection_topic_};
  }

  void Published(std::uint32_t header_id) override {
    header_ids_.push_back(header_id);
    reception_.Forget();
    told_ = "the robot has sent no state since";
    if (!progress_.ended) Tell();
  }

  void Receive(const message::Incoming& message) override {
    if (progress_.ended || (message.retained && !header_ids_.empty())) return;
    if (message.topic == connection_topic_) {
      OnConnection(message);
    } else if (message.topic == state_topic_) {
      const auto state = reception_.Take<RobotState>("state", message.payload, ReadState);
      if (state && header_ids_.empty()) {
        for (const RobotError& error : state->errors) old_errors_.push_back(FingerprintOf(error));
      } else if (state) {
        OnState(*state);
      }
    }
    if (!progress_.ended) Tell();
  }

  [[nodiscard]] const Progress& progress() const override { return progress_; }

 private:
  // A new error comes before what the state shows: a robot that refuses an order or a zone set of
  // an id that it has goes on showing the old one. Once ours is shown, errors are of its way.
  void OnState(const RobotState& state) {
    if (!progress_.seen) {
      const std::string refusal = RefusalIn(state);
      if (!refusal.empty()) return End(CommandStatus::kRejected, refusal);
    }
    if (auto shown = item_.look(state)) {
      progress_ = std::move(*shown);
      told_ = progress_.message;
    } else if (progress_.seen) {
      End(CommandStatus::kVanished,
          fmt::format("the robot's state no longer shows {} {}", item_.id_key, Shown(item_.id)));
    } else {
      told_ = fmt::format("the robot's state does not show {} {}; it is of {}", item_.id_key,
                          Shown(item_.id), Shown(state.header.timestamp));
    }
  }

  [[nodiscard]] std::string RefusalIn(const RobotState& state) const {
    std::string told;
    for (const RobotError& error : state.errors) {
      if (IsOurs(error)) told += (told.empty() ? "" : "; ") + Told(error);
    }
    return told;
  }

  [[nodiscard]] bool IsOurs(const RobotError& error) const {
    const auto attribution = AttributionOf(error, {.topic = item_.topic,
                                                   .id_key = item_.id_key,
                                                   .id = item_.id,
                                                   .header_ids = header_ids_,
                                                   .update_id = item_.update_id});
    if (attribution != Attribution::kItem && attribution != Attribution::kHeaderId) return false;
    const auto fingerprint = FingerprintOf(error);
    return std::find(old_errors_.begin(), old_errors_.end(), fingerprint) == old_errors_.end();
  }

  void OnConnection(const message::Incoming& message) {
    const auto connection =
        reception_.Take<ConnectionMessage>("connection message", message.payload, ReadConnection);
    if (!connection || message.retained || header_ids_.empty()) return;
    const std::string& state = connection->connection_state;
    if (state != "OFFLINE" && state != "CONNECTION_BROKEN" && state != "HIBERNATING") return;
    End(CommandStatus::kOffline, fmt::format("the robot became {} while we waited", state));
  }

  void Tell() {
    progress_.message = told_;
    const std::string& passed_over = reception_.passed_over();
    if (!passed_over.empty()) progress_.message += "; " + passed_over;
  }

  void End(CommandStatus status, std::string message) {
    progress_ = {.seen = true, .ended = true, .status = status, .message = std::move(message)};
  }

  Item item_;
  Reception reception_;
  std::string state_topic_;
  std::string connection_topic_;
  Progress progress_;
  std::string told_ = "not sent yet";      // of the robot's last word, while it is no end
  std::vector<std::uint32_t> header_ids_;  // of each time it was published
  std::vector<std::size_t> old_errors_;    // fingerprints of what stood there before
};

// Several actions in one message: ends with the last of them, or with the first that goes wrong.
class EveryAction final : public message::ResponseTracker {
 public:
  explicit EveryAction(std::vector<std::unique_ptr<message::ResponseTracker>> parts)
      : parts_(std::move(parts)) {}

  [[nodiscard]] std::vector<std::string> Topics() const override {
    std::vector<std::string> topics;
    for (const auto& part : parts_) {
      for (std::string& topic : part->Topics()) topics.push_back(std::move(topic));
    }
    std::sort(topics.begin(), topics.end());
    topics.erase(std::unique(topics.begin(), topics.end()), topics.end());
    return topics;
  }

  void Published(std::uint32_t header_id) override {
    for (const auto& part : parts_) part->Published(header_id);
    Summarize();
  }

  void Receive(const message::Incoming& message) override {
    for (const auto& part : parts_) part->Receive(message);
    Summarize();
  }

  [[nodiscard]] const Progress& progress() const override { return progress_; }

 private:
  void Summarize() {
    const auto went_well = [](const Progress& p) {
      return p.status == CommandStatus::kFinished || p.status == CommandStatus::kAccepted;
    };
    progress_ = {.seen = true, .ended = true};
    for (const auto& part : parts_) {
      const Progress& own = part->progress();
      if (own.ended && !went_well(own)) {
        progress_ = own;
        return;
      }
      progress_.seen = progress_.seen && own.seen;
      if (!own.ended || progress_.ended) progress_.message = own.message;
      progress_.ended = progress_.ended && own.ended;
      progress_.status = own.ended ? own.status : CommandStatus::kTimeout;
    }
  }

  std::vector<std::unique_ptr<message::ResponseTracker>> parts_;
  Progress progress_;
};

Progress Done(CommandStatus status, std::string message = {}) {
  return {.seen = true, .ended = true, .status = status, .message = std::move(message)};
}

// What an order needs to be recognised as done.
struct OrderEnd {
  struct Action {
    std::string id;
    std::string type;
  };
  std::string last_node;
  std::vector<Action> actions;
};

OrderEnd EndOf(const Value& order) {
  OrderEnd end;
  for (const std::string_view list : {"nodes", "edges"}) {
    const Value* legs = FindArray(order, list);
    if (legs == nullptr) continue;
    for (const Value& leg : legs->GetArray()) {
      if (list == "nodes") end.last_node = StringMember(leg, "nodeId");
      const Value* actions = FindArray(leg, "actions");
      if (actions == nullptr) continue;
      for (const Value& action : actions->GetArray()) {
        end.actions.push_back({std::string(StringMember(action, "actionId")),
                               std::string(StringMember(action, "actionType"))});
      }
    }
  }
  return end;
}

Progress OrderProgress(const RobotState& state, const OrderEnd& end) {
  Progress progress{.seen = true};
  std::string failed;
  std::string other;
  std::size_t open = 0;
  for (const auto& [id, type] : end.actions) {
    const ActionState* action = FindActionState(state, id);
    if (action == nullptr) continue;
    const bool is_ours = FindActionState(state, id, type) != nullptr;
    if (!is_ours) {
      other = fmt::format("; it lists the actionId of {} as another action, {}", Shown(type),
                          Shown(action->type));
    }
    if (action->status == "FAILED") {
      failed += fmt::format("{}action {} failed", failed.empty() ? "" : "; ",
                            Shown(action->type.empty() ? id : action->type));
      if (!action->result.empty()) failed += ": " + Shown(action->result);
    } else if (action->status != "FINISHED" || !is_ours) {
      ++open;
    }
  }
  const std::size_t legs = state.nodes_left.value_or(1) + state.edges_left.value_or(1);
  if (legs > 0 || open > 0) {
    progress.message =
        fmt::format("under way: {} nodes and {} actions to go, last node {}{}",
                    state.nodes_left.value_or(0), open, Shown(state.last_node_id), other);
    return progress;
  }
  if (!failed.empty()) return Done(CommandStatus::kFailed, failed);
  if (state.last_node_id == end.last_node) return Done(CommandStatus::kFinished);
  return Done(CommandStatus::kFailed,
              fmt::format("the order ended at node {}, before its last node {}",
                          Shown(state.last_node_id), Shown(end.last_node)));
}

Item OrderItem(const Value& order, WaitFor wait_for) {
  Item item{.topic = "order",
            .id_key = "orderId",
            .id = std::string(StringMember(order, "orderId")),
            .update_id = 0,
            .look = {}};
  const Value* update = FindMember(order, "orderUpdateId");
  if (update != nullptr && update->IsUint()) item.update_id = update->GetUint();
  item.look = [id = item.id, update_id = *item.update_id, end = EndOf(order),
               wait_for](const RobotState& state) -> std::optional<Progress> {
    if (state.order_id != id || state.order_update_id.value_or(0) < update_id) return std::nullopt;
    if (wait_for == WaitFor::kAccepted)
      return Done(CommandStatus::kAccepted, "the robot has the order");
    return OrderProgress(state, end);
  };
  return item;
}

CommandStatus StatusOf(WaitFor wait_for) {
  return wait_for == WaitFor::kAccepted ? CommandStatus::kAccepted : CommandStatus::kFinished;
}

Item ZoneSetItem(const Value& message, WaitFor wait_for) {
  const Value* set = FindMember(message, "zoneSet");
  const std::string id = set == nullptr ? "" : std::string(StringMember(*set, "zoneSetId"));
  return {.topic = "zoneSet",
          .id_key = "zoneSetId",
          .id = id,
          .update_id = {},
          .look = [id, wait_for](const RobotState& state) -> std::optional<Progress> {
            for (const ZoneSetState& known : state.zone_sets) {
              if (known.id != id) continue;
              return Done(StatusOf(wait_for),
                          fmt::format("the robot lists it as {}", Shown(known.status)));
            }
            return std::nullopt;
          }};
}

Result<Item> ResponseItem(const Value& message, WaitFor wait_for) {
  const Value* responses = FindArray(message, "responses");
  if (responses == nullptr || responses->Size() != 1) {
    return Fail(ErrorKind::kUsage, "waiting takes a message with one response");
  }
  const Value& response = (*responses)[0];
  const std::string id(StringMember(response, "requestId"));
  const std::string grant(StringMember(response, "grantType"));
  if (grant != "GRANTED" && grant != "REVOKED") {
    return Fail(ErrorKind::kUsage,
                fmt::format("no state of a robot shows that a request is {}: leave out --wait",
                            base::Printable(grant)));
  }
  return Item{.topic = "responses",
              .id_key = "requestId",
              .id = id,
              .update_id = {},
              .look = [id, grant, wait_for](const RobotState& state) -> std::optional<Progress> {
                for (const RobotRequest& request : state.requests) {
                  if (request.id != id || request.status != grant) continue;
                  return Done(StatusOf(wait_for),
                              fmt::format("the robot has the request as {}", grant));
                }
                return std::nullopt;
              }};
}

Result<std::unique_ptr<message::ResponseTracker>> ConfirmActions(const RobotAddress& robot,
                                                                 const Dialect& dialect,
                                                                 const Value& message,
                                                                 WaitFor wait_for) {
  const std::string_view own_key = FactsOf(dialect.version).actions_key;
  const Value* actions =
      FindArray(message, dialect.actions_key.empty() ? own_key : dialect.actions_key);
  std::vector<std::unique_ptr<message::ResponseTracker>> parts;
  if (actions != nullptr) {
    for (const Value& action : actions->GetArray()) {
      auto part = TrackInstantAction(robot, dialect, StringMember(action, "actionType"),
                                     std::string(StringMember(action, "actionId")), wait_for);
      if (!part) return part;
      parts.push_back(std::move(*part));
    }
  }
  return std::make_unique<EveryAction>(std::move(parts));
}

}  // namespace

Result<std::unique_ptr<message::ResponseTracker>> TrackUserMessage(const RobotAddress& robot,
                                                                   const Dialect& dialect,
                                                                   std::string_view topic,
                                                                   const Value& message,
                                                                   WaitFor wait_for) {
  if (topic == "instantActions") return ConfirmActions(robot, dialect, message, wait_for);
  auto state = TopicFor(dialect.topics, dialect.version, robot, "state");
  if (!state) return Fail(std::move(state.error()));
  auto connection = TopicFor(dialect.topics, dialect.version, robot, "connection");
  if (!connection) return Fail(std::move(connection.error()));
  Result<Item> item = topic == "order"     ? OrderItem(message, wait_for)
                      : topic == "zoneSet" ? ZoneSetItem(message, wait_for)
                                           : ResponseItem(message, wait_for);
  if (!item) return Fail(std::move(item.error()));
  return std::make_unique<ItemTracker>(std::move(*item), Reception(robot, dialect),
                                       std::move(*state), std::move(*connection));
}

}  // namespace fleetpub::vda5050
