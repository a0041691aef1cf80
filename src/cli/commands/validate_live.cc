#include "cli/commands/validate_live.h"

#include <fmt/format.h>

#include <map>
#include <optional>
#include <utility>

#include "app/validate_live.h"
#include "base/json.h"
#include "base/text.h"
#include "cli/environment.h"
#include "cli/listening.h"
#include "cli/options/report_options.h"
#include "cli/output/interrupt.h"
#include "cli/output/stop_signal.h"
#include "cli/parser/option_set.h"

namespace fleetpub::cli {
namespace {

using vda5050::ValidationResult;

using Tally = app::LiveSummary::Tally;

std::string TallyJson(const Tally& tally) {
  return fmt::format(R"("messages":{},"valid":{},"invalid":{})", tally.messages,
                     tally.messages - tally.invalid, tally.invalid);
}

std::string TallyText(const Tally& tally) {
  return fmt::format("{}, {} valid, {} invalid", base::Counted(tally.messages, "message"),
                     tally.messages - tally.invalid, tally.invalid);
}

void ShowSummary(const app::LiveSummary& summary, Output& output) {
  if (output.json()) {
    std::string topics;
    for (const auto& [topic, tally] : summary.by_topic) {
      topics += fmt::format(R"({}"{}":{{{}}})", topics.empty() ? "" : ",", topic, TallyJson(tally));
    }
    output.Line(fmt::format(R"({{{},"withoutConnection":{},"topics":{{{}}}}})",
                            TallyJson(summary.all), summary.without_connection, topics));
    return;
  }
  for (const auto& [topic, tally] : summary.by_topic) {
    output.PeopleLine(fmt::format("{:<14}  {}", topic, TallyText(tally)));
  }
  output.PeopleLine(fmt::format("{:<14}  {}", "all", TallyText(summary.all)));
}

// What one robot said on one topic, as a case. Findings that are alike are told once.
class Case {
 public:
  void Add(const mqtt::Message& message, const ValidationResult& result) {
    const auto& [errors, warnings, satisfies_schema] = result.findings;
    if (!message.payload.empty()) ++tally_.messages;
    if (!errors.empty()) ++tally_.invalid;
    for (const auto* list : {&errors, &warnings}) {
      for (const auto& [path, words] : *list) {
        const std::string text = fmt::format("{}{}{}{}", list == &errors ? "" : "warning: ", path,
                                             path.empty() ? "" : ": ", words);
        Note(text, result.header_id);
      }
    }
  }

  [[nodiscard]] TestResult Result(const std::string& robot, const std::string& topic) const {
    TestResult result{.group = robot,
                      .id = robot + " " + topic,
                      .says = "messages are valid",
                      .verdict = tally_.invalid > 0 ? app::Verdict::kFail : app::Verdict::kPass,
                      .why = TallyText(tally_),
                      .details = {}};
    for (const auto& [text, seen] : findings_) {
      result.details.push_back(
          fmt::format("{} ({}x{})", text, seen.second,
                      seen.first ? fmt::format(", first headerId {}", *seen.first) : ""));
    }
    if (more_ > 0) result.details.push_back(fmt::format("{} more findings", more_));
    return result;
  }

 private:
  void Note(const std::string& text, std::optional<std::uint32_t> header_id) {
    constexpr std::size_t kMost = 100;
    const auto found = findings_.find(text);
    if (found != findings_.end()) {
      ++found->second.second;
    } else if (findings_.size() < kMost) {
      findings_.emplace(text, std::pair(header_id, 1));
    } else {
      ++more_;
    }
  }

  Tally tally_;
  std::map<std::string, std::pair<std::optional<std::uint32_t>, std::size_t>> findings_;
  std::size_t more_ = 0;
};

// Prints what is found. Once it has begun, the first Ctrl-C is an orderly end.
class Printer final : public app::LiveObserver {
 public:
  Printer(Output& output, bool keeps) : output_(output), keeps_(keeps) {}

  void Begin() override { stop_.emplace(); }

  void Checked(const mqtt::Message& message, const ValidationResult& result) override {
    if (keeps_) cases_[{result.robot.ToString(), result.topic_name}].Add(message, result);
    for (const auto& violation : result.findings.errors) Show(message, result, violation);
    for (const auto& [path, words] : result.findings.warnings) {
      output_.Warn(fmt::format("{}: {}{}{}", FormatPlace(message, result), base::Printable(path),
                               path.empty() ? "" : ": ", words));
    }
    has_violations_ = has_violations_ || !result.findings.errors.empty();
  }

  Result<bool> GoesOn() override {
    if (auto flushed = output_.Flush(); !flushed) return Fail(std::move(flushed.error()));
    return !StopSignal::Received();
  }

