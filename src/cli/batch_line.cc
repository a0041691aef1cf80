#include "cli/batch_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "base/json.h"
#include "base/text.h"
#include "dispatch/validate.h"
#include "vda5050/preflight.h"
#include "vda5050/prepared_message.h"

namespace fleetpub::cli {
namespace {

using base::FindMember;
using base::Printable;
using base::StringMember;
using dispatch::Command;
using rapidjson::Value;
using vda5050::Dialect;
using vda5050::RobotAddress;
using vda5050::WaitFor;

enum class Kind { kText, kTexts, kId, kWait, kObject, kNumber, kFlag };
enum class Use { kAll, kAction, kMessage };

struct Member {
  std::string_view name;
  Kind kind;
  Use use = Use::kAll;
};

constexpr auto kMembers = std::to_array<Member>({
    {"id", Kind::kId},
    {"target", Kind::kTexts},
    {"vda", Kind::kText},
    {"wait", Kind::kWait},
    {"headerId", Kind::kNumber},
    {"action", Kind::kText, Use::kAction},
    {"parameters", Kind::kObject, Use::kAction},
    {"actionId", Kind::kText, Use::kAction},
    {"descriptor", Kind::kText, Use::kAction},
    {"blockingType", Kind::kText, Use::kAction},
    {"topic", Kind::kText, Use::kMessage},
    {"payload", Kind::kObject, Use::kMessage},
    {"restamp", Kind::kFlag, Use::kMessage},
});

bool IsOfKind(const Value& value, Kind kind) {
  switch (kind) {
    case Kind::kText:
      return value.IsString();
    case Kind::kTexts:
      return value.IsString() || (value.IsArray() && !value.Empty() &&
                                  std::all_of(value.Begin(), value.End(),
                                              [](const Value& one) { return one.IsString(); }));
    case Kind::kId:
      return value.IsString() || value.IsNumber();
    case Kind::kWait:
      return value.IsBool() || value == "accepted" || value == "finished";
    case Kind::kObject:
      return value.IsObject();
    case Kind::kNumber:
      return value.IsUint();
    case Kind::kFlag:
      return value.IsBool();
  }
  return false;
}

std::string_view Described(Kind kind) {
  switch (kind) {
    case Kind::kText:
      return "a text";
    case Kind::kTexts:
      return "a text such as \"KIT/0001\", or an array of them";
    case Kind::kId:
      return "a text or a number";
    case Kind::kWait:
      return "true, false, \"accepted\" or \"finished\"";
    case Kind::kObject:
      return "an object";
    case Kind::kNumber:
      return "a whole number from 0 to 4294967295";
    case Kind::kFlag:
      return "true or false";
  }
  return "";
}

tl::unexpected<Error> Wrong(std::string message) {
  return Fail(ErrorKind::kInvalid, std::move(message));
}

tl::unexpected<Error> UnknownMember(std::string_view name) {
  std::array<std::string_view, kMembers.size()> names;
  std::transform(kMembers.begin(), kMembers.end(), names.begin(),
                 [](const Member& member) { return member.name; });
  const auto nearest = base::Nearest(name, names);
  return Wrong(fmt::format(
      "'{}' is not understood: {}", Printable(name),
      nearest ? fmt::format("did you mean {}?", *nearest)
              : "a line has id, target, vda, wait, headerId, and action, parameters, actionId, "
                "descriptor, blockingType, or topic, payload, restamp"));
}

// `at line 1, column 7`: it is always the first of its text, and another of the input.
std::string WithoutLine(std::string message) {
  constexpr std::string_view kFirst = "line 1, ";
  if (const auto at = message.find(kFirst); at != message.npos) message.erase(at, kFirst.size());
  return message;
}

Status CheckMembers(const Value& line) {
  const bool is_action = FindMember(line, "action") != nullptr;
  const bool is_message = FindMember(line, "topic") != nullptr;
  for (const auto& [name, value] : line.GetObject()) {
    const auto* const member =
        std::find_if(kMembers.begin(), kMembers.end(), [key = base::ViewOf(name)](const auto& one) {
          return one.name == key;
        });
    if (member == kMembers.end()) return UnknownMember(base::ViewOf(name));
    if (!IsOfKind(value, member->kind)) {
      return Wrong(fmt::format("{} must be {}", member->name, Described(member->kind)));
    }
    if (member->use == Use::kMessage && !is_message) {
      return Wrong(fmt::format("{} needs a topic beside it", member->name));
    }
    if (member->use == Use::kAction && !is_action) {
      return Wrong(fmt::format("{} needs an action beside it", member->name));
    }
  }
  if (is_action && is_message) return Wrong("action and topic exclude each other");
  if (!is_action && !is_message) {
    return Wrong("there is neither an action nor a topic with its payload");
  }
  if (is_message && FindMember(line, "payload") == nullptr) {
    return Wrong("topic needs a payload beside it");
  }
  if (FindMember(line, "target") == nullptr) {
    return Wrong("there is no target: name the robot as manufacturer/serialNumber");
  }
  return {};
}

Result<std::vector<RobotAddress>> TargetsOf(const Value& target) {
  std::vector<RobotAddress> robots;
  const auto add = [&robots](const Value& text) -> Status {
    auto robot = vda5050::ParseRobotAddress(base::ViewOf(text));
    if (!robot) return Fail(std::move(robot.error()));
    if (std::find(robots.begin(), robots.end(), *robot) != robots.end()) {
      return Wrong(fmt::format("target names {} twice", Printable(robot->ToString())));
    }
    robots.push_back(std::move(*robot));
    return {};
  };
  if (target.IsString()) {
    if (auto ok = add(target); !ok) return Fail(std::move(ok.error()));
  } else {
    for (const Value& text : target.GetArray()) {
      if (auto ok = add(text); !ok) return Fail(std::move(ok.error()));
    }
  }
  return robots;
}

std::optional<WaitFor> WaitOf(const Value& line, const LineDefaults& defaults) {
  const Value* wait = FindMember(line, "wait");
  const bool is_order = StringMember(line, "topic") == "order";
  if (wait == nullptr) {
    if (defaults.wait_for && !defaults.names_end && is_order) return WaitFor::kAccepted;
    return defaults.wait_for;
  }
  if (wait->IsString()) return *wait == "accepted" ? WaitFor::kAccepted : WaitFor::kFinished;
  if (wait->IsFalse()) return std::nullopt;
  if (defaults.names_end) return defaults.wait_for;
  // An order may take hours: that the robot has it is what one usually waits for.
  return is_order ? WaitFor::kAccepted : WaitFor::kFinished;
}

Result<Dialect> DialectOf(const Value& line, const Dialect& base) {
  Dialect dialect = base;
  if (const Value* text = FindMember(line, "vda")) {
    if (*text == "auto") {
      return Wrong("vda auto needs the robot to be asked first: name its version");
    }
    const auto version = vda5050::ParseVersion(base::ViewOf(*text));
    if (!version) return Fail(version.error());
    dialect.version = *version;
    dialect.assumed = false;
  } else if (const Value* payload = FindMember(line, "payload"); payload && dialect.assumed) {
    if (const auto said = vda5050::VersionSaidBy(*payload)) {
      dialect.version = *said;
      dialect.assumed = false;
    }
  }
  return dialect;
}

std::optional<std::uint32_t> HeaderIdOf(const Value& line) {
  const Value* id = FindMember(line, "headerId");
  return id == nullptr ? std::nullopt : std::optional(id->GetUint());
}

// What one line asks for, for one robot after the other.
struct Request {
  const Value& line;
  Dialect dialect;
  std::optional<WaitFor> wait_for;

