#include "cli/listening.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/targets.h"
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

std::string NameOf(const FleetOptions& options) {
  return options.words.empty() ? "all" : base::Printable(base::Join(options.words, " "));
}

Result<vda5050::FleetView> FleetViewOf(const FleetOptions& options, const Context& context) {
  const auto dialect = app::ParseDialect(app::Configured(options.vda, context.config));
  if (!dialect) return Fail(dialect.error());
  auto words = app::ParseTargetSpec(options.words, context.config, context.output);
  if (!words) return Fail(std::move(words.error()));
  auto patterns = std::move(words->patterns);
  for (const vda5050::RobotAddress& robot : words->robots) {
    patterns.push_back(vda5050::RobotPattern::Of(robot));
  }
  return vda5050::FleetView(dialect->topics, std::move(patterns));
}

std::string AbridgedWarning(std::size_t robots) {
  return fmt::format(
      "robots say more than is kept: of {} of them the worst error is shown, texts are cut with "
      "…, and requests are left out. try: fewer TARGETs",
      robots);
}

Result<delivery::RetainedOptions> DiscoverOf(const std::string& text) {
  const auto quiet = base::ParseDuration(text, milliseconds(1));
  if (!quiet) return Fail(quiet.error());
  delivery::RetainedOptions options;
  options.quiet = *quiet;
  options.most = std::max(options.most, *quiet);
  return options;
}

}  // namespace fleetpub::cli
