// Dijkstra's algorithm over arcs. An arc costs the same wherever the vehicle comes from, and arcs are
// settled in the order of their cost: the first one that may be followed by another is the best to
// come from. So each arc is entered once, and leaves its node's list then; a node with many edges
// costs what its edges are, not their square.
#include "layout/route_search.h"

#include <algorithm>
#include <functional>
#include <limits>

namespace fleetpub::layout {
namespace {

constexpr double kPenalty = 1e12;  // m, or s: more than any way costs

Vehicle MakeVehicle(const RouteRequest& request) {
  return {request.vehicle_type, request.loaded, request.load_set};
}

}  // namespace

RouteSearch::RouteSearch(const Site& site, const RouteRequest& request, Obstacles obstacles)
    : site_(site),
      request_(request),
      obstacles_(obstacles),
      arcs_(ListArcs(site, MakeVehicle(request))),
      forward_(arcs_.size()) {
  if (obstacles == Obstacles::kCost) AddReversed();
  lengths_.assign(arcs_.size(), -1);
  for (const auto& nodes : request.stops) {
    auto& mask = is_stop_.emplace_back(site.nodes.size());
    for (const std::size_t node : nodes) mask[node] = true;
  }
  layers_.resize(request.stops.size());
  SortByStart();
}

void RouteSearch::AddReversed() {
  arcs_.reserve(2 * forward_);
  for (std::size_t i = 0; i < forward_; ++i) {
    arcs_.push_back({.edge = arcs_[i].edge, .start = arcs_[i].end, .end = arcs_[i].start});
  }
}

void RouteSearch::SortByStart() {
  begins_.assign(site_.nodes.size() + 1, 0);
  for (const Arc& arc : arcs_) ++begins_[arc.start + 1];
  for (std::size_t i = 1; i < begins_.size(); ++i) begins_[i] += begins_[i - 1];
  by_start_.resize(arcs_.size());
  std::vector<std::uint32_t> next = begins_;
  for (std::size_t i = 0; i < arcs_.size(); ++i) {
    by_start_[next[arcs_[i].start]++] = static_cast<std::uint32_t>(i);
  }
}

RouteSearch::Layer& RouteSearch::Open(std::size_t stop) {
  auto& layer = layers_[stop];
  if (!layer) {
    layer.emplace();
    layer->open = by_start_;
    layer->ends.assign(begins_.begin() + 1, begins_.end());
    layer->cost.assign(arcs_.size(), std::numeric_limits<double>::infinity());
    layer->before.assign(arcs_.size(), kNone);
    layer->is_done.assign(arcs_.size(), false);
  }
  return *layer;
}

double RouteSearch::Length(std::size_t index) const {
  double& length = lengths_[index];
  if (length < 0) {
    const Arc& arc = arcs_[index];
    length =
        arc.properties == nullptr ? 0 : EdgeLength(site_, site_.edges[arc.edge], *arc.properties);
  }
  return length;
}

double RouteSearch::Seconds(std::size_t index) const {
  const Arc& arc = arcs_[index];
  const auto limit = arc.properties == nullptr ? std::nullopt : arc.properties->max_speed;
  double speed = request_.vehicle_speed.value_or(limit.value_or(1));
  if (limit) speed = std::min(speed, *limit);
  return speed > 0 ? Length(index) / speed : kPenalty;
}

std::size_t RouteSearch::Advance(std::size_t stop, std::size_t node) const {
  while (stop < is_stop_.size() && is_stop_[stop][node]) ++stop;
  return stop;
}

// What is in the way between two arcs, or before the first one.
double RouteSearch::Penalty(const Arc* from, std::size_t to) const {
  const Arc& arc = arcs_[to];
  const bool may_follow = from == nullptr ? CanStart(request_.heading, arc) : CanFollow(*from, arc);
  const int obstacles = (IsReversed(to) || arc.barrier != Barrier::kNone ? 1 : 0) +
                        (may_follow ? 0 : 1) + (CanEnd(arc) ? 0 : 1);
  return kPenalty * obstacles;
}

void RouteSearch::Leave(std::size_t node, const State& state, const Arc* from, std::size_t before) {
  Layer& layer = Open(state.stop);
  for (std::uint32_t i = begins_[node]; i < layer.ends[node];) {
    const std::size_t next = layer.open[i];
    const double penalty = Penalty(from, next);
    const bool is_barred = obstacles_ == Obstacles::kBar && penalty > 0;
    const double cost =
        state.cost + penalty + (request_.cost == RouteCost::kTime ? Seconds(next) : Length(next));
    if (!is_barred && cost < layer.cost[next]) {
      layer.cost[next] = cost;
      layer.before[next] = before;
      heap_.push_back({cost, state.edges + 1, next, state.stop});
      std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
    }
    if (!is_barred && obstacles_ == Obstacles::kBar) {
      layer.open[i] = layer.open[--layer.ends[node]];
    } else {
      ++i;
    }
  }
}

std::optional<std::vector<std::size_t>> RouteSearch::Run() {
  State state;
  state.stop = Advance(0, request_.from);
  if (state.stop == is_stop_.size()) return std::vector<std::size_t>();
  Leave(request_.from, state, nullptr, kNone);
  while (!heap_.empty()) {
    std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
    state = heap_.back();
    heap_.pop_back();
    Layer& layer = Open(state.stop);
    if (layer.is_done[state.arc]) continue;
    layer.is_done[state.arc] = true;
    const Arc& arc = arcs_[state.arc];
    State next = state;
    next.stop = Advance(state.stop, arc.end);
    if (next.stop == is_stop_.size()) return Trace(state);
    Leave(arc.end, next, &arc, state.arc + state.stop * arcs_.size());
  }
  return std::nullopt;
}

std::vector<std::size_t> RouteSearch::Trace(const State& last) const {
  std::vector<std::size_t> way;
  std::size_t at = last.arc + last.stop * arcs_.size();
  while (at != kNone) {
    way.push_back(at % arcs_.size());
    at = layers_[at / arcs_.size()]->before[at % arcs_.size()];
  }
  std::reverse(way.begin(), way.end());
  return way;
}

}  // namespace fleetpub::layout
