#include "cli/main.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <memory>
#include <optional>

#include "base/text.h"
#include "cli/arguments.h"
#include "cli/config_files.h"
#include "cli/help.h"
#include "cli/option_set.h"

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
    return Fail(ErrorKind::kUsage, fmt::format("{}: {} needs a value", invocation.name,
                                               base::Printable(what.substr(0, what.find(':')))));
  } catch (const CLI::ParseError& error) {
    return Fail(ErrorKind::kUsage,
                fmt::format("{}: {}", invocation.name, base::Printable(error.what())));
  }
  if (!app.remaining(true).empty()) return Fail(UnknownArguments(app, invocation.name));
  return {};
}

Result<Output::Settings> OutputSettings(const GlobalOptions& options) {
  if (options.format != "text" && options.format != "json") {
    return Fail(ErrorKind::kUsage, fmt::format("--output takes text or json, not '{}'",
                                               base::Printable(options.format)));
  }
  return Output::Settings{options.format == "json" ? Format::kJson : Format::kText, options.quiet,
                          options.verbose || options.debug};
}

ExitCode Complain(const Error& error, bool verbose) {
  Output({.verbose = verbose}).Complain(error);
  return CodeOf(error.kind);
}

ExitCode Finish(const Result<ExitCode>& result, Output& output) {
  if (!result) output.Complain(result.error());
  const ExitCode code = result ? *result : CodeOf(result.error().kind);
  const auto flushed = output.Flush();
  if (flushed) return code;
  output.Complain(flushed.error());
  // After sending, what the broker and the robots said weighs more than that nobody could read it.
  return code == ExitCode::kDone && !output.something_was_sent() ? ExitCode::kLedger : code;
}

ExitCode PrintHelp(const CLI::App& app, const Invocation& invocation) {
  const bool general = invocation.name.empty();
  fmt::print("{}", general ? GeneralHelp(app) : CommandHelp(app, invocation));
  return ExitCode::kDone;
}

ExitCode NoCommand() {
  fmt::print(stderr, "{}", ShortHelp());
  return ExitCode::kUsage;
}

// What the arguments ask for.
struct Call {
  GlobalOptions options;
  CLI::App app;
  std::optional<OptionSet> set;  // the options in it are asked until the end
  Invocation invocation;
  Run run;  ///< empty: no command was named
  Config config;

  // Errors: kUsage. Throws CLI::Success for --help and --version, which only Extent::kAll knows.
  Status Read(OptionSet::Extent extent, const std::vector<std::string>& arguments);

  // Takes from the configuration what the arguments leave open. Errors: kUsage.
  Status Configure();
};

Status Call::Read(OptionSet::Extent extent, const std::vector<std::string>& arguments) {
  set.emplace(app, extent, arguments);
  app.set_help_flag();
  if (extent == OptionSet::Extent::kAll) {
    app.set_help_flag("-h,--help", "Print this help")->group("Output");
    app.set_version_flag(
           "--version", [] { return std::string("fleetpub " FLEETPUB_VERSION); },
           "Print the version")
        ->group("Output");
  }
  DeclareGlobalOptions(*set, options);
  auto found = FindSubcommand(app, arguments);
  if (!found) return Fail(std::move(found.error()));
  invocation = std::move(*found);
  if (invocation.subcommand != nullptr) {
    run = invocation.subcommand->declare(*set);
  } else if (!invocation.name.empty()) {
    run = DeclareInstantAction(*set, invocation.name);
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
  ApplyConfig(config, *set, options);
  return {};
}

ExitCode RunMain(const std::vector<std::string>& arguments) {
  auto call = std::make_unique<Call>();
  if (!call->Read(OptionSet::Extent::kMentioned, arguments) || !call->run) {
    call = std::make_unique<Call>();
    try {
      if (const auto read = call->Read(OptionSet::Extent::kAll, arguments); !read) {
        return Complain(read.error(), call->options.verbose);
      }
    } catch (const CLI::CallForVersion& version) {
      fmt::print("{}\n", version.what());
      return ExitCode::kDone;
    } catch (const CLI::CallForHelp&) {
      return PrintHelp(call->app, call->invocation);
    }
    if (!call->run) return NoCommand();
  }
  if (const auto configured = call->Configure(); !configured) {
    return Complain(configured.error(), call->options.verbose);
  }
  const auto settings = OutputSettings(call->options);
  if (!settings) return Complain(settings.error(), call->options.verbose);
  Output output(*settings);
  return Finish(call->run(Context{call->options, output, call->config}), output);
}

}  // namespace

int Main(int argc, char** argv) {
  // A closed pipe and a file that may not grow are errors that we report, not our end.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  ExitCode code = ExitCode::kUnexpected;
  try {
    code = RunMain({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    fmt::print(stderr, "fleetpub: unexpected error: {}\n", error.what());
  }
  std::fflush(stdout);
  // Nothing is left to do, and the libraries' own clean-up costs more than the command did.
  _exit(static_cast<int>(code));
}

}  // namespace fleetpub::cli
