// What the commands that listen have in common: whose topics, and how long.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "base/result.h"
#include "cli/options/global_options.h"
#include "cli/options/vda_options.h"
#include "delivery/retained.h"
#include "vda5050/model/robot_pattern.h"
#include "vda5050/reports/fleet_view.h"

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

/// The words as a person reads them; `all` without any.
[[nodiscard]] std::string NameOf(const FleetOptions& options);

/// An empty view for these options. Errors: ErrorKind::kUsage.
[[nodiscard]] Result<vda5050::FleetView> FleetViewOf(const FleetOptions& options,
                                                     const Context& context);

/// What to say when so many robots' states could not be kept whole (FleetView::abridged).
[[nodiscard]] std::string AbridgedWarning(std::size_t robots);

/// `--discover`: a number of milliseconds. Errors: ErrorKind::kUsage.
[[nodiscard]] Result<delivery::RetainedOptions> DiscoverOf(const std::string& text);

}  // namespace fleetpub::cli
