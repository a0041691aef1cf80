#include "cli/main.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <csignal>
#include <cstdio>
#include <memory>
#include <new>

#include "base/text.h"
#include "cli/commands/version.h"
#include "cli/output/output_kinds.h"
#include "cli/output/pager.h"
#include "cli/parser/command_line.h"
#include "cli/parser/help.h"
#include "cli/parser/help_json.h"
#include "cli/parser/shell_completion.h"

namespace fleetpub::cli {
namespace {

// What a script asked for, even if its command line cannot be read.
Format FormatOfErrors(const std::vector<std::string>& arguments, const GlobalOptions& options) {
  const auto asks = [&](std::size_t i) {
    const std::string& word = arguments[i];
    const bool is_option = word == "-o" || word == "--output";
    return word == "-ojson" || word == "--output=json" ||
           (is_option && i + 1 < arguments.size() && arguments[i + 1] == "json");
  };
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (asks(i)) return Format::kJson;
  }
  return options.format == "json" ? Format::kJson : Format::kText;
}

// Ends a command that could not begin.
ExitCode EndBefore(const Error& error, const std::vector<std::string>& arguments,
                   const GlobalOptions& options) {
  Output output({.format = FormatOfErrors(arguments, options), .verbose = options.verbose});
  output.PrintFinalError(error, GetExitCode(error.kind));
  return GetExitCode(error.kind);
}

ExitCode Finish(const Result<ExitCode>& result, Output& output) {
  const ExitCode code = result ? *result : GetExitCode(result.error().kind);
  if (!result) output.PrintFinalError(result.error(), code);
  const auto flushed = output.Flush();
  if (flushed) return code;
  // After sending, what the broker and the robots said weighs more than that nobody could read it.
  if (output.something_was_sent()) {
    output.Warn(flushed.error().message + ": fleetpub history shows them");
    return code;
  }
  output.PrintError(flushed.error());
  return code == ExitCode::kDone ? ExitCode::kLedger : code;
}

ExitCode PrintText(const std::string& text) {
  Output output({});
  Print(stdout, text);
  return Finish(ExitCode::kDone, output);
}

// `-h localhost` is what MQTT's own tools take: a script that means it must not take help for done.
bool IsMeantAsHost(const std::vector<std::string>& arguments) {
  const auto help = std::find(arguments.begin(), arguments.end(), "-h");
  return help != arguments.begin() && std::distance(help, arguments.end()) > 1 &&
         !(help + 1)->starts_with('-');
}

ExitCode PrintHelp(OptionSet::Asked asked, const CommandLine& call,
                   const std::vector<std::string>& arguments) {
  if (IsMeantAsHost(arguments)) {
    return EndBefore(
        {ErrorKind::kUsage, "-h shows the help and takes no value: the broker's host is --host"},
        arguments, {});
  }
  const SubcommandMatch& match = call.match;
  if (asked == OptionSet::Asked::kHelp && FormatOfErrors(arguments, {}) == Format::kJson) {
    Output output({.format = Format::kJson});
    output.Line(HelpJson(call));
    return Finish(ExitCode::kDone, output);
  }
  if (match.family != nullptr) return PrintText(FamilyHelp(*match.family));
  if (asked == OptionSet::Asked::kBriefHelp) {
    return PrintText(match.name.empty() ? EverydayHelp() : BriefHelp(call.set(), match));
  }
  const std::string text =
      match.name.empty() ? GeneralHelp(call.set()) : CommandHelp(call.set(), match);
  return ShowInPager(text) ? ExitCode::kDone : PrintText(text);
}

ExitCode NoCommand() {
  Print(stderr, EverydayHelp());
  return ExitCode::kUsage;
}

// What the command's objects are to be shown as.
Result<Records> MakeRecords(const CommandLine& call) {
  const GlobalOptions& options = call.options;
  if (FindFormat(options.format) == Format::kOpenMetrics && call.match.name != "fleet") {
    return Fail(
        ErrorKind::kUsage,
        fmt::format("{} has no metrics. try: fleetpub fleet -o openmetrics", call.match.name));
  }
  const bool is_plain = options.format == "text" || options.format == "json";
  if (is_plain && options.fields.empty()) return Records();
  const std::string schema = FindOutputSchema(call.match.name, call.match.arguments);
  return Records::Make(options.format, options.fields,
                       schema.empty() ? std::vector<std::string>() : ListMembers(schema));
}

ExitCode RunMain(const std::vector<std::string>& arguments, const BuildInfo& build) {
  if (!arguments.empty() && arguments.front() == kCompleteWord) return PrintCandidates(arguments);
  auto call = std::make_unique<CommandLine>();
  if (!call->Read(OptionSet::Extent::kMentioned, arguments) || !call->run) {
    call = std::make_unique<CommandLine>();
    const auto asked = call->Read(OptionSet::Extent::kAll, arguments);
    if (!asked) return EndBefore(asked.error(), arguments, call->options);
    if (*asked == OptionSet::Asked::kVersion) return PrintText(VersionText(build) + "\n");
    if (*asked != OptionSet::Asked::kRun || call->match.family != nullptr) {
      return PrintHelp(*asked, *call, arguments);
    }
    if (!call->run) return NoCommand();
  }
  if (const auto configured = call->Configure(); !configured) {
    return EndBefore(configured.error(), arguments, call->options);
  }
  const GlobalOptions& options = call->options;
  auto records = MakeRecords(*call);
  if (!records) return EndBefore(records.error(), arguments, options);
  Output output({.format = FindFormat(options.format),
                 .records = *std::move(records),
                 .quiet = options.quiet,
                 .verbose = options.verbose || !options.debug.empty(),
                 .color = options.color});
  return Finish(call->run(Context{options, output, call->config}), output);
}

// One that is closed would be the number of the next file that is opened: a result would be written
// into the connection. In its place comes what cannot be read or written, and for errors nothing.
void FillStandardDescriptors() {
  constexpr std::array kModes = {O_WRONLY, O_RDONLY, O_WRONLY};
  for (int descriptor = 0; descriptor < static_cast<int>(kModes.size()); ++descriptor) {
    if (fcntl(descriptor, F_GETFD) != -1) continue;
    const int opened = open("/dev/null", kModes[static_cast<std::size_t>(descriptor)]);
    if (opened == -1) return;
    assert(opened == descriptor);  // the lowest that is free
  }
}

// A core holds passwords. One byte, not none: a kernel that hands cores to a program (systemd's,
// for one) asks for the limit only when it is 1 (core(5)).
void ForbidCores() {
  rlimit limit{};
  getrlimit(RLIMIT_CORE, &limit);
  limit.rlim_cur = 1;
  if (setrlimit(RLIMIT_CORE, &limit) != 0) prctl(PR_SET_DUMPABLE, 0);
}

}  // namespace

int Main(int argc, char** argv, const BuildInfo& build) {
  ForbidCores();
  FillStandardDescriptors();
  // A closed pipe and a file that may not grow are errors that we report, not our end.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  ExitCode code = ExitCode::kUnexpected;
  try {
    code = RunMain({argv + 1, argv + argc}, build);
  } catch (const std::bad_alloc&) {
    std::fputs(
        "fleetpub: error: memory ran out, and whether anything was sent is not known (fleetpub "
        "history shows it): allow more (ulimit -v), or send less at a time\n",
        stderr);
  } catch (const std::exception& error) {
    Print(stderr,
          fmt::format("fleetpub: error: unexpected, and whether anything was sent is not known "
                      "(fleetpub history shows it): please report this\nfleetpub: detail: {}\n",
                      base::Printable(error.what())));
  }
  std::fflush(stdout);
  // Nothing is left to do, and the libraries' own clean-up costs more than the command did.
  _exit(static_cast<int>(code));
}

}  // namespace fleetpub::cli
