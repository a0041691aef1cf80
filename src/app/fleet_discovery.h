// Looks around once: which robots the broker knows, and what they say.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <vector>

#include "app/dialect_resolver.h"
#include "app/environment.h"
#include "app/observer.h"
#include "base/result.h"
#include "config/config.h"
#include "delivery/retained.h"
#include "vda5050/reports/fleet_view.h"

namespace fleetpub::app {

struct FleetRequest {
  std::vector<std::string> words;  ///< robots and patterns; none: all
  VdaOptions vda;
  delivery::RetainedOptions discover;
  std::chrono::milliseconds state_wait{};
};

/// The words as a person reads them; `all` without any.
[[nodiscard]] std::string FormatFleetName(const std::vector<std::string>& words);

/// An empty view of these robots. Errors: ErrorKind::kUsage.
[[nodiscard]] Result<vda5050::FleetView> MakeFleetView(const std::vector<std::string>& words,
                                                       const VdaOptions& vda,
                                                       const config::Config& config, Log& log);

/// What to say when so many robots' states could not be kept whole (FleetView::abridged).
[[nodiscard]] std::string AbridgedWarning(std::size_t robots);

/// Waits until every robot that is online has sent a state, and warns of those that did not in
/// time. Errors: ErrorKind::kUsage, kBroker; kPreflight when no robot is known.
[[nodiscard]] Result<vda5050::FleetView> DiscoverFleet(const FleetRequest& request,
                                                       const Environment& environment, Log& log);

}  // namespace fleetpub::app
