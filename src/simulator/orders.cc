// The part of VirtualRobot that takes orders, and what ends them.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/json.h"
#include "base/text.h"
#include "simulator/order_decision.h"
#include "simulator/permissions.h"
#include "simulator/virtual_robot.h"

namespace fleetpub::simulator {
namespace {

using vda5050::Version;

bool HasSameContent(std::string_view one, base::JsonDocument& other) {
  auto message = base::ParseJson(one);
  if (!message || !message->IsObject() || !other.IsObject()) return false;
  base::JsonDocument copy;
  copy.CopyFrom(other, copy.GetAllocator());
  for (base::JsonDocument* document : {&*message, &copy}) {
    for (const char* member : {"headerId", "timestamp"}) document->RemoveMember(member);
  }
  return *message == copy;
}

// A fault: whatever can be driven is.
bool CanBeDriven(const base::JsonValue& message) {
  const auto* nodes = base::FindArray(message, "nodes");
  return nodes != nullptr && !nodes->Empty() && base::FindArray(message, "edges") != nullptr;
}

// Up to 2.1 who enters or leaves MANUAL ends the order (2.1 §6.10.6), from 3.0 who enters a mode in
// which fleet control has nothing to say (3.0 §6.6.7).
bool EndsOrder(std::string_view from, std::string_view to, Version version) {
  if (version < Version::k300) return from == "MANUAL" || to == "MANUAL";
  constexpr std::array<std::string_view, 4> kModes = {"STARTUP", "MANUAL", "SERVICE", "TEACH_IN"};
  return std::find(kModes.begin(), kModes.end(), to) != kModes.end();
}

bool ForgetsNode(std::string_view mode) {
  return mode == "SERVICE" || mode == "TEACH_IN" || mode == "TEACHIN";
}

}  // namespace

void VirtualRobot::ReceiveOrder(std::string_view payload, const Moment& now,
                                const EventCallback& on_event) {
  Inspection inspection = shared_.inspector.InspectOrder(payload);
  const std::string place = inspection.Place("order");
  if (Has(Fault::kTakeMalformed) && CanBeDriven(inspection.message)) inspection.fault.clear();
  Decision decision;
  OrderPlan plan;
  if (inspection.fault.empty()) {
    plan = ReadOrder(inspection.message, shared_.terms);
    if (Has(Fault::kIgnoreUpdates) && plan.order.id == state_.order.id) return;
    decision = Decide(
        {inspection, plan, state_, shared_.settings, shared_.terms,
         plan.order.id == state_.order.id && HasSameContent(accepted_order_, inspection.message),
         IsCancelling()});
  } else {
    decision.error = RefuseMalformed(inspection, shared_.settings);
  }
  if (decision.outcome == Outcome::kRefuse) {
    on_event({Event::Kind::kFault, fmt::format("{}: {}", place, decision.error.description)});
    changed_ = true;
    if (!Has(Fault::kSilentRejection)) AddError(std::move(decision.error));
    return;
  }
  const std::string id = base::Printable(plan.order.id);
  if (decision.outcome == Outcome::kDiscard) {
    return on_event({Event::Kind::kReceived, fmt::format("{}: order {} again", place, id)});
  }
  on_event({Event::Kind::kReceived, fmt::format("{}: order {}", place, id)});
  changed_ = true;
  accepted_order_ = payload;
  ForgetErrors(state_, Until::kNextOrder);
  if (decision.outcome == Outcome::kNew) {
    state_.requests.clear();
    if (shared_.terms.OrderClearsInstantActions() != Has(Fault::kInstantActionsOverOrder)) {
      std::erase_if(state_.instant_actions,
                    [](const ActionState& action) { return IsEnded(action.status); });
    }
    run_.Begin(std::move(plan), state_);
  } else {
    run_.Extend(std::move(plan), state_);
  }
  if (shared_.terms.HasZoneSets()) AskForPermissions(inspection.message, state_);
  NoteLeases(now);
}

void VirtualRobot::NoteLeases(const Moment& now) {
  const auto expiry = NextExpiry(state_);
  lease_end_.reset();
  if (expiry) lease_end_ = now.steady + (*expiry - now.wall);
}

// Somebody turns the key, or presses a button.
void VirtualRobot::ApplyMode(std::string_view mode) {
  if (state_.operating_mode == mode) return;
  if (EndsOrder(state_.operating_mode, mode, shared_.settings.version)) {
    state_.requests.clear();
    if (state_.HasWork()) GiveUpOrder(state_);
  }
  if (mode == "INTERVENED") state_.requests.clear();
  if (ForgetsNode(mode)) {
    state_.last_node_id.clear();
    state_.last_node_sequence_id = 0;
  }
  state_.operating_mode = mode;
  if (state_.IsAutomatic()) ForgetErrors(state_, Until::kNextMode);
  changed_ = true;
}

// RUNNING until the robot stands and what cannot be given up has ended.
void VirtualRobot::Cancel(const ActionCall& call, const Moment& now) {
  if (Has(Fault::kCancelFinishedFirst)) {
    if (ActionState* action = Find(call.id)) action->status = ActionStatus::kFinished;
    SayState(now);
    return run_.Cancel(state_, now.steady);
  }
  if (ActionState* action = Find(call.id)) action->status = ActionStatus::kRunning;
  cancels_.push_back(call.id);
  cancels_told_ = false;
  run_.Cancel(state_, now.steady);
  changed_ = true;
  SayStateIfChanged(now);
}

bool VirtualRobot::IsCancelling() const {
  return run_.is_cancelling() ||
         std::any_of(running_.begin(), running_.end(),
                     [](const Running& running) { return running.call.type == "cancelOrder"; });
}

bool VirtualRobot::FinishCancels() {
  if (cancels_.empty() || !cancels_told_ || run_.is_cancelling()) return false;
  for (const std::string& id : cancels_) {
    if (ActionState* action = Find(id)) action->status = ActionStatus::kFinished;
  }
  cancels_.clear();
  return true;
}

}  // namespace fleetpub::simulator
