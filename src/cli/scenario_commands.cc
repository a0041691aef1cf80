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

std::vector<std::string> ListTargets(const CommandLine& call) {
  for (const Option& option : call.set().options()) {
    const std::string name = option.IsPositional() ? option.position_name() : "";
    if (name == "target" || name == "targets" || name == "destination") return option.texts();
  }
  return {};
}

// As people name it, whatever the scenario calls it.
std::string Resolve(const std::string& word, const config::Config& config) {
  const auto robot = app::ResolveRobot(word, config);
  return robot ? robot->ToString() : word;
}

// With --force, the real robots of these names may be there, too.
std::vector<std::string> ListSimulated(const CommandLine& call, const config::Config& config) {
  std::vector<std::string> simulated;
  if (call.set().IsByFlag("--force")) return simulated;
  const Option count = call.set().Find("--count");
  for (const std::string& word : ListTargets(call)) {
    simulated.push_back(Resolve(word, config));
    const auto first = vda5050::ParseRobotAddress(simulated.back());
    if (!first || !count.IsGiven()) continue;
    const auto robots = simulator::CountUp(*first, std::stoul(count.texts().front()));
    if (!robots) continue;
    for (const auto& robot : *robots) simulated.push_back(robot.ToString());
  }
  return simulated;
}

// Who may be moved.
std::vector<std::string> ListCommanded(const CommandLine& call, const config::Config& config) {
  const SubcommandMatch& match = call.match;
  if (match.subcommand == nullptr) {
    const std::string_view type = vda5050::ActionCalled(match.name).value_or(match.name);
    if (app::DecideConsent(type) == app::NeedsConsent::kNo) return {};
  }
  std::vector<std::string> commanded;
  for (const std::string& word : ListTargets(call)) commanded.push_back(Resolve(word, config));
  if (commanded.empty() || call.set().IsByFlag("--all")) {
    commanded.push_back(fmt::format("whomever {} finds", match.name));
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
    if (!option.TakesValue()) handed_on_.push_back(name);
    if (!option.TakesValue()) continue;
    for (const std::string& text : option.texts()) handed_on_.push_back(name + "=" + text);
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
  if (step.kind == StepKind::kSimulate) {
    step.targets = ListSimulated(call, context_.config);
    return {};
  }
  if (subcommand != nullptr && subcommand->group != HelpGroup::kRobots &&
      subcommand->group != HelpGroup::kSoar) {
    return Fail(ErrorKind::kUsage,
                fmt::format("{} sends nothing: a step that looks is an await or an expect, virtual "
                            "robots are a simulate",
                            call.match.name));
  }
  step.targets = ListCommanded(call, context_.config);
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
