// `fleetpub test FILE…`: scenarios of a user's own.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <set>

#include "app/test_scenarios.h"
#include "base/file.h"
#include "base/json.h"
#include "base/text.h"
#include "cli/environment.h"
#include "cli/listening.h"
#include "cli/options/report_options.h"
#include "cli/output/consent.h"
#include "cli/output/sending_observer.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "cli/scenario_commands.h"

namespace fleetpub::cli {
namespace {

using app::Verdict;
using app::scenario::Step;
using app::scenario::Suite;
using app::scenario::Test;
using app::scenario::TestEnd;
using base::JsonString;

struct TestOptions {
  std::vector<std::string> files;
  bool check = false;
  std::vector<std::string> only;
  std::vector<std::string> skip;
  bool yes = false;
  std::vector<std::string> reports;
  std::string record;
  app::VdaOptions vda;
};

// ---- Reading ----

bool NamesOne(const std::vector<std::string>& words, const Test& test) {
  const std::string name = base::ToLower(test.name);
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    return name.find(base::ToLower(word)) != std::string::npos;
  });
}

// Those that are chosen. Errors: the last mistake, once the others are told.
Result<std::vector<Suite>> ReadSuites(const TestOptions& o, const ScenarioCommands& commands,
                                      const Context& context) {
  constexpr std::size_t kLargest = std::size_t{1} << 20;
  if (o.files.empty()) {
    return Fail(ErrorKind::kUsage, "name the scenarios. try: fleetpub test smoke.toml");
  }
  config::Mistakes mistakes;
  std::vector<Suite> suites;
  for (const std::string& file : o.files) {
    const auto text = base::ReadFile(file, kLargest);
    if (!text) {
      mistakes.push_back(text.error());
      continue;
    }
    suites.push_back(app::scenario::ReadSuite(
        *text, file, context.config, [&](Step& step) { return commands.Check(step); }, mistakes));
  }
  if (!mistakes.empty()) {
    Error last = std::move(mistakes.back());
    mistakes.pop_back();
    for (const Error& mistake : mistakes) context.output.PrintError(mistake);
    return Fail(std::move(last));
  }
  std::size_t chosen = 0;
  for (Suite& suite : suites) {
    std::erase_if(suite.tests, [&](const Test& test) {
      return (!o.only.empty() && !NamesOne(o.only, test)) || NamesOne(o.skip, test);
    });
    chosen += suite.tests.size();
  }
  if (chosen > 0) return suites;
  return Fail(ErrorKind::kUsage, "--only and --skip leave no test");
}

ExitCode ShowSuites(const std::vector<Suite>& suites, Output& output) {
  for (const Suite& suite : suites) {
    std::size_t steps = 0;
    for (const Test& test : suite.tests) steps += test.steps.size();
    if (output.json()) {
      output.Line(fmt::format(R"({{"file":{},"tests":{},"steps":{}}})", JsonString(suite.file),
                              suite.tests.size(), steps));
    } else {
      output.PeopleLine(fmt::format("{}: {} tests, {} steps", base::Printable(suite.file),
                                    suite.tests.size(), steps));
    }
  }
  return ExitCode::kDone;
}

Status AgreeToReal(const TestOptions& o, const std::vector<Suite>& suites, const Context& context) {
  std::set<std::string> real;
  for (const Suite& suite : suites) {
    for (const Test& test : suite.tests) {
      if (!test.skip.empty()) continue;
      const auto some = test.ListReal();
      real.insert(some.begin(), some.end());
    }
  }
  if (o.yes || real.empty()) return {};
  const std::string text =
      base::Printable(fmt::format("the tests command {} at {}, which they do not simulate",
                                  fmt::join(real, ", "), FormatSite(context)));
  return AskOnTerminal(text + ". Go on", "nothing was sent: " + text + ". --yes agrees");
}

// ---- The results ----

std::string DescribeEnd(const TestEnd& end) {
  if (end.step == nullptr) return end.finding.why;
  return fmt::format("line {}, {}: {}", end.step->line, base::Printable(end.step->text),
                     end.finding.why);
}

