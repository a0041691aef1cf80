// One robot on a screen: all that is known of it.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/time.h"
#include "cli/output/output.h"
#include "vda5050/reports/robot_directory.h"

namespace fleetpub::cli {

/// Lines no wider than `width`. `silence`: since it last sent a state; nothing: that is not known.
[[nodiscard]] std::vector<std::string> RobotLines(const vda5050::ListedRobot& robot,
                                                  base::WallTime now,
                                                  std::optional<std::chrono::nanoseconds> silence,
                                                  std::size_t width, const Output& output);

}  // namespace fleetpub::cli
