// What a virtual robot knows of itself; what its `state` messages are made of.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/time.h"

namespace fleetpub::simulator {

enum class ActionStatus { kWaiting, kInitializing, kRunning, kRetriable, kFinished, kFailed };

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
enum class Until { kNextInstantAction, kNextOrder, kCleared, kEnd };

struct RobotError {
  std::string type;
  std::string description;
  std::vector<std::pair<std::string, std::string>> references;  ///< key, value
  Until until = Until::kNextInstantAction;
  std::string_view level = "WARNING";
};

/// What is still to be travelled of an order.
struct Leg {
  std::string id;
  std::uint32_t sequence_id = 0;
  bool released = true;
};

struct Order {
  std::string id;
  std::uint32_t update_id = 0;
  std::vector<Leg> nodes;
  std::vector<Leg> edges;

  [[nodiscard]] bool Active() const { return !nodes.empty() || !edges.empty(); }
};

struct RobotState {
  std::string operating_mode = "AUTOMATIC";
  Order order;
  std::string last_node_id;
  std::uint32_t last_node_sequence_id = 0;
  bool paused = false;
  bool charging = false;
  std::uint32_t battery = 80;                ///< per cent
  std::string_view emergency_stop = "NONE";  ///< who must acknowledge it, as the version says it
  bool field_violation = false;
  Position position;
  std::vector<Map> maps = {{"map-1", "1", true}};
  std::vector<ZoneSet> zone_sets;
  std::vector<ActionState> order_actions;
  std::vector<ActionState> instant_actions;
  std::vector<RobotError> errors;
  std::vector<Request> requests;  ///< for the active order
  std::uint32_t requests_made = 0;

  /// Safety or an error holds it (3.0: CRITICAL and FATAL, before that FATAL).
  [[nodiscard]] bool IsHeld() const {
    return emergency_stop != "NONE" || field_violation ||
           std::any_of(errors.begin(), errors.end(), [](const RobotError& error) {
             return error.level == "FATAL" || error.level == "CRITICAL";
           });
  }
  [[nodiscard]] bool MayDrive() const {
    return !IsHeld() && std::all_of(requests.begin(), requests.end(), [](const Request& request) {
      return request.status == "GRANTED";
    });
  }
  [[nodiscard]] bool Driving() const { return order.Active() && !paused && MayDrive(); }
};

}  // namespace fleetpub::simulator
