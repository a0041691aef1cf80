// Follows what was published from a file until the robot's state shows it. One class for what has
// one id (an order, a zone set, a response), one for several actions.
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/json.h"
#include "base/text.h"
#include "vda5050/messages/user_message.h"
#include "vda5050/reports/robot_errors.h"
#include "vda5050/reports/robot_messages.h"
#include "vda5050/tracking/alerts.h"
#include "vda5050/tracking/order_progress.h"
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
  /// Told of a live state that came before.
  std::function<void(const RobotState&)> before;
  /// What a state says of it; nothing: it does not show it.
  std::function<std::optional<Progress>(const RobotState&)> look;
  std::optional<std::uint32_t> update_id = {};
  std::vector<ErrorReference> parts = {};
  /// What has come to light since the last call, in words.
  std::function<std::vector<std::string>()> news = [] { return std::vector<std::string>(); };
  /// How far the robot has come, when that is new; else "".
  std::function<std::string()> place = [] { return std::string(); };
};

class ItemTracker final : public message::ResponseTracker {
 public:
  ItemTracker(Item item, const RobotAddress& robot, const Dialect& dialect, std::string state_topic,
              std::string connection_topic)
      : item_(std::move(item)),
        robot_(robot.ToString()),
        reception_(robot, dialect),
        alerts_(robot.ToString(), item_.topic),
        state_topic_(std::move(state_topic)),
        connection_topic_(std::move(connection_topic)) {
    UpdateMessage();
  }

  [[nodiscard]] std::vector<std::string> Topics() const override {
    return {state_topic_, connection_topic_};
  }

  void Published(std::uint32_t header_id) override {
    if (header_ids_.empty()) {
      reception_.Forget();
      told_ = "the robot has sent no state since";
    }
    header_ids_.push_back(header_id);
    alerts_.Published(header_id);
    if (!progress_.ended) UpdateMessage();
    PassOnNews();
  }

  void Receive(const message::Incoming& message) override {
    if (progress_.ended || (message.retained && !header_ids_.empty())) return;
    if (message.topic == connection_topic_) {
      OnConnection(message);
    } else if (message.topic == state_topic_) {
      const auto state = reception_.TakeState(message);
      if (state && !message.retained) alerts_.Look(*state);
      if (state && header_ids_.empty()) {
        errors_.Remember(state->errors, message.retained);
        if (!message.retained) item_.before(*state);
      } else if (state) {
        OnState(*state);
      }
    }
    if (const std::string place = item_.place(); !place.empty()) {
      AddNews(fmt::format("{}  {}", base::Printable(robot_), place));
    }
    if (!progress_.ended) {
      UpdateMessage();
      alerts_.Add(item_.news());
      alerts_.Add(errors_.TakeSevere());
    }
    PassOnNews();
  }

  [[nodiscard]] const Progress& progress() const override { return progress_; }

 private:
  void PassOnNews() {
    for (std::string& line : alerts_.Take()) AddNews(std::move(line));
  }

  // A new error that names ours comes before what the state shows: a robot that refuses an order or
  // a zone set of an id that it has goes on showing the old one. Once ours is shown, errors are of
  // its way; so are those of its nodes and actions in the state that shows it first.
  void OnState(const RobotState& state) {
    const auto nearest = errors_.Add(state.errors, {.topic = item_.topic,
                                                    .id_key = item_.id_key,
                                                    .id = item_.id,
                                                    .header_ids = header_ids_,
                                                    .update_id = item_.update_id,
                                                    .parts = item_.parts});
    auto shown = item_.look(state);
    const bool is_shown = shown && shown->seen;
    const bool is_refused = nearest == Attribution::kItem || nearest == Attribution::kHeaderId ||
                            (nearest == Attribution::kPart && !is_shown);
    if (!progress_.seen && is_refused) {
      return End(CommandStatus::kRejected,
                 is_shown ? "the robot shows it nevertheless, and may have had it before" : "");
    }
    if (!shown && progress_.seen) {
      return End(CommandStatus::kVanished, fmt::format("the robot's state no longer shows {} {}",
                                                       item_.id_key, Shown(item_.id)));
    }
    if (!shown) {
      told_ = fmt::format("the robot's state does not show {} {}; it is of {}", item_.id_key,
                          Shown(item_.id), Shown(state.header.timestamp));
      return;
    }
    if (shown->ended) return End(shown->status, shown->message);
    progress_.seen = progress_.seen || shown->seen;
    told_ = shown->message;
  }

