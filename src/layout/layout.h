// A layout: where nodes, edges and stations are, and which vehicle types may use them, as files of
// the Layout Interchange Format (LIF, VDMA) say. One graph, whatever the file's version: readers
// translate into it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/json.h"
#include "base/result.h"

namespace fleetpub::layout {

/// LIF 1.0 §8 `requirementType`.
enum class Requirement { kRequired, kConditional, kOptional };

struct ActionParameter {
  std::string key;
  std::string value;     ///< 1.0 has texts only: the factsheet's valueDataType says what is meant
  bool is_json = false;  ///< of 2.0: the value is JSON, and sent as it is
};

/// What a vehicle does on a node or an edge.
struct LayoutAction {
  std::string type;
  std::string description;
  Requirement requirement = Requirement::kOptional;
  std::string blocking_type;  ///< NONE, SOFT, HARD, SINGLE
  std::vector<ActionParameter> parameters;
};

/// Which loads may be carried along an edge, from 2.0 also over a node.
struct LoadRestriction {
  bool unloaded = true;
  bool loaded = true;
  std::vector<std::string> load_sets;  ///< when loaded; empty: any

  friend bool operator==(const LoadRestriction&, const LoadRestriction&) = default;
};

/// From 2.0: between which an order's allowedDeviationXY may lie, m; its theta is said, rad.
struct DeviationRange {
  double a_minimum = 0;
  std::optional<double> a_maximum;
  double b_minimum = 0;
  std::optional<double> b_maximum;
  double theta = 0;
};

struct NodeProperties {
  std::string vehicle_type;
  std::optional<double> theta;  ///< rad, heading on the node
  std::vector<LayoutAction> actions;
  LoadRestriction load;
  std::vector<std::string> forbidden_actions;  ///< from 2.0
  std::optional<DeviationRange> deviation;
};

struct Node {
  std::string id;
  std::string name;
  std::string description;
  std::string map_id;
  double x = 0;  ///< m
  double y = 0;
  std::vector<NodeProperties> properties;
  std::size_t layout = 0;   ///< index into Site::layouts
  std::uint32_t index = 0;  ///< in the file's array

  /// Null: vehicles of this type do not use it.
  [[nodiscard]] const NodeProperties* Find(std::string_view vehicle_type) const;
};

struct ControlPoint {
  double x = 0;
  double y = 0;
  double weight = 1;

  friend bool operator==(const ControlPoint&, const ControlPoint&) = default;
};

/// A NURBS curve, clamped: it begins at its first point and ends at its last one.
struct Trajectory {
  int degree = 1;
  std::vector<double> knots;
  std::vector<ControlPoint> points;

  friend bool operator==(const Trajectory&, const Trajectory&) = default;
};

/// From 2.0: how wide an order's corridor may be, m.
struct CorridorLimits {
  double left = 0;
  double right = 0;
};

/// Which way a vehicle may turn on the spot.
enum class Turning { kBoth, kNone, kCcw, kCw };

struct EdgeProperties {
  std::string vehicle_type;
  std::optional<double> orientation;       ///< rad; nothing: any
  std::vector<double> other_orientations;  ///< from 2.0: one of which may be chosen instead
  bool is_tangential = true;               ///< the orientation is relative to the path, else global
  bool rotation_allowed = false;           ///< while driving along it
  Turning turning_at_start = Turning::kBoth;
  Turning turning_at_end = Turning::kBoth;
  std::optional<double> max_speed;           ///< m/s
  std::optional<double> max_rotation_speed;  ///< rad/s
  std::optional<double> min_height;          ///< m
  std::optional<double> max_height;
  LoadRestriction load;
  std::vector<LayoutAction> actions;
  std::optional<Trajectory> trajectory;
  /// A vehicle that stands on it may be taken over; driving is not meant.
  bool reentry_allowed = true;
  std::vector<std::string> forbidden_actions;  ///< from 2.0, as the next three
  std::optional<CorridorLimits> corridor;
  std::string line_direction;         ///< of a vehicle that follows a line
  std::optional<double> line_length;  ///< m
};

struct Edge {
  std::string id;
  std::string name;
  std::string description;
  std::size_t start = 0;  ///< index into Site::nodes
  std::size_t end = 0;
  std::vector<EdgeProperties> properties;
  std::size_t layout = 0;
  std::uint32_t index = 0;  ///< in the file's array

  [[nodiscard]] const EdgeProperties* Find(std::string_view vehicle_type) const;
};

struct StationPosition {
  double x = 0;
  double y = 0;
  std::optional<double> theta;
};

struct Station {
  std::string id;
  std::string name;
  std::string type;  ///< from 2.0
  std::string description;
  std::vector<std::size_t> nodes;  ///< where a vehicle interacts with it
  std::optional<double> height;    ///< m; nothing: not said
  std::optional<StationPosition> position;
  std::size_t layout = 0;
  std::uint32_t index = 0;  ///< in the file's array
};

/// One of the layouts of a file: a level or a part of one.
struct Layout {
  std::string id;
  std::string name;
  std::string version;
  std::string level;
  std::string description;
  std::string origin;  ///< from 2.0 the id of its origin of coordinates; before, all share one
  std::string place;   ///< the JSON pointer to it
};

/// All that one file describes.
struct Site {
  std::string project;  ///< from 2.0 `lifId`
  std::string creator;
  std::string exported;     ///< as written
  std::string lif_version;  ///< as written
  std::vector<Layout> layouts;
  std::vector<Node> nodes;
  std::vector<Edge> edges;
  std::vector<Station> stations;

  [[nodiscard]] std::optional<std::size_t> FindNode(std::string_view id) const;
  /// By id, else by name where only one has that name.
  [[nodiscard]] const Station* FindStation(std::string_view word) const;
  /// Each once, in the order in which they first appear.
  [[nodiscard]] std::vector<std::string> VehicleTypes() const;
};

/// Something wrong or odd in a layout file.
struct LayoutFinding {
  enum class Level { kError, kWarning };
  Level level = Level::kError;
  std::string place;  ///< a JSON pointer: `/layouts/0/nodes/3/nodePosition`
  std::string text;
};

/// The JSON pointer to an element: a node, an edge, a station.
template <class Element>
[[nodiscard]] std::string FormatPlace(const Site& site, std::string_view array,
                                      const Element& element) {
  return site.layouts[element.layout].place + "/" + std::string(array) + "/" +
         std::to_string(element.index);
}

/// What a file holds, read leniently: what can be used is read, the rest becomes findings. Nothing is
/// driven that is not understood: an edge is not there for a type whose property is faulty. Errors:
/// ErrorKind::kInvalid: no JSON, no layout at all.
struct ReadSite {
  Site site;
  std::vector<LayoutFinding> findings;
};
[[nodiscard]] Result<ReadSite> ReadLayout(std::string_view text);

/// The same from a file (`-`: standard input). Errors: also kLedger (cannot be read); they name it.
[[nodiscard]] Result<ReadSite> ReadLayoutFile(const std::string& file);

}  // namespace fleetpub::layout
