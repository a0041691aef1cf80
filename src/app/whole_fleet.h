// Reads who has left a connection message, also from brokers that hand out only so many for one
// subscription (ejabberd: 1,000, by default).
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "app/expected_robots.h"
#include "app/observer.h"
#include "base/result.h"
#include "delivery/retained.h"
#include "mqtt/transport.h"
#include "vda5050/model/robot_address.h"

namespace fleetpub::app {

struct FleetQuery {
  std::span<const vda5050::TopicScheme> schemes;  ///< of the topics
  std::vector<std::string> filters;               ///< with wildcards
  std::span<const ExpectedRobot> expected;        ///< their manufacturers are asked for too
};

struct HandedOut {
  bool any = false;       ///< something retained came
  std::size_t limit = 0;  ///< robots that came for one filter, when more were perhaps left out
};

/// Takes everything, retained or not. When the number of robots looks like a limit of the broker's,
/// asks again for smaller parts of the fleet, by interface, version and manufacturer, until nobody new
/// comes. `known` tells of how many robots there are. Errors: as ReadAllRetained.
[[nodiscard]] Result<HandedOut> ReadWholeFleet(
    mqtt::Transport& transport, const FleetQuery& query, delivery::RetainedOptions options,
    const std::function<void(const mqtt::Message&)>& take,
    const std::function<std::size_t()>& known);

/// Of a limit.
void WarnOfLimit(const HandedOut& handed_out, Log& log);

}  // namespace fleetpub::app
