#include "cli/main.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <memory>
#include <new>

#include "base/text.h"
#include "cli/call.h"
#include "cli/help.h"
#include "cli/shell_completion.h"

namespace fleetpub::cli {
namespace {

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
  // After sending, what the broker and the robots said weighs more than that nobody could read it.
  if (output.something_was_sent()) {
    output.Warn(flushed.error().message + ": fleetpub history shows them");
    return code;
  }
  output.Complain(flushed.error());
  return code == ExitCode::kDone ? ExitCode::kLedger : code;
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

ExitCode RunMain(const std::vector<std::string>& arguments) {
  if (!arguments.empty() && arguments.front() == kCompleteWord) return PrintCandidates(arguments);
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
      return PrintHelp(call->app(), call->invocation);
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
  } catch (const std::bad_alloc&) {
    std::fputs(
        "fleetpub: error: memory ran out, and whether anything was sent is not known (fleetpub "
        "history tells): allow it more (ulimit -v), or give it less at a time\n",
        stderr);
  } catch (const std::exception& error) {
    fmt::print(stderr,
               "fleetpub: error: nobody foresaw this, and whether anything was sent is not known "
               "(fleetpub history tells): please report it\nfleetpub: detail: {}\n",
               base::Printable(error.what()));
  }
  std::fflush(stdout);
  // Nothing is left to do, and the libraries' own clean-up costs more than the command did.
  _exit(static_cast<int>(code));
}

}  // namespace fleetpub::cli
