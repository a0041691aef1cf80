// `fleetpub await TARGET [TOPIC] CONDITION…`: waits until a message of each robot says so.
#include <fmt/format.h>

#include <memory>

#include "app/await_conditions.h"
#include "base/text.h"
#include "base/time.h"
#include "cli/environment.h"
#include "cli/listening.h"
#include "cli/output/interrupt.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"

namespace fleetpub::cli {
namespace {

struct AwaitOptions {
  std::string target;
  std::string topic;
  std::vector<std::string> conditions;  ///< perhaps the topic among them
  bool print = false;
  std::optional<std::chrono::milliseconds> timeout;
  app::VdaOptions vda;
  std::string from;

  [[nodiscard]] std::chrono::milliseconds Timeout() const {
    return from.empty() ? timeout.value_or(std::chrono::minutes(10)) : app::kUntilItEnds;
  }
};

bool IsCondition(std::string_view text) {
  return text.find_first_of("=<>") != std::string_view::npos;
}

// A topic may be left out: then its place holds the first condition.
std::vector<std::string> ConditionTexts(const AwaitOptions& o) {
  std::vector<std::string> texts = o.conditions;
  if (IsCondition(o.topic)) texts.insert(texts.begin(), o.topic);
  return texts;
}

Result<app::AwaitRequest> ParseAwaitOptions(const AwaitOptions& o) {
  const std::vector<std::string> texts = ConditionTexts(o);
  if (o.target.empty() || o.topic.empty() || texts.empty()) {
    return Fail(ErrorKind::kUsage,
                "await needs a robot and what its message must say. try: "
                "fleetpub await KIT/0001 paused=true");
  }
  if (o.timeout && !o.from.empty()) return Fail(NoTimeFrom("--timeout"));
  app::AwaitRequest request{.target = o.target,
                            .topic = IsCondition(o.topic) ? "state" : o.topic,
                            .conditions = {},
                            .timeout = o.Timeout(),
                            .vda = o.vda};
  for (const std::string& text : texts) {
    auto condition = vda5050::ParseCondition(text);
    if (!condition) return Fail(std::move(condition.error()));
    request.conditions.push_back(*std::move(condition));
  }
  return request;
}

Result<ExitCode> RunAwait(const AwaitOptions& o, const Context& context) {
  const auto request = ParseAwaitOptions(o);
  if (!request) return Fail(request.error());
  const InterruptGuard interrupt;
  Output& output = context.output;
  const std::string what =
      base::Printable(fmt::format("{}: {}", request->topic, base::Join(ConditionTexts(o), ", ")));
  const auto show = [&](const vda5050::RobotAddress& robot, const std::string& line,
                        std::chrono::nanoseconds elapsed) {
    if (o.print || output.json()) {
      output.JsonLine(line);
    } else {
      output.PeopleLine(fmt::format("{}  {}  after {}", base::Printable(robot.ToString()), what,
                                    base::FormatElapsed(elapsed)));
    }
    Output::FlushNow();
  };
  const auto environment = MakeEnvironment(context, o.from, delivery::Play::kAll, o.Timeout());
  const auto awaited = app::AwaitConditions(*request, environment, show, output);
  if (!awaited) return Fail(awaited.error());
  TellRecording(environment, output);
  return ExitCode::kDone;
}

}  // namespace

Run DeclareAwait(OptionSet& set) {
  const auto options = std::make_shared<AwaitOptions>();
  set.AddOption("target", options->target,
                "A robot: manufacturer/serialNumber, or its alias; all of @group, of 'KIT/*'")
      .Type("TARGET");
  set.AddOption("topic", options->topic, "state, connection, factsheet ... [state]").Type("TOPIC");
  set.AddOption("conditions", options->conditions, "What one message must say").Type("CONDITION");
  set.AddOption("-W,--timeout", Duration(options->timeout), "How long to wait [10m]")
      .Group("Waiting");
  set.AddFlag("--print", options->print, "Print the message, as -o json does").Group("Waiting");
  set.AddOption("--vda", VdaVersion(options->vda.version),
                "Listen to this version's topic only [auto: whichever the robot uses]")
      .Variable("FLEETPUB_VDA")
      .Group("VDA 5050");
  DeclareTopicOptions(set, options->vda);
  DeclareFrom(set, options->from);
  return [options](const Context& context) { return RunAwait(*options, context); };
}

}  // namespace fleetpub::cli
