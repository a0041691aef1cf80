// `fleetpub show TARGET…`: all that is known of robots, now.
#include <unistd.h>

#include <memory>

#include "app/show_robots.h"
#include "cli/environment.h"
#include "cli/listening.h"
#include "cli/options/target_options.h"
#include "cli/options/vda_options.h"
#include "cli/output/robot_sheet.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"

namespace fleetpub::cli {
namespace {

struct ShowOptions {
  TargetOptions targets{.state_wait = kUsualStateWait};
  app::VdaOptions vda;
  bool no_ask = false;
  std::chrono::milliseconds discover = kUsualDiscover;
  std::string from;
};

Result<app::ShowRequest> MakeRequest(const ShowOptions& o, const Context& context) {
  auto request = ParseTargetOptions(o.targets);
  if (!request) return Fail(std::move(request.error()));
  if (!o.from.empty()) request->state_wait = app::kUntilItEnds;
  auto targets = app::ResolveTargets(*std::move(request), context.config, context.output);
  if (!targets) return Fail(std::move(targets.error()));
  auto resolver = app::DialectResolver::Make(o.vda, context.config);
  if (!resolver) return Fail(std::move(resolver.error()));
  return app::ShowRequest{.targets = *std::move(targets),
                          .resolver = *std::move(resolver),
                          .ask = !o.no_ask && o.from.empty(),
                          .discover = MakeRetainedOptions(o.discover)};
}

void Show(const std::vector<app::RobotSheet>& sheets, bool is_one, base::WallTime now,
          Output& output) {
  const std::size_t width = TerminalWidth(STDOUT_FILENO);
  for (const app::RobotSheet& sheet : sheets) {
    if (output.json()) {
      output.Line(RobotSheetJson(sheet));
      continue;
    }
    if (&sheet != &sheets.front()) output.Line("");
    const Extent extent = is_one ? Extent::kWhole : Extent::kBlock;
    for (const std::string& line : RobotSheetLines(sheet, extent, width, now, output)) {
      output.Line(line);
    }
  }
}

Result<ExitCode> RunShow(const ShowOptions& o, const Context& context) {
  const auto request = MakeRequest(o, context);
  if (!request) return Fail(request.error());
  const auto environment = MakeEnvironment(context, o.from, delivery::Play::kLast);
  const auto shown = app::ShowRobots(*request, environment, context.output);
  if (!shown) return Fail(shown.error());
  const bool is_one = shown->sheets.size() + shown->unknown.size() == 1;
  Show(shown->sheets, is_one, environment.Now(), context.output);
  TellRecording(environment, context.output);
  if (shown->unknown.empty()) return ExitCode::kDone;
  for (const Error& error : std::span(shown->unknown).subspan(1)) {
    context.output.PrintError(error);
  }
  return Fail(shown->unknown.front());
}

}  // namespace

Run DeclareShow(OptionSet& set) {
  const auto options = std::make_shared<ShowOptions>();
  DeclareTargetWords(set, options->targets);
  DeclareSelectionFlags(set, options->targets);
  DeclareStateWait(set, options->targets.state_wait, "2s");
  DeclareDiscover(set, options->discover);
  set.AddFlag("--no-ask", options->no_ask,
              "Send no stateRequest: wait for the states that robots send anyway")
      .Group("Waiting");
  DeclareFrom(set, options->from);
  DeclareVdaOptions(set, options->vda);
  return [options](const Context& context) { return RunShow(*options, context); };
}

}  // namespace fleetpub::cli
