// `fleetpub simulate --protocol soar DESTINATION…`: virtual platforms that acknowledge.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "cli/options/global_options.h"
#include "cli/output/exit_code.h"
#include "simulator/virtual_robot.h"
#include "soar/message_type.h"

namespace fleetpub::cli {

struct SoarSimulation {
  std::vector<std::string> destinations;
  std::string prefix = "soar";
  std::optional<soar::Level> stop_at;
  std::chrono::milliseconds delay{};
  std::chrono::milliseconds status_interval{};
  std::optional<std::chrono::milliseconds> duration;  ///< nothing: until `stopped`
  bool silent = false;
  std::function<bool()> stopped;
  std::function<void()> on_ready;  ///< called before it is told that they are there
};

/// A fault of a virtual robot or platform as a warning, anything else of it with `-v`.
void ShowEvent(std::string_view name, const simulator::Event& event, Output& output);

[[nodiscard]] Result<ExitCode> RunSoarSimulation(const SoarSimulation& simulation,
                                                 const Context& context);

}  // namespace fleetpub::cli
