// An order as a virtual robot reads it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/rapidjson.h"
#include "simulator/protocol_terms.h"
#include "simulator/robot_state.h"
#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::simulator {

struct OrderPlan {
  Order order;                       ///< with its first node
  std::vector<OrderAction> actions;  ///< in the order of its nodes and edges
};

/// Of a message that satisfies its schema and the rules of the text.
[[nodiscard]] OrderPlan ReadOrder(const base::JsonValue& message, const ProtocolTerms& terms);

/// A robot that is under way, for longer than anybody waits.
[[nodiscard]] Order ExampleOrder();

/// A member of an order that the specification leaves to the robot.
struct OptionalMember {
  std::string_view path;  ///< as a factsheet names it: `order.nodes.nodePosition.theta`
  vda5050::VersionRange versions;
  bool is_supported;
};

/// Those of the version.
[[nodiscard]] std::vector<OptionalMember> ListOptionalMembers(vda5050::Version version);

/// The members in this order that the robot cannot use.
[[nodiscard]] std::vector<std::string_view> FindUnsupported(const base::JsonValue& message,
                                                            vda5050::Version version);

}  // namespace fleetpub::simulator
