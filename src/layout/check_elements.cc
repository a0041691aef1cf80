#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <unordered_map>

#include "base/text.h"
#include "layout/check.h"
#include "layout/navigation.h"
#include "layout/route.h"

namespace fleetpub::layout {
namespace {

using base::Printable;

class ElementChecker {
 public:
  ElementChecker(const Site& site, std::vector<LayoutFinding>& findings)
      : site_(site), findings_(findings) {}

  void Check() {
    for (const Edge& edge : site_.edges) CheckEdge(edge);
    CheckParallel();
    CheckPlaces();
    CheckMaps();
    for (const Station& station : site_.stations) CheckStation(station);
  }

 private:
  void Warn(std::string place, std::string text) {
    findings_.push_back({LayoutFinding::Level::kWarning, std::move(place), std::move(text)});
  }
  [[nodiscard]] std::string PlaceOfEdge(const Edge& edge) const {
    return FormatPlace(site_, "edges", edge);
  }

  void CheckEdge(const Edge& edge) {
    const Node& start = site_.nodes[edge.start];
    const Node& end = site_.nodes[edge.end];
    if (edge.start == edge.end) {
      Warn(PlaceOfEdge(edge), fmt::format("starts and ends at {}", Printable(start.id)));
    }
    bool has_length = edge.start == edge.end || !ShareMap(site_, start, end);
    for (const EdgeProperties& properties : edge.properties) {
      has_length = has_length || EdgeLength(site_, edge, properties) > 1e-6;
      for (const Node* const node : {&start, &end}) {
        if (node->Find(properties.vehicle_type) != nullptr) continue;
        Warn(PlaceOfEdge(edge),
             fmt::format("is for vehicles of type {}, and node {} is not: they cannot use it",
                         Printable(properties.vehicle_type), Printable(node->id)));
      }
      CheckTrajectory(edge, properties);
    }
    if (!has_length && !edge.properties.empty()) {
      Warn(PlaceOfEdge(edge), fmt::format("has no length: {} and {} are in one place",
                                          Printable(start.id), Printable(end.id)));
    }
  }

  void CheckTrajectory(const Edge& edge, const EdgeProperties& properties) {
    if (!properties.trajectory) return;
    const Node& start = site_.nodes[edge.start];
    const Node& end = site_.nodes[edge.end];
    const auto check = [&](const ControlPoint& point, const Node& node, std::string_view word) {
      constexpr double kTolerance = 0.05;
      const double distance = std::hypot(point.x - node.x, point.y - node.y);
      if (distance <= kTolerance) return;
      Warn(PlaceOfEdge(edge), fmt::format("its trajectory {} {:.2f} m off node {}", word, distance,
                                          Printable(node.id)));
    };
    check(properties.trajectory->points.front(), start, "begins");
    if (ShareMap(site_, start, end)) check(properties.trajectory->points.back(), end, "ends");
  }

  static bool AreAlike(const EdgeProperties& a, const EdgeProperties& b) {
    const auto key = [](const EdgeProperties& p) {
      return std::tie(p.orientation, p.other_orientations, p.is_tangential, p.rotation_allowed,
                      p.turning_at_start, p.turning_at_end, p.max_speed, p.max_rotation_speed,
                      p.min_height, p.max_height, p.load, p.trajectory, p.line_direction);
    };
    const auto has_actions = !a.actions.empty() || !b.actions.empty();
    return key(a) == key(b) && !has_actions;
  }

  void CheckParallel() {
    std::map<std::pair<std::size_t, std::size_t>, std::vector<const Edge*>> bundles;
    for (const Edge& edge : site_.edges) bundles[{edge.start, edge.end}].push_back(&edge);
    constexpr std::size_t kMost = 100;  // pairs are compared
    for (const auto& [ends, bundle] : bundles) {
      for (std::size_t i = 1; i < bundle.size() && i < kMost; ++i) {
        for (std::size_t j = 0; j < i; ++j) {
          if (ComparePair(*bundle[j], *bundle[i])) break;
        }
      }
    }
  }

  bool ComparePair(const Edge& first, const Edge& second) {
    for (const EdgeProperties& properties : second.properties) {
      const auto* const other = first.Find(properties.vehicle_type);
      if (other == nullptr || !AreAlike(*other, properties)) continue;
      Warn(PlaceOfEdge(second),
           fmt::format("cannot be told from edge {} by vehicles of type {}", Printable(first.id),
                       Printable(properties.vehicle_type)));
      return true;
    }
    return false;
  }

  void CheckPlaces() {
    using Spot = std::tuple<std::string_view, std::string_view, double, double>;
    std::map<Spot, const Node*> spots;
    for (const Node& node : site_.nodes) {
      if (node.properties.empty()) continue;
      const auto to_millimetres = [](double metres) { return std::round(metres * 1000); };
      const Spot spot{site_.layouts[node.layout].origin, node.map_id, to_millimetres(node.x),
                      to_millimetres(node.y)};
      const auto [known, is_new] = spots.emplace(spot, &node);
      if (is_new) continue;
      Warn(FormatPlace(site_, "nodes", node),
           fmt::format("is where node {} is", Printable(known->second->id)));
    }
  }

  // The maps of a layout, and which of them edges join.
  void CheckMaps() {
    std::vector<std::map<std::string_view, std::string_view>> leaders(site_.layouts.size());
    for (const Node& node : site_.nodes) leaders[node.layout].emplace(node.map_id, node.map_id);
    const auto find = [](auto& maps, std::string_view map) {
      while (maps[map] != map) map = maps[map];
      return map;
    };
    for (const Edge& edge : site_.edges) {
      const Node& end = site_.nodes[edge.end];
      auto& maps = leaders[edge.layout];
      if (end.layout != edge.layout || site_.nodes[edge.start].layout != edge.layout) continue;
      maps[find(maps, site_.nodes[edge.start].map_id)] = find(maps, end.map_id);
    }
    for (std::size_t i = 0; i < leaders.size(); ++i) {
      std::set<std::string_view> parts;
      std::vector<std::string> names;
      for (const auto& [map, above] : leaders[i]) {
        if (parts.insert(find(leaders[i], map)).second) names.push_back(Printable(map));
      }
      if (names.size() < 2) continue;
      Warn(site_.layouts[i].place,
           fmt::format("has maps that no edge joins: {}", base::Join(names, ", ")));
    }
  }

  void CheckStation(const Station& station) {
    const std::string place = FormatPlace(site_, "stations", station);
    bool has_action = station.nodes.empty();
    for (const std::size_t index : station.nodes) {
      const Node& node = site_.nodes[index];
      has_action = has_action || std::any_of(node.properties.begin(), node.properties.end(),
                                             [](const auto& p) { return !p.actions.empty(); });
      if (node.layout == station.layout) continue;
      Warn(place, fmt::format("its node {} is in another layout", Printable(node.id)));
    }
    if (!has_action) Warn(place, "no node of it has an action: what is it for?");
  }

  const Site& site_;
  std::vector<LayoutFinding>& findings_;
};

}  // namespace

void CheckElements(const Site& site, std::vector<LayoutFinding>& findings) {
  ElementChecker(site, findings).Check();
}

}  // namespace fleetpub::layout