  [[nodiscard]] Result<Command> ActionFor(const RobotAddress& robot) const {
    vda5050::InstantAction action{.type = std::string(StringMember(line, "action")),
                                  .id = std::string(StringMember(line, "actionId")),
                                  .descriptor = std::string(StringMember(line, "descriptor")),
                                  .blocking_type = std::string(StringMember(line, "blockingType")),
                                  .parameters = {}};
    if (FindMember(line, "actionId") == nullptr) action.id = vda5050::SuitableActionId(nullptr);
    if (const Value* parameters = FindMember(line, "parameters")) {
      for (const auto& [key, value] : parameters->GetObject()) {
        action.parameters.push_back({std::string(base::ViewOf(key)), base::ToJson(value)});
      }
    }
    auto command =
        vda5050::BuildInstantActions(robot, dialect, std::span(&action, 1), HeaderIdOf(line));
    if (!command || !wait_for) return command;
    const ledger::ActionRef& sent = command->actions.front();
    auto confirmation =
        vda5050::ConfirmInstantAction(robot, dialect, sent.type, sent.id, *wait_for);
    if (!confirmation) return Fail(std::move(confirmation.error()));
    command->confirmation = std::move(*confirmation);
    return command;
  }

  [[nodiscard]] Result<Command> MessageFor(const RobotAddress& robot) const {
    const auto topic = vda5050::PublishedTopic(StringMember(line, "topic"));
    if (!topic) return Fail(topic.error());
    const Value& payload = *FindMember(line, "payload");
    const Value* restamp = FindMember(line, "restamp");
    const auto foreign = restamp != nullptr && restamp->IsTrue() ? vda5050::ForeignHeader::kReplace
                                                                 : vda5050::ForeignHeader::kRefuse;
    auto command =
        vda5050::BuildPrepared(robot, dialect, *topic, payload, foreign, HeaderIdOf(line));
    if (!command || !wait_for) return command;
    auto confirmation = vda5050::ConfirmPrepared(robot, dialect, *topic, payload, *wait_for);
    if (!confirmation) return Fail(std::move(confirmation.error()));
    command->confirmation = std::move(*confirmation);
    return command;
  }
};

}  // namespace

LineParser::LineParser(LineDefaults defaults, const std::string& schema_directory)
    : defaults_(std::move(defaults)), registry_(schema_directory) {}

Result<LineCommands> LineParser::Parse(std::string_view text, LineOrigin& origin) {
  const auto line = base::ParseJson(text);
  if (!line) return Wrong(WithoutLine(line.error().message));
  if (!line->IsObject()) return Wrong("a line must be a JSON object");
  if (const Value* id = FindMember(*line, "id"); id != nullptr && IsOfKind(*id, Kind::kId)) {
    origin.id = base::ToJson(*id);
  }
  origin.target = StringMember(*line, "target");
  if (auto ok = CheckMembers(*line); !ok) return Fail(std::move(ok.error()));
  const auto robots = TargetsOf(*FindMember(*line, "target"));
  if (!robots) return Fail(robots.error());
  auto dialect = DialectOf(*line, defaults_.dialect);
  if (!dialect) return Fail(std::move(dialect.error()));
  const bool is_action = FindMember(*line, "action") != nullptr;
  if (robots->size() > 1 && FindMember(*line, "actionId") != nullptr) {
    return Wrong("actionId names one action: give one target with it");
  }
  const Request request{*line, std::move(*dialect), WaitOf(*line, defaults_)};
  LineCommands result;
  for (const RobotAddress& robot : *robots) {
    auto command = is_action ? request.ActionFor(robot) : request.MessageFor(robot);
    if (!command) return Fail(std::move(command.error()));
    if (auto ok = Validate(*command, result.warnings); !ok) return Fail(std::move(ok.error()));
    result.commands.push_back(std::move(*command));
  }
  return result;
}

Status LineParser::Validate(const Command& command, std::vector<std::string>& warnings) {
  const auto findings = dispatch::Validate(command, registry_);
  if (!findings) return Fail(findings.error());
  if (!findings->errors.empty()) return Wrong(dispatch::Describe(*findings));
  for (const std::string& warning : command.warnings) {
    warnings.push_back(fmt::format("{}: {}", Printable(command.target), warning));
  }
  for (const auto& warning : findings->warnings) {
    warnings.push_back(fmt::format("{}: {}", Printable(command.target), warning.message));
  }
  return {};
}

}  // namespace fleetpub::cli
