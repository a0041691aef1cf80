#include "cli/listening.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

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

mqtt::Deadline FindEnd(std::optional<milliseconds> duration) {
  return duration ? std::chrono::steady_clock::now() + *duration : mqtt::Deadline::max();
}

void DeclareDiscover(OptionSet& set, milliseconds& quiet, std::string_view more_help) {
  set.AddOption("--discover", Duration(quiet, milliseconds(1)),
                fmt::format("Silence in ms after which a retained message is not there [300]{}",
                            more_help))
      .Type("MS")
      .Group("Waiting");
}

delivery::RetainedOptions MakeRetainedOptions(milliseconds quiet) {
  delivery::RetainedOptions options;
  options.quiet = quiet;
  options.most = std::max(options.most, quiet);
  return options;
}

void DeclareStateWait(OptionSet& set, milliseconds& state_wait) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(state_wait);
  set.AddOption("--state-wait", Duration(state_wait),
                fmt::format("How long to wait for the states of robots that are online [{}s]",
                            seconds.count()))
      .Group("Waiting");
}

void DeclareFleetDiscoveryOptions(OptionSet& set, FleetDiscoveryOptions& options) {
  DeclareFleetOptions(set, options.fleet);
  DeclareStateWait(set, options.state_wait);
  DeclareDiscover(set, options.discover);
}

app::FleetRequest MakeFleetRequest(const FleetDiscoveryOptions& options) {
  return {.words = options.fleet.words,
          .vda = options.fleet.vda,
          .discover = MakeRetainedOptions(options.discover),
          .state_wait = options.state_wait};
}

}  // namespace fleetpub::cli
