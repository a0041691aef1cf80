// The search behind FindRoute: the cheapest sequence of arcs through all stops.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "layout/navigation.h"
#include "layout/route.h"

namespace fleetpub::layout {

class RouteSearch {
 public:
  /// With obstacles: what is barred may be driven all the same, also against an edge's direction, but
  /// the way with the fewest obstacles is the cheapest.
  enum class Obstacles { kBar, kCost };

  RouteSearch(const Site& site, const RouteRequest& request, Obstacles obstacles);

  /// The arcs in their order; empty: the vehicle is there. Nothing: there is no way.
  [[nodiscard]] std::optional<std::vector<std::size_t>> Run();

  [[nodiscard]] const Arc& arc(std::size_t index) const { return arcs_[index]; }
  /// Whether the arc is an edge that is driven against its direction.
  [[nodiscard]] bool IsReversed(std::size_t index) const { return index >= forward_; }
  [[nodiscard]] double Length(std::size_t index) const;
  [[nodiscard]] double Seconds(std::size_t index) const;
  /// How many of the stops that follow are there at this node too.
  [[nodiscard]] std::size_t Advance(std::size_t stop, std::size_t node) const;

 private:
  struct State {
    double cost = 0;
    std::uint32_t edges = 0;  // of two ways that cost the same the one with fewer edges
    std::size_t arc = 0;
    std::size_t stop = 0;  // the next one

    bool operator>(const State& other) const {
      return cost != other.cost ? cost > other.cost : edges > other.edges;
    }
  };
  // What may still be entered, once for each number of stops that were reached.
  struct Layer {
    std::vector<std::uint32_t> open;  // arcs by their start node
    std::vector<std::uint32_t> ends;  // of each node's part
    std::vector<double> cost;         // of the cheapest way that ends with the arc
    std::vector<std::size_t> before;  // the state before, as arc + stop · arcs; kNone: the first
    std::vector<bool> is_done;
  };

  static constexpr std::size_t kNone = SIZE_MAX;

  void AddReversed();
  void SortByStart();
  Layer& Open(std::size_t stop);
  [[nodiscard]] double Penalty(const Arc* from, std::size_t to) const;
  void Leave(std::size_t node, const State& state, const Arc* from, std::size_t before);
  [[nodiscard]] std::vector<std::size_t> Trace(const State& last) const;

  const Site& site_;
  const RouteRequest& request_;
  Obstacles obstacles_;
  std::vector<Arc> arcs_;
  std::size_t forward_;
  mutable std::vector<double> lengths_;  // negative: not known yet
  std::vector<std::vector<bool>> is_stop_;
  std::vector<std::uint32_t> by_start_;
  std::vector<std::uint32_t> begins_;
  std::vector<std::optional<Layer>> layers_;
  std::vector<State> heap_;
};

}  // namespace fleetpub::layout
