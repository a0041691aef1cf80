#include "vda5050/tracking/action_tracker.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "base/json.h"
#include "base/text.h"
#include "vda5050/catalogue/catalogue.h"
#include "vda5050/reports/robot_errors.h"
#include "vda5050/reports/robot_messages.h"
#include "vda5050/tracking/alerts.h"
#include "vda5050/tracking/ending.h"
#include "vda5050/tracking/reception.h"

namespace fleetpub::vda5050 {
namespace {

using message::CommandStatus;

constexpr std::size_t kLongestMessage = 500;

void Append(std::string& text, std::string_view part) {
  if (part.empty()) return;
  if (!text.empty()) text += "; ";
  text += part;
}

// The action, and what is known of how it was sent.
struct Followed {
  std::string type;
  std::string id;
  std::string order_json;  ///< the orderId that is to be cancelled, as JSON; "": whichever
  std::string hint;        ///< what to try when the robot does not list it
};

class ActionTracker final : public message::ResponseTracker {
 public:
  struct RobotTopics {
    std::string state;
    std::string connection;
    std::string factsheet;  ///< empty: not needed
  };

  ActionTracker(RobotTopics topics, Reception reception, std::string robot, Followed followed,
                WaitFor wait_for)
      : topics_(std::move(topics)),
        reception_(std::move(reception)),
        type_(std::move(followed.type)),
        id_(std::move(followed.id)),
        order_json_(std::move(followed.order_json)),
        hint_(std::move(followed.hint)),
        ending_(FindEnding(type_)),
        wait_for_(wait_for),
        alerts_(std::move(robot), "instantActions") {
    progress_.message = "not sent yet";
  }

  [[nodiscard]] std::vector<std::string> Topics() const override {
    std::vector<std::string> topics{topics_.state, topics_.connection};
    if (!topics_.factsheet.empty()) topics.push_back(topics_.factsheet);
    return topics;
  }

  void Published(std::uint32_t header_id) override {
    if (!WasPublished()) reception_.Forget();
    header_ids_.push_back(header_id);
    alerts_.Published(header_id);
    if (!progress_.ended) TellPending();
    PassOnNews();
  }

  void Receive(const message::Incoming& message) override;

  [[nodiscard]] const message::Progress& progress() const override { return progress_; }

 private:
  void RememberBefore(const RobotState& state, bool retained);
  void OnState(const RobotState& state);
  void OnConnection(const ConnectionMessage& message, bool retained);
  void OnListed(const ActionState& entry, const RobotState& state);
  void OnAbsent(const RobotState& state, bool is_named_by_error);
  void NoteEndedOnes(const RobotState& state);
  void PassOnNews();

  [[nodiscard]] const ActionState* OwnEntry(const RobotState& state);
  [[nodiscard]] bool ListsAsFinished(const RobotState& state) const;
  [[nodiscard]] bool HasNoOrder(const RobotState& state) const;
  [[nodiscard]] bool IsGone(const RobotState& state) const;
  [[nodiscard]] bool EndedOnesAreGone(const RobotState& state) const;
  [[nodiscard]] bool WasPublished() const { return !header_ids_.empty(); }

  void End(CommandStatus status, const std::string& message);
  void TellPending();
  [[nodiscard]] std::string FailureText(std::string_view result) const;
  [[nodiscard]] std::string ModeNote() const;
  [[nodiscard]] std::string LastSaid(std::string_view robot) const;

  RobotTopics topics_;
  Reception reception_;
  std::string type_;
  std::string id_;
  std::string order_json_;
  std::string hint_;
  const Ending& ending_;
  WaitFor wait_for_;
  Alerts alerts_;
  message::Progress progress_;

