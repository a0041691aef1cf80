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
  DeclareSelectionOptions(set, options.targets);
  DeclareTopicOptions(set, options.vda);
}

void DeclareFleetViewOptions(OptionSet& set, FleetViewOptions& options) {
  set.AddFlag("--problems", options.problems,
              "Only robots in trouble: an emergency stop, an error, a lost connection …")
      .Group("Targets");
  set.AddOption("--sort", OneOf(options.sort, kSortings),
                "In which order: {} [trouble; with -o json name]")
      .Group("Targets");
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

void DeclareStateWait(OptionSet& set, std::optional<milliseconds>& state_wait,
                      std::string_view usual) {
  set.AddOption(
         "--state-wait", Duration(state_wait),
         fmt::format("How long to wait for the states of robots that are online [{}]", usual))
      .Group("Waiting");
}

void DeclareFrom(OptionSet& set, std::string& from) {
  set.AddOption("--from", from, "Read a recording (fleetpub record) in the broker's place")
      .Type("FILE")
      .Group("Targets");
}

Error NoTimeFrom(std::string_view option) {
  return {ErrorKind::kUsage,
          fmt::format("{} is for a broker: a recording is read to its end", option)};
}

void DeclareFleetDiscoveryOptions(OptionSet& set, FleetDiscoveryOptions& options) {
  DeclareFleetOptions(set, options.fleet);
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(options.state_wait);
  DeclareStateWait(set, options.fleet.targets.state_wait,
                   fmt::format("{}s; 35s when --where needs them", seconds.count()));
  DeclareDiscover(set, options.discover);
  set.AddFlag("--ask", options.ask,
              "Send a stateRequest to robots that are online: their states come at once")
      .Group("Waiting");
  DeclareFrom(set, options.from);
}

Result<app::FleetRequest> ParseFleetOptions(const FleetOptions& options) {
  auto targets = ParseTargetOptions(options.targets);
  if (!targets) return Fail(std::move(targets.error()));
  return app::FleetRequest{.targets = *std::move(targets), .vda = options.vda};
}

Result<app::FleetRequest> ParseFleetOptions(const FleetDiscoveryOptions& options) {
  auto request = ParseFleetOptions(options.fleet);
  if (!request) return request;
  if (!options.from.empty()) {
    if (options.ask) return Fail(ErrorKind::kUsage, "--ask needs robots, and --from has none");
    request->targets.state_wait = app::kUntilItEnds;
    return request;
  }
  const bool waits_for_all =
      options.fleet.targets.state_wait || app::Need(request->targets.where, "state");
  if (!waits_for_all) request->targets.state_wait = options.state_wait;
  request->discover = MakeRetainedOptions(options.discover);
  request->ask = options.ask;
  return request;
}

}  // namespace fleetpub::cli
