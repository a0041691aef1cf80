#include "cli/call.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "base/text.h"
#include "cli/config_files.h"
#include "cli/version.h"

namespace fleetpub::cli {
namespace {

std::vector<std::string_view> LongNames(const CLI::App& app) {
  std::vector<std::string_view> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back(name);
  }
  return names;
}

// `--tiemout` → the sentence with the nearest option.
Error UnknownArguments(const CLI::App& app, const std::string& command) {
  const std::string first = app.remaining(true).front();
  std::string hint = fmt::format("fleetpub {} --help lists its options", command);
  if (first.starts_with("--")) {
    const std::string name = first.substr(2, first.find('=') - 2);
    if (const auto nearest = base::Nearest(name, LongNames(app))) {
      hint = fmt::format("did you mean --{}?", *nearest);
    }
  }
  return {ErrorKind::kUsage,
          fmt::format("{}: '{}' is not understood: {}", command, base::Printable(first), hint)};
}

// CLI11's sentence names the option somewhere; ours says what it was given.
Error NotTaken(const CLI::App& app, const std::string& command, std::string_view what) {
  for (const CLI::Option* option : app.get_options()) {
    const std::string name = option->get_name();
    if (name.empty() || what.find(name) == std::string_view::npos) continue;
    const std::string given = base::Printable(base::Join(option->results(), " "));
    const std::string why = option->get_expected_max() == 0
                                ? "takes no value"
                                : fmt::format("does not take '{}'", given);
    return {ErrorKind::kUsage,
            fmt::format("{0}: {1} {2}: fleetpub {0} --help says what it takes", command, name, why),
            std::string(what)};
  }
  return {ErrorKind::kUsage,
          fmt::format("{0}: the arguments are not understood: fleetpub {0} --help", command),
          std::string(what)};
}

// CLI11 throws; the rest of the program does not.
Status Parse(CLI::App& app, const Invocation& invocation) {
  std::vector<std::string> reversed(invocation.arguments.rbegin(), invocation.arguments.rend());
  app.allow_extras();
  try {
    app.parse(std::move(reversed));
  } catch (const CLI::Success&) {
    throw;  // --help, --version
  } catch (const CLI::ArgumentMismatch& error) {
    const std::string_view what = error.what();
    const bool too_many = what.find("At Most") != std::string_view::npos;
    return Fail(
        ErrorKind::kUsage,
        fmt::format("{}: {} {}", invocation.name, base::Printable(what.substr(0, what.find(':'))),
                    too_many ? "is given more than once" : "needs a value"));
  } catch (const CLI::ParseError& error) {
    return Fail(NotTaken(app, invocation.name, error.what()));
  }
  if (!app.remaining(true).empty()) return Fail(UnknownArguments(app, invocation.name));
  return {};
}

}  // namespace

Call::Call() : app_(std::make_unique<CLI::App>()) {}

Call::~Call() = default;

Status Call::Read(OptionSet::Extent extent, const std::vector<std::string>& arguments) {
  CLI::App& app = *app_;
  set_.emplace(app, extent, arguments);
  app.set_help_flag();
  if (extent == OptionSet::Extent::kAll) {
    app.set_help_flag("-h,--help", "Print this help")->group("Output");
    app.set_version_flag("--version", VersionText, "Print the version")->group("Output");
  }
  DeclareGlobalOptions(*set_, options);
  auto found = FindSubcommand(app, arguments);
  if (!found) return Fail(std::move(found.error()));
  invocation = std::move(*found);
  if (invocation.subcommand != nullptr) {
    run = invocation.subcommand->declare(*set_);
  } else if (!invocation.name.empty()) {
    run = DeclareInstantAction(*set_, invocation.name);
  } else if (!invocation.arguments.empty() && invocation.arguments.front() == "--") {
    return {};
  }
  return Parse(app, invocation);
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
