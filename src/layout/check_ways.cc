#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "base/text.h"
#include "layout/check.h"
#include "layout/navigation.h"

namespace fleetpub::layout {
namespace {

using base::Printable;

bool IsForType(const Arc& arc) {
  return arc.barrier != Barrier::kType && arc.barrier != Barrier::kStartType &&
         arc.barrier != Barrier::kEndType;
}

// Parts of a graph in which every node can be reached from every other: Tarjan's algorithm, with a
// stack of its own.
class Parts {
 public:
  Parts(std::size_t nodes, const std::vector<Arc>& arcs) : next_(nodes) {
    for (const Arc& arc : arcs) {
      if (arc.barrier == Barrier::kNone) next_[arc.start].push_back(arc.end);
    }
    part_.assign(nodes, 0);
    index_.assign(nodes, 0);
    low_.assign(nodes, 0);
    for (std::size_t node = 0; node < nodes; ++node) {
      if (index_[node] == 0) Visit(node);
    }
  }

  /// From 1.
  [[nodiscard]] std::size_t Of(std::size_t node) const { return part_[node]; }

 private:
  struct Frame {
    std::size_t node;
    std::size_t edge = 0;
  };

  void Enter(std::size_t node, std::vector<Frame>& calls) {
    index_[node] = low_[node] = ++count_;
    open_.push_back(node);
    calls.push_back({node});
  }

  void Visit(std::size_t root) {
    std::vector<Frame> calls;
    Enter(root, calls);
    while (!calls.empty()) {
      const std::size_t node = calls.back().node;
      if (calls.back().edge < next_[node].size()) {
        const std::size_t to = next_[node][calls.back().edge++];
        if (index_[to] == 0) {
          Enter(to, calls);
        } else if (part_[to] == 0) {
          low_[node] = std::min(low_[node], index_[to]);
        }
        continue;
      }
      calls.pop_back();
      if (!calls.empty()) {
        std::size_t& low = low_[calls.back().node];
        low = std::min(low, low_[node]);
      }
      if (low_[node] == index_[node]) Close(node);
    }
  }

  void Close(std::size_t first) {
    ++parts_;
    for (std::size_t node = SIZE_MAX; node != first;) {
      node = open_.back();
      open_.pop_back();
      part_[node] = parts_;
    }
  }

  std::vector<std::vector<std::size_t>> next_;
  std::vector<std::size_t> part_;
  std::vector<std::size_t> index_;  // 0: not seen yet
  std::vector<std::size_t> low_;
  std::vector<std::size_t> open_;
  std::size_t count_ = 0;
  std::size_t parts_ = 0;
};

class WayChecker {
 public:
  WayChecker(const Site& site, std::vector<LayoutFinding>& findings)
      : site_(site), findings_(findings) {}

  void Check(const std::string& type) {
    const auto arcs = ListArcs(site_, {type, false, ""});
    CheckEnds(type, arcs);
    CheckTurning(type, arcs);
    const auto loads = ListLoads(type);
    for (const auto& [loaded, set, words] : loads) {
      CheckParts(type, words, ListArcs(site_, {type, loaded, set}));
    }
  }

 private:
  struct Load {
    bool loaded = false;
    std::string set;
    std::string words;
  };

  void Warn(std::string place, std::string text) {
    findings_.push_back({LayoutFinding::Level::kWarning, std::move(place), std::move(text)});
  }

  // The loads that make a difference to vehicles of this type.
  [[nodiscard]] std::vector<Load> ListLoads(std::string_view type) const {
    bool has_restriction = false;
    std::set<std::string> sets;
    const auto note = [&](const auto& elements) {
      for (const auto& element : elements) {
        const auto* const properties = element.Find(type);
        if (properties == nullptr || properties->load == LoadRestriction()) continue;
        has_restriction = true;
        sets.insert(properties->load.load_sets.begin(), properties->load.load_sets.end());
      }
    };
    note(site_.nodes);
    note(site_.edges);
    if (!has_restriction) return {{}};
    std::vector<Load> loads = {{false, "", ", unloaded"}};
    constexpr std::size_t kMost = 32;
    for (const std::string& set : sets) {
      if (loads.size() > kMost) break;
      loads.push_back({true, set, fmt::format(", loaded with {}", Printable(set))});
    }
    if (sets.empty()) loads.push_back({true, "", ", loaded"});
    return loads;
  }

