#include "simulator/order_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simulator/action_handlers.h"

namespace fleetpub::simulator {
namespace {

using std::chrono::duration;
using std::chrono::duration_cast;
using std::chrono::steady_clock;

constexpr double kDrivingHours = 8;   // with a full battery
constexpr double kChargingHours = 1;  // until it is full again
constexpr std::chrono::milliseconds kRest{500};
constexpr double kBesideNode = 2;  // m

steady_clock::duration FromSeconds(double seconds) {
  return duration_cast<steady_clock::duration>(duration<double>(seconds));
}

bool IsHorizon(const Leg& leg) { return !leg.released; }

}  // namespace

void OrderRun::Begin(OrderPlan plan, RobotState& state) {
  motion_.reset();
  is_stuck_ = false;
  is_cancelling_ = false;
  if (Has(Fault::kListFirstNode)) first_node_turns_ = 2;
  const NodeLeg first = plan.order.nodes.front();
  if (first_node_turns_ == 0) plan.order.nodes.erase(plan.order.nodes.begin());
  state.order = std::move(plan.order);
  state.order_actions = std::move(plan.actions);
  state.last_node_id = first.id;
  state.last_node_sequence_id = first.sequence_id;
  state.new_base_request = false;
  if (first.place && !state.is_placed) {
    state.position = {first.place->x, first.place->y,
                      first.place->theta.value_or(state.position.theta), first.place->map_id};
    state.is_placed = true;
  }
  Trigger(state, first.sequence_id);
}

void OrderRun::Extend(OrderPlan plan, RobotState& state) {
  Order& order = state.order;
  const std::uint32_t base_end = plan.order.nodes.front().sequence_id;
  if (!Has(Fault::kAppendHorizon)) {
    std::erase_if(order.nodes, IsHorizon);
    std::erase_if(order.edges, IsHorizon);
  }
  std::erase_if(state.order_actions, [&](const OrderAction& action) {
    return action.sequence_id > base_end && !action.is_due;
  });
  order.id = plan.order.id;
  order.update_id = plan.order.update_id;
  order.decision_point = plan.order.decision_point;
  order.is_cancelled = false;
  order.edge_count = std::max<std::size_t>(1, order.edges.size() + plan.order.edges.size());
  const bool reruns = Has(Fault::kRerunStitched);
  order.nodes.insert(order.nodes.end(), plan.order.nodes.begin() + 1, plan.order.nodes.end());
  order.edges.insert(order.edges.end(), plan.order.edges.begin(), plan.order.edges.end());
  // What it has of the first node counts, not what is sent again.
  for (OrderAction& action : plan.actions) {
    if (action.sequence_id == base_end && !reruns) continue;
    action.is_due = reruns && action.sequence_id == state.last_node_sequence_id;
    state.order_actions.push_back(std::move(action));
  }
  if (!Has(Fault::kNewBaseStuck)) state.new_base_request = false;
}

void OrderRun::Cancel(RobotState& state, TimePoint now) {
  SetMoving(state, false, now);
  motion_.reset();
  is_cancelling_ = true;
  for (OrderAction& action : state.order_actions) {
    if (IsEnded(action.status)) continue;
    const bool goes_on = action.status == ActionStatus::kRunning && !IsInterruptible(action.type) &&
                         action.end.has_value();
    if (!goes_on) action.status = ActionStatus::kFailed;
  }
  state.new_base_request = false;
  changed_ = true;
}

bool OrderRun::Retry(RobotState& state, std::string_view id, TimePoint now) {
  for (OrderAction& action : state.order_actions) {
    if (action.id != id || action.status != ActionStatus::kRetriable) continue;
    action.was_retried = true;
    action.result.clear();
    StartAction(action, now);
    return true;
  }
  return false;
}

bool OrderRun::Advance(RobotState& state, TimePoint now) {
  changed_ = false;
  now_ = now;
  Drain(state, now);
  if (!state.order.Active()) {
    if (motion_) SetMoving(state, false, now);
    motion_.reset();
  }
  CatchUpWithFaults(state);
  if (const auto arrival = Arrival(); arrival && *arrival <= now) Arrive(state, now);
  CompleteActions(state, now);
  GoOn(state, now);
  return changed_;
}

// What they have left in the state for one message.
void OrderRun::CatchUpWithFaults(RobotState& state) {
  if (first_node_turns_ > 0 && --first_node_turns_ == 0 && !state.order.nodes.empty()) {
    state.order.nodes.erase(state.order.nodes.begin());
    changed_ = true;
  }
  if (has_edge_left_) {
    has_edge_left_ = false;
    if (!state.order.edges.empty()) state.order.edges.erase(state.order.edges.begin());
    changed_ = true;
  }
}

TimePoint OrderRun::Due(const RobotState& state) const {
  TimePoint due = TimePoint::max();
  if (has_edge_left_ || first_node_turns_ > 0) return now_;
  if (const auto arrival = Arrival()) due = *arrival;
  if (rests_until_) due = std::min(due, *rests_until_);
  for (const OrderAction& action : state.order_actions) {
    if (action.IsQueued() && action.end && action.status == ActionStatus::kRunning) {
      due = std::min(due, *action.end);
    }
  }
  return due;
}

void OrderRun::Locate(RobotState& state, TimePoint now) {
  Drain(state, now);
  state.distance_since_last_node.reset();
  if (!motion_ || motion_->path.IsEmpty() || state.order.edges.empty()) return;
  const double distance = ShareDone(now) * motion_->path.length();
  const auto spot = motion_->path.At(distance);
  const EdgeLeg& edge = state.order.edges.front();
  state.position.x = spot.point.x;
  state.position.y = spot.point.y;
  if (motion_->path.length() > 0) {
    const double turn = edge.orientation.value_or(0);
    const bool is_global = edge.is_global && edge.orientation;
    state.position.theta = NormalizeAngle(is_global ? turn : spot.tangent + turn);
    state.speed_angle = NormalizeAngle(spot.tangent - state.position.theta);
  }
  state.distance_since_last_node = distance;
}

void OrderRun::Trigger(RobotState& state, std::uint32_t sequence_id) {
  for (OrderAction& action : state.order_actions) {
    if (action.sequence_id == sequence_id) action.is_due = true;
  }
}

// Whatever can go on now does.
void OrderRun::GoOn(RobotState& state, TimePoint now) {
  PauseActions(state, now);
  StartActions(state, now);
  if (rests_until_ && *rests_until_ <= now) rests_until_.reset();
  if (is_cancelling_) return EndCancelledOrder(state);
  if (MayEnterEdge(state)) {
    EnterEdge(state);
    StartActions(state, now);
  }
  SetMoving(state, motion_ && !is_stuck_ && MayDrive(state) && !IsStopped(state), now);
  AskForBase(state);
  const bool ends_base =
      !motion_ && std::all_of(state.order.nodes.begin(), state.order.nodes.end(), IsHorizon);
  if (Has(Fault::kDropHorizon) && ends_base && state.order.Active()) {
    state.order.nodes.clear();
    state.order.edges.clear();
    changed_ = true;
  }
  if (Has(Fault::kWipeOrderAtEnd) && !state.HasWork()) state.order.id.clear();
}

// ---- Driving ----

bool OrderRun::IsStopped(const RobotState& state) const {
  return std::any_of(state.order_actions.begin(), state.order_actions.end(),
                     [&](const OrderAction& action) {
                       if (!action.IsQueued()) return false;
                       if (action.status == ActionStatus::kRetriable) return true;
                       if (Has(Fault::kNoneStops) && action.blocking == Blocking::kNone)
                         return true;
                       if (Has(Fault::kSingleStops) && action.blocking == Blocking::kSingle) {
                         return true;
                       }
                       return action.Stops() && !Has(Fault::kActionsNeverStop);
                     });
}

bool OrderRun::MayDrive(const RobotState& state) const {
  return state.MayDrive() || (Has(Fault::kPauseDrives) && state.paused && !state.IsHeld());
}

bool OrderRun::MayEnterEdge(const RobotState& state) const {
  const Order& order = state.order;
  if (motion_ || order.edges.empty() || order.nodes.empty()) return false;
  if (rests_until_ || has_edge_left_ || first_node_turns_ > 0) return false;
  const bool is_released = order.edges.front().released && order.nodes.front().released;
  return (is_released || Has(Fault::kEnterHorizon)) && MayDrive(state) && !IsStopped(state);
}

void OrderRun::EnterEdge(RobotState& state) {
  Order& order = state.order;
  const EdgeLeg& edge = order.edges.front();
  motion_ = Motion{.path = PathAlong(state, edge, order.nodes.front())};
  motion_->seconds = TimeFor(state, edge) / settings_.time_scale;
  if (motion_->seconds > 0) {
    const double length =
        motion_->path.IsEmpty() ? edge.length.value_or(0) : motion_->path.length();
    motion_->speed = length / (motion_->seconds * settings_.time_scale);
  }
  state.charging = false;
  Trigger(state, edge.sequence_id);
  changed_ = true;
}

// Empty when it is not known where one of its ends is.
Path OrderRun::PathAlong(const RobotState& state, const EdgeLeg& edge, const NodeLeg& end) const {
  if (!end.place || !state.is_placed || end.place->map_id != state.position.map_id) return {};
  std::vector<Point> points = {{state.position.x, state.position.y}};
  points.insert(points.end(), edge.via.begin(), edge.via.end());
  points.push_back({end.place->x, end.place->y});
  return Path(std::move(points));
}

double OrderRun::TimeFor(const RobotState& state, const EdgeLeg& edge) const {
  if (settings_.order_time.count() > 0) {
    const double edges = static_cast<double>(std::max<std::size_t>(1, state.order.edge_count));
    return duration<double>(settings_.order_time).count() / edges;
  }
  double speed = settings_.speed;
  if (edge.max_speed && !Has(Fault::kIgnoreSpeedLimit)) speed = std::min(speed, *edge.max_speed);
  if (!motion_->path.IsEmpty()) return motion_->path.length() / speed;
  if (edge.length) return *edge.length / speed;
  return duration<double>(settings_.edge_time).count();
}

double OrderRun::ShareDone(TimePoint now) const {
  if (!motion_->since) return motion_->done;
  const double passed = duration<double>(now - *motion_->since).count();
  const double most = is_stuck_ ? 0.5 : 1;
  if (motion_->seconds <= 0) return most;
  return std::min(most, motion_->done + passed / motion_->seconds);
}

std::optional<TimePoint> OrderRun::Arrival() const {
  if (!motion_ || !motion_->since) return std::nullopt;
  const double end = Has(Fault::kStuck) ? 0.5 : 1;
  return *motion_->since + FromSeconds((end - motion_->done) * motion_->seconds);
}

void OrderRun::SetMoving(RobotState& state, bool is_moving, TimePoint now) {
  if (motion_ && motion_->since.has_value() != is_moving) {
    motion_->done = ShareDone(now);
    motion_->since.reset();
    Locate(state, now);
    motion_->since = is_moving ? std::optional(now) : std::nullopt;
  }
  const bool driving = is_moving && !Has(Fault::kNeverDriving);
  if (state.driving != driving) changed_ = true;
  state.driving = driving;
  state.speed = is_moving ? motion_->speed : 0;
}

// One state for all of it (3.0 §6.6.2): node and edge are gone, the edge's actions have ended, the
// node's begin.
void OrderRun::Arrive(RobotState& state, TimePoint now) {
  changed_ = true;
  if (Has(Fault::kStuck)) {
    motion_->done = 0.5;
    is_stuck_ = true;
    return;
  }
  Locate(state, now);
  Order& order = state.order;
  const NodeLeg node = order.nodes.front();
  order.nodes.erase(order.nodes.begin());
  EndEdgeActions(state, order.edges.front().sequence_id);
  if (Has(Fault::kNodeBeforeEdge)) {
    has_edge_left_ = true;
  } else {
    order.edges.erase(order.edges.begin());
  }
  motion_.reset();
  ReachNode(state, node);
  Trigger(state, node.sequence_id);
  if (Has(Fault::kStopAtNodes)) rests_until_ = now + settings_.Scaled(kRest);
}

void OrderRun::ReachNode(RobotState& state, const NodeLeg& node) {
  if (!Has(Fault::kWrongLastNode)) state.last_node_id = node.id;
  state.last_node_sequence_id = node.sequence_id;
  state.is_placed = node.place.has_value();
  if (!node.place) return;
  state.position.x = node.place->x;
  state.position.y = node.place->y;
  state.position.map_id = node.place->map_id;
  if (node.place->theta && !Has(Fault::kSkipTheta)) state.position.theta = *node.place->theta;
  if (Has(Fault::kDeviation)) state.position.y += kBesideNode + node.place->deviation_a;
}

void OrderRun::AskForBase(RobotState& state) {
  const auto& nodes = state.order.nodes;
  const auto base =
      std::count_if(nodes.begin(), nodes.end(), [](const NodeLeg& node) { return node.released; });
  const bool has_horizon = static_cast<std::size_t>(base) < nodes.size();
  bool asks = has_horizon && base <= 1;
  if (Has(Fault::kNewBaseNever)) asks = false;
  if (Has(Fault::kNewBaseStuck)) asks = asks || state.new_base_request;
  if (asks != state.new_base_request) changed_ = true;
  state.new_base_request = asks;
}

void OrderRun::EndCancelledOrder(RobotState& state) {
  if (state.HasOpenActions()) return;
  is_cancelling_ = false;
  GiveUpOrder(state);
  if (Has(Fault::kCancelWipesOrderId)) state.order.id.clear();
  if (Has(Fault::kCancelDropsActions)) state.order_actions.clear();
  changed_ = true;
}

void OrderRun::Drain(RobotState& state, TimePoint now) {
  if (drained_at_ && (state.driving || state.charging)) {
    const double hours =
        duration<double, std::ratio<3600>>(now - *drained_at_).count() * settings_.time_scale;
    const double change = state.charging ? 100 / kChargingHours : -100 / kDrivingHours;
    state.battery = std::clamp(state.battery + change * hours, 0.0, 100.0);
  }
  drained_at_ = now;
}

// ---- Actions ----

void OrderRun::ChangeStatus(ActionState& action, ActionStatus status) {
  if (action.status == status) return;
  action.status = status;
  if (!Has(Fault::kNoStateOnStatus)) changed_ = true;
}

void OrderRun::PauseActions(RobotState& state, TimePoint now) {
  if (is_paused_ == state.paused) return;
  is_paused_ = state.paused;
  if (state.paused && Has(Fault::kPauseLosesOrder)) return GiveUpOrder(state);
  for (OrderAction& action : state.order_actions) {
    if (!action.IsQueued() || !action.end || !IsInterruptible(action.type)) continue;
    if (is_paused_ && action.status == ActionStatus::kRunning) {
      action.left = *action.end - now;
      ChangeStatus(action, ActionStatus::kPaused);
    } else if (!is_paused_ && action.status == ActionStatus::kPaused) {
      action.end = now + action.left;
      ChangeStatus(action, ActionStatus::kRunning);
    }
  }
}

// NONE and SOFT begin together; SINGLE and HARD wait until all before them have ended, and nothing
// begins before they have.
void OrderRun::StartActions(RobotState& state, TimePoint now) {
  if (is_paused_ || is_cancelling_) return;
  if (Has(Fault::kEdgeActionsEarly)) StartEdgeActionsEarly(state, now);
  const bool hard_waits =
      Has(Fault::kHardFirst) && std::any_of(state.order_actions.begin(), state.order_actions.end(),
                                            [](const OrderAction& action) {
                                              return action.IsQueued() &&
                                                     action.blocking == Blocking::kHard;
                                            });
  bool any_before = false;
  bool soft_before = false;
  for (OrderAction& action : state.order_actions) {
    if (!action.IsQueued()) continue;
    if (hard_waits && action.blocking != Blocking::kHard) continue;
    const bool is_soft = action.blocking == Blocking::kSoft;
    const Fault in_parallel =
        action.blocking == Blocking::kHard ? Fault::kHardInParallel : Fault::kSingleInParallel;
    const bool is_alone = action.IsAlone() && !Has(in_parallel);
    const bool waits =
        (is_alone && any_before) || (is_soft && soft_before && Has(Fault::kSoftOneByOne));
    if (action.status == ActionStatus::kWaiting && !waits) StartAction(action, now);
    if (is_alone) break;
    any_before = true;
    soft_before = soft_before || is_soft;
  }
}

void OrderRun::StartEdgeActionsEarly(RobotState& state, TimePoint now) {
  if (state.order.edges.empty() || !state.order.edges.front().released) return;
  for (OrderAction& action : state.order_actions) {
    if (action.sequence_id != state.order.edges.front().sequence_id || action.is_due) continue;
    action.is_due = true;
    if (action.status == ActionStatus::kWaiting) StartAction(action, now);
  }
}

// Somebody beside the robot triggers what fleet control cannot: up to 2.1 no message does.
void OrderRun::StartAction(OrderAction& action, TimePoint now) {
  ChangeStatus(action, ActionStatus::kRunning);
  const std::string triggers = ActionCall{"", "", action.parameters}.Text("triggerType");
  const bool waits = action.type == "waitForTrigger" && terms_.HasTrigger() &&
                     (triggers.empty() || triggers.find("FLEET_CONTROL") != std::string::npos);
  action.end.reset();
  if (!waits && !settings_.hang.contains(action.type)) action.end = now + settings_.ActionTime();
}

void OrderRun::CompleteActions(RobotState& state, TimePoint now) {
  for (OrderAction& action : state.order_actions) {
    if (action.IsQueued() && action.status == ActionStatus::kRunning && action.end &&
        *action.end <= now) {
      Complete(state, action);
    }
  }
}

void OrderRun::Complete(RobotState& state, OrderAction& action) {
  const bool fails_once = settings_.retriable.contains(action.type) && !action.was_retried;
  if (settings_.fail.contains(action.type) || fails_once) {
    const bool may_retry = action.is_retriable && !Has(Fault::kNeverRetriable);
    if (!may_retry) return FailAction(state, action, action.type + " failed, as asked for");
    action.result = fmt::format("{} can be retried, as asked for", action.type);
    return ChangeStatus(action, ActionStatus::kRetriable);
  }
  const std::vector<Load> loads = state.loads;
  ActionResult result = Execute({action.id, action.type, action.parameters}, state, terms_);
  if (Has(Fault::kNoLoads)) state.loads = loads;
  if (result.error) AddError(state, *result.error);
  if (!result.finished) return FailAction(state, action, result.result);
  action.result = result.result;
  ChangeStatus(action, ActionStatus::kFinished);
}

// A load that was not taken or left stops it, from 3.0; up to 2.1 only FATAL would, which asks for a
// person.
void OrderRun::FailAction(RobotState& state, OrderAction& action, std::string why) {
  ChangeStatus(action, ActionStatus::kFailed);
  const bool stops = !IsInterruptible(action.type) && terms_.HasRetriable();
  AddError(state, {.type = std::string(terms_.failed_action),
                   .description = why,
                   .references = {{"actionId", action.id}, {"orderId", state.order.id}},
                   .until = Until::kNextOrder,
                   .level = stops ? "CRITICAL" : "WARNING"});
  action.result = std::move(why);
  changed_ = true;
  if (Has(Fault::kFailureWipesOrder)) GiveUpOrder(state);
}

void OrderRun::EndEdgeActions(RobotState& state, std::uint32_t sequence_id) {
  if (Has(Fault::kEdgeActionsRunOn)) return;
  for (OrderAction& action : state.order_actions) {
    if (action.sequence_id != sequence_id || IsEnded(action.status)) continue;
    const bool has_begun = action.status == ActionStatus::kRunning;
    ChangeStatus(action, has_begun ? ActionStatus::kFinished : ActionStatus::kFailed);
  }
}

}  // namespace fleetpub::simulator
