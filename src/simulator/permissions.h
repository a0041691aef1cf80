// What a virtual robot asks fleet control for (VDA 5050 3.0 §6.4.3): access to RELEASE zones that
// its order leads into, and to corridors that need a release. It drives when all is granted.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/rapidjson.h"
#include "base/time.h"
#include "simulator/robot_state.h"

namespace fleetpub::simulator {

/// Takes over the zone set of a message. It is to be enabled by an instant action. Returns why it
/// cannot, or "".
[[nodiscard]] std::string AcceptZoneSet(const base::JsonValue& message, RobotState& state);

/// Asks for what this order or update needs and has not been asked for.
void AskForPermissions(const base::JsonValue& order, RobotState& state);

/// Carries out the answers. Returns the requestIds that it does not have.
[[nodiscard]] std::vector<std::string> TakeResponses(const base::JsonValue& message,
                                                     RobotState& state);

/// When a grant's time is up next.
[[nodiscard]] std::optional<base::WallTime> NextExpiry(const RobotState& state);

/// Grants whose time is up are EXPIRED. True when there was one.
[[nodiscard]] bool ExpireLeases(RobotState& state, base::WallTime now);

}  // namespace fleetpub::simulator
