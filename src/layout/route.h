// The cheapest way through a layout for one vehicle (LIF 1.0 §10). What may follow an edge depends
// on the heading with which it is left, so a state of the search is an edge with its heading, not a
// node. Headings that differ by less than 2° are one.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/choice.h"
#include "base/result.h"
#include "layout/layout.h"

namespace fleetpub::layout {

enum class RouteCost { kLength, kTime };
inline constexpr auto kRouteCosts = std::to_array<base::Choice<RouteCost>>({
    {"length", RouteCost::kLength},
    {"time", RouteCost::kTime},
});

struct RouteRequest {
  std::string vehicle_type;  ///< LIF `vehicleTypeId`
  bool loaded = false;
  std::string load_set;  ///< of the load; "": not said
  RouteCost cost = RouteCost::kLength;
  /// Where an edge says nothing, or more (m/s): the vehicle's own. Only for kTime.
  std::optional<double> vehicle_speed;
  std::size_t from = 0;                ///< index into Site::nodes
  std::optional<double> heading = {};  ///< rad, in which the vehicle stands there
  /// The stops in their order, each one of some nodes: a station has several. The last is the end.
  std::vector<std::vector<std::size_t>> stops;
};

struct RouteEdge {
  std::size_t edge = 0;  ///< index into Site::edges
  double length = 0;     ///< m; between maps 0
  double seconds = 0;    ///< with RouteRequest::vehicle_speed, else 1 m/s where nothing limits it
  /// Which of its orientations (EdgeProperties) is driven; nothing: any.
  std::optional<double> orientation;
  double heading = 0;  ///< rad, once its end node is reached; meaningless without `has_heading`
  bool has_heading = false;
};

struct Route {
  std::vector<std::size_t> nodes;  ///< indices into Site::nodes; one more than edges
  std::vector<RouteEdge> edges;
  std::vector<std::size_t> stops;  ///< positions in `nodes` at which the stops are reached
  double length = 0;               ///< m
  double seconds = 0;
};

/// Errors: ErrorKind::kPreflight, with the nearest reason (`n7 is not for vehicles of type T`, `only
/// loaded`, `no edge leaves n7`).
[[nodiscard]] Result<Route> FindRoute(const Site& site, const RouteRequest& request);

/// The length of an edge for a type: along its trajectory, else straight, m; between maps 0.
[[nodiscard]] double EdgeLength(const Site& site, const Edge& edge,
                                const EdgeProperties& properties);

/// The nodes that a word means: a node's id, else those of a station (id or name). Errors:
/// ErrorKind::kUsage, with near names.
[[nodiscard]] Result<std::vector<std::size_t>> ResolvePlace(const Site& site,
                                                            std::string_view word);

/// The vehicle type meant: `asked`, else `suggested` (manufacturer.seriesName) when the layout has
/// it, else the only one. Errors: ErrorKind::kUsage, listing them.
[[nodiscard]] Result<std::string> ChooseVehicleType(const Site& site, std::string_view asked,
                                                    std::string_view suggested);

}  // namespace fleetpub::layout
