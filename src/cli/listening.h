// What the commands that listen have in common: whose topics, and how long.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/fleet_discovery.h"
#include "base/result.h"
#include "cli/options/global_options.h"
#include "cli/options/target_options.h"
#include "cli/options/vda_options.h"
#include "cli/output/fleet_table.h"
#include "delivery/retained.h"

namespace fleetpub::cli {

class OptionSet;

/// `--interface` and `--topic-template`.
void DeclareTopicOptions(OptionSet& set, app::VdaOptions& options);

/// Of those that show robots.
struct FleetOptions {
  TargetOptions targets;  ///< none: all
  app::VdaOptions vda;
};

/// The robots and the topics' options.
void DeclareFleetOptions(OptionSet& set, FleetOptions& options);

/// Which of them are shown, and in which order.
struct FleetViewOptions {
  bool problems = false;
  std::optional<SortBy> sort;
};
void DeclareFleetViewOptions(OptionSet& set, FleetViewOptions& options);

inline constexpr std::chrono::milliseconds kUsualDiscover{300};
inline constexpr std::chrono::milliseconds kUsualStateWait = std::chrono::seconds(2);

/// `--from`.
void DeclareFrom(OptionSet& set, std::string& from);
/// It is over when it ends: this option has no use.
[[nodiscard]] Error NoTimeFrom(std::string_view option);

/// `--state-wait`. `usual`: what its help says that it is otherwise.
void DeclareStateWait(OptionSet& set, std::optional<std::chrono::milliseconds>& state_wait,
                      std::string_view usual);

/// `--discover`.
void DeclareDiscover(OptionSet& set, std::chrono::milliseconds& quiet,
                     std::string_view more_help = "");
[[nodiscard]] delivery::RetainedOptions MakeRetainedOptions(std::chrono::milliseconds quiet);

/// `--for`: when to stop listening. Nothing: never.
[[nodiscard]] mqtt::Deadline FindEnd(std::optional<std::chrono::milliseconds> duration);

/// Options of those that look around once.
struct FleetDiscoveryOptions {
  FleetOptions fleet;
  std::chrono::milliseconds discover = kUsualDiscover;
  /// Unless somebody says it, or a condition needs states.
  std::chrono::milliseconds state_wait = kUsualStateWait;
  bool ask = false;  ///< robots for their states
  std::string from;  ///< a recording; empty: the broker
};

void DeclareFleetDiscoveryOptions(OptionSet& set, FleetDiscoveryOptions& options);

/// Errors: ErrorKind::kUsage.
[[nodiscard]] Result<app::FleetRequest> ParseFleetOptions(const FleetOptions& options);
[[nodiscard]] Result<app::FleetRequest> ParseFleetOptions(const FleetDiscoveryOptions& options);

}  // namespace fleetpub::cli
