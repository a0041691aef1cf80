// What a file says of nodes and edges for one vehicle type.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "layout/lif_fields.h"

namespace fleetpub::layout {

/// What the members are called in a major version of the format, as far as the names differ.
struct Terms {
  int major;
  std::string_view project;
  std::string_view layout_description;
  std::string_view node_description;
  std::string_view edge_description;
  std::string_view station_description;
  std::string_view action_description;
  std::string_view node_properties;
  std::string_view edge_properties;
  std::string_view max_speed;
  std::string_view max_rotation_speed;
  std::string_view min_height;
  std::string_view max_height;
};

/// The properties of an element, each once per vehicle type. Faulty ones are left out.
[[nodiscard]] std::vector<NodeProperties> ReadNodeProperties(Fields& node, const Terms& terms);
[[nodiscard]] std::vector<EdgeProperties> ReadEdgeProperties(Fields& edge, const Terms& terms);

}  // namespace fleetpub::layout
