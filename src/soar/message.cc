#include "soar/message.h"

#include <fmt/format.h>

#include "base/json.h"
#include "base/text.h"
#include "base/uuid.h"

namespace fleetpub::soar {

using base::JsonString;

std::string PayloadSchema(MessageType type) {
  return fmt::format("soar/{}/messages#/components/schemas/{}", kFormatVersion, GetName(type));
}

std::string BuildPayload(MessageType type, std::span<const Member> members) {
  std::string json = fmt::format(R"({{"message_type":"{}")", GetName(type));
  std::string_view parent;
  for (const Member& member : members) {
    const bool same = member.parent == parent;
    if (!same && !parent.empty()) json += '}';
    if (!same && !member.parent.empty()) {
      json += fmt::format(",{}:{{", JsonString(member.parent));
    } else {
      json += ',';
    }
    json += fmt::format("{}:{}", JsonString(member.name), member.json);
    parent = member.parent;
  }
  return json + (parent.empty() ? "}" : "}}");
}

Result<std::string> ParsePlanningConfiguration(std::string_view json,
                                               std::string_view planning_config_id) {
  const auto document = base::ParseJson(json);
  if (!document) return Fail(document.error());
  if (!document->IsObject()) {
    return Fail(ErrorKind::kInvalid, "it must be an object with squads and exclusion_zones");
  }
  constexpr auto kType = MessageType::kPlanningConfiguration;
  std::vector<Member> members;
  if (!planning_config_id.empty()) {
    members.push_back({"planning_config_ID", std::string(planning_config_id)});
  }
  for (const auto& [name, value] : document->GetObject()) {
    const std::string_view key = base::ToView(name);
    if (key == "message_type") {
      if (value.IsString() && base::ToView(value) == GetName(kType)) continue;
      return Fail(ErrorKind::kInvalid,
                  fmt::format("its message_type is {}, not {}",
                              base::Printable(base::ToJson(value).substr(0, 60)), GetName(kType)));
    }
    if (key == "planning_config_ID" && !planning_config_id.empty()) continue;
    members.push_back({std::string(key), base::ToJson(value)});
  }
  return BuildPayload(kType, members);
}

message::Command BuildMessage(MessageType type, const Destination& destination,
                              const Sender& sender, std::string_view payload) {
  const std::string id = base::RandomUuid();
  message::Command command;
  command.target = destination.name;
  command.protocol = "soar";
  command.version = kFormatVersion;
  command.topic = destination.topic;
  command.schema = kMessageSchema;
  command.text_rules = [strictness = sender.strictness](const base::JsonValue& message) {
    return CheckMessage(message, strictness);
  };
  command.actions = {{std::string(GetName(type)), id}};
  command.payload = {
      .before_id = "",
      .before_time = fmt::format(R"({{"header":{{"message_ID":"{}","timestamp":")", id),
      .rest = fmt::format(R"(","version":{},"source":{},"destination":{},"delivery_type":"{}",)"
                          R"("encoded":false}},"payload":{}}})",
                          sender.header_version, JsonString(sender.source),
                          JsonString(destination.header),
                          destination.broadcast ? "broadcast" : "publish", payload),
      .counted = false};
  command.warnings = destination.warnings;
  return command;
}

}  // namespace fleetpub::soar
