#include "layout/layout.h"

#include <algorithm>
#include <unordered_set>

namespace fleetpub::layout {
namespace {

template <class Element>
auto FindProperties(const Element& element, std::string_view vehicle_type) {
  const auto found =
      std::find_if(element.properties.begin(), element.properties.end(),
                   [&](const auto& properties) { return properties.vehicle_type == vehicle_type; });
  return found == element.properties.end() ? nullptr : &*found;
}

}  // namespace

const NodeProperties* Node::Find(std::string_view vehicle_type) const {
  return FindProperties(*this, vehicle_type);
}

const EdgeProperties* Edge::Find(std::string_view vehicle_type) const {
  return FindProperties(*this, vehicle_type);
}

std::optional<std::size_t> Site::FindNode(std::string_view id) const {
  const auto found =
      std::find_if(nodes.begin(), nodes.end(), [&](const Node& node) { return node.id == id; });
  if (found == nodes.end()) return std::nullopt;
  return static_cast<std::size_t>(found - nodes.begin());
}

const Station* Site::FindStation(std::string_view word) const {
  const auto by_id = std::find_if(stations.begin(), stations.end(),
                                  [&](const Station& station) { return station.id == word; });
  if (by_id != stations.end()) return &*by_id;
  const auto is_called = [&](const Station& station) { return station.name == word; };
  const auto by_name = std::find_if(stations.begin(), stations.end(), is_called);
  const bool is_only =
      by_name != stations.end() && std::none_of(by_name + 1, stations.end(), is_called);
  return is_only ? &*by_name : nullptr;
}

std::vector<std::string> Site::VehicleTypes() const {
  std::vector<std::string> types;
  std::unordered_set<std::string_view> seen;
  const auto add = [&](const auto& elements) {
    for (const auto& element : elements) {
      for (const auto& properties : element.properties) {
        if (seen.insert(properties.vehicle_type).second) types.push_back(properties.vehicle_type);
      }
    }
  };
  add(nodes);
  add(edges);
  return types;
}

}  // namespace fleetpub::layout