  void OnConnection(const message::Incoming& message) {
    const auto connection = reception_.TakeConnection(message);
    if (!connection || message.retained || header_ids_.empty()) return;
    const std::string& state = connection->connection_state;
    if (!IsAway(state)) return;
    End(CommandStatus::kOffline,
        fmt::format("the robot went {} while we waited; {}", state, told_));
  }

  void UpdateMessage() {
    progress_.unreadable = reception_.passed_over() > 0;
    progress_.message = WithErrors(told_);
    if (const std::string text = reception_.Text(); !text.empty()) {
      progress_.message += "; " + text;
    }
  }

  void End(CommandStatus status, const std::string& message) {
    const bool is_well = !message::ToErrorKind(status);
    progress_ = {.seen = true,
                 .ended = true,
                 .status = status,
                 .message = is_well && !errors_.AreOurs() ? message : WithErrors(message)};
  }

  [[nodiscard]] std::string WithErrors(const std::string& message) const {
    const std::string errors = errors_.Text();
    return message + (message.empty() || errors.empty() ? "" : "; ") + errors;
  }

  Item item_;
  std::string robot_;
  Reception reception_;
  Alerts alerts_;
  std::string state_topic_;
  std::string connection_topic_;
  Progress progress_;
  std::string told_ = "not sent yet";      // of the robot's last word, while it is no end
  std::vector<std::uint32_t> header_ids_;  // of each time it was published
  RelatedErrors errors_;
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
    PassOnNews();
  }

  void Receive(const message::Incoming& message) override {
    for (const auto& part : parts_) part->Receive(message);
    Summarize();
    PassOnNews();
  }

  [[nodiscard]] const Progress& progress() const override { return progress_; }

 private:
  // Once, what several say.
  void PassOnNews() {
    for (const auto& part : parts_) {
      for (std::string& line : part->TakeNews()) {
        if (told_.insert(line).second) AddNews(std::move(line));
      }
    }
  }

  void Summarize() {
    const auto went_well = [](const Progress& p) {
      return p.status == CommandStatus::kFinished || p.status == CommandStatus::kAccepted;
    };
    progress_ = {.seen = true, .ended = true};
    auto kept = message::Kept::kNothing;
    for (const auto& part : parts_) {
      const Progress& own = part->progress();
      kept = std::max(kept, own.kept);
      progress_.kept = kept;
      if (own.ended && !went_well(own)) {
        progress_ = own;
        progress_.kept = kept;
        return;
      }
      progress_.seen = progress_.seen && own.seen;
      progress_.unreadable = progress_.unreadable || own.unreadable;
      if (!own.ended || progress_.ended) progress_.message = own.message;
      progress_.ended = progress_.ended && own.ended;
      progress_.status = own.ended ? own.status : CommandStatus::kTimeout;
    }
  }

  std::vector<std::unique_ptr<message::ResponseTracker>> parts_;
  std::set<std::string> told_;
  Progress progress_;
};

Item OrderItem(const Value& order, WaitFor wait_for, bool is_taken = false) {
  const auto progress = std::make_shared<OrderProgress>(order, wait_for);
  if (is_taken) progress->AssumeTaken();
  return {.topic = "order",
          .id_key = "orderId",
          .id = progress->id(),
          .before = [progress](const RobotState& state) { progress->Before(state); },
          .look = [progress](const RobotState& state) { return progress->Look(state); },
          .update_id = progress->update_id(),
          .parts = progress->parts(),
          .news = [progress] { return progress->TakeNews(); },
          .place = [progress] { return progress->TakePlace(); }};
}

CommandStatus ToStatus(WaitFor wait_for) {
  return wait_for == WaitFor::kAccepted ? CommandStatus::kAccepted : CommandStatus::kFinished;
}

