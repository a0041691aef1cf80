// `fleetpub conform TARGET`: whether a robot keeps the standard.
#include "app/conform.h"

#include <fmt/format.h>
#include <unistd.h>

#include <memory>

#include "base/json.h"
#include "base/text.h"
#include "cli/environment.h"
#include "cli/layout_file.h"
#include "cli/listening.h"
#include "cli/one_robot.h"
#include "cli/options/report_options.h"
#include "cli/output/consent.h"
#include "cli/output/sending_observer.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"

namespace fleetpub::cli {
namespace {

using app::Verdict;
using app::conformance::Case;
using app::conformance::CaseResult;
using app::conformance::Level;
using base::JsonString;

constexpr std::string_view kExample = "fleetpub conform KIT/0001 --level actions";

constexpr auto kLevels = std::to_array<base::Choice<Level>>({
    {"listen", Level::kListen},
    {"actions", Level::kActions},
    {"drive", Level::kDrive},
});

struct ConformOptions : RobotOptions {
  Level level = Level::kListen;
  bool list = false;
  std::vector<std::string> only;
  std::vector<std::string> skip;
  std::chrono::milliseconds listen = std::chrono::seconds(40);
  std::string nodes;
  std::optional<double> distance;
  std::string layout_file;
  std::string vehicle_type;
  bool yes = false;
  std::vector<std::string> reports;
  std::string record;
};

// ---- The cases ----

std::string FormatVersions(const Case& one) {
  const auto name = [](vda5050::Version version) {
    return vda5050::GetFacts(version).name.substr(0, 3);
  };
  if (one.first == vda5050::kVersions.front() && one.last == vda5050::kVersions.back())
    return "all";
  if (one.first == one.last) return std::string(name(one.first));
  return fmt::format("{}-{}", name(one.first), name(one.last));
}

std::string ListJson(const Case& one) {
  return fmt::format(
      R"({{"id":"{}","level":"{}","versions":"{}","clause":"{}","says":{},"limit":"{}","advice":{},"person":{}}})",
      one.id, GetName(one.level), FormatVersions(one), one.clause, JsonString(one.says), one.limit,
      JsonString(one.advice), one.check == nullptr);
}

ExitCode ShowCases(Output& output) {
  for (const Case& one : app::conformance::ListCases()) {
    if (output.json()) {
      output.Line(ListJson(one));
      continue;
    }
    output.Line(fmt::format("{}  {:<7}  {:<7}  {} ({}){}{}", one.id,
                            one.check == nullptr ? "person" : GetName(one.level),
                            FormatVersions(one), one.says, one.clause,
                            one.limit.empty() ? "" : "; ", one.limit));
  }
  return ExitCode::kDone;
}

// ---- The results ----

void Show(const CaseResult& result, const std::string& target, std::string_view version,
          Output& output) {
  const auto& [of, finding] = result;
  if (output.json()) {
    return output.Line(fmt::format(
        R"({{"target":{},"version":"{}","id":"{}","level":"{}","verdict":"{}","says":{},"clause":"{}","limit":"{}","why":{},"evidence":{},"advice":{}}})",
        JsonString(target), version, of.id, GetName(of.level), GetName(finding.verdict),
        JsonString(of.says), of.clause, of.limit, JsonString(finding.why),
        base::JsonStrings(finding.evidence), JsonString(of.advice)));
  }
  output.Line(fmt::format("{}  {}  {} ({}): {}{}", VerdictColumn(finding.verdict, output), of.id,
                          of.says, of.clause, finding.why, SeeEvidence(finding.evidence)));
  if (finding.verdict == Verdict::kFail) {
    output.Line(fmt::format("              advice: {}", of.advice));
  }
}

TestReport MakeReport(const app::ConformReport& report, const ConformOptions& o,
                      const Context& context, base::WallTime started) {
  TestReport made{.name = "fleetpub conform " + report.target,
                  .properties = {{"robot", report.target},
                                 {"VDA 5050", report.version},
                                 {"level", std::string(GetName(o.level))},
                                 {"broker", FormatSite(context)}},
                  .started = started,
                  .results = {}};
  if (!report.abort_reason.empty())
    made.properties.emplace_back("ended early", report.abort_reason);
  for (const auto& [of, finding] : report.outcome.results) {
    TestResult result{.group = std::string(of.id.substr(0, 1)),
                      .id = std::string(of.id),
                      .says = std::string(of.says),
                      .verdict = finding.verdict,
                      .why = finding.why,
                      .details = finding.evidence};
    result.details.push_back(fmt::format("clause {}", of.clause));
    if (finding.verdict == Verdict::kFail) {
      result.details.push_back("advice: " + std::string(of.advice));
    }
    made.results.push_back(std::move(result));
  }
  return made;
}

ExitCode ShowSummary(const app::ConformReport& report, Output& output) {
  VerdictCounts counts;
  for (const CaseResult& result : report.outcome.results) counts.Add(result.finding.verdict);
  const ExitCode code = counts.ToExitCode(!report.abort_reason.empty());
  if (output.json()) {
    output.Line(fmt::format(
        R"({{"summary":{{"target":{},"version":"{}",{},"complete":{},"exitCode":{}}}}})",
        JsonString(report.target), report.version, counts.ToJson(), report.abort_reason.empty(),
        static_cast<int>(code)));
  } else {
    output.PeopleLine(fmt::format("{}, VDA 5050 {}: {}", base::Printable(report.target),
                                  report.version, counts.ToText()));
  }
  if (!report.abort_reason.empty()) output.Warn("not all was tested: " + report.abort_reason);
  for (const std::string& left : report.outcome.leftover) output.Important(left);
  return code;
}

// ---- Running ----

Status AgreeToDrive(const ConformOptions& o, const vda5050::RobotAddress& robot,
                    const std::string& extent, const Context& context) {
  if (o.yes) return {};
  const std::string text = fmt::format(
      "{} at {} drives: {}; a robot that breaks the standard may drive elsewhere. No load, "
      "nobody near it",
      base::Printable(robot.ToString()), FormatSite(context), extent);
  return AskOnTerminal(text + ". Go on", "nothing was sent: " + text + ". --yes agrees");
}

Result<app::ConformRequest> MakeRequest(const ConformOptions& o, const Context& context) {
  auto robot = MakeFollowRequest(o, kExample, context);
  if (!robot) return Fail(std::move(robot.error()));
  robot->timeout = std::chrono::hours(24);
  robot->ask = false;
  if (o.level != Level::kDrive && !(o.nodes.empty() && !o.distance)) {
    return Fail(ErrorKind::kUsage, "--nodes and --distance belong to --level drive");
  }
  if (!o.nodes.empty() && o.distance) {
    return Fail(ErrorKind::kUsage, "--nodes and --distance exclude each other");
  }
  const auto known = [](const std::string& word) {
    const auto cases = app::conformance::ListCases();
    return std::any_of(cases.begin(), cases.end(), [&](const Case& one) {
      return base::EqualsIgnoringCase(one.id, word) ||
             base::EqualsIgnoringCase(one.id.substr(0, 1), word);
    });
  };
  app::ConformRequest request{.robot = *std::move(robot), .tool = "fleetpub " FLEETPUB_VERSION};
  request.selection = {.level = o.level, .listen = o.listen};
  for (const auto* words : {&o.only, &o.skip}) {
    for (const std::string& word : *words) {
      for (std::string& id : base::Split(word, ',')) {
        if (!known(id)) {
          return Fail(ErrorKind::kUsage,
                      fmt::format("there is no case {}. try: fleetpub conform --list",
                                  base::Printable(id)));
        }
        (words == &o.only ? request.selection.only : request.selection.skip)
            .push_back(std::move(id));
      }
    }
  }
  if (!request.selection.RunsAny(app::conformance::ListCases())) {
    return Fail(ErrorKind::kUsage,
                fmt::format("--only and --skip leave no case of --level {}. try: fleetpub conform "
                            "--list",
                            GetName(o.level)));
  }
  if (!o.nodes.empty()) request.nodes = base::Split(o.nodes, ',');
  if (o.distance) request.distance = *o.distance;
  if (request.distance < 0.5) {
    return Fail(ErrorKind::kUsage, "--distance: at least 0.5 m, or nothing can be seen of it");
  }
  request.vehicle_type = o.vehicle_type;
  request.recording = o.record;
  if (!o.layout_file.empty() && !o.nodes.empty()) {
    auto site = LoadLayout(o.layout_file, context.output);
    if (!site) return Fail(std::move(site.error()));
    request.site = std::make_shared<const layout::Site>(*std::move(site));
  }
  return request;
}

Result<ExitCode> RunConform(const ConformOptions& o, const Context& context) {
  if (o.list) return ShowCases(context.output);
  auto request = MakeRequest(o, context);
  if (!request) return Fail(std::move(request.error()));
  const auto reports = ParseReportFiles(o.reports);
  if (!reports) return Fail(reports.error());
  SendingObserver observer(context.output, SendingObserver::Show::kResults, FormatSite(context));
  observer.ListenForStop();
  const auto started = base::WallTime::clock::now();
  const auto report = app::Conform(
      *request, MakeEnvironment(context),
      [&](const vda5050::RobotAddress& robot, const std::string& extent) {
        return AgreeToDrive(o, robot, extent, context);
      },
      {}, observer);
  if (!report) return Fail(report.error());
  for (const CaseResult& result : report->outcome.results) {
    Show(result, report->target, report->version, context.output);
  }
  const ExitCode code = ShowSummary(*report, context.output);
  if (auto written = WriteReports(*reports, MakeReport(*report, o, context, started)); !written) {
    return Fail(std::move(written.error()));
  }
  return code;
}

}  // namespace

Run DeclareConform(OptionSet& set) {
  constexpr const char* kTest = "Test";
  constexpr const char* kWay = "Way";
  const auto options = std::make_shared<ConformOptions>();
  set.AddOption("target", options->target, "The robot: manufacturer/serialNumber, or its alias")
      .Type("TARGET");
  set.AddOption("--level", OneOf(options->level, kLevels), "What is done to it: {} [listen]")
      .Type("WORD")
      .Group(kTest);
  set.AddOption("--only", options->only, "Only these cases, or groups of them: H,I01; repeatable")
      .Type("CASES")
      .OneValueEach()
      .Group(kTest);
  set.AddOption("--skip", options->skip, "Not these; repeatable")
      .Type("CASES")
      .OneValueEach()
      .Group(kTest);
  set.AddOption("--for", Duration(options->listen), "Listen for so long in all, at least [40s]")
      .Group(kTest);
  set.AddFlag("--list", options->list, "List the cases, and end").Group(kTest);
  set.AddOption("--distance", Measure(options->distance, vda5050::ParameterType::kLength),
                "So far straight on, and back, in m [2]")
      .Type("M")
      .Group(kWay);
  set.AddOption("--nodes", options->nodes, "Along these nodes, three or more, and back: n1,n2,n3")
      .Type("NODES")
      .Group(kWay);
  set.AddOption("--layout", options->layout_file,
                "Where they are, a LIF file [of the configuration]")
      .Type("FILE")
      .Key("layout")
      .Group(kWay);
  set.AddOption("--vehicle-type", options->vehicle_type,
                "The layout's name for it [manufacturer.series]")
      .Type("TYPE")
      .Group(kWay);
  set.AddFlag("--yes", options->yes, "Let it drive without asking").Group(kWay);
  DeclareReport(set, options->reports);
  DeclareRecord(set, options->record);
  DeclareVdaOptions(set, options->vda);
  return [options](const Context& context) { return RunConform(*options, context); };
}

}  // namespace fleetpub::cli
