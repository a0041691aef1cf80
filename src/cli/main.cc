#include "cli/main.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>

#include "base/text.h"
#include "cli/arguments.h"
#include "cli/help.h"

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

ExitCode RunMain(std::vector<std::string> arguments) {
  GlobalOptions options;
  CLI::App app;
  app.set_help_flag("-h,--help", "Print this help")->group("Output");
  app.set_version_flag(
         "--version", [] { return std::string("fleetpub " FLEETPUB_VERSION); }, "Print the version")
      ->group("Output");
  DeclareGlobalOptions(app, options);

  const auto invocation = FindSubcommand(app, std::move(arguments));
  if (!invocation) return Complain(invocation.error(), false);
  Run run;
  if (invocation->subcommand != nullptr) {
    run = invocation->subcommand->declare(app);
  } else if (!invocation->name.empty()) {
    run = DeclareInstantAction(app, invocation->name);
  }
  if (!run && !invocation->arguments.empty() && invocation->arguments.front() == "--") {
    return NoCommand();
  }
  try {
    if (const auto parsed = Parse(app, *invocation); !parsed) {
      return Complain(parsed.error(), options.verbose);
    }
  } catch (const CLI::CallForVersion& version) {
    fmt::print("{}\n", version.what());
    return ExitCode::kDone;
  } catch (const CLI::CallForHelp&) {
    return PrintHelp(app, *invocation);
  }
  if (!run) return NoCommand();

  const auto settings = OutputSettings(options);
  if (!settings) return Complain(settings.error(), options.verbose);
  Output output(*settings);
  return Finish(run(Context{options, output}), output);
}

}  // namespace

int Main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);  // a closed pipe is an error that we report, not our end
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
