// What the commands that listen have in common: whose topics, and how long.
#pragma once

#include <string>
#include <vector>

#include "app/fleet_discovery.h"
#include "base/result.h"
#include "cli/options/global_options.h"
#include "cli/options/vda_options.h"
#include "delivery/retained.h"

namespace fleetpub::cli {

class OptionSet;

/// `--interface` and `--topic-template`.
void DeclareTopicOptions(OptionSet& set, app::VdaOptions& options);

/// Options of `fleet` and `watch`.
struct FleetOptions {
  std::vector<std::string> words;  ///< none: all
  app::VdaOptions vda;
};

/// The robots and the topics' options.
void DeclareFleetOptions(OptionSet& set, FleetOptions& options);

/// `--discover`: a number of milliseconds. Errors: ErrorKind::kUsage.
[[nodiscard]] Result<delivery::RetainedOptions> ParseDiscover(const std::string& text);

/// `--for`: when to stop listening; empty: never. Errors: ErrorKind::kUsage.
[[nodiscard]] Result<mqtt::Deadline> ParseEnd(const std::string& duration);

/// Options of those that look around once.
struct FleetDiscoveryOptions {
  FleetOptions fleet;
  std::string discover = "300";
  std::string state_wait = "2s";
};

void DeclareFleetDiscoveryOptions(OptionSet& set, FleetDiscoveryOptions& options);

/// Errors: ErrorKind::kUsage.
[[nodiscard]] Result<app::FleetRequest> ParseFleetDiscoveryOptions(
    const FleetDiscoveryOptions& options);

}  // namespace fleetpub::cli