  std::vector<std::uint32_t> header_ids_;  // of each time it was published
  // What the robot said before publishing.
  std::optional<std::string> status_before_;  // it knew this actionId already
  std::vector<std::string> ended_ids_;        // what clearInstantActions is to remove
  // What it said since.
  int states_ = 0;
  std::string last_timestamp_;
  std::string first_mode_;
  std::string mode_;
  std::string connection_;
  std::string status_;
  std::string result_;
  bool listed_as_instant_ = false;
  bool listed_ = false;  // by a state
  RelatedErrors errors_;
};

void ActionTracker::Receive(const message::Incoming& message) {
  if (progress_.ended) return;
  if (message.topic == topics_.connection) {
    if (const auto connection = reception_.TakeConnection(message)) {
      OnConnection(*connection, message.retained);
    }
  } else if (message.topic == topics_.state) {
    if (message.retained && WasPublished()) return;  // subscribed anew: old by definition
    const auto state = reception_.TakeState(message);
    if (state && WasPublished()) OnState(*state);
    if (state && !WasPublished()) RememberBefore(*state, message.retained);
  } else if (message.topic == topics_.factsheet && ending_.factsheet) {
    // The old one arrives with the retain flag upon subscribing.
    if (message.retained || !WasPublished()) return;
    if (reception_.TakeFactsheet(message)) {
      progress_.seen = true;
      End(CommandStatus::kFinished, "its factsheet arrived");
    }
  }
  if (WasPublished() && !progress_.ended) {
    TellPending();
    alerts_.Add(errors_.TakeSevere());
  }
  PassOnNews();
}

void ActionTracker::PassOnNews() {
  using message::Kept;
  const bool is_listed = listed_as_instant_ && IsTerminal(status_);
  if (!ending_.clears_list) {
    progress_.kept = alerts_.list_full() ? Kept::kTooMuch
                     : is_listed         ? Kept::kEntry
                                         : Kept::kNothing;
  }
  for (std::string& line : alerts_.Take()) AddNews(std::move(line));
}

void ActionTracker::RememberBefore(const RobotState& state, bool retained) {
  errors_.Remember(state.errors, retained);
  if (const ActionState* entry = FindActionState(state, id_, type_)) status_before_ = entry->status;
  if (retained) return;
  alerts_.Look(state);
  if (!state.operating_mode.empty()) first_mode_ = mode_ = state.operating_mode;
  NoteEndedOnes(state);
}

void ActionTracker::OnState(const RobotState& state) {
  ++states_;
  alerts_.Look(state);
  last_timestamp_ = state.header.timestamp;
  if (!state.operating_mode.empty()) mode_ = state.operating_mode;
  if (first_mode_.empty()) first_mode_ = mode_;
  const auto nearest = errors_.Add(
      state.errors,
      {.topic = "instantActions", .id_key = "actionId", .id = id_, .header_ids = header_ids_});
  if (const ActionState* entry = OwnEntry(state)) {
    OnListed(*entry, state);
  } else {
    OnAbsent(state, nearest == Attribution::kItem);
  }
}

// Null too for an entry that stood there before and is unchanged: that is an earlier action of the
// same id, which some robots keep listed for ever.
const ActionState* ActionTracker::OwnEntry(const RobotState& state) {
  const ActionState* entry = FindActionState(state, id_, type_);
  const ActionState* other = entry == nullptr ? FindActionState(state, id_) : nullptr;
  if (other != nullptr) {
    reception_.PassOver(
        "state", fmt::format("it lists this actionId as another action, {}", Shown(other->type)));
  }
  if (entry == nullptr || !status_before_) return entry;
  if (entry->status == *status_before_) return nullptr;
  status_before_.reset();
  return entry;
}

void ActionTracker::OnListed(const ActionState& entry, const RobotState& state) {
  progress_.seen = true;
  status_ = entry.status;
  result_ = entry.result;
  const auto& instant = state.instant_action_states;
  listed_as_instant_ = std::any_of(instant.begin(), instant.end(),
                                   [&](const ActionState& other) { return other.id == id_; });
  listed_ = true;
  if (status_ == "FAILED") {
    std::string message = FailureText(result_);
    if (ListsAsFinished(state)) Append(message, "the same state lists it as FINISHED too");
    return End(HasNoOrder(state) ? CommandStatus::kNoOrder : CommandStatus::kFailed, message);
  }
  if (wait_for_ == WaitFor::kAccepted) {
    return End(CommandStatus::kAccepted, fmt::format("the robot lists it as {}", Shown(status_)));
  }
  if (status_ == "FINISHED" && ending_.factsheet) return;  // it has not come
  if (status_ == "FINISHED" || ending_.listed) return End(CommandStatus::kFinished, Shown(result_));
  if (status_ == "RETRIABLE") {
    std::string message = fmt::format(
        "the robot waits: retry it with retry --actionId {0}, give it up with skipRetry --actionId "
        "{0}, or help at the robot",
        Shown(id_));
    Append(message, FailureText(result_));
    End(CommandStatus::kRetriable, message);
  }
}

void ActionTracker::OnAbsent(const RobotState& state, bool is_named_by_error) {
  if (is_named_by_error || (errors_.AreOurs() && !progress_.seen)) {
    progress_.seen = true;
    return End(HasNoOrder(state) ? CommandStatus::kNoOrder : CommandStatus::kRejected,
               FailureText(""));
  }
  if (IsGone(state)) {
    if (ending_.clears_list) return End(CommandStatus::kFinished, "the robot has cleared its list");
    std::string message =
        fmt::format("the robot no longer lists it, which last was {}", Shown(status_));
    Append(message, FailureText(result_));
    return End(CommandStatus::kVanished, message);
  }
  if (EndedOnesAreGone(state)) {
    progress_.seen = true;
    return End(CommandStatus::kFinished, "the robot has cleared its list");
  }
  NoteEndedOnes(state);
}

// By an error. One that names nobody and stood there before may be of an earlier attempt: then the
// state has to show that there is none.
bool ActionTracker::HasNoOrder(const RobotState& state) const {
  if (type_ != "cancelOrder") return false;
  const bool has_order = state.nodes_left.value_or(0) + state.edges_left.value_or(0) > 0;
  const bool is_meant = order_json_.empty() || order_json_ == base::JsonString(state.order_id);
  if (has_order && is_meant) return false;
  const bool is_said = std::any_of(
      state.errors.begin(), state.errors.end(),
      [](const RobotError& error) { return IsNoOrder(error) && error.references.empty(); });
  return errors_.SayNoOrder() || (is_said && state.nodes_left == 0);
}

bool ActionTracker::ListsAsFinished(const RobotState& state) const {
  const auto is_finished = [&](const ActionState& entry) {
    return entry.id == id_ && entry.status == "FINISHED";
  };
  return std::any_of(state.action_states.begin(), state.action_states.end(), is_finished) ||
         std::any_of(state.instant_action_states.begin(), state.instant_action_states.end(),
                     is_finished);
}

// Only after it was listed, and only by a state that has the array. Who waits for a factsheet goes
// on doing so.
bool ActionTracker::IsGone(const RobotState& state) const {
  if (!listed_ || (ending_.factsheet && status_ == "FINISHED")) return false;
  if (FindActionState(state, id_) != nullptr) return false;  // as an action of another type
  return listed_as_instant_ ? state.has_instant_action_states : state.has_action_states;
}

void ActionTracker::NoteEndedOnes(const RobotState& state) {
  if (!ending_.clears_list) return;
  ended_ids_.clear();
  for (const ActionState& entry : state.instant_action_states) {
    if (IsTerminal(entry.status) && entry.id != id_) ended_ids_.push_back(entry.id);
  }
}

bool ActionTracker::EndedOnesAreGone(const RobotState& state) const {
  if (ended_ids_.empty() || !state.has_instant_action_states) return false;
  const auto& list = state.instant_action_states;
  return std::none_of(list.begin(), list.end(), [&](const ActionState& entry) {
    return std::find(ended_ids_.begin(), ended_ids_.end(), entry.id) != ended_ids_.end();
  });
}

void ActionTracker::OnConnection(const ConnectionMessage& message, bool retained) {
  connection_ = message.connection_state;
  if (retained || !WasPublished()) return;
  if (!ending_.connection_state.empty() && connection_ == ending_.connection_state) {
    progress_.seen = true;
    return End(CommandStatus::kFinished, fmt::format("the robot is {}", connection_));
  }
  if (!IsAway(connection_) || ending_.may_reconnect) return;
  End(CommandStatus::kOffline,
      fmt::format("the robot went {} while we waited; {}", connection_, LastSaid("it")));
}

void ActionTracker::End(CommandStatus status, const std::string& message) {
  progress_.ended = true;
  progress_.status = status;
  progress_.message = Shown(message, kLongestMessage);
}

// The robot's result, and the errors that are nearest to being about us.
std::string ActionTracker::FailureText(std::string_view result) const {
  std::string text = Shown(result);
  Append(text, errors_.Text());
  Append(text, ModeNote());
  return text.empty() ? "the robot gave no reason" : text;
}

std::string ActionTracker::ModeNote() const {
  if (mode_ != first_mode_) {
    return fmt::format("the robot went from {} to {}", Shown(first_mode_), Shown(mode_));
  }
  const bool is_usual = mode_.empty() || mode_ == "AUTOMATIC" || mode_ == "SEMIAUTOMATIC";
  return is_usual ? "" : fmt::format("the robot is in {}", Shown(mode_));
}

std::string ActionTracker::LastSaid(std::string_view robot) const {
  if (listed_) return fmt::format("the action last was {}", Shown(status_));
  return fmt::format("{} has {}", robot,
                     states_ > 0                    ? "not listed the action"
                     : reception_.passed_over() > 0 ? "sent no state that counts"
                                                    : "sent no state since");
}

void ActionTracker::TellPending() {
  progress_.unreadable = reception_.passed_over() > 0;
  std::string text = LastSaid("the robot");
  if (listed_) Append(text, Shown(result_));
  if (!listed_ && reception_.passed_over() == 0) Append(text, hint_);
  if (ending_.factsheet) Append(text, "no factsheet has come");
  if (states_ > 0 && !last_timestamp_.empty()) {
    Append(text, "its last state is of " + Shown(last_timestamp_));
  }
  if (status_before_) {
    Append(text, fmt::format("it had listed this actionId as {} before: each needs a new one",
                             Shown(*status_before_)));
  }
  if (IsAway(connection_)) Append(text, fmt::format("it is {}", connection_));
  Append(text, reception_.Text());
  Append(text, errors_.Text());
  Append(text, ModeNote());
  progress_.message = Shown(text, kLongestMessage);
}

}  // namespace

Result<std::unique_ptr<message::ResponseTracker>> TrackInstantAction(const RobotAddress& robot,
                                                                     const Dialect& dialect,
                                                                     const InstantAction& action,
                                                                     WaitFor wait_for) {
  Followed followed{.type = std::string(NameIn(dialect.version, action.type)),
                    .id = action.id,
                    .order_json = {},
                    .hint = MayExpectOtherKey(dialect)
                                ? "some 2.0 robots expect --actions-key instantActions"
                                : ""};
  for (const Parameter& parameter : action.parameters) {
    if (parameter.key == "orderId") followed.order_json = parameter.json;
  }
  ActionTracker::RobotTopics topics;
  const std::pair<std::string_view, std::string*> wanted[] = {{"state", &topics.state},
                                                              {"connection", &topics.connection},
                                                              {"factsheet", &topics.factsheet}};
  for (const auto& [name, topic] : wanted) {
    if (name == "factsheet" && !FindEnding(followed.type).factsheet) continue;
    auto full = TopicFor(dialect.topics, dialect.version, robot, name);
    if (!full) return Fail(std::move(full.error()));
    *topic = std::move(*full);
  }
  return std::make_unique<ActionTracker>(std::move(topics), Reception(robot, dialect),
                                         robot.ToString(), std::move(followed), wait_for);
}

}  // namespace fleetpub::vda5050
