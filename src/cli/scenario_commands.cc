#include "cli/scenario_commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "app/targets.h"
#include "base/child_process.h"
#include "base/json.h"
#include "base/text.h"
#include "cli/parser/command_line.h"
#include "simulator/fleet.h"
#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::cli {
namespace {

using app::scenario::CommandEnd;
using app::scenario::Step;
using app::scenario::StepKind;

constexpr std::string_view kOnline = " online at ";  // as simulate says it

std::string FirstName(const Option& option) {
  return option.long_names().empty() ? "" : "--" + option.long_names().front();
}

bool IsByFlag(const OptionSet& set, const Option& option) {
  return !option.IsPositional() && !FirstName(option).empty() && set.IsByFlag(FirstName(option));
}

// As people name them, whatever the scenario calls them; what a variable will name stays a variable.
Result<std::vector<std::string>> ListTargets(const CommandLine& call, const Context& context) {
  std::vector<std::string> targets;
  for (const Option& option : call.set().options()) {
    const std::string name = option.IsPositional() ? option.position_name() : "";
    if (name != "target" && name != "targets" && name != "destination") continue;
    if (option.texts().empty() && name != "destination" && !call.set().IsByFlag("--all")) {
      return Fail(ErrorKind::kUsage, fmt::format("whom? write {} KIT/0001", call.match.name));
    }
    const bool is_soar = name == "destination" || call.set().IsByFlag("--protocol");
    for (const std::string& word : option.texts()) {
      targets.push_back(word);
      if (is_soar || word == "-" || word.find("${") != std::string::npos) continue;
      const auto spec = app::ParseTargetSpec({word}, context.config, context.output);
      if (!spec) return Fail(spec.error());
      if (!spec->robots.empty()) targets.pop_back();
      for (const auto& robot : spec->robots) targets.push_back(robot.ToString());
    }
  }
  return targets;
}

// With --force, the real robots of these names may be there, too.
Result<std::vector<std::string>> ListSimulated(const CommandLine& call, const Context& context) {
  auto simulated = ListTargets(call, context);
  const Option count = call.set().Find("--count");
  if (!simulated) return simulated;
  if (call.set().IsByFlag("--force")) simulated->clear();
  if (!count.IsGiven()) return simulated;
  std::vector<std::string> more;
  for (const std::string& target : *simulated) {
    const auto first = vda5050::ParseRobotAddress(target);
    if (!first) continue;
    const auto robots = simulator::CountUp(*first, std::stoul(count.texts().front()));
    if (!robots) return Fail(robots.error());
    for (const auto& robot : *robots) more.push_back(robot.ToString());
  }
  return more;
}

// Who may be moved.
Result<std::vector<std::string>> ListCommanded(const CommandLine& call, const Context& context) {
  const SubcommandMatch& match = call.match;
  auto commanded = ListTargets(call, context);
  if (!commanded) return commanded;
  const std::string_view type = vda5050::ActionCalled(match.name).value_or(match.name);
  if (match.subcommand == nullptr && app::DecideConsent(type) == app::NeedsConsent::kNo) {
    commanded->clear();
  } else if (commanded->empty() || call.set().IsByFlag("--all")) {
    commanded->push_back(fmt::format("whomever {} finds", match.name));
  }
  return commanded;
}

CommandEnd::Kind ToKind(int code) {
  switch (static_cast<ExitCode>(code)) {
    case ExitCode::kDone:
      return CommandEnd::Kind::kDone;
    case ExitCode::kRejected:
    case ExitCode::kUnconfirmed:
    case ExitCode::kPreflight:
    case ExitCode::kInvalid:
      return CommandEnd::Kind::kFailed;
    default:
      return CommandEnd::Kind::kTrouble;
  }
}

// A line of its results.
void Read(const base::JsonValue& line, CommandEnd& end) {
  const base::JsonValue* error = base::FindMember(line, "error");
  if (error != nullptr && error->IsObject()) {
    end.why = base::Printable(base::StringMember(*error, "message"));
  }
  const std::string_view status = base::StringMember(line, "status");
  if (status.empty()) return;
  end.outcomes.emplace_back(status);
  const std::string_view topic = base::StringMember(line, "topic");
  if (const auto* id = base::FindMember(line, "headerId")) {
    end.evidence.push_back(
        base::Printable(fmt::format("{} {} headerId {}", base::StringMember(line, "target"),
                                    topic.substr(topic.rfind('/') + 1), base::ToJson(*id))));
  }
  const std::string_view message = base::StringMember(line, "message");
  if (end.why.empty() && !message.empty()) {
    end.why = base::Printable(fmt::format("{}: {}", status, message));
  }
}

class Child final : public app::scenario::RunningCommand {
 public:
  explicit Child(std::unique_ptr<base::ChildProcess> process) : process_(std::move(process)) {}

