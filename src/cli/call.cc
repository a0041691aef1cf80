#include "cli/call.h"

#include "cli/config_files.h"

namespace fleetpub::cli {
Result<OptionSet::Asked> Call::Read(OptionSet::Extent extent,
                                    const std::vector<std::string>& arguments) {
  OptionSet& set = set_.emplace(extent, arguments);
  DeclareGlobalOptions(set, options);
  auto found = FindSubcommand(set, arguments);
  if (!found) return Fail(std::move(found.error()));
  invocation = std::move(*found);
  if (invocation.subcommand != nullptr) {
    run = invocation.subcommand->declare(set);
  } else if (!invocation.name.empty()) {
    run = DeclareInstantAction(set, invocation.name);
  } else if (!invocation.arguments.empty() && invocation.arguments.front() == "--") {
    return OptionSet::Asked::kRun;
  }
  return set.Parse(invocation.name, invocation.arguments);
}

Status Call::Configure() {
  if (invocation.subcommand != nullptr && invocation.subcommand->config == ConfigUse::kNone) {
    return {};
  }
  auto loaded = LoadConfig(options.config_file, options.profile);
  if (!loaded) return Fail(std::move(loaded.error()));
  config = *std::move(loaded);
  return ApplyConfig(config, *set_, options);
}

}  // namespace fleetpub::cli
