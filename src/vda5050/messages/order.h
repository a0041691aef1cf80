// Writes orders (VDA 5050 1.1–2.1 §6.6, 3.0 §6.1 and §7.3): nodes and edges in the members of each
// version, as far as the robot's factsheet says that it takes them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/json.h"
#include "base/result.h"
#include "vda5050/messages/instant_actions.h"
#include "vda5050/model/version.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::vda5050 {

/// Lengths in m, angles in rad.
struct OrderPosition {
  double x = 0;
  double y = 0;
  std::optional<double> theta;
  std::string map_id;
  std::optional<double> deviation_xy;  ///< a radius
  std::optional<double> deviation_theta;
};

struct OrderNode {
  std::string id;
  std::string description;
  std::optional<OrderPosition> position;
  std::vector<InstantAction> actions;
};

struct OrderControlPoint {
  double x = 0;
  double y = 0;
  double weight = 1;
};

/// A NURBS curve.
struct OrderTrajectory {
  int degree = 1;
  std::vector<double> knots;
  std::vector<OrderControlPoint> points;
};

struct OrderEdge {
  std::string id;
  std::string description;
  std::optional<double> max_speed;           ///< m/s
  std::optional<double> max_rotation_speed;  ///< rad/s
  std::optional<double> max_height;          ///< m, of the robot
  std::optional<double> min_height;          ///< m, of its load handling device
  std::optional<double> orientation;         ///< rad
  bool is_tangential = true;                 ///< relative to the path, else global
  std::optional<bool> rotation_allowed;
  std::optional<double> length;   ///< m
  std::optional<double> heading;  ///< rad, of the straight line between its nodes; not sent
  std::optional<OrderTrajectory> trajectory;
  std::vector<InstantAction> actions;
};

/// What lies ahead, node by node: one edge less than nodes.
struct OrderPath {
  std::vector<OrderNode> nodes;
  std::vector<OrderEdge> edges;
};

/// A member of nodes or edges that the specification leaves to the robot.
struct OrderMember {
  std::string_view list;  ///< `order.nodes`, `order.nodes.nodePosition`, `order.edges`
  std::string_view key;   ///< its name in 2.1: as it is called here
  std::array<std::string_view, kVersions.size()> names;  ///< in each version; "": it has none
  bool is_binding;  ///< without it the order would be another one
};

/// All that are written, for help and completion.
[[nodiscard]] std::span<const OrderMember> OrderMembers();

/// Writes nodes and edges for one robot.
class OrderWriter {
 public:
  /// `factsheet` may be null: then everything is taken. `without`: members that are left out, by
  /// any version's name (`maxSpeed`). The factsheet must outlive the writer.
  OrderWriter(Version version, const Factsheet* factsheet, std::set<std::string> without = {});

  [[nodiscard]] std::string WriteNode(const OrderNode& node, std::uint32_t sequence_id,
                                      bool released);
  /// `start` and `end`: the ids of its nodes.
  [[nodiscard]] std::string WriteEdge(const OrderEdge& edge, std::uint32_t sequence_id,
                                      bool released, std::string_view start, std::string_view end);

  /// Members that the robot does not take and that were left out, each once: `order.nodes.x`.
  [[nodiscard]] const std::set<std::string>& left_out() const { return left_out_; }
  /// Why the order cannot be written for this robot, each once.
  [[nodiscard]] const std::vector<std::string>& refusals() const { return refusals_; }

 private:
  void Add(std::string& json, std::string_view key, const std::string& value, std::string_view of);
  void Add(std::string& json, std::string_view key, const std::optional<double>& value,
           std::string_view of);
  void AddPosition(std::string& json, const OrderNode& node);
  void AddOrientation(std::string& json, const OrderEdge& edge);
  void AddTrajectory(std::string& json, const OrderEdge& edge);
  void CheckRequired(std::string_view list, std::string_view of);
  [[nodiscard]] std::string WriteActions(std::span<const InstantAction> actions,
                                         std::string_view scope, std::string_view of);
  void CheckAction(const InstantAction& action, std::string_view scope, std::string_view of);
  void CheckId(std::string_view id, std::string_view of);
  void Refuse(std::string reason);

  Version version_;
  const Factsheet* factsheet_;
  std::set<std::string> without_;
  std::set<std::string, std::less<>> written_;  // of the node or edge in hand
  std::set<std::string> left_out_;
  std::vector<std::string> refusals_;
};

/// What the factsheet limits of an order of these sizes; "": nothing is against it. `base`: nodes
/// that are released.
[[nodiscard]] std::string CheckOrderLimits(const Factsheet& factsheet, std::size_t nodes,
                                           std::size_t edges, std::size_t base);

/// One order message without header, for BuildUserMessage. `nodes` and `edges` are JSON texts.
[[nodiscard]] base::JsonDocument MakeOrder(std::string_view order_id, std::uint32_t update_id,
                                           std::string_view zone_set_id,
                                           std::span<const std::string> nodes,
                                           std::span<const std::string> edges);

/// A text of a layout as the value that the robot's factsheet says (`valueDataType`): JSON.
[[nodiscard]] std::string ToParameterValue(const Factsheet* factsheet, std::string_view action_type,
                                           std::string_view key, std::string_view text);

}  // namespace fleetpub::vda5050