  [[nodiscard]] bool has_violations() const { return has_violations_; }
  [[nodiscard]] std::vector<TestResult> Results() const {
    std::vector<TestResult> results;
    for (const auto& [key, one] : cases_) results.push_back(one.Result(key.first, key.second));
    return results;
  }

 private:
  static std::string FormatPlace(const mqtt::Message& message, const ValidationResult& result) {
    return fmt::format("{} {}{}{}", base::Printable(result.robot.ToString()), result.topic_name,
                       result.header_id ? fmt::format(" headerId {}", *result.header_id) : "",
                       message.retained ? " (retained)" : "");
  }

  void Show(const mqtt::Message& message, const ValidationResult& result,
            const schema::Violation& violation) const {
    if (!output_.json()) {
      const std::string path = base::Printable(violation.path);
      return output_.Line(fmt::format("{}: {}{}{}", FormatPlace(message, result), path,
                                      path.empty() ? "" : ": ", violation.message));
    }
    output_.Line(fmt::format(
        R"({{"target":{},"topic":{},"version":"{}","headerId":{},"retained":{},"path":{},"message":{}}})",
        base::JsonString(result.robot.ToString()), base::JsonString(message.topic), result.version,
        result.header_id ? std::to_string(*result.header_id) : "null", message.retained,
        base::JsonString(violation.path), base::JsonString(violation.message)));
  }

  Output& output_;
  bool keeps_;
  std::map<std::pair<std::string, std::string>, Case> cases_;  // by robot and topic
  bool has_violations_ = false;
  const InterruptGuard before_;
  std::optional<StopSignal> stop_;
};

Result<vda5050::ConformanceOptions> ParseConformance(const LiveOptions& options,
                                                     const config::Config& config) {
  vda5050::ConformanceOptions conformance;
  const auto dialect = app::ParseDialect(app::WithConfig(options.vda, config));
  if (!dialect) return Fail(dialect.error());
  conformance.scheme = dialect->topics;
  if (!options.version.empty()) {
    const auto version = vda5050::ParseVersion(options.version);
    if (!version) return Fail(version.error());
    conformance.version = *version;
  }
  conformance.topic = options.topic;
  conformance.strict = options.strict;
  return conformance;
}

}  // namespace

void DeclareLive(OptionSet& set, LiveOptions& options) {
  constexpr const char* kLive = "Live";
  set.AddFlag("--live", options.live,
              "Check what robots and fleet controls publish; FILE… are robots then")
      .Group(kLive);
  set.AddOption("--for", Duration(options.duration), "End after this time [on Ctrl-C]")
      .Group(kLive);
  set.AddOption("--count", WholeNumber(options.count, 1, 1'000'000'000'000),
                "End after so many messages")
      .Group(kLive);
  DeclareSelectionFlags(set, options.targets);
  DeclareTopicOptions(set, options.vda);
  DeclareFrom(set, options.from);
}

Result<ExitCode> ValidateLive(const LiveOptions& options, const Context& context) {
  auto conformance = ParseConformance(options, context.config);
  if (!conformance) return Fail(std::move(conformance.error()));
  auto robots = ParseFleetOptions(FleetOptions{.targets = options.targets, .vda = options.vda});
  if (!robots) return Fail(std::move(robots.error()));
  if (options.duration && !options.from.empty()) return Fail(NoTimeFrom("--for"));
  const auto reports = ParseReportFiles(options.reports);
  if (!reports) return Fail(reports.error());
  TestReport report{.name = "fleetpub validate --live",
                    .properties = {{"broker", FormatSite(context)}},
                    .started = base::WallTime::clock::now(),
                    .results = {}};
  if (!options.from.empty()) report.properties = {{"recording", options.from}};
  const auto environment = MakeEnvironment(context, options.from, delivery::Play::kAll);
  Printer printer(context.output, !reports->empty());
  const auto summary = app::ValidateLive({.robots = *std::move(robots),
                                          .conformance = *std::move(conformance),
                                          .end = FindEnd(options.duration),
                                          .count = options.count.value_or(SIZE_MAX)},
                                         environment, printer, context.output);
  if (!summary) return Fail(summary.error());
  ShowSummary(*summary, context.output);
  TellRecording(environment, context.output);
  report.results = printer.Results();
  if (auto written = WriteReports(*reports, std::move(report)); !written) {
    return Fail(std::move(written.error()));
  }
  if (summary->all.messages == 0) {
    return Fail(ErrorKind::kUnconfirmed, "no message came: nothing was checked");
  }
  return printer.has_violations() ? ExitCode::kInvalid : ExitCode::kDone;
}

}  // namespace fleetpub::cli
