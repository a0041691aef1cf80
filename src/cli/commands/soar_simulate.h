// `fleetpub simulate --protocol soar DESTINATION…`: virtual platforms that acknowledge.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "base/result.h"
#include "cli/options/global_options.h"
#include "cli/output/exit_code.h"

namespace fleetpub::cli {

struct SoarSimulation {
  std::vector<std::string> destinations;
  std::string prefix = "soar";
  std::string stop_at;
  std::string delay;
  std::string status_interval;
  std::string duration;  ///< empty: until `stopped`
  bool silent = false;
  std::function<bool()> stopped;
  std::function<void()> on_ready;  ///< called before it is told that they are there
};

[[nodiscard]] Result<ExitCode> RunSoarSimulation(const SoarSimulation& simulation,
                                                 const Context& context);

}  // namespace fleetpub::cli
