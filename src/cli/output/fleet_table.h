// How robots are shown: as rows of a table, as a line for each change, as JSON.
#pragma once

#include <span>
#include <string>

#include "base/time.h"
#include "cli/output/table.h"
#include "vda5050/reports/robot_directory.h"

namespace fleetpub::cli {

[[nodiscard]] std::span<const Column> FleetColumns();

/// One robot; what is not known is `-`. `now` is for the age of its connection message.
[[nodiscard]] Row FleetRow(const vda5050::ListedRobot& robot, base::WallTime now);

/// One robot with its columns named, for a line that stands alone.
[[nodiscard]] std::string FleetLine(const vda5050::ListedRobot& robot, const Output& output);

/// The members of a JSON object (docs/manual.md), without its braces.
[[nodiscard]] std::string FleetJson(const vda5050::ListedRobot& robot);

/// `12 s`, `3 min`, `5 h`, `9 d`.
[[nodiscard]] std::string AgeText(std::chrono::nanoseconds age);

}  // namespace fleetpub::cli