Item ZoneSetItem(const Value& message, WaitFor wait_for) {
  const Value* set = FindMember(message, "zoneSet");
  const std::string id = set == nullptr ? "" : std::string(StringMember(*set, "zoneSetId"));
  const auto find = [id](const RobotState& state) {
    return std::find_if(state.zone_sets.begin(), state.zone_sets.end(),
                        [&](const ZoneSetState& known) { return known.id == id; });
  };
  const auto had_it = std::make_shared<bool>(false);
  return {
      .topic = "zoneSet",
      .id_key = "zoneSetId",
      .id = id,
      .before = [=](const RobotState& state) { *had_it = find(state) != state.zone_sets.end(); },
      .look = [=](const RobotState& state) -> std::optional<Progress> {
        const auto known = find(state);
        if (known == state.zone_sets.end()) return std::nullopt;
        return message::Ended(ToStatus(wait_for),
                              fmt::format("the robot lists it as {}{}", Shown(known->status),
                                          *had_it ? "; it had one of this id before" : ""));
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
  const auto status_in = [id](const RobotState& state) -> std::optional<std::string> {
    for (const RobotRequest& request : state.requests) {
      if (request.id == id) return request.status;
    }
    return std::nullopt;
  };
  const auto last = std::make_shared<std::optional<std::string>>();
  return Item{.topic = "responses",
              .id_key = "requestId",
              .id = id,
              .before = [=](const RobotState& state) { *last = status_in(state); },
              .look = [=](const RobotState& state) -> std::optional<Progress> {
                const auto status = status_in(state);
                if (status == grant) {
                  return message::Ended(ToStatus(wait_for),
                                        fmt::format("the robot has the request as {}", grant));
                }
                if (status) {
                  *last = status;
                  return Progress{.message = "the robot has the request as " + Shown(*status)};
                }
                if (!*last) return std::nullopt;
                if (grant == "REVOKED") {
                  return message::Ended(ToStatus(wait_for), "the robot has removed the request");
                }
                return message::Ended(
                    CommandStatus::kVanished,
                    "the robot no longer shows the request, which last was " + Shown(**last));
              }};
}

Result<std::unique_ptr<message::ResponseTracker>> ConfirmActions(const RobotAddress& robot,
                                                                 const Dialect& dialect,
                                                                 const Value& message,
                                                                 WaitFor wait_for) {
  std::vector<std::unique_ptr<message::ResponseTracker>> parts;
  for (const InstantAction& action : ActionsIn(message, dialect)) {
    auto part = TrackInstantAction(robot, dialect, action, wait_for);
    if (!part) return part;
    parts.push_back(std::move(*part));
  }
  return std::make_unique<EveryAction>(std::move(parts));
}

}  // namespace

namespace {

Result<std::unique_ptr<message::ResponseTracker>> TrackItem(Result<Item> item,
                                                            const RobotAddress& robot,
                                                            const Dialect& dialect) {
  if (!item) return Fail(std::move(item.error()));
  auto state = TopicFor(dialect.topics, dialect.version, robot, "state");
  if (!state) return Fail(std::move(state.error()));
  auto connection = TopicFor(dialect.topics, dialect.version, robot, "connection");
  if (!connection) return Fail(std::move(connection.error()));
  return std::make_unique<ItemTracker>(std::move(*item), robot, dialect, std::move(*state),
                                       std::move(*connection));
}

}  // namespace

Result<std::unique_ptr<message::ResponseTracker>> TrackUserMessage(const RobotAddress& robot,
                                                                   const Dialect& dialect,
                                                                   std::string_view topic,
                                                                   const Value& message,
                                                                   WaitFor wait_for) {
  if (topic == "instantActions") return ConfirmActions(robot, dialect, message, wait_for);
  return TrackItem(topic == "order"     ? OrderItem(message, wait_for)
                   : topic == "zoneSet" ? ZoneSetItem(message, wait_for)
                                        : ResponseItem(message, wait_for),
                   robot, dialect);
}

Result<std::unique_ptr<message::ResponseTracker>> TrackTakenOrder(const RobotAddress& robot,
                                                                  const Dialect& dialect,
                                                                  const Value& order) {
  return TrackItem(OrderItem(order, WaitFor::kFinished, true), robot, dialect);
}

}  // namespace fleetpub::vda5050