  void CheckEnds(const std::string& type, const std::vector<Arc>& arcs) {
    std::vector<bool> is_left(site_.nodes.size());
    std::vector<bool> is_entered(site_.nodes.size());
    for (const Arc& arc : arcs) {
      if (!IsForType(arc) || arc.start == arc.end) continue;
      is_left[arc.start] = true;
      is_entered[arc.end] = true;
    }
    for (std::size_t i = 0; i < site_.nodes.size(); ++i) {
      const Node& node = site_.nodes[i];
      if (node.Find(type) == nullptr || (is_left[i] && is_entered[i])) continue;
      const std::string_view fault = is_left[i]      ? "come here"
                                     : is_entered[i] ? "leave it again"
                                                     : "come here or leave";
      Warn(FormatPlace(site_, "nodes", node),
           fmt::format("vehicles of type {} cannot {}", Printable(type), fault));
    }
  }

  void CheckTurning(const std::string& type, const std::vector<Arc>& arcs) {
    std::vector<std::vector<const Arc*>> leaving(site_.nodes.size());
    for (const Arc& arc : arcs) {
      if (IsForType(arc)) leaving[arc.start].push_back(&arc);
    }
    std::size_t told = SIZE_MAX;
    for (const Arc& arc : arcs) {
      if (!IsForType(arc) || arc.edge == told) continue;
      const auto& next = leaving[arc.end];
      const bool is_stuck =
          !next.empty() && std::none_of(next.begin(), next.end(),
                                        [&](const Arc* to) { return CanFollow(arc, *to); });
      if (CanEnd(arc) && !is_stuck) continue;
      told = arc.edge;
      Warn(FormatPlace(site_, "edges", site_.edges[arc.edge]),
           fmt::format("vehicles of type {} that come along it may not turn on {} {}",
                       Printable(type), Printable(site_.nodes[arc.end].id),
                       CanEnd(arc) ? "to drive on: no edge can follow" : "as the node wants it"));
    }
  }

  void CheckParts(const std::string& type, const std::string& load, const std::vector<Arc>& arcs) {
    const Parts parts(site_.nodes.size(), arcs);
    std::vector<std::size_t> sizes(site_.nodes.size() + 1);
    std::size_t count = 0;
    std::size_t largest = 0;
    const auto is_for_type = [&](std::size_t i) { return site_.nodes[i].Find(type) != nullptr; };
    for (std::size_t i = 0; i < site_.nodes.size(); ++i) {
      if (!is_for_type(i)) continue;
      const std::size_t part = parts.Of(i);
      if (++sizes[part] == 1) ++count;
      if (sizes[part] > sizes[largest]) largest = part;
    }
    if (count < 2) return;
    std::string inside;
    std::string outside;
    for (std::size_t i = 0; i < site_.nodes.size(); ++i) {
      if (!is_for_type(i)) continue;
      std::string& name = parts.Of(i) == largest ? inside : outside;
      if (name.empty()) name = Printable(site_.nodes[i].id);
    }
    Warn("", fmt::format("vehicles of type {}{} find {} parts with no way there and back, such as "
                         "between {} and {}",
                         Printable(type), load, count, inside, outside));
  }

  const Site& site_;
  std::vector<LayoutFinding>& findings_;
};

}  // namespace

void CheckWays(const Site& site, std::vector<LayoutFinding>& findings) {
  WayChecker checker(site, findings);
  constexpr std::size_t kMost = 100;
  const auto types = site.VehicleTypes();
  for (std::size_t i = 0; i < types.size() && i < kMost; ++i) checker.Check(types[i]);
}

}  // namespace fleetpub::layout
