#include "cli/parser/command_line.h"

#include "config/config_files.h"

namespace fleetpub::cli {
Result<OptionSet::Asked> CommandLine::Read(OptionSet::Extent extent,
                                           const std::vector<std::string>& arguments) {
  OptionSet& set = set_.emplace(extent, arguments);
  DeclareGlobalOptions(set, options);
  auto found = FindSubcommand(set, arguments);
  if (!found) return Fail(std::move(found.error()));
  match = std::move(*found);
  if (match.subcommand != nullptr) {
    run = match.subcommand->declare(set);
  } else if (!match.name.empty()) {
    run = DeclareInstantAction(set, match.name);
  } else if (!match.arguments.empty() && match.arguments.front() == "--") {
    return OptionSet::Asked::kRun;
  }
  return set.Parse(match.name, match.arguments);
}

Status CommandLine::Configure() {
  if (match.subcommand != nullptr && match.subcommand->config == ConfigUse::kNone) {
    return {};
  }
  auto loaded = config::LoadConfig(options.config_file, options.profile);
  if (!loaded) return Fail(std::move(loaded.error()));
  config = *std::move(loaded);
  return ApplyConfig(config, *set_, options);
}

}  // namespace fleetpub::cli
