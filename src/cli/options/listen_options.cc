#include "cli/options/listen_options.h"

#include "cli/listening.h"
#include "cli/parser/option_set.h"

namespace fleetpub::cli {

void DeclareListenOptions(OptionSet& set, ListenOptions& options) {
  constexpr const char* kTargets = "Targets";
  DeclareTargetWords(set, options.targets, " [all]");
  set.AddOption("--except", options.targets.except,
                "But not this robot, alias, @group or pattern; repeatable")
      .Type("TARGET")
      .OneValueEach()
      .Group(kTargets);
  set.AddOption("--topic", options.topics, "Only state, connection, order …; repeatable [all]")
      .Type("TOPIC")
      .OneValueEach()
      .Group(kTargets);
  set.AddOption("--filter", options.filters,
                "Whatever is published here, in place of robots: 'soar/#'; repeatable")
      .Type("FILTER")
      .OneValueEach()
      .Group(kTargets);
  DeclareTopicOptions(set, options.vda);
}

Result<app::ListenRequest> ParseListenOptions(const ListenOptions& options) {
  const bool by_robot =
      !options.targets.words.empty() || !options.targets.except.empty() || !options.topics.empty();
  if (!options.filters.empty() && by_robot) {
    return Fail(ErrorKind::kUsage,
                "--filter says it all: without TARGET, --except and --topic, or without --filter");
  }
  auto targets = ParseTargetOptions(options.targets);
  if (!targets) return Fail(std::move(targets.error()));
  return app::ListenRequest{.targets = *std::move(targets),
                            .vda = options.vda,
                            .topics = options.topics,
                            .filters = options.filters};
}

}  // namespace fleetpub::cli
