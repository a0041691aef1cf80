// Looks around once: which robots the broker knows, and what they say.
#pragma once

#include <string>

#include "base/result.h"
#include "cli/listening.h"
#include "cli/options/global_options.h"
#include "vda5050/reports/fleet_view.h"

namespace fleetpub::cli {

struct GatheringOptions {
  FleetOptions fleet;
  std::string discover = "300";
  std::string state_wait = "2s";
};

void DeclareGatheringOptions(OptionSet& set, GatheringOptions& options);

/// Waits until every robot that is online has sent a state, and warns of those that did not in
/// time. Errors: ErrorKind::kUsage, kBroker; kPreflight when no robot is known.
[[nodiscard]] Result<vda5050::FleetView> GatherFleet(const GatheringOptions& options,
                                                     const Context& context);

}  // namespace fleetpub::cli
