#include "vda5050/messages/instant_actions.h"

#include <fmt/format.h>

#include "base/json.h"
#include "base/text.h"
#include "vda5050/catalogue/catalogue.h"
#include "vda5050/rules/text_rules.h"

namespace fleetpub::vda5050 {
namespace {

using base::JsonString;

std::string ParametersJson(std::span<const Parameter> parameters) {
  std::string json;
  for (const Parameter& parameter : parameters) {
    json += fmt::format(R"({}{{"key":{},"value":{}}})", json.empty() ? "" : ",",
                        JsonString(parameter.key), parameter.json);
  }
  return "[" + json + "]";
}

// Everything behind the timestamp's opening quotation mark.
std::string HeaderRest(const RobotAddress& robot, const Dialect& dialect) {
  return fmt::format(
      R"(","version":{},"manufacturer":{},"serialNumber":{},)",
      JsonString(base::NonEmptyOr(dialect.header_version, GetFacts(dialect.version).name)),
      JsonString(base::NonEmptyOr(dialect.header_manufacturer, robot.manufacturer)),
      JsonString(base::NonEmptyOr(dialect.header_serial, robot.serial_number)));
}

message::PayloadTemplate BuildPayload(const RobotAddress& robot, const Dialect& dialect,
                                      std::string_view actions_key, std::string_view actions_json) {
  return {.before_id = R"({"headerId":)",
          .before_time = R"(,"timestamp":")",
          .rest = fmt::format(R"({}"{}":[{}]}})", HeaderRest(robot, dialect), actions_key,
                              actions_json)};
}

void WarnOfRename(std::string_view asked, std::string_view type, const VersionFacts& facts,
                  std::vector<std::string>& warnings) {
  if (asked == type) return;
  warnings.push_back(
      fmt::format("{} is called {} in version {}: sent as {}", asked, type, facts.name, type));
}

}  // namespace

std::string WriteAction(const InstantAction& action, std::string_view type,
                        const VersionFacts& facts) {
  std::string json =
      fmt::format(R"({{"actionType":{},"actionId":{})", JsonString(type), JsonString(action.id));
  if (!action.descriptor.empty()) {
    json += fmt::format(R"(,"{}":{})", facts.descriptor_key, JsonString(action.descriptor));
  }
  json += fmt::format(R"(,"blockingType":{})",
                      JsonString(base::NonEmptyOr(action.blocking_type, "NONE")));
  if (!action.parameters.empty() || facts.empty_parameters) {
    json += R"(,"actionParameters":)" + ParametersJson(action.parameters);
  }
  return json + "}";
}

void WarnOfNoRelease(const Dialect& dialect, std::vector<std::string>& warnings) {
  if (dialect.version_said.empty()) return;
  warnings.push_back("its version " + NoReleaseText(dialect.version_said, dialect.version) +
                     "; --vda states another");
}

Result<message::Command> BuildInstantActions(const RobotAddress& robot, const Dialect& dialect,
                                             std::span<const InstantAction> actions,
                                             std::optional<std::uint32_t> header_id) {
  const VersionFacts& facts = GetFacts(dialect.version);
  auto topic = TopicFor(dialect.topics, dialect.version, robot, "instantActions");
  if (!topic) return Fail(std::move(topic.error()));

  message::Command command;
  command.target = robot.ToString();
  command.protocol = "vda5050";
  command.version = facts.name;
  command.version_assumed = dialect.assumed;
  command.topic = std::move(*topic);
  command.schema = fmt::format("vda5050/{}/instantActions", facts.name);
  command.text_rules = [version = dialect.version](const base::JsonValue& message) {
    return CheckInstantActions(message, version);
  };
  command.header_id = header_id;

  const std::string_view actions_key = base::NonEmptyOr(dialect.actions_key, facts.actions_key);
  if (actions_key != facts.actions_key) {
    command.renamed_member = std::pair<std::string, std::string>(actions_key, facts.actions_key);
  }
  std::string json;
  for (const InstantAction& action : actions) {
    const std::string_view type = NameIn(dialect.version, action.type);
    WarnOfRename(action.type, type, facts, command.warnings);
    json += (json.empty() ? "" : ",") + WriteAction(action, type, facts);
    command.actions.push_back({std::string(type), action.id});
  }
  WarnOfNoRelease(dialect, command.warnings);
  command.payload = BuildPayload(robot, dialect, actions_key, json);
  const bool moves_nothing = actions.size() == 1 && actions.front().type == "stateRequest";
  if (moves_nothing && MayExpectOtherKey(dialect)) {
    command.other_way = {
        BuildPayload(robot, dialect, "instantActions", json),
        "sent again with --actions-key instantActions, which some 2.0 robots expect"};
  }
  if (!HasRecommendedCharacters(robot.serial_number)) {
    command.warnings.push_back(
        fmt::format("serial number '{}' has characters other than A-Z a-z 0-9 _ . : -",
                    base::Printable(robot.serial_number)));
  }
  return command;
}

}  // namespace fleetpub::vda5050
