#include "cli/listening.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "base/text.h"
#include "base/time.h"
#include "cli/parser/option_set.h"

namespace fleetpub::cli {

using std::chrono::milliseconds;

void DeclareTopicOptions(OptionSet& set, app::VdaOptions& options) {
  set.AddOption("--interface", options.interface_name, "First topic level [any]")
      .Type("NAME")
      .Variable("FLEETPUB_INTERFACE")
      .Group("VDA 5050");
  set.AddOption("--topic-template", options.topic_template,
                "The topic, with its placeholders in braces (see the manual)")
      .Type("TEMPLATE")
      .Group("VDA 5050");
}

void DeclareFleetOptions(OptionSet& set, FleetOptions& options) {
  set.AddOption("targets", options.words,
                "Robots: manufacturer/serialNumber, alias, @group, 'KIT/*' [all]")
      .Type("TARGET");
  DeclareTopicOptions(set, options.vda);
}

Result<mqtt::Deadline> ParseEnd(const std::string& duration) {
  if (duration.empty()) return mqtt::Deadline::max();
  const auto time = base::ParseDuration(duration);
  if (!time) return Fail(time.error());
  return std::chrono::steady_clock::now() + *time;
}

Result<delivery::RetainedOptions> ParseDiscover(const std::string& text) {
  const auto quiet = base::ParseDuration(text, milliseconds(1));
  if (!quiet) return Fail(quiet.error());
  delivery::RetainedOptions options;
  options.quiet = *quiet;
  options.most = std::max(options.most, *quiet);
  return options;
}

void DeclareFleetDiscoveryOptions(OptionSet& set, FleetDiscoveryOptions& options) {
  DeclareFleetOptions(set, options.fleet);
  set.AddOption("--state-wait", options.state_wait,
                fmt::format("How long to wait for the states of robots that are online [{}]",
                            options.state_wait))
      .Type("TIME")
      .Group("Waiting");
  set.AddOption("--discover", options.discover,
                "Silence in ms after which a retained message is not there [300]")
      .Type("MS")
      .Group("Waiting");
}

Result<app::FleetRequest> ParseFleetDiscoveryOptions(const FleetDiscoveryOptions& options) {
  auto discover = ParseDiscover(options.discover);
  if (!discover) return Fail(std::move(discover.error()));
  const auto state_wait = base::ParseDuration(options.state_wait);
  if (!state_wait) return Fail(state_wait.error());
  return app::FleetRequest{.words = options.fleet.words,
                           .vda = options.fleet.vda,
                           .discover = *discover,
                           .state_wait = *state_wait};
}

}  // namespace fleetpub::cli
