// What a person asks virtual robots to rehearse, in words.
#pragma once

#include <string_view>

#include "base/result.h"
#include "simulator/robot_state.h"
#include "vda5050/model/version.h"

namespace fleetpub::simulator {

/// `TYPE:LEVEL` or `TYPE:LEVEL:TEXT`, in a level that the version has; it stays. Errors:
/// ErrorKind::kUsage.
[[nodiscard]] Result<RobotError> ParseRobotError(std::string_view text, vda5050::Version version);

/// `x,y,theta` or `x,y,theta,map`. Errors: ErrorKind::kUsage.
[[nodiscard]] Result<Position> ParsePosition(std::string_view text);

/// Whether the version has this value of the emergency stop: from 3.0 none acknowledges itself.
[[nodiscard]] bool HasEmergencyStop(std::string_view value, vda5050::Version version);

}  // namespace fleetpub::simulator