  [[nodiscard]] bool IsOnline() const override {
    return process_->Errors().find(kOnline) != std::string::npos;
  }

  [[nodiscard]] std::optional<CommandEnd> Poll() override {
    const auto code = process_->Poll();
    if (!code) return std::nullopt;
    CommandEnd end{.kind = ToKind(*code)};
    for (const std::string& text : base::Split(process_->Output(), '\n')) {
      if (const auto line = base::ParseJson(text); line && line->IsObject()) Read(*line, end);
    }
    if (end.why.empty() && *code != 0) end.why = DescribeErrors(*code);
    return end;
  }

  void Terminate() override { process_->Terminate(); }

 private:
  [[nodiscard]] std::string DescribeErrors(int code) const {
    auto lines = base::Split(process_->Errors(), '\n');
    std::erase(lines, "");
    return lines.empty() ? fmt::format("it ended with exit code {}", code)
                         : base::Printable(lines.back());
  }

  std::unique_ptr<base::ChildProcess> process_;
};

}  // namespace

ScenarioCommands::ScenarioCommands(const OptionSet& set, const Context& context)
    : context_(context) {
  if (const char* password = std::getenv("FLEETPUB_PASSWORD")) password_ = password;
  for (const Option& option : set.options()) {
    const std::string name = FirstName(option);
    // Output is ours to read, and two clients must not have one id.
    const bool is_own = option.group() == "Output" || name == "--client-id";
    if (is_own || !IsGlobalGroup(option.group()) || !IsByFlag(set, option)) continue;
    if (!option.TakesValue()) {
      handed_on_.push_back(name);
      continue;
    }
    for (const std::string& text : option.texts())
      handed_on_.push_back(fmt::format("{}={}", name, text));
  }
}

Status ScenarioCommands::Check(Step& step) const {
  CommandLine call;
  const auto asked = call.Read(OptionSet::Extent::kAll, step.words);
  if (!asked) return Fail(asked.error());
  if (*asked != OptionSet::Asked::kRun || !call.run) {
    return Fail(ErrorKind::kUsage, "this is no command. try: fleetpub pause KIT/0001 --wait");
  }
  for (const Option& option : call.set().options()) {
    if (!IsGlobalGroup(option.group()) || !IsByFlag(call.set(), option)) continue;
    return Fail(ErrorKind::kUsage,
                fmt::format("{0} is for all of it: fleetpub test {0} …", FirstName(option)));
  }
  const Subcommand* subcommand = call.match.subcommand;
  const bool simulates = step.kind == StepKind::kSimulate;
  if (!simulates && subcommand != nullptr && subcommand->group != HelpGroup::kRobots &&
      subcommand->group != HelpGroup::kSoar) {
    return Fail(ErrorKind::kUsage,
                fmt::format("{} sends nothing: a step that looks is an await or an expect, virtual "
                            "robots are a simulate",
                            call.match.name));
  }
  auto targets = simulates ? ListSimulated(call, context_) : ListCommanded(call, context_);
  if (!targets) return Fail(std::move(targets.error()));
  step.targets = *std::move(targets);
  return {};
}

Result<std::unique_ptr<app::scenario::RunningCommand>> ScenarioCommands::Start(
    const std::vector<std::string>& words, const std::string& input) const {
  base::ChildProcess::Command command{.arguments = {"/proc/self/exe"}, .input = input};
  command.arguments.insert(command.arguments.end(), handed_on_.begin(), handed_on_.end());
  if (!context_.options.client_id.empty()) {
    command.arguments.push_back(
        fmt::format("--client-id={}-{}", context_.options.client_id, ++started_));
  }
  command.arguments.insert(command.arguments.end(), {"-o", "json"});
  command.arguments.insert(command.arguments.end(), words.begin(), words.end());
  if (!password_.empty()) command.environment.emplace_back("FLEETPUB_PASSWORD", password_);
  auto process = base::ChildProcess::Start(command);
  if (!process) return Fail(std::move(process.error()));
  return std::make_unique<Child>(*std::move(process));
}

}  // namespace fleetpub::cli
