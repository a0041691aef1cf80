// How a virtual robot carries out its order: it drives along edges, and does the actions that it
// comes to by the rule of the queue (Figure 11 of 1.1, 17 of 2.1, 15 of 3.0). No clock.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "simulator/order_plan.h"
#include "simulator/path.h"
#include "simulator/protocol_terms.h"
#include "simulator/robot_state.h"
#include "simulator/settings.h"

namespace fleetpub::simulator {

class OrderRun {
 public:
  /// Both outlive it.
  OrderRun(const Settings& settings, const ProtocolTerms& terms)
      : settings_(settings), terms_(terms) {}

  /// Takes over a new order. The robot is at its first node.
  void Begin(OrderPlan plan, RobotState& state);
  /// Replaces the horizon. The plan begins with the last node of the base, which stays as it was.
  void Extend(OrderPlan plan, RobotState& state);
  /// Stops, gives up what can be given up, and ends the order once the rest has ended.
  void Cancel(RobotState& state, TimePoint now);
  /// A RETRIABLE action is begun again. False when there is none.
  bool Retry(RobotState& state, std::string_view id, TimePoint now);

  /// To be called whenever something has changed, and at Due(). True when the state has changed.
  bool Advance(RobotState& state, TimePoint now);
  [[nodiscard]] TimePoint Due(const RobotState& state) const;
  /// Where it is now, and what is left in its battery.
  void Locate(RobotState& state, TimePoint now);

  [[nodiscard]] bool is_cancelling() const { return is_cancelling_; }

 private:
  // An edge while it is driven.
  struct Motion {
    Path path;                       // empty: its length is not known
    double seconds = 0;              // that it takes
    double done = 0;                 // share, when it was set off
    std::optional<TimePoint> since;  // it is moving
    double speed = 0;
  };

  [[nodiscard]] bool Has(Fault fault) const { return settings_.Has(fault); }
  void Trigger(RobotState& state, std::uint32_t sequence_id);
  void CatchUpWithFaults(RobotState& state);
  void GoOn(RobotState& state, TimePoint now);
  void PauseActions(RobotState& state, TimePoint now);
  void StartActions(RobotState& state, TimePoint now);
  void StartEdgeActionsEarly(RobotState& state, TimePoint now);
  void StartAction(OrderAction& action, TimePoint now);
  void CompleteActions(RobotState& state, TimePoint now);
  void Complete(RobotState& state, OrderAction& action);
  void FailAction(RobotState& state, OrderAction& action, std::string why);
  [[nodiscard]] bool IsStopped(const RobotState& state) const;
  [[nodiscard]] bool MayDrive(const RobotState& state) const;
  [[nodiscard]] bool MayEnterEdge(const RobotState& state) const;
  void EnterEdge(RobotState& state);
  [[nodiscard]] Path PathAlong(const RobotState& state, const EdgeLeg& edge,
                               const NodeLeg& end) const;
  [[nodiscard]] double TimeFor(const RobotState& state, const EdgeLeg& edge) const;
  void SetMoving(RobotState& state, bool is_moving, TimePoint now);
  void Arrive(RobotState& state, TimePoint now);
  void ReachNode(RobotState& state, const NodeLeg& node);
  void EndEdgeActions(RobotState& state, std::uint32_t sequence_id);
  [[nodiscard]] double ShareDone(TimePoint now) const;
  [[nodiscard]] std::optional<TimePoint> Arrival() const;
  void AskForBase(RobotState& state);
  void EndCancelledOrder(RobotState& state);
  void Drain(RobotState& state, TimePoint now);
  void ChangeStatus(ActionState& action, ActionStatus status);

  const Settings& settings_;
  const ProtocolTerms& terms_;
  std::optional<Motion> motion_;
  bool is_paused_ = false;
  bool is_cancelling_ = false;
  bool is_stuck_ = false;
  bool changed_ = false;
  TimePoint now_;                         // of the last Advance
  bool has_edge_left_ = false;            // a fault: its node has gone already
  int first_node_turns_ = 0;              // a fault: for so long it is listed
  std::optional<TimePoint> rests_until_;  // a fault: stands at a node
  std::optional<TimePoint> drained_at_;
};

}  // namespace fleetpub::simulator
