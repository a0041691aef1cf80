// The Transport over paho-mqtt-c.
#pragma once

#include <memory>

#include "base/result.h"
#include "mqtt/transport.h"

namespace fleetpub::mqtt {

/// Connects to the first broker that accepts. When none does, the error tells what each one said.
[[nodiscard]] Result<std::unique_ptr<Transport>> ConnectPaho(const ConnectOptions& options);

/// The same for a virtual robot.
[[nodiscard]] Result<std::unique_ptr<RobotTransport>> ConnectPahoAsRobot(
    const ConnectOptions& options);

}  // namespace fleetpub::mqtt
