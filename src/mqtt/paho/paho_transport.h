// The Transport over paho-mqtt-c.
#pragma once

#include <memory>

#include "base/result.h"
#include "mqtt/transport.h"

namespace fleetpub::mqtt {

/// Connects to the first broker that accepts. When none does, the error tells what each one said,
/// and `may_heal` whether a later attempt may end otherwise: nobody was there, or too busy. It is
/// false for what a person must mend, such as a login or a certificate.
[[nodiscard]] Result<std::unique_ptr<Transport>> ConnectPaho(const ConnectOptions& options,
                                                             bool* may_heal = nullptr);

/// The same for a virtual robot.
[[nodiscard]] Result<std::unique_ptr<RobotTransport>> ConnectPahoAsRobot(
    const ConnectOptions& options, bool* may_heal = nullptr);

}  // namespace fleetpub::mqtt
