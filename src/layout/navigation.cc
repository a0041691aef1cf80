#include "layout/navigation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "layout/curve.h"
#include "layout/route.h"

namespace fleetpub::layout {
namespace {

constexpr double kAlike = 2 * std::numbers::pi / 180;  // files round what they say

bool IsAlike(std::optional<double> a, std::optional<double> b) {
  return !a || !b || std::abs(std::remainder(*a - *b, 2 * std::numbers::pi)) < kAlike;
}

// NONE wins, and the two directions leave none (LIF 1.0 §8.3.11.1).
bool MayTurn(Turning a, Turning b) {
  if (a == Turning::kNone || b == Turning::kNone) return false;
  return a == b || a == Turning::kBoth || b == Turning::kBoth;
}

struct Tangents {
  std::optional<double> start;
  std::optional<double> end;
};

Tangents FindTangents(const Site& site, const Edge& edge, const EdgeProperties& properties) {
  if (properties.trajectory) {
    return {StartTangent(*properties.trajectory), EndTangent(*properties.trajectory)};
  }
  const Node& a = site.nodes[edge.start];
  const Node& b = site.nodes[edge.end];
  const bool is_point = a.x == b.x && a.y == b.y;
  if (is_point || !ShareMap(site, a, b)) return {};
  const double angle = std::atan2(b.y - a.y, b.x - a.x);
  return {angle, angle};
}

std::optional<double> Heading(std::optional<double> tangent, std::optional<double> orientation,
                              bool is_tangential) {
  if (!orientation || (is_tangential && !tangent)) return std::nullopt;
  return std::remainder(*orientation + (is_tangential ? *tangent : 0), 2 * std::numbers::pi);
}

Barrier FindBarrier(const Node& start, const Node& end, const EdgeProperties* properties,
                    const Vehicle& vehicle) {
  const auto* const from = start.Find(vehicle.type);
  const auto* const to = end.Find(vehicle.type);
  if (properties == nullptr) return Barrier::kType;
  if (from == nullptr) return Barrier::kStartType;
  if (to == nullptr) return Barrier::kEndType;
  if (!Admits(properties->load, vehicle)) return Barrier::kLoad;
  if (!Admits(from->load, vehicle) || !Admits(to->load, vehicle)) return Barrier::kNodeLoad;
  return properties->max_speed == 0.0 ? Barrier::kSpeed : Barrier::kNone;
}

}  // namespace

bool ShareMap(const Site& site, const Node& a, const Node& b) {
  return a.map_id == b.map_id && site.layouts[a.layout].origin == site.layouts[b.layout].origin;
}

bool Admits(const LoadRestriction& load, const Vehicle& vehicle) {
  if (!vehicle.loaded) return load.unloaded;
  if (!load.loaded) return false;
  return load.load_sets.empty() || std::find(load.load_sets.begin(), load.load_sets.end(),
                                             vehicle.load_set) != load.load_sets.end();
}

std::vector<Arc> ListArcs(const Site& site, const Vehicle& vehicle) {
  std::vector<Arc> arcs;
  arcs.reserve(site.edges.size());
  for (std::size_t i = 0; i < site.edges.size(); ++i) {
    const Edge& edge = site.edges[i];
    const Node& end = site.nodes[edge.end];
    Arc arc{.edge = i, .start = edge.start, .end = edge.end};
    arc.properties = edge.Find(vehicle.type);
    arc.barrier = FindBarrier(site.nodes[edge.start], end, arc.properties, vehicle);
    if (const auto* const there = end.Find(vehicle.type)) arc.theta = there->theta;
    if (arc.properties == nullptr) {
      arcs.push_back(arc);
      continue;
    }
    const Tangents tangents = FindTangents(site, edge, *arc.properties);
    const auto add = [&](std::optional<double> orientation) {
      const bool is_tangential = arc.properties->is_tangential;
      arc.orientation = orientation;
      arc.start_heading = Heading(tangents.start, orientation, is_tangential);
      arc.end_heading = Heading(tangents.end, orientation, is_tangential);
      arcs.push_back(arc);
    };
    add(arc.properties->orientation);
    for (const double other : arc.properties->other_orientations) add(other);
  }
  return arcs;
}

bool CanEnd(const Arc& arc) {
  if (arc.properties == nullptr || arc.properties->turning_at_end != Turning::kNone) return true;
  return IsAlike(arc.end_heading, arc.theta);
}

bool CanFollow(const Arc& from, const Arc& to) {
  if (from.properties == nullptr || to.properties == nullptr) return true;
  if (MayTurn(from.properties->turning_at_end, to.properties->turning_at_start)) return true;
  if (!IsAlike(from.end_heading, from.theta)) return false;
  return to.properties->rotation_allowed || IsAlike(from.Arrived(), to.start_heading);
}

bool CanStart(std::optional<double> heading, const Arc& arc) {
  if (arc.properties == nullptr || arc.properties->rotation_allowed ||
      arc.properties->turning_at_start != Turning::kNone) {
    return true;
  }
  return IsAlike(heading, arc.start_heading);
}

double EdgeLength(const Site& site, const Edge& edge, const EdgeProperties& properties) {
  const Node& a = site.nodes[edge.start];
  const Node& b = site.nodes[edge.end];
  if (!ShareMap(site, a, b)) return 0;
  if (properties.trajectory) return CurveLength(*properties.trajectory);
  if (properties.line_length) return *properties.line_length;
  return std::hypot(b.x - a.x, b.y - a.y);
}

}  // namespace fleetpub::layout
