// The fleet as metrics, for a collector such as node_exporter's.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string_view>

#include "app/confirm_times.h"
#include "base/time.h"
#include "vda5050/reports/robot_directory.h"

namespace fleetpub::cli {

/// OpenMetrics 1.0, in those of its forms that Prometheus' older text format has, too. The robots in
/// the order in which they come; what is not known of one is left out. `write` gets the text in
/// pieces. `times`: nothing when nobody knows them.
void WriteFleetMetrics(std::span<const vda5050::ListedRobot* const> robots, base::WallTime now,
                       const std::optional<app::ConfirmTimes>& times,
                       const std::function<void(std::string_view)>& write);

}  // namespace fleetpub::cli
