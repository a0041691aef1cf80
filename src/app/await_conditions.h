// `fleetpub await`: waits until a message of each robot satisfies conditions.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "app/dialect_resolver.h"
#include "app/environment.h"
#include "app/observer.h"
#include "base/result.h"
#include "vda5050/reports/condition.h"

namespace fleetpub::app {

struct AwaitRequest {
  std::string target;  ///< a robot, or several; of a pattern those that the broker knows now
  std::string topic;   ///< its name: `state`
  std::vector<vda5050::Condition> conditions;
  std::chrono::milliseconds timeout{};
  VdaOptions vda;
};

/// A robot's message satisfies the conditions; it is one line of JSON.
using SatisfiedHook = std::function<void(
    const vda5050::RobotAddress& robot, const std::string& line, std::chrono::nanoseconds elapsed)>;

/// Errors: ErrorKind::kUsage, kBroker; kPreflight: no robot matches; kUnconfirmed: time is up, and
/// what was said instead.
[[nodiscard]] Status AwaitConditions(const AwaitRequest& request, const Environment& environment,
                                     const SatisfiedHook& satisfied, Log& log);

}  // namespace fleetpub::app
