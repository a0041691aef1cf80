// What is odd in a layout that was read: warnings that no schema can state.
#pragma once

#include <vector>

#include "layout/layout.h"

namespace fleetpub::layout {

/// Of single elements: trajectories beside their nodes, edges without length, maps that nothing
/// joins, nodes in one place, edges that cannot be told apart, stations without actions.
void CheckElements(const Site& site, std::vector<LayoutFinding>& findings);

/// Of ways, for each vehicle type and load: dead ends, parts that are not joined, arrivals from which
/// nothing follows under the rules of turning.
void CheckWays(const Site& site, std::vector<LayoutFinding>& findings);

}  // namespace fleetpub::layout
