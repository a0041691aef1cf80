#include "layout/route.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/text.h"
#include "layout/route_search.h"

namespace fleetpub::layout {
namespace {

using base::Printable;

std::string Listed(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 6;
  std::vector<std::string> shown;
  for (std::size_t i = 0; i < names.size() && i < kMost; ++i) shown.push_back(Printable(names[i]));
  if (names.size() > kMost) shown.push_back(fmt::format("{} more", names.size() - kMost));
  return base::Join(shown, ", ");
}

template <class Element>
std::string OnlyFor(const Element& element) {
  std::vector<std::string> types;
  for (const auto& properties : element.properties) types.push_back(properties.vehicle_type);
  return types.empty() ? ", nor of any other" : fmt::format(", only of {}", Listed(types));
}

std::string NotForType(const Node& node, std::string_view type) {
  return fmt::format("{} is not for vehicles of type {}{}", Printable(node.id), Printable(type),
                     OnlyFor(node));
}

std::string NotForLoad(std::string_view what, const LoadRestriction& load,
                       const RouteRequest& request) {
  if (!load.unloaded && !load.loaded) return fmt::format("{} admits no vehicle", what);
  if (!request.loaded) return fmt::format("{} is only for loaded vehicles", what);
  if (!load.loaded) return fmt::format("{} is only for unloaded vehicles", what);
  return fmt::format("{} is only for loads of the set {}{}", what, Listed(load.load_sets),
                     request.load_set.empty() ? ", and it is not said which one is carried" : "");
}

// Says what is in the way, once there is no way.
class Explainer {
 public:
  Explainer(const Site& site, const RouteRequest& request)
      : site_(site), request_(request), search_(site, request, RouteSearch::Obstacles::kCost) {}

  std::string Explain() {
    const auto way = search_.Run();
    if (!way) return DescribeGap();
    std::string first;
    std::size_t count = 0;
    for (std::size_t i = 0; i < way->size(); ++i) {
      const std::string obstacle =
          Describe(i == 0 ? nullptr : &search_.arc((*way)[i - 1]), (*way)[i]);
      if (obstacle.empty()) continue;
      if (count++ == 0) first = obstacle;
    }
    if (count > 1) first += fmt::format("; {} more in the way", count - 1);
    return first;
  }

 private:
  [[nodiscard]] std::string EdgeName(const Arc& arc) const {
    return fmt::format("edge {}", Printable(site_.edges[arc.edge].id));
  }
  [[nodiscard]] std::string NodeName(std::size_t node) const {
    return Printable(site_.nodes[node].id);
  }

  [[nodiscard]] std::string DescribeBarrier(const Arc& arc) const {
    const Edge& edge = site_.edges[arc.edge];
    const Node& start = site_.nodes[arc.start];
    const Node& end = site_.nodes[arc.end];
    switch (arc.barrier) {
      case Barrier::kNone:
        return "";
      case Barrier::kType:
        return fmt::format("{} is not for vehicles of type {}{}", EdgeName(arc),
                           Printable(request_.vehicle_type), OnlyFor(edge));
      case Barrier::kStartType:
        return NotForType(start, request_.vehicle_type);
      case Barrier::kEndType:
        return NotForType(end, request_.vehicle_type);
      case Barrier::kLoad:
        return NotForLoad(EdgeName(arc), arc.properties->load, request_);
      case Barrier::kNodeLoad: {
        const Vehicle vehicle{request_.vehicle_type, request_.loaded, request_.load_set};
        const auto* const there = start.Find(vehicle.type);
        const Node& node = Admits(there->load, vehicle) ? end : start;
        return NotForLoad(Printable(node.id), node.Find(vehicle.type)->load, request_);
      }
      case Barrier::kSpeed:
        return fmt::format("the speed on {} is 0", EdgeName(arc));
    }
    return "";
  }

  [[nodiscard]] std::string Describe(const Arc* before, std::size_t index) const {
    const Arc& arc = search_.arc(index);
    if (search_.IsReversed(index)) {
      return fmt::format("{} leads only from {} to {}", EdgeName(arc), NodeName(arc.end),
                         NodeName(arc.start));
    }
    if (std::string text = DescribeBarrier(arc); !text.empty()) return text;
    if (before != nullptr && !CanFollow(*before, arc)) {
      return fmt::format("who comes to {} along {} may not turn there for {}", NodeName(arc.start),
                         EdgeName(*before), EdgeName(arc));
    }
    if (before == nullptr && !CanStart(request_.heading, arc)) {
      return fmt::format("the vehicle may not turn on {} for {}", NodeName(arc.start),
                         EdgeName(arc));
    }
    if (!CanEnd(arc)) {
      return fmt::format("who comes to {} along {} may not turn there as the node wants it",
                         NodeName(arc.end), EdgeName(arc));
    }
    return "";
  }

