// Orders as tests write them.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <vector>

#include "vda5050/model/version.h"

namespace fleetpub::simulator {

/// A node, and the edge that leads to it.
struct Stop {
  std::string id;
  bool released = true;
  std::string actions = {};       ///< JSON, without brackets
  std::string more = {};          ///< further members of the node: `,"nodePosition":{…}`
  std::string edge_actions = {};  ///< JSON, without brackets
  std::string edge_more = {};
};

struct Route {
  std::string id = "o1";
  std::uint32_t update = 0;
  std::vector<Stop> stops;
  std::uint32_t first_sequence = 0;
  std::string more = {};  ///< further members of the order
};

inline std::string Act(const std::string& id, const std::string& blocking,
                       const std::string& type = "detectObject", const std::string& more = "") {
  return fmt::format(R"({{"actionId":"{}","actionType":"{}","blockingType":"{}"{}}})", id, type,
                     blocking, more);
}

inline std::string At(double x, double y, const std::string& more = "",
                      const std::string& map = "map-1") {
  return fmt::format(R"(,"nodePosition":{{"x":{},"y":{},"mapId":"{}"{}}})", x, y, map, more);
}

inline std::string OrderHeader(vda5050::Version version) {
  return fmt::format(R"("headerId":3,"timestamp":"2026-01-02T03:04:05.678Z","version":"{}",)"
                     R"("manufacturer":"KIT","serialNumber":"0001")",
                     vda5050::GetFacts(version).name);
}

/// Edges are called after the nodes that they join: `n1-n2`.
inline std::string Write(const Route& route, vda5050::Version version) {
  std::string nodes;
  std::string edges;
  std::uint32_t sequence = route.first_sequence;
  for (std::size_t i = 0; i < route.stops.size(); ++i) {
    const Stop& stop = route.stops[i];
    if (i > 0) {
      const std::string& from = route.stops[i - 1].id;
      edges +=
          fmt::format(R"({}{{"edgeId":"{}-{}","sequenceId":{},"released":{},"startNodeId":"{}",)"
                      R"("endNodeId":"{}","actions":[{}]{}}})",
                      edges.empty() ? "" : ",", from, stop.id, sequence + 1, stop.released, from,
                      stop.id, stop.edge_actions, stop.edge_more);
      sequence += 2;
    }
    nodes += fmt::format(R"({}{{"nodeId":"{}","sequenceId":{},"released":{},"actions":[{}]{}}})",
                         nodes.empty() ? "" : ",", stop.id, sequence, stop.released, stop.actions,
                         stop.more);
  }
  return fmt::format(R"({{{},"orderId":"{}","orderUpdateId":{},"nodes":[{}],"edges":[{}]{}}})",
                     OrderHeader(version), route.id, route.update, nodes, edges, route.more);
}

}  // namespace fleetpub::simulator
