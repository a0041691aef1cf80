// What a virtual robot knows of itself; what its `state` messages are made of.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "base/time.h"

namespace fleetpub::simulator {

using TimePoint = std::chrono::steady_clock::time_point;

enum class ActionStatus {
  kWaiting,
  kInitializing,
  kRunning,
  kPaused,
  kRetriable,
  kFinished,
  kFailed
};

[[nodiscard]] std::string_view GetName(ActionStatus status);
[[nodiscard]] inline bool IsEnded(ActionStatus status) {
  return status == ActionStatus::kFinished || status == ActionStatus::kFailed;
}

struct ActionState {
  std::string id;
  std::string type;
  std::string descriptor;
  ActionStatus status = ActionStatus::kWaiting;
  std::string result;
};

struct Parameter {
  std::string key;
  std::variant<std::string, double> value;
};

/// Who may act beside an action: anybody, nobody who drives, nobody else, nobody at all.
enum class Blocking { kNone, kSoft, kSingle, kHard };

/// An action on a node or an edge of the order.
struct OrderAction : ActionState {
  std::vector<Parameter> parameters = {};
  Blocking blocking = Blocking::kHard;
  bool is_retriable = false;
  bool was_retried = false;
  std::uint32_t sequence_id = 0;  ///< of its node or edge
  bool is_due = false;            ///< the robot has come to its node or edge
  std::optional<TimePoint> end = {};
  std::chrono::steady_clock::duration left{0};  ///< until its end, while it is PAUSED

  /// The robot has come to it, and it has not ended.
  [[nodiscard]] bool IsQueued() const { return is_due && !IsEnded(status); }
  [[nodiscard]] bool Stops() const {
    return blocking == Blocking::kSoft || blocking == Blocking::kHard;
  }
  [[nodiscard]] bool IsAlone() const {
    return blocking == Blocking::kSingle || blocking == Blocking::kHard;
  }
};

struct Load {
  std::string id;
  std::string type;
};

struct Map {
  std::string id;
  std::string version;
  bool enabled = false;
};

struct Point {
  double x = 0;
  double y = 0;
};

/// A zone that may be entered only with a permission.
struct ReleaseZone {
  std::string id;
  std::vector<Point> corners;
};

struct ZoneSet {
  std::string id;
  std::string map_id;
  bool enabled = false;
  std::vector<ReleaseZone> release_zones = {};
};

/// For a zone, or for an edge's corridor.
struct Request {
  std::string id = {};
  std::string_view type;
  std::string_view status = "REQUESTED";
  std::string zone_id = {};
  std::string zone_set_id = {};
  std::string edge_id = {};
  std::uint32_t sequence_id = 0;  ///< of the edge
  std::optional<base::WallTime> lease_expiry = {};
};

struct Position {
  double x = 0;
  double y = 0;
  double theta = 0;
  std::string map_id = "map-1";
};

/// How long an error stays in the state (3.0 §6.6.5; the older texts leave it open).
enum class Until { kNextInstantAction, kNextOrder, kNextMode, kCleared, kEnd };

using References = std::vector<std::pair<std::string, std::string>>;  // key, value

struct RobotError {
  std::string type;
  std::string description;
  References references;
  Until until = Until::kNextInstantAction;
  std::string_view level = "WARNING";

  [[nodiscard]] bool StopsDriving() const { return level == "FATAL" || level == "CRITICAL"; }
};

/// What is still to be travelled of an order: a node or an edge.
struct Leg {
  std::string id;
  std::uint32_t sequence_id = 0;
  bool released = true;
};

/// Where a node is, and how far beside it counts as there.
struct Place {
  double x = 0;
  double y = 0;
  std::optional<double> theta;
  std::string map_id;
  double deviation_a = 0;  ///< semi-axes of an ellipse, m
  double deviation_b = 0;
  double deviation_angle = 0;  ///< of the first axis, rad
  double deviation_theta = 0;
};

struct NodeLeg : Leg {
  std::optional<Place> place = {};
};

struct EdgeLeg : Leg {
  std::optional<double> max_speed = {};  ///< m/s
  std::optional<double> length = {};     ///< m, where no positions say it
  std::optional<double> orientation = {};
  bool is_global = false;       ///< the orientation is on the map, not to the tangent
  std::vector<Point> via = {};  ///< the control points of its trajectory
};

struct Order {
  std::string id;
  std::uint32_t update_id = 0;
  std::string zone_set_id = {};
  std::vector<NodeLeg> nodes = {};
  std::vector<EdgeLeg> edges = {};
  Leg decision_point = {};     ///< the last node of the base
  std::size_t edge_count = 0;  ///< when it was accepted
  bool is_cancelled = false;

  [[nodiscard]] bool Active() const { return !nodes.empty() || !edges.empty(); }
};

struct RobotState {
  std::string operating_mode = "AUTOMATIC";
  Order order;
  std::string last_node_id;
  std::uint32_t last_node_sequence_id = 0;
  bool paused = false;
  bool charging = false;
  bool driving = false;
  bool new_base_request = false;
  std::optional<double> distance_since_last_node = {};
  double battery = 80;                       ///< per cent
  std::string_view emergency_stop = "NONE";  ///< who must acknowledge it, as the version says it
  bool field_violation = false;
  Position position;
  /// Whether somebody said where it is. Otherwise it is where its first order begins.
  bool is_placed = false;
  double speed = 0;        ///< m/s, while it is driving
  double speed_angle = 0;  ///< of its way, to its heading
  std::vector<Load> loads = {};
  std::vector<Map> maps = {{"map-1", "1", true}};
  std::vector<ZoneSet> zone_sets;
  std::vector<OrderAction> order_actions;  ///< in the order in which it comes to them
  std::vector<ActionState> instant_actions;
  std::vector<RobotError> errors;
  std::vector<Request> requests;  ///< for the active order
  std::uint32_t requests_made = 0;

  /// Safety or an error holds it (3.0: CRITICAL and FATAL, before that FATAL).
  [[nodiscard]] bool IsHeld() const {
    return emergency_stop != "NONE" || field_violation ||
           std::any_of(errors.begin(), errors.end(),
                       [](const RobotError& error) { return error.StopsDriving(); });
  }
  [[nodiscard]] bool IsAutomatic() const {
    return operating_mode == "AUTOMATIC" || operating_mode == "SEMIAUTOMATIC";
  }
  [[nodiscard]] bool MayDrive() const {
    return !paused && !IsHeld() && IsAutomatic() &&
           std::all_of(requests.begin(), requests.end(),
                       [](const Request& request) { return request.status == "GRANTED"; });
  }
  [[nodiscard]] bool HasOpenActions() const {
    return std::any_of(order_actions.begin(), order_actions.end(),
                       [](const OrderAction& action) { return !IsEnded(action.status); });
  }
  /// There is something to cancel.
  [[nodiscard]] bool HasWork() const { return order.Active() || HasOpenActions(); }
};

/// It is there, and has the map of the place.
void PlaceAt(Position position, RobotState& state);

/// In the place of an error that says the same; of too many, the oldest goes.
void AddError(RobotState& state, RobotError error);
void ForgetErrors(RobotState& state, Until until);

/// Ends the order at once (1.1–2.1 §6.6.3, 3.0 §6.1.3): orderId and orderUpdateId stay.
void GiveUpOrder(RobotState& state);

}  // namespace fleetpub::simulator