  // Not even against the edges.
  [[nodiscard]] std::string DescribeGap() const {
    const auto has_edge = [&](std::size_t node) {
      return std::any_of(site_.edges.begin(), site_.edges.end(),
                         [&](const Edge& edge) { return edge.start == node || edge.end == node; });
    };
    if (!has_edge(request_.from)) return fmt::format("no edge leaves {}", NodeName(request_.from));
    for (const auto& stop : request_.stops) {
      if (std::none_of(stop.begin(), stop.end(), has_edge)) {
        return fmt::format("no edge leads to {}", NodeName(stop.front()));
      }
    }
    return "they lie in parts of the layout that no edge joins";
  }

  const Site& site_;
  const RouteRequest& request_;
  RouteSearch search_;
};

Error NoRoute(const Site& site, const RouteRequest& request, std::string_view why) {
  std::string stops;
  for (const auto& stop : request.stops) {
    stops += fmt::format("{}{}", stops.empty() ? " to " : ", ",
                         stop.empty() ? "nowhere" : Printable(site.nodes[stop.front()].id));
  }
  return {ErrorKind::kPreflight, fmt::format("no route from {}{}: {}",
                                             Printable(site.nodes[request.from].id), stops, why)};
}

// What can be said without a search.
std::string FindSimpleFault(const Site& site, const RouteRequest& request) {
  const Node& from = site.nodes[request.from];
  if (from.Find(request.vehicle_type) == nullptr) return NotForType(from, request.vehicle_type);
  for (const auto& stop : request.stops) {
    const bool is_for_none = std::none_of(stop.begin(), stop.end(), [&](std::size_t node) {
      return site.nodes[node].Find(request.vehicle_type) != nullptr;
    });
    if (!is_for_none) continue;
    return stop.empty() ? "a stop has no node"
                        : NotForType(site.nodes[stop.front()], request.vehicle_type);
  }
  return "";
}

}  // namespace

Result<Route> FindRoute(const Site& site, const RouteRequest& request) {
  if (const std::string fault = FindSimpleFault(site, request); !fault.empty()) {
    return Fail(NoRoute(site, request, fault));
  }
  RouteSearch search(site, request, RouteSearch::Obstacles::kBar);
  const auto way = search.Run();
  if (!way) return Fail(NoRoute(site, request, Explainer(site, request).Explain()));
  Route route;
  std::size_t stop = 0;
  const auto arrive = [&](std::size_t node) {
    route.nodes.push_back(node);
    for (const std::size_t reached = search.Advance(stop, node); stop < reached; ++stop) {
      route.stops.push_back(route.nodes.size() - 1);
    }
  };
  arrive(request.from);
  for (const std::size_t index : *way) {
    const Arc& arc = search.arc(index);
    const auto heading = arc.Arrived();
    route.edges.push_back({.edge = arc.edge,
                           .length = search.Length(index),
                           .seconds = search.Seconds(index),
                           .orientation = arc.orientation,
                           .heading = heading.value_or(0),
                           .has_heading = heading.has_value()});
    route.length += route.edges.back().length;
    route.seconds += route.edges.back().seconds;
    arrive(arc.end);
  }
  return route;
}

Result<std::vector<std::size_t>> ResolvePlace(const Site& site, std::string_view word) {
  if (const auto node = site.FindNode(word)) return std::vector{*node};
  if (const Station* const station = site.FindStation(word)) {
    if (!station->nodes.empty()) return station->nodes;
    return Fail(ErrorKind::kUsage,
                fmt::format("station '{}' has no node to interact from", Printable(word)));
  }
  std::vector<std::string_view> names;
  std::size_t of_this_name = 0;
  for (const Node& node : site.nodes) names.push_back(node.id);
  for (const Station& station : site.stations) {
    names.push_back(station.id);
    if (!station.name.empty()) names.push_back(station.name);
    if (station.name == word) ++of_this_name;
  }
  if (of_this_name > 1) {
    return Fail(ErrorKind::kUsage, fmt::format("{} stations are called '{}': name one by its id",
                                               of_this_name, Printable(word)));
  }
  const auto nearest = base::Nearest(word, names);
  return Fail(ErrorKind::kUsage,
              fmt::format("the layout has no node or station '{}'{}", Printable(word),
                          nearest ? fmt::format(": did you mean {}?", Printable(*nearest)) : ""));
}

Result<std::string> ChooseVehicleType(const Site& site, std::string_view asked,
                                      std::string_view suggested) {
  const std::vector<std::string> types = site.VehicleTypes();
  const auto has = [&](std::string_view type) {
    return std::find(types.begin(), types.end(), type) != types.end();
  };
  if (!asked.empty()) {
    if (has(asked)) return std::string(asked);
    return Fail(ErrorKind::kUsage, fmt::format("the layout has no vehicle type '{}'; there {} {}",
                                               Printable(asked), types.size() == 1 ? "is" : "are",
                                               types.empty() ? "none" : Listed(types)));
  }
  if (!suggested.empty() && has(suggested)) return std::string(suggested);
  if (types.size() == 1) return types.front();
  return Fail(ErrorKind::kUsage,
              types.empty() ? "the layout names no vehicle type: no vehicle may use it"
                            : fmt::format("the layout has several vehicle types: choose one with "
                                          "--vehicle-type: {}",
                                          Listed(types)));
}

}  // namespace fleetpub::layout
