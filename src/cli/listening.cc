#include "cli/listening.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "base/time.h"
#include "cli/option_set.h"
#include "cli/targets.h"
#include "mqtt/paho_transport.h"

namespace fleetpub::cli {

using std::chrono::milliseconds;

void DeclareTopicOptions(OptionSet& set, VdaOptions& options) {
  set.AddOption("--interface", options.interface_name, "First topic level [any]")
      ->type_name("NAME")
      ->envname("FLEETPUB_INTERFACE")
      ->group("VDA 5050");
  set.AddOption("--topic-template", options.topic_template,
                "The topic, with its placeholders in braces (see the manual)")
      ->type_name("TEMPLATE")
      ->group("VDA 5050");
}

void DeclareFleetOptions(OptionSet& set, FleetOptions& options) {
  set.AddOption("pattern", options.pattern,
                "Robots: manufacturer/serialNumber with * and ?, quoted [all]")
      ->type_name("PATTERN");
  DeclareTopicOptions(set, options.vda);
}

Result<vda5050::FleetView> FleetViewOf(const FleetOptions& options, const Context& context) {
  const Config& config = context.config;
  const auto dialect = DialectOf(Configured(options.vda, config));
  if (!dialect) return Fail(dialect.error());
  std::string text = options.pattern.empty() ? "*/*" : options.pattern;
  if (const auto alias = config.aliases.find(text); alias != config.aliases.end()) {
    text = alias->second.ToString();
  }
  auto pattern = vda5050::ParseRobotPattern(text);
  if (!pattern) return Fail(std::move(pattern.error()));
  return vda5050::FleetView(dialect->topics, *std::move(pattern));
}

dispatch::ConnectHook ConnectHookOf(mqtt::ConnectOptions options) {
  return [options = std::move(options)](mqtt::Deadline deadline) {
    mqtt::ConnectOptions timely = options;
    const auto left = std::chrono::ceil<milliseconds>(deadline - std::chrono::steady_clock::now());
    timely.connect_timeout = std::clamp(left, milliseconds(1), options.connect_timeout);
    return mqtt::ConnectPaho(timely);
  };
}

Result<dispatch::CollectOptions> DiscoverOf(const std::string& text) {
  const auto quiet = base::ParseDuration(text, milliseconds(1));
  if (!quiet) return Fail(quiet.error());
  dispatch::CollectOptions options;
  options.quiet = *quiet;
  options.most = std::max(options.most, *quiet);
  return options;
}

}  // namespace fleetpub::cli
