// The way of an order: from words, a route over a layout or the rows of a file (app/path_file) to nodes and edges
// with their actions.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "layout/layout.h"
#include "layout/route.h"
#include "vda5050/messages/order.h"
#include "vda5050/model/robot_address.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::app {

/// An action at a node, an edge or a station of the way: `pick@dock-3 loadType=EPAL`.
struct PlacedAction {
  std::string type;
  std::string place;
  std::vector<vda5050::Parameter> parameters;
};

/// A row of a file of nodes.
struct PathPoint {
  std::string node;
  std::optional<vda5050::OrderPosition> position;
  std::vector<PlacedAction> actions;
};

struct PathRequest {
  /// One of these three.
  std::vector<std::string> nodes;  ///< ids, or stations of the layout
  std::vector<PathPoint> points;
  std::vector<std::string> stops;  ///< of a route; the last one is its end

  std::string from;  ///< where a route begins; "": where the robot is
  std::vector<PlacedAction> actions;
  std::string blocking_type;  ///< of these; "": as the layout says, else HARD
  std::string vehicle_type;   ///< of the layout; "": the robot's own, or the only one
  bool loaded = false;        ///< else as the robot says
  std::string load_set;
  layout::RouteCost cost = layout::RouteCost::kLength;
  std::optional<double> deviation_xy;  ///< of nodes that have a position, m
  std::optional<double> deviation_theta;
};

/// What the way depends on, of the robot.
struct PathRobot {
  vda5050::RobotAddress address;
  const vda5050::Factsheet* factsheet = nullptr;  ///< may be null
  const vda5050::RobotState* state = nullptr;     ///< a live one; may be null
  /// Where the way begins: the robot's last node, or the end of what it drives already; "": not known.
  std::string start;
  bool is_checked = true;  ///< refuse where its position is against it
  bool continues = false;  ///< it begins where an order ends, not where the robot is
};

struct PlannedPath {
  vda5050::OrderPath path;
  std::optional<double> length;       ///< m; nothing: some place is not known
  std::vector<std::string> warnings;  ///< one line each
};

/// `site` may be null: there is no layout. Errors: ErrorKind::kUsage (a place that is none, an action
/// whose place is not on the way), kPreflight (no route, the robot is elsewhere).
[[nodiscard]] Result<PlannedPath> PlanPath(const PathRequest& request, const layout::Site* site,
                                           const PathRobot& robot);

/// `n1 → n4 → dock-3, 23.4 m, 2 actions`.
[[nodiscard]] std::string DescribePath(const PlannedPath& planned);

}  // namespace fleetpub::app
