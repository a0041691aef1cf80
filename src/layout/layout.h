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
  std::string value;  ///< 1.0 has texts only: the factsheet's valueDataType says what is meant
};

/// What a vehicle does on a node or an edge.
struct LayoutAction {
  std::string type;
  std::string description;
  Requirement requirement = Requirement::kOptional;
  std::string blocking_type;  ///< NONE, SOFT, HARD, SINGLE
  std::vector<ActionParameter> parameters;
};

struct NodeProperties {
  std::string vehicle_type;
  std::optional<double> theta;  ///< rad, heading on the node
  std::vector<LayoutAction> actions;
};

struct Node {
  std::string id;
  std::string name;
  std::string description;
  std::string map_id;
  double x = 0;  ///< m
  double y = 0;
  std::vector<NodeProperties> properties;
  std::size_t layout = 0;  ///< index into Site::layouts

  /// Null: vehicles of this type do not use it.
  [[nodiscard]] const NodeProperties* Find(std::string_view vehicle_type) const;
};

struct ControlPoint {
  double x = 0;
  double y = 0;
  double weight = 1;
};

/// A NURBS curve.
struct Trajectory {
  int degree = 1;
  std::vector<double> knots;
  std::vector<ControlPoint> points;
};

/// Which way a vehicle may turn on the spot.
enum class Turning { kBoth, kNone, kCcw, kCw };

/// Which loads may be carried along an edge.
struct LoadRestriction {
  bool unloaded = true;
  bool loaded = true;
  std::vector<std::string> load_sets;  ///< when loaded; empty: any
};

struct EdgeProperties {
  std::string vehicle_type;
  std::optional<double> orientation;  ///< rad
  bool is_tangential = true;          ///< the orientation is relative to the path, else global
  bool rotation_allowed = false;      ///< while driving along it
  Turning turning_at_start = Turning::kBoth;
  Turning turning_at_end = Turning::kBoth;
  std::optional<double> max_speed;           ///< m/s
  std::optional<double> max_rotation_speed;  ///< rad/s
  std::optional<double> min_height;          ///< m
  std::optional<double> max_height;
  LoadRestriction load;
  std::vector<LayoutAction> actions;
  std::optional<Trajectory> trajectory;
  bool reentry_allowed =
      true;  ///< a vehicle that stands on it may be taken over; driving is not meant
};

struct Edge {
  std::string id;
  std::string name;
  std::string description;
  std::size_t start = 0;  ///< index into Site::nodes
  std::size_t end = 0;
  std::vector<EdgeProperties> properties;
  std::size_t layout = 0;

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
  std::string description;
  std::vector<std::size_t> nodes;  ///< where a vehicle interacts with it
  std::optional<double> height;    ///< m; nothing: not said
  std::optional<StationPosition> position;
  std::size_t layout = 0;
};

/// One of the layouts of a file: a level or a part of one.
struct Layout {
  std::string id;
  std::string name;
  std::string version;
  std::string level;
  std::string description;
};

/// All that one file describes. All layouts share one origin.
struct Site {
  std::string project;
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

/// What a file holds, read leniently: what can be used is read, the rest becomes findings. Errors:
/// ErrorKind::kInvalid: no JSON, no layout at all.
struct ReadSite {
  Site site;
  std::vector<LayoutFinding> findings;
};
[[nodiscard]] Result<ReadSite> ReadLayout(std::string_view text);

/// The same from a file (`-`: standard input). Errors: also kUsage (cannot be read), naming it.
[[nodiscard]] Result<ReadSite> ReadLayoutFile(const std::string& file);

}  // namespace fleetpub::layout
