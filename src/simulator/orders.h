// Orders, as far as a virtual robot understands them: it takes them, drives, and gives them up.
#pragma once

#include <string>

#include "base/rapidjson.h"
#include "simulator/protocol_terms.h"
#include "simulator/robot_state.h"

namespace fleetpub::simulator {

/// A robot that is under way.
[[nodiscard]] Order ExampleOrder();

/// Takes over a new order, or an update of the active one. Returns why it cannot, or "".
[[nodiscard]] std::string AcceptOrder(const base::JsonValue& message, RobotState& state,
                                      const ProtocolTerms& terms);

/// Everything is reached and done.
void FinishOrder(RobotState& state);

}  // namespace fleetpub::simulator
