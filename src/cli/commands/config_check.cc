// `fleetpub config path`, `config check`, `config profiles`: which files are read, what is wrong in
// them, and which sites they name.
#include <fmt/format.h>

#include <filesystem>

#include "base/json.h"
#include "base/text.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "config/config_files.h"

namespace fleetpub::cli {
namespace {

using base::JsonString;

Result<ExitCode> RunPath(const Context& context) {
  for (const auto& file : config::ListConfigFiles(context.options.config_file)) {
    std::error_code failed;
    const bool exists = std::filesystem::exists(file, failed);
    context.output.Line(
        context.output.json()
            ? fmt::format(R"({{"file":{},"exists":{}}})", JsonString(file.string()), exists)
            : fmt::format("{}{}", base::Printable(file.string()), exists ? "" : "  (not there)"));
  }
  return ExitCode::kDone;
}

Result<ExitCode> RunCheck(const Context& context) {
  config::Config config;
  const auto mistakes = CheckConfiguration(context.options, config);
  Output& output = context.output;
  for (const Error& mistake : mistakes) {
    output.Line(output.json() ? fmt::format(R"({{"message":{}}})", JsonString(mistake.message))
                              : mistake.message);
  }
  if (!mistakes.empty()) return ExitCode::kUsage;
  if (!output.json()) {
    output.PeopleLine(config.files.empty()
                          ? "no configuration file"
                          : "right: " + base::Printable(base::Join(config.files, ", ")));
  }
  return ExitCode::kDone;
}

Result<ExitCode> RunProfiles(const Context& context) {
  const config::Config& config = context.config;
  const std::string standard = config.default_profile ? config.default_profile->texts.front() : "";
  Output& output = context.output;
  for (const auto& [name, section] : config.profiles) {
    const auto own = section.find("broker");
    const auto general = config.settings.find("broker");
    std::vector<std::string> brokers;
    if (own != section.end()) {
      brokers = own->second.texts;
    } else if (general != config.settings.end()) {
      brokers = general->second.texts;
    }
    const bool is_default = name == standard;
    if (output.json()) {
      output.Line(fmt::format(R"({{"profile":{},"brokers":{},"default":{}}})", JsonString(name),
                              base::JsonStrings(brokers), is_default));
    } else {
      output.Line(fmt::format("{}  {}{}", base::Printable(name),
                              base::Printable(base::Join(brokers, ", ")),
                              is_default ? "  (default)" : ""));
    }
  }
  if (config.profiles.empty() && !output.json()) output.PeopleLine("no profiles");
  return ExitCode::kDone;
}

}  // namespace

Run DeclareConfigPath(OptionSet& /*set*/) { return RunPath; }

Run DeclareConfigCheck(OptionSet& /*set*/) { return RunCheck; }

Run DeclareConfigProfiles(OptionSet& /*set*/) { return RunProfiles; }

}  // namespace fleetpub::cli
