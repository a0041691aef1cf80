// Whether many robots are meant.
#pragma once

#include <span>
#include <string_view>

#include "base/result.h"
#include "vda5050/model/robot_address.h"

namespace fleetpub::cli {

/// Asks on a terminal whether all of these are meant; `set` is the word that stands for them.
/// Errors: ErrorKind::kUsage: refused, or nobody is there to be asked.
[[nodiscard]] Status AskForConsent(std::span<const vda5050::RobotAddress> robots,
                                   std::string_view set);

}  // namespace fleetpub::cli
