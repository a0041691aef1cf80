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
  const ConfigUse use = match.subcommand == nullptr ? ConfigUse::kRead : match.subcommand->config;
  if (use == ConfigUse::kNone) return {};
  auto loaded = config::LoadConfig(options.config_file, options.profile);
  Status applied;
  if (loaded) {
    config = *std::move(loaded);
    applied = ApplyConfig(config, *set_, options);
  } else {
    applied = Fail(std::move(loaded.error()));
  }
  if (applied || use == ConfigUse::kRead) return applied;
  config::Config ignored;
  return CheckConfiguration(options, ignored).empty() ? applied : Status();
}

}  // namespace fleetpub::cli
