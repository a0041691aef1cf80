#include "app/batch_line.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "base/json.h"
#include "base/text.h"
#include "delivery/validate.h"
#include "soar/acknowledgement_tracker.h"
#include "vda5050/catalogue/catalogue.h"
#include "vda5050/messages/user_message.h"

namespace fleetpub::app {
namespace {

using base::FindMember;
using base::Printable;
using base::StringMember;
using message::Command;
using Value = base::JsonValue;
using vda5050::Dialect;
using vda5050::RobotAddress;
using vda5050::WaitFor;

enum class Kind { kText, kTexts, kId, kWait, kObject, kNumber, kFlag };
enum class Use { kAll, kVda, kAction, kMessage, kPayload, kSoar };

struct Member {
  std::string_view name;
  Kind kind;
  Use use = Use::kAll;
};

constexpr auto kMembers = std::to_array<Member>({
    {"id", Kind::kId},
    {"target", Kind::kTexts},
    {"wait", Kind::kWait},
    {"vda", Kind::kText, Use::kVda},
    {"headerId", Kind::kNumber, Use::kVda},
    {"action", Kind::kText, Use::kAction},
    {"parameters", Kind::kObject, Use::kAction},
    {"actionId", Kind::kText, Use::kAction},
    {"descriptor", Kind::kText, Use::kAction},
    {"blockingType", Kind::kText, Use::kAction},
    {"exact", Kind::kFlag, Use::kAction},
    {"topic", Kind::kText, Use::kMessage},
    {"restamp", Kind::kFlag, Use::kMessage},
    {"soar", Kind::kText, Use::kSoar},
    {"payload", Kind::kObject, Use::kPayload},
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
      return value.IsBool() || value.IsString();
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
      return "true, false, or the end to wait for";
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
  return Wrong(fmt::format("unknown member '{}': {}", Printable(name),
                           nearest ? fmt::format("did you mean {}?", *nearest)
                                   : fmt::format("a line has {}", fmt::join(names, ", "))));
}

// What a line is about.
struct Shape {
  bool action = false;
  bool message = false;
  bool soar = false;
};

std::string_view WhyUnfit(Use use, const Shape& shape) {
  switch (use) {
    case Use::kAction:
      return shape.action ? "" : "needs an action beside it";
    case Use::kMessage:
      return shape.message ? "" : "needs a topic beside it";
    case Use::kPayload:
      return shape.message || shape.soar ? "" : "needs a topic, or soar, beside it";
    case Use::kVda:
      return shape.soar ? "belongs to VDA 5050, not to soar" : "";
    case Use::kSoar:
    case Use::kAll:
      return "";
  }
  return "";
}

// `at line 1, column 7`: it is always the first of its text, and another of the input.
std::string WithoutLine(std::string message) {
  constexpr std::string_view kFirst = "line 1, ";
  if (const auto at = message.find(kFirst); at != message.npos) message.erase(at, kFirst.size());
  return message;
}

Status CheckMember(std::string_view name, const Value& value, const Shape& shape) {
  const auto* const member = std::find_if(kMembers.begin(), kMembers.end(),
                                          [name](const Member& one) { return one.name == name; });
  if (member == kMembers.end()) return UnknownMember(name);
  if (!IsOfKind(value, member->kind)) {
    return Wrong(fmt::format("{} must be {}", name, Described(member->kind)));
  }
  const std::string_view unfit = WhyUnfit(member->use, shape);
  if (!unfit.empty()) return Wrong(fmt::format("{} {}", name, unfit));
  return {};
}

Status CheckMembers(const Value& line, const Shape& shape) {
  for (const auto& [name, value] : line.GetObject()) {
    if (auto ok = CheckMember(base::ToView(name), value, shape); !ok) return ok;
  }
  const int kinds = int{shape.action} + int{shape.message} + int{shape.soar};
  if (kinds > 1) return Wrong("action, topic and soar exclude each other");
  if (kinds == 0) return Wrong("the action, the topic or soar is missing");
  if (!shape.action && FindMember(line, "payload") == nullptr) {
    return Wrong(fmt::format("{} needs a payload beside it", shape.soar ? "soar" : "topic"));
  }
  if (FindMember(line, "target") == nullptr) {
    return Wrong(shape.soar ? "the target is missing: name the destination, or \"broadcast\""
                            : "the target is missing: name the robot as manufacturer/serialNumber");
  }
  return {};
}

std::vector<std::string_view> ListTargets(const Value& target) {
  if (target.IsString()) return {base::ToView(target)};
  std::vector<std::string_view> targets;
  for (const Value& text : target.GetArray()) targets.push_back(base::ToView(text));
  return targets;
}

Result<std::optional<WaitFor>> ReadWait(const Value& line, const LineDefaults& defaults) {
  using Waits = std::optional<WaitFor>;
  const Value* wait = FindMember(line, "wait");
  const bool is_order = base::EqualsIgnoringCase(StringMember(line, "topic"), "order");
  // An order may take hours: that the robot has it is what one usually waits for.
  const WaitFor usual = is_order ? WaitFor::kAccepted : WaitFor::kFinished;
  if (wait == nullptr || wait->IsTrue()) {
    if (defaults.names_end || (wait == nullptr && !defaults.wait_for)) return defaults.wait_for;
    return Waits(usual);
  }
  if (wait->IsFalse()) return Waits();
  if (*wait == "accepted") return Waits(WaitFor::kAccepted);
  if (*wait == "finished") return Waits(WaitFor::kFinished);
  return Wrong("wait must be true, false, \"accepted\" or \"finished\"");
}

// As the line says, and as its message does. With `vda` `auto` the robot is asked whatever somebody
// else states.
Result<AddressedRobot> ReadDialect(const Value& line, AddressedRobot robot) {
  const auto speak = [&](vda5050::Version version, bool is_asked) {
    Dialect dialect = *robot.dialect;
    dialect.version = version;
    dialect.assumed = robot.automatic = is_asked;
    robot.dialect = std::make_shared<const Dialect>(std::move(dialect));
  };
  const Value* text = FindMember(line, "vda");
  if (text != nullptr && *text == "auto") {
    speak(vda5050::kVersions.back(), true);
  } else if (text != nullptr) {
    const auto version = vda5050::ParseVersion(base::ToView(*text));
    if (!version) return Fail(version.error());
    speak(*version, false);
  } else if (const Value* payload = FindMember(line, "payload"); payload && robot.automatic) {
    if (const auto said = vda5050::VersionSaidBy(*payload)) speak(said->version, false);
  }
  return robot;
}

std::optional<std::uint32_t> ReadHeaderId(const Value& line) {
  const Value* id = FindMember(line, "headerId");
  return id == nullptr ? std::nullopt : std::optional(id->GetUint());
}

// As on the command line: predefined names in any letter case, and short names. What nearly is one
// is refused; a manufacturer's own name that looks like one is said to be exact.
Result<std::string> ReadActionType(const Value& line) {
  const std::string_view type = StringMember(line, "action");
  const Value* exact = FindMember(line, "exact");
  if (exact != nullptr && exact->IsTrue()) return std::string(type);
  if (const auto predefined = vda5050::ActionCalled(type)) return std::string(*predefined);
  const auto near = base::Nearest(type, vda5050::AllActionWords());
  if (!near) return std::string(type);
  return Wrong(
      fmt::format("'{}' is not a predefined action: did you mean {}? A manufacturer's own "
                  "action of this name needs \"exact\":true beside it",
                  Printable(type), *near));
}

std::unique_ptr<RobotMessage> MakeAction(const Value& line, std::string type) {
  vda5050::InstantAction action{.type = std::move(type),
                                .id = std::string(StringMember(line, "actionId")),
                                .descriptor = std::string(StringMember(line, "descriptor")),
                                .blocking_type = std::string(StringMember(line, "blockingType")),
                                .parameters = {}};
  if (const Value* parameters = FindMember(line, "parameters")) {
    for (const auto& [key, value] : parameters->GetObject()) {
      action.parameters.push_back({std::string(base::ToView(key)), base::ToJson(value)});
    }
  }
  return MakeInstantMessage(std::move(action), FindMember(line, "actionId") != nullptr);
}

// What one line asks for, for one robot after the other.
struct Request {
  const Value& line;
  const LineDefaults& defaults;
  std::optional<WaitFor> wait_for;

  [[nodiscard]] Result<LineCommand> MakeFor(std::string_view target) const {
    if (target.find_first_of("*?") != std::string_view::npos) {
      return Fail(
          ErrorKind::kUsage,
          fmt::format("'{}' is a pattern, and a line names robots: `fleetpub fleet -o json` "
                      "lists them",
                      Printable(target)));
    }
    auto named = defaults.address(target);
    if (!named) return Fail(std::move(named.error()));
    auto robot = ReadDialect(line, *std::move(named));
    if (!robot) return Fail(std::move(robot.error()));
    auto message = MakeMessage();
    if (!message) return Fail(std::move(message.error()));
    return LineCommand{.command = std::nullopt,
                       .robot = *std::move(robot),
                       .message = *std::move(message),
                       .header_id = ReadHeaderId(line),
                       .wait_for = wait_for,
                       .reference = {}};
  }

  [[nodiscard]] Result<std::unique_ptr<RobotMessage>> MakeMessage() const {
    if (FindMember(line, "action") != nullptr) {
      auto type = ReadActionType(line);
      if (!type) return Fail(std::move(type.error()));
      return MakeAction(line, *std::move(type));
    }
    const auto topic = vda5050::PublishedTopic(StringMember(line, "topic"));
    if (!topic) return Fail(topic.error());
    auto payload = std::make_shared<base::JsonDocument>();
    payload->CopyFrom(*FindMember(line, "payload"), payload->GetAllocator());
    const Value* restamp = FindMember(line, "restamp");
    return MakeUserMessage(*topic, std::move(payload),
                           restamp != nullptr && restamp->IsTrue()
                               ? vda5050::HeaderMismatch::kReplace
                               : vda5050::HeaderMismatch::kRefuse);
  }
};

// SoAR's: by target as well.
struct SoarRequest {
  const Value& line;
  const LineDefaults& defaults;
  soar::MessageType type{};
  std::string payload = {};
  std::optional<soar::Level> wait_for = {};

  // Errors: the line is wrong.
  [[nodiscard]] Status Read() {
    std::string name(StringMember(line, "soar"));
    std::replace(name.begin(), name.end(), '-', '_');
    const auto known = soar::ParseMessageType(name);
    if (!known) {
      return Wrong(fmt::format("soar must be one of {}", soar::MessageTypeNames()));
    }
    type = *known;
    std::vector<soar::Member> members;
    for (const auto& [key, value] : FindMember(line, "payload")->GetObject()) {
      if (base::ToView(key) != "message_type") {
        members.push_back({std::string(base::ToView(key)), base::ToJson(value)});
      } else if (value != soar::GetName(type).data()) {
        return Wrong("the payload's message_type is not the type that soar names");
      }
    }
    payload = soar::BuildPayload(type, members);
    const Value* wait = FindMember(line, "wait");
    if (wait == nullptr ? defaults.wait_for.has_value() : wait->IsTrue()) {
      wait_for = soar::Level::kExecuted;
    } else if (wait != nullptr && wait->IsString()) {
      wait_for = soar::ParseLevel(base::ToView(*wait));
      if (!wait_for) {
        return Wrong(
            "wait must be true, false, \"c2_received\", \"operator_approved_and_sent\" "
            "or \"executed\"");
      }
    }
    return {};
  }

  [[nodiscard]] Result<LineCommand> MakeFor(std::string_view target) const {
    const soar::Sender& sender = defaults.soar;
    const auto destination = target == "broadcast"
                                 ? Result<soar::Destination>(soar::Broadcast(sender.prefix))
                                 : soar::ParseDestination(target, sender.prefix, type);
    if (!destination) return Fail(destination.error());
    Command command = soar::BuildMessage(type, *destination, sender, payload);
    if (!wait_for) return LineCommand{.command = std::move(command)};
    command.tracker = soar::TrackAcknowledgements(
        {.message_id = command.actions.front().id,
         .topics = soar::AcknowledgementTopics(*destination, sender.prefix, sender.source),
         .prefix = sender.prefix,
         .wait_for = *wait_for,
         .count = 1,
         .target = destination->name});
    return LineCommand{.command = std::move(command)};
  }
};

}  // namespace

Result<AddressedRobot> AsWritten(std::string_view word) {
  static const auto dialect = std::make_shared<const Dialect>();
  auto robot = vda5050::ParseRobotAddress(word);
  if (!robot) return Fail(std::move(robot.error()));
  return AddressedRobot{*std::move(robot), dialect, false};
}

LineParser::LineParser(LineDefaults defaults, const std::string& schema_directory)
    : defaults_(std::move(defaults)), registry_(schema_directory) {}

Result<LineCommands> LineParser::Parse(std::string_view text, LineOrigin& origin) {
  const auto line = base::ParseJson(text, {.exact = true});
  if (!line) return Wrong(WithoutLine(line.error().message));
  if (!line->IsObject()) return Wrong("a line must be a JSON object");
  if (const Value* id = FindMember(*line, "id"); id != nullptr && IsOfKind(*id, Kind::kId)) {
    origin.id = base::ToJson(*id);
  }
  origin.target = StringMember(*line, "target");
  const Shape shape{FindMember(*line, "action") != nullptr, FindMember(*line, "topic") != nullptr,
                    FindMember(*line, "soar") != nullptr};
  if (auto ok = CheckMembers(*line, shape); !ok) return Fail(std::move(ok.error()));
  if (shape.soar) {
    SoarRequest request{*line, defaults_};
    if (auto ok = request.Read(); !ok) return Fail(std::move(ok.error()));
    return ForEach(*line, request);
  }
  const auto wait_for = ReadWait(*line, defaults_);
  if (!wait_for) return Fail(wait_for.error());
  return ForEach(*line, Request{*line, defaults_, *wait_for});
}

template <class Request>
Result<LineCommands> LineParser::ForEach(const Value& line, const Request& request) {
  const auto targets = ListTargets(*FindMember(line, "target"));
  if (targets.size() > 1 && FindMember(line, "actionId") != nullptr) {
    return Wrong("actionId names one action: give one target with it");
  }
  LineCommands result;
  std::set<std::string> named;
  for (const std::string_view target : targets) {
    auto command = request.MakeFor(target);
    if (!command) return Fail(std::move(command.error()));
    const std::string name =
        command->command ? command->command->target : command->robot.robot.ToString();
    if (targets.size() > 1 && !named.insert(name).second)
      return Wrong(fmt::format("target names {} twice", Printable(name)));
    if (command->message != nullptr) {
      const auto& [robot, dialect, automatic] = command->robot;
      const bool waits = command->wait_for.has_value();
      if (auto ok = owners_.Add(robot, dialect->topics, waits); !ok) return Fail(ok.error());
    }
    const bool looks = defaults_.check || defaults_.online || command->robot.automatic;
    const bool is_asked_first = !command->command && looks;
    if (!is_asked_first) {
      if (auto ok = Build(*command); !ok) return Fail(std::move(ok.error()));
      if (auto ok = Validate(*command->command, result.warnings); !ok) {
        return Fail(std::move(ok.error()));
      }
    }
    result.commands.push_back(std::move(*command));
  }
  return result;
}

// Of whom nothing is asked, the command can be made at once.
Status LineParser::Build(LineCommand& line) {
  if (line.command) return {};
  const auto& [robot, dialect, automatic] = line.robot;
  auto command = line.message->Build(robot, *dialect, line.header_id);
  if (!command) return Fail(std::move(command.error()));
  if (line.wait_for) {
    auto tracker = line.message->Track(robot, *dialect, *line.wait_for);
    if (!tracker) return Fail(std::move(tracker.error()));
    command->tracker = std::move(*tracker);
  }
  line.command = *std::move(command);
  line.message.reset();
  return {};
}

Status LineParser::Validate(const Command& command, std::vector<std::string>& warnings) {
  const auto findings = delivery::Validate(command, registry_);
  if (!findings) return Fail(findings.error());
  if (!findings->errors.empty()) return Wrong(delivery::Describe(*findings));
  for (const std::string& warning : command.warnings) {
    warnings.push_back(fmt::format("{}: {}", Printable(command.target), warning));
  }
  for (const auto& warning : findings->warnings) {
    warnings.push_back(fmt::format("{}: {}", Printable(command.target), warning.message));
  }
  return {};
}

}  // namespace fleetpub::app
