// Builds the messages of the SoAR backbone.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "base/result.h"
#include "message/command.h"
#include "soar/destination.h"
#include "soar/field.h"
#include "soar/message_type.h"
#include "soar/text_rules.h"

namespace fleetpub::soar {

/// The version of the message format that we speak, as our schemas' folder names it.
constexpr std::string_view kFormatVersion = "1.0";
/// The schema of a whole message.
constexpr std::string_view kMessageSchema = "soar/1.0/messages#/components/schemas/MESSAGE";

/// `soar/1.0/messages#/components/schemas/mission_plan`
[[nodiscard]] std::string PayloadSchema(MessageType type);

/// Who sends, and how.
struct Sender {
  Prefix prefix;
  std::string source = "fleetpub";
  std::string header_version = std::string(kFormatVersion);  ///< a JSON number
  Strictness strictness = Strictness::kWarn;
};

/// A payload as JSON: its message_type and these members. Members of one parent that follow each
/// other stand in one object.
[[nodiscard]] std::string BuildPayload(MessageType type, std::span<const Member> members);

/// A planning configuration from the JSON text of a file (`planning_config_ID` may be given apart,
/// as JSON). What it must hold is for the schema to say. Errors: ErrorKind::kInvalid (no JSON, no
/// object, another message_type).
[[nodiscard]] Result<std::string> ParsePlanningConfiguration(std::string_view json,
                                                             std::string_view planning_config_id);

/// The message with all seven header fields, a hole for the timestamp and a fresh message_ID, which
/// is the id of its only action.
[[nodiscard]] message::Command BuildMessage(MessageType type, const Destination& destination,
                                            const Sender& sender, std::string_view payload);

}  // namespace fleetpub::soar
