// `fleetpub explain TARGET [--from FILE]`: what became of an order or an action.
#include "app/explain.h"

#include <fmt/format.h>

#include <memory>
#include <optional>

#include "base/json.h"
#include "base/text.h"
#include "cli/environment.h"
#include "cli/listening.h"
#include "cli/output/test_report.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"

namespace fleetpub::cli {
namespace {

using base::JsonString;

struct ExplainOptions {
  std::string target;
  std::string order;
  std::string action;
  std::string from;
  std::optional<std::chrono::milliseconds> duration;
  app::VdaOptions vda;
};

std::string ToJson(const vda5050::RobotAddress& robot, const app::Explanation& told) {
  const auto or_null = [](const std::string& text) {
    return text.empty() ? "null" : JsonString(text);
  };
  std::string timeline;
  for (const app::TimelineEntry& entry : told.timeline) {
    timeline += fmt::format(R"({}{{"time":"{}","text":{}}})", timeline.empty() ? "" : ",",
                            base::FormatTimestamp(entry.at), JsonString(entry.text));
  }
  std::string findings;
  for (const app::ExplainFinding& finding : told.findings) {
    findings += fmt::format(
        R"({}{{"id":"{}","clause":"{}","verdict":"{}","text":{},"evidence":{}}})",
        findings.empty() ? "" : ",", finding.id, finding.clause, GetName(finding.verdict),
        JsonString(finding.text), base::JsonStrings(finding.evidence));
  }
  return fmt::format(R"({{"target":{},"order":{},"action":{},"timeline":[{}],"findings":[{}]}})",
                     JsonString(robot.ToString()), or_null(told.order), or_null(told.action),
                     timeline, findings);
}

void Show(const vda5050::RobotAddress& robot, const app::Explanation& told, Output& output) {
  if (output.json()) return output.Line(ToJson(robot, told));
  output.Line(fmt::format("{}  {}", base::Printable(robot.ToString()),
                          told.order.empty() ? "action " + base::Printable(told.action)
                                             : "order " + base::Printable(told.order)));
  for (const app::TimelineEntry& entry : told.timeline) {
    output.Line(fmt::format("  {}  {}", base::FormatLocal(entry.at), entry.text));
  }
  for (const app::ExplainFinding& finding : told.findings) {
    output.Line(fmt::format("{}  {:<9}  {} ({}){}", VerdictColumn(finding.verdict, output),
                            finding.id, finding.text, finding.clause,
                            SeeEvidence(finding.evidence)));
  }
}

Result<ExitCode> RunExplain(const ExplainOptions& o, const Context& context) {
  if (o.target.empty()) {
    return Fail(ErrorKind::kUsage, "explain needs a robot. try: fleetpub explain KIT/0001");
  }
  if (o.duration && !o.from.empty()) return Fail(NoTimeFrom("--for"));
  if (o.from == "-") {
    return Fail(ErrorKind::kUsage, "explain reads its file twice, and standard input once only");
  }
  auto robot = app::ResolveRobot(o.target, context.config);
  if (!robot) return Fail(std::move(robot.error()));
  const auto told = app::Explain({.robot = *robot,
                                  .vda = o.vda,
                                  .order = o.order,
                                  .action = o.action,
                                  .file = o.from,
                                  .listen = o.duration},
                                 MakeEnvironment(context), context.output);
  if (!told) return Fail(told.error());
  if (told->faults.unreadable > 0) {
    context.output.Warn(fmt::format("{} lines could not be read, the first at {}",
                                    told->faults.unreadable, told->faults.first));
  }
  Show(*robot, *told, context.output);
  return ExitCode::kDone;
}

}  // namespace

Run DeclareExplain(OptionSet& set) {
  const auto options = std::make_shared<ExplainOptions>();
  set.AddOption("target", options->target, "A robot: manufacturer/serialNumber, or its alias")
      .Type("TARGET");
  set.AddOption("--order", options->order, "The order [the last one that is known]")
      .Type("ID")
      .Group("Targets");
  set.AddOption("--action", options->action, "An action in its place").Type("ID").Group("Targets");
  DeclareFrom(set, options->from);
  set.AddOption("--for", Duration(options->duration),
                "Listen for this time [until the robot's next state, 35s at most]")
      .Group("Waiting");
  DeclareTopicOptions(set, options->vda);
  return [options](const Context& context) { return RunExplain(*options, context); };
}

}  // namespace fleetpub::cli