void Show(const Suite& suite, const Test& test, const TestEnd& end, Output& output) {
  const auto& finding = end.finding;
  const bool decided = end.step != nullptr;
  if (output.json()) {
    return output.Line(fmt::format(
        R"({{"file":{},"line":{},"test":{},"verdict":"{}","why":{},"step":{},"stepLine":{},"evidence":{},"elapsedMs":{:.3f}}})",
        JsonString(suite.file), test.line, JsonString(test.name), GetName(finding.verdict),
        JsonString(finding.why), decided ? JsonString(end.step->text) : "null",
        decided ? std::to_string(end.step->line) : "null", base::JsonStrings(finding.evidence),
        std::chrono::duration<double, std::milli>(end.elapsed).count()));
  }
  const std::string line = fmt::format("{}  {}: {}: {}{}", VerdictColumn(finding.verdict, output),
                                       base::Printable(suite.file), base::Printable(test.name),
                                       DescribeEnd(end), SeeEvidence(finding.evidence));
  finding.verdict == Verdict::kPass ? output.PeopleLine(line) : output.Line(line);
}

TestResult MakeResult(const Suite& suite, const Test& test, const TestEnd& end) {
  return {.group = suite.file,
          .id = test.name,
          .says = {},
          .verdict = end.finding.verdict,
          .why = DescribeEnd(end),
          .details = end.finding.evidence};
}

ExitCode ShowSummary(std::size_t files, const VerdictCounts& counts, Output& output) {
  const ExitCode code = counts.ToExitCode(counts.inconclusive > 0);
  if (output.json()) {
    output.Line(fmt::format(R"({{"summary":{{"files":{},{},"complete":{},"exitCode":{}}}}})", files,
                            counts.ToJson(), !StopSignal::Received(), static_cast<int>(code)));
  } else {
    output.PeopleLine(counts.ToText());
  }
  return code;
}

Result<ExitCode> RunTest(const TestOptions& o, const OptionSet& set, const Context& context) {
  if (context.options.ask_password) {
    return Fail(ErrorKind::kUsage,
                "test starts commands that cannot ask: use --password-file or FLEETPUB_PASSWORD");
  }
  const ScenarioCommands commands(set, context);
  auto suites = ReadSuites(o, commands, context);
  if (!suites) return Fail(std::move(suites.error()));
  if (o.check) return ShowSuites(*suites, context.output);
  const auto reports = ParseReportFiles(o.reports);
  if (!reports) return Fail(reports.error());
  if (auto agreed = AgreeToReal(o, *suites, context); !agreed) return Fail(agreed.error());
  TestReport report{.name = "fleetpub test",
                    .properties = {{"broker", FormatSite(context)}},
                    .started = base::WallTime::clock::now(),
                    .results = {}};
  SendingObserver observer(context.output, SendingObserver::Show::kResults, FormatSite(context));
  observer.ListenForStop();
  VerdictCounts counts;
  const app::ScenarioRequest request{
      .suites = *std::move(suites),
      .vda = o.vda,
      .recording = o.record,
      .tool = "fleetpub " FLEETPUB_VERSION,
      .start = [&](const auto& words, const auto& input) { return commands.Start(words, input); }};
  const auto tested = app::TestScenarios(
      request, MakeEnvironment(context),
      [&](const Suite& suite, const Test& test, const TestEnd& end) {
        Show(suite, test, end, context.output);
        Output::FlushNow();
        counts.Add(end.finding.verdict);
        report.results.push_back(MakeResult(suite, test, end));
      },
      observer);
  if (StopSignal::Received()) report.properties.emplace_back("ended early", "interrupted");
  const auto written = WriteReports(*reports, std::move(report));
  if (!tested) return Fail(tested.error());
  const ExitCode code = ShowSummary(request.suites.size(), counts, context.output);
  if (!written) return Fail(written.error());
  return code;
}

}  // namespace

Run DeclareTest(OptionSet& set) {
  constexpr const char* kTests = "Tests";
  const auto options = std::make_shared<TestOptions>();
  set.AddOption("file", options->files, "Scenarios, in TOML").Type("FILE");
  set.AddFlag("--check", options->check, "Only read the files: all that is wrong in them")
      .Group(kTests);
  set.AddOption("--only", options->only, "Only tests whose name has this text; repeatable")
      .Type("TEXT")
      .OneValueEach()
      .Group(kTests);
  set.AddOption("--skip", options->skip, "Not these; repeatable")
      .Type("TEXT")
      .OneValueEach()
      .Group(kTests);
  set.AddFlag("--yes", options->yes, "Command robots that are not simulated, without asking")
      .Group(kTests);
  DeclareReport(set, options->reports);
  DeclareRecord(set, options->record);
  DeclareTopicOptions(set, options->vda);
  return [options, &set](const Context& context) { return RunTest(*options, set, context); };
}

}  // namespace fleetpub::cli
