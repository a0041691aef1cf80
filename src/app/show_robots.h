// Gathers all that is known of some robots: `fleetpub show`.
#pragma once

#include <vector>

#include "app/dialect_resolver.h"
#include "app/environment.h"
#include "app/observer.h"
#include "app/robot_sheet.h"
#include "app/targets.h"
#include "base/result.h"
#include "delivery/retained.h"

namespace fleetpub::app {

struct ShowRequest {
  Targets targets;  ///< its `state_wait` bounds each waiting for states
  DialectResolver resolver;
  bool ask = true;  ///< those that are there for their states
  delivery::RetainedOptions discover;
};

struct ShownRobots {
  std::vector<RobotSheet> sheets;
  std::vector<Error> unknown;  ///< of robots that the broker does not know, what to type instead
};

/// Errors: ErrorKind::kUsage, kBroker; kPreflight when patterns and conditions leave no robot.
[[nodiscard]] Result<ShownRobots> ShowRobots(const ShowRequest& request,
                                             const Environment& environment, Log& log);

}  // namespace fleetpub::app
