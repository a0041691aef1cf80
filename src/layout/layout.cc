#include "layout/layout.h"

#include <algorithm>

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

}  // namespace fleetpub::layout
