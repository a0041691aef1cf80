#include "robot/virtual_robot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/text.h"
#include "robot/orders.h"

namespace fleetpub::robot {
namespace {

using std::chrono::steady_clock;

// How much a robot keeps. Ended actions stay until the version says that they go, or until there
// are too many of them.
constexpr std::size_t kMostEndedActions = 20;
constexpr std::size_t kMostErrors = 10;
constexpr std::size_t kMostKnownIds = 200;

// In which modes fleet control may send instant actions (1.1–2.1 §6.10.6, 3.0 §6.6.7).
bool Takes(std::string_view mode, std::string_view action) {
  if (mode == "INTERVENED") return action == "cancelOrder";
  return mode == "AUTOMATIC" || mode == "SEMIAUTOMATIC";
}

ActionStatus StatusOf(Beginning beginning) {
  constexpr std::array kStatus = {ActionStatus::kWaiting, ActionStatus::kInitializing,
                                  ActionStatus::kRunning};
  return kStatus.at(static_cast<std::size_t>(beginning));
}

std::string TypesOf(const Inspection& inspection) {
  std::vector<std::string> types;
  for (const ReceivedAction& action : inspection.actions) {
    types.push_back(base::Printable(action.call.type + " " + action.call.id));
  }
  return base::Join(types, ", ");
}

std::string Place(std::string_view topic, const Inspection& inspection) {
  return inspection.header_id.empty() ? std::string(topic)
                                      : fmt::format("{} headerId {}", topic, inspection.header_id);
}

}  // namespace

VirtualRobot::VirtualRobot(Shared shared, Header header)
    : shared_(shared), header_(std::move(header)) {
  state_.operating_mode = shared_.settings.operating_mode;
  if (shared_.settings.with_order) state_.order = ExampleOrder();
}

Utterance VirtualRobot::Will(const Moment& now) {
  return {"connection",
          Message(header_, connection_id_++, now.wall, ConnectionBody(shared_.words.broken)),
          shared_.words.connection_qos, true};
}

void VirtualRobot::Start(const Moment& now, Utterances& out) {
  if (gone_) return;
  out_ = &out;
  SayConnection(hibernating_ ? "HIBERNATING" : "ONLINE", now);
  SayFactsheet(now);
  SayState(now);
  if (state_.order.Active() && shared_.settings.order_time.count() > 0 && !order_end_) {
    order_end_ = now.steady + shared_.settings.order_time;
  }
}

void VirtualRobot::End(const Moment& now, Utterances& out) {
  if (gone_) return;
  out_ = &out;
  SayConnection("OFFLINE", now);
  gone_ = true;
}

void VirtualRobot::Receive(std::string_view topic, std::string_view payload, const Moment& now,
                           Utterances& out, const Listener& listener) {
  if (gone_) return;
  out_ = &out;
  if (topic == "instantActions") ReceiveActions(payload, now, listener);
  if (topic == "order" && !hibernating_) ReceiveOrder(payload, now, listener);
  SayStateIfChanged(now);
}

void VirtualRobot::Tick(const Moment& now, Utterances& out) {
  if (gone_) return;
  out_ = &out;
  // An action that ends may begin another one: by index.
  for (std::size_t i = 0; i < running_.size();) {
    if (running_[i].next > now.steady) {
      ++i;
      continue;
    }
    Running running = std::move(running_[i]);
    running_.erase(running_.begin() + static_cast<std::ptrdiff_t>(i));
    Advance(running, now);
  }
  if (order_end_ && *order_end_ <= now.steady && !state_.paused) EndOrder();
  if (next_state_ <= now.steady) changed_ = true;
  SayStateIfChanged(now);
}

steady_clock::time_point VirtualRobot::Due() const {
  if (gone_) return steady_clock::time_point::max();
  steady_clock::time_point due = next_state_;
  if (hibernating_ || shared_.settings.silent) due = steady_clock::time_point::max();
  for (const Running& running : running_) due = std::min(due, running.next);
  if (order_end_ && !state_.paused) due = std::min(due, *order_end_);
  return due;
}

void VirtualRobot::ReceiveActions(std::string_view payload, const Moment& now,
                                  const Listener& listener) {
  const Inspection inspection = shared_.inspector.InspectInstantActions(payload);
  const std::string place = Place("instantActions", inspection);
  if (!inspection.fault.empty()) {
    listener({Remark::Kind::kFault, fmt::format("{}: {}", place, inspection.fault)});
    if (!hibernating_) RefuseMessage(inspection, "instantActions");
    return;
  }
  listener({Remark::Kind::kReceived, fmt::format("{}: {}", place, TypesOf(inspection))});
  for (const ReceivedAction& action : inspection.actions) {
    if (!action.fault.empty()) {
      listener({Remark::Kind::kFault, fmt::format("{}: {}", place, action.fault)});
    }
    // Asleep it hears nothing but its alarm clock (3.0 §6.7).
    if (!hibernating_ || action.call.type == "stopHibernation") Begin(action, now);
    if (gone_) return;
  }
}

void VirtualRobot::RefuseMessage(const Inspection& inspection, std::string_view topic) {
  RobotError error{std::string(shared_.words.invalid_message), inspection.fault, {}};
  error.references.emplace_back("topic", topic);
  if (!inspection.header_id.empty())
    error.references.emplace_back("headerId", inspection.header_id);
  for (const ReceivedAction& action : inspection.actions) {
    if (!action.call.id.empty()) error.references.emplace_back("actionId", action.call.id);
  }
  AddError(std::move(error));
}

void VirtualRobot::Begin(const ReceivedAction& action, const Moment& now) {
  const Call& call = action.call;
  changed_ = true;  // a repeated one is answered, not carried out again
  if (known_.contains(call.id)) return;
  if (const std::string reason = ReasonToReject(action); !reason.empty()) {
    Reject(action, reason);
    return;
  }
  ForgetErrors(Until::kNextInstantAction);
  Remember(call.id);
  const Beginning beginning = BeginningOf(call.type);
  state_.instant_actions.push_back(
      {call.id, call.type, action.descriptor, StatusOf(beginning), ""});
  ForgetOldActions();
  const auto delay = shared_.settings.delay;
  if (delay.count() == 0) {
    Complete({call, now.steady}, now);
  } else {
    running_.push_back(
        {call, now.steady + (beginning == Beginning::kInitializing ? delay / 2 : delay)});
  }
}

std::string VirtualRobot::ReasonToReject(const ReceivedAction& action) const {
  if (!action.fault.empty()) return action.fault;
  if (shared_.settings.reject.contains(action.call.type)) {
    return fmt::format("{} is rejected, as asked for", action.call.type);
  }
  if (!Takes(state_.operating_mode, action.call.type)) {
    return fmt::format("{} is not possible in operating mode {}", action.call.type,
                       state_.operating_mode);
  }
  return {};
}

void VirtualRobot::Reject(const ReceivedAction& action, const std::string& reason) {
  const Call& call = action.call;
  if (shared_.settings.Style() == RejectStyle::kState) {
    Remember(call.id);
    state_.instant_actions.push_back(
        {call.id, call.type, action.descriptor, ActionStatus::kFailed, reason});
    ForgetOldActions();
  }
  AddError({std::string(shared_.words.invalid_action),
            reason,
            {{"topic", "instantActions"}, {"actionId", call.id}, {"actionType", call.type}}});
}

// Its time has come: from INITIALIZING to RUNNING, or to its end.
void VirtualRobot::Advance(Running& running, const Moment& now) {
  changed_ = true;
  ActionState* action = Find(running.call.id);
  if (action == nullptr || action->status != ActionStatus::kInitializing) {
    Complete(running, now);
    return;
  }
  action->status = ActionStatus::kRunning;
  running.next = now.steady + shared_.settings.delay / 2;
  running_.push_back(std::move(running));
}

void VirtualRobot::Complete(const Running& running, const Moment& now) {
  const Call& call = running.call;
  Outcome outcome;
  if (shared_.settings.fail.contains(call.type)) {
    outcome = {.finished = false, .result = fmt::format("{} failed, as asked for", call.type)};
  } else if (shared_.settings.retriable.contains(call.type) && !running.retried) {
    if (ActionState* action = Find(call.id); action != nullptr) {
      action->status = ActionStatus::kRetriable;
      action->result = fmt::format("{} can be retried, as asked for", call.type);
    }
    retriable_.push_back(running);
    return;
  } else {
    outcome = Carry(call, state_, shared_.words);
  }
  if (ActionState* action = Find(call.id); action != nullptr) {
    action->status = outcome.finished ? ActionStatus::kFinished : ActionStatus::kFailed;
    action->result = outcome.result;
  }
  if (outcome.error) AddError(*outcome.error);
  if (!state_.order.Active()) order_end_.reset();
  Follow(outcome, now);
}

void VirtualRobot::Follow(const Outcome& outcome, const Moment& now) {
  switch (outcome.consequence) {
    case Consequence::kNone:
      return;
    case Consequence::kFactsheet:
      return SayFactsheet(now);
    case Consequence::kHibernate:
      falling_asleep_ = true;
      return SayStateIfChanged(now);
    case Consequence::kWake:
      if (hibernating_) {
        hibernating_ = false;
        SayConnection("ONLINE", now);
      }
      return;
    case Consequence::kShutDown:
      leaving_ = true;
      return SayStateIfChanged(now);
    case Consequence::kRetry:
      return Retry(outcome.target, now);
    case Consequence::kSkipRetry:
      std::erase_if(retriable_, [&](const Running& r) { return r.call.id == outcome.target; });
      if (ActionState* action = Find(outcome.target); action != nullptr) {
        action->status = ActionStatus::kFailed;
      }
      return;
  }
}

void VirtualRobot::Retry(const std::string& id, const Moment& now) {
  const auto found = std::find_if(retriable_.begin(), retriable_.end(),
                                  [&](const Running& running) { return running.call.id == id; });
  if (found == retriable_.end()) return;
  Running running = std::move(*found);
  retriable_.erase(found);
  running.retried = true;
  running.next = now.steady + shared_.settings.delay;
  if (ActionState* action = Find(id); action != nullptr) {
    action->status = ActionStatus::kRunning;
    action->result.clear();
  }
  if (shared_.settings.delay.count() == 0) {
    Complete(running, now);
  } else {
    running_.push_back(std::move(running));
  }
}

void VirtualRobot::ReceiveOrder(std::string_view payload, const Moment& now,
                                const Listener& listener) {
  const Inspection inspection = shared_.inspector.InspectOrder(payload);
  const std::string place = Place("order", inspection);
  std::string fault = inspection.fault;
  if (fault.empty()) fault = AcceptOrder(inspection.message, state_, shared_.words);
  if (!fault.empty()) {
    listener({Remark::Kind::kFault, fmt::format("{}: {}", place, fault)});
    RobotError error{std::string(inspection.fault.empty() ? shared_.words.invalid_order
                                                          : shared_.words.invalid_message),
                     fault,
                     {{"topic", "order"}},
                     Until::kNextOrder};
    if (!inspection.header_id.empty()) {
      error.references.emplace_back("headerId", inspection.header_id);
    }
    return AddError(std::move(error));
  }
  listener({Remark::Kind::kReceived,
            fmt::format("{}: order {}", place, base::Printable(state_.order.id))});
  changed_ = true;
  ForgetErrors(Until::kNextOrder);
  order_end_.reset();
  if (shared_.settings.order_time.count() > 0) {
    order_end_ = now.steady + shared_.settings.order_time;
  }
}

void VirtualRobot::EndOrder() {
  FinishOrder(state_);
  order_end_.reset();
  changed_ = true;
}

void VirtualRobot::AddError(RobotError error) {
  changed_ = true;
  std::erase_if(state_.errors, [&](const RobotError& old) {
    return old.type == error.type && old.references == error.references;
  });
  if (state_.errors.size() >= kMostErrors) state_.errors.erase(state_.errors.begin());
  state_.errors.push_back(std::move(error));
}

void VirtualRobot::ForgetErrors(Until until) {
  std::erase_if(state_.errors, [&](const RobotError& error) { return error.until == until; });
}

void VirtualRobot::ForgetOldActions() {
  auto& actions = state_.instant_actions;
  const auto ended = [](const ActionState& action) { return IsEnded(action.status); };
  while (std::count_if(actions.begin(), actions.end(), ended) >
         static_cast<std::ptrdiff_t>(kMostEndedActions)) {
    actions.erase(std::find_if(actions.begin(), actions.end(), ended));
  }
}

void VirtualRobot::Remember(const std::string& id) {
  known_.insert(id);
  known_in_order_.push_back(id);
  if (known_in_order_.size() <= kMostKnownIds) return;
  known_.erase(known_in_order_.front());
  known_in_order_.pop_front();
}

ActionState* VirtualRobot::Find(std::string_view id) {
  const auto found = std::find_if(state_.instant_actions.begin(), state_.instant_actions.end(),
                                  [&](const ActionState& action) { return action.id == id; });
  return found == state_.instant_actions.end() ? nullptr : &*found;
}

void VirtualRobot::Say(std::string_view topic, std::string_view body, std::uint32_t& counter,
                       const Moment& now) {
  out_->push_back({topic, Message(header_, counter++, now.wall, body)});
}

void VirtualRobot::SayConnection(std::string_view connection_state, const Moment& now) {
  Say("connection", ConnectionBody(connection_state), connection_id_, now);
  out_->back().qos = shared_.words.connection_qos;
  out_->back().retained = true;
}

void VirtualRobot::SayFactsheet(const Moment& now) {
  if (shared_.factsheet.empty()) return;
  Say("factsheet", shared_.factsheet, factsheet_id_, now);
  out_->back().retained = true;
}

void VirtualRobot::SayState(const Moment& now) {
  changed_ = false;
  next_state_ = now.steady + shared_.settings.state_interval;
  if (shared_.settings.silent || hibernating_) return;
  Say("state", StateBody(state_, shared_.words), state_id_, now);
}

// The last state comes before the robot falls asleep or leaves.
void VirtualRobot::SayStateIfChanged(const Moment& now) {
  if (changed_) SayState(now);
  if (falling_asleep_) {
    falling_asleep_ = false;
    hibernating_ = true;
    SayConnection("HIBERNATING", now);
  }
  if (leaving_) {
    leaving_ = false;
    SayConnection("OFFLINE", now);
    gone_ = true;
  }
}

}  // namespace fleetpub::robot
