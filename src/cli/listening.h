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

/// `--discover`.
void DeclareDiscover(OptionSet& set, std::chrono::milliseconds& quiet,
                     std::string_view more_help = "");
[[nodiscard]] delivery::RetainedOptions MakeRetainedOptions(std::chrono::milliseconds quiet);

/// `--state-wait`.
void DeclareStateWait(OptionSet& set, std::chrono::milliseconds& state_wait);

/// `--for`: when to stop listening. Nothing: never.
[[nodiscard]] mqtt::Deadline FindEnd(std::optional<std::chrono::milliseconds> duration);

inline constexpr std::chrono::milliseconds kUsualDiscover{300};
inline constexpr std::chrono::milliseconds kUsualStateWait{2'000};

/// Options of those that look around once.
struct FleetDiscoveryOptions {
  FleetOptions fleet;
  std::chrono::milliseconds discover = kUsualDiscover;
  std::chrono::milliseconds state_wait = kUsualStateWait;
};

void DeclareFleetDiscoveryOptions(OptionSet& set, FleetDiscoveryOptions& options);

[[nodiscard]] app::FleetRequest MakeFleetRequest(const FleetDiscoveryOptions& options);

}  // namespace fleetpub::cli
