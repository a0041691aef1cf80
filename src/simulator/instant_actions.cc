// The part of VirtualRobot that takes instant actions and carries them out.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/text.h"
#include "simulator/virtual_robot.h"

namespace fleetpub::simulator {
namespace {

// How much a robot keeps. Ended actions stay until the version says that they go, or until there
// are too many of them.
constexpr std::size_t kMostEndedActions = 20;
constexpr std::size_t kMostKnownIds = 200;
constexpr std::string_view kClear = "clearInstantActions";

// In which modes fleet control may send instant actions (1.1–2.1 §6.10.6, 3.0 §6.6.7).
bool Takes(std::string_view mode, std::string_view action) {
  if (mode == "INTERVENED") return action == "cancelOrder";
  return mode == "AUTOMATIC" || mode == "SEMIAUTOMATIC";
}

ActionStatus ToStatus(Beginning beginning) {
  constexpr std::array kStatus = {ActionStatus::kWaiting, ActionStatus::kInitializing,
                                  ActionStatus::kRunning};
  return kStatus.at(static_cast<std::size_t>(beginning));
}

std::string FormatTypes(const Inspection& inspection) {
  std::vector<std::string> types;
  for (const ReceivedAction& action : inspection.actions) {
    types.push_back(base::Printable(action.call.type + " " + action.call.id));
  }
  return base::Join(types, ", ");
}

}  // namespace

void VirtualRobot::ReceiveActions(std::string_view payload, const Moment& now,
                                  const EventCallback& on_event) {
  const Inspection inspection = shared_.inspector.InspectInstantActions(payload);
  const std::string place = inspection.Place("instantActions");
  if (!inspection.fault.empty()) {
    on_event({Event::Kind::kFault, fmt::format("{}: {}", place, inspection.fault)});
    if (!hibernating_) RefuseMessage(inspection, "instantActions");
    return;
  }
  on_event({Event::Kind::kReceived, fmt::format("{}: {}", place, FormatTypes(inspection))});
  for (const ReceivedAction& action : inspection.actions) {
    if (!action.fault.empty()) {
      on_event({Event::Kind::kFault, fmt::format("{}: {}", place, action.fault)});
    }
    // Asleep it hears nothing but its alarm clock (3.0 §6.7).
    if (!hibernating_ || action.call.type == "stopHibernation") Begin(action, now);
    if (gone_) return;
  }
}

void VirtualRobot::Begin(const ReceivedAction& action, const Moment& now) {
  const ActionCall& call = action.call;
  // A repeated one is answered, not carried out again.
  const bool is_secret = Has(Fault::kNoStateOnRequest) && call.type == "stateRequest";
  changed_ = changed_ || !is_secret;
  if (known_.contains(call.id)) return;
  if (const std::string reason = ReasonToReject(action); !reason.empty()) {
    Reject(action, reason);
    return;
  }
  ForgetErrors(state_, Until::kNextInstantAction);
  Remember(call.id);
  const Beginning beginning = FindBeginning(call.type);
  state_.instant_actions.push_back(
      {call.id, call.type, action.descriptor, ToStatus(beginning), ""});
  ForgetOldActions();
  const auto delay = shared_.settings.Delay();
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
  if (IsListFull() && action.call.type != kClear) {
    return fmt::format("the list of instant actions is full: {} is needed first", kClear);
  }
  if (!Takes(state_.operating_mode, action.call.type)) {
    return fmt::format("{} is not possible in operating mode {}", action.call.type,
                       state_.operating_mode);
  }
  return {};
}

void VirtualRobot::Reject(const ReceivedAction& action, const std::string& reason) {
  const ActionCall& call = action.call;
  if (shared_.settings.Style() == RejectStyle::kState && !IsListFull()) {
    Remember(call.id);
    state_.instant_actions.push_back(
        {call.id, call.type, action.descriptor, ActionStatus::kFailed, reason});
    ForgetOldActions();
    TellWhetherListIsFull();
  }
  AddError({std::string(shared_.terms.invalid_action),
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
  running.next = now.steady + shared_.settings.Delay() / 2;
  running_.push_back(std::move(running));
}

void VirtualRobot::Complete(const Running& running, const Moment& now) {
  const ActionCall& call = running.call;
  ActionResult result;
  if (shared_.settings.fail.contains(call.type)) {
    result = {.finished = false, .result = fmt::format("{} failed, as asked for", call.type)};
  } else if (shared_.settings.retriable.contains(call.type) && !running.retried) {
    if (ActionState* action = Find(call.id); action != nullptr) {
      action->status = ActionStatus::kRetriable;
      action->result = fmt::format("{} can be retried, as asked for", call.type);
    }
    retriable_.push_back(running);
    return;
  } else {
    result = CarryOut(call);
  }
  if (result.side_effect == SideEffect::kCancel) return Cancel(call, now);
  if (ActionState* action = Find(call.id); action != nullptr) {
    action->status = result.finished ? ActionStatus::kFinished : ActionStatus::kFailed;
    action->result = result.result;
  }
  if (result.error) AddError(*result.error);
  TellWhetherListIsFull();
  ApplySideEffect(result, now);
}

ActionResult VirtualRobot::CarryOut(const ActionCall& call) {
  if (call.type == "cancelOrder") {
    if (Has(Fault::kNoCancelError) && !state_.HasWork()) return {};
    if (Has(Fault::kCancelAnyOrder)) {
      return Execute({call.id, call.type, {}}, state_, shared_.terms);
    }
  }
  if (call.type == "startPause" && state_.paused && Has(Fault::kPauseOnce)) {
    RobotError error{"controlError", "it is paused already", {{"actionId", call.id}}};
    return {.finished = false, .result = error.description, .error = error};
  }
  return Execute(call, state_, shared_.terms);
}

void VirtualRobot::ApplySideEffect(const ActionResult& result, const Moment& now) {
  switch (result.side_effect) {
    case SideEffect::kNone:
    case SideEffect::kCancel:
      return;
    case SideEffect::kFactsheet:
      if (!Has(Fault::kFactsheetNotLive)) SayFactsheet(now);
      return;
    case SideEffect::kHibernate:
      falling_asleep_ = true;
      return SayStateIfChanged(now);
    case SideEffect::kWake:
      if (hibernating_) {
        hibernating_ = false;
        SayConnection("ONLINE", now);
      }
      return;
    case SideEffect::kShutDown:
      leaving_ = true;
      return SayStateIfChanged(now);
    case SideEffect::kRetry:
      return Retry(result.target, now);
    case SideEffect::kSkipRetry:
      for (OrderAction& action : state_.order_actions) {
        if (action.id == result.target) action.status = ActionStatus::kFailed;
      }
      std::erase_if(retriable_, [&](const Running& r) { return r.call.id == result.target; });
      if (ActionState* action = Find(result.target); action != nullptr) {
        action->status = ActionStatus::kFailed;
      }
      return;
  }
}

void VirtualRobot::Retry(const std::string& id, const Moment& now) {
  if (run_.Retry(state_, id, now.steady)) return;
  const auto found = std::find_if(retriable_.begin(), retriable_.end(),
                                  [&](const Running& running) { return running.call.id == id; });
  if (found == retriable_.end()) return;
  Running running = std::move(*found);
  retriable_.erase(found);
  running.retried = true;
  running.next = now.steady + shared_.settings.Delay();
  if (ActionState* action = Find(id); action != nullptr) {
    action->status = ActionStatus::kRunning;
    action->result.clear();
  }
  if (shared_.settings.Delay().count() == 0) {
    Complete(running, now);
  } else {
    running_.push_back(std::move(running));
  }
}

bool VirtualRobot::IsListFull() const {
  const auto ended = std::count_if(state_.instant_actions.begin(), state_.instant_actions.end(),
                                   [](const ActionState& a) { return IsEnded(a.status); });
  const std::size_t limit = shared_.settings.list_limit;
  return limit > 0 && static_cast<std::size_t>(ended) >= limit;
}

void VirtualRobot::TellWhetherListIsFull() {
  ForgetErrors(state_, Until::kCleared);
  if (!IsListFull()) return;
  AddError({"INSTANT_ACTION_STATES_FULL",
            fmt::format("send {}", kClear),
            {},
            Until::kCleared,
            "URGENT"});
}

void VirtualRobot::ForgetOldActions() {
  if (shared_.settings.list_limit > 0) return;
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

}  // namespace fleetpub::simulator
