// How one vehicle may move through a layout: along which edges, with which headings, and which edge
// may follow which (LIF 1.0 §8, §10; 2.0 §8.3).
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "layout/layout.h"

namespace fleetpub::layout {

struct Vehicle {
  std::string_view type;
  bool loaded = false;
  std::string_view load_set;  ///< "": not said
};

/// Why a vehicle may not drive an edge.
enum class Barrier { kNone, kType, kStartType, kEndType, kLoad, kNodeLoad, kSpeed };

/// An edge, driven with one of its orientations.
struct Arc {
  std::size_t edge = 0;
  std::size_t start = 0;  ///< nodes
  std::size_t end = 0;
  const EdgeProperties* properties = nullptr;  ///< null: there are none for the type
  std::optional<double> orientation = {};
  std::optional<double> start_heading = {};  ///< rad; nothing: any
  std::optional<double> end_heading = {};
  std::optional<double> theta = {};  ///< in which it stands on the end node
  Barrier barrier = Barrier::kNone;

  /// In which the vehicle is, once it is on the end node.
  [[nodiscard]] std::optional<double> Arrived() const { return theta ? theta : end_heading; }
};

/// Of every edge one for each orientation, in the order of the edges; with those that are barred.
[[nodiscard]] std::vector<Arc> ListArcs(const Site& site, const Vehicle& vehicle);

/// Whether a vehicle may stop on the arc's end node: turned as the node wants it.
[[nodiscard]] bool CanEnd(const Arc& arc);

/// Whether one arc may follow another at a node. The heading is turned there only as far as both
/// allow, or along the second one.
[[nodiscard]] bool CanFollow(const Arc& from, const Arc& to);

/// The same for a vehicle that stands there with a heading.
[[nodiscard]] bool CanStart(std::optional<double> heading, const Arc& arc);

/// Whether distances between two nodes mean something: they are on one map of one origin.
[[nodiscard]] bool ShareMap(const Site& site, const Node& a, const Node& b);

/// Whether the restriction admits the vehicle.
[[nodiscard]] bool Admits(const LoadRestriction& load, const Vehicle& vehicle);

}  // namespace fleetpub::layout
