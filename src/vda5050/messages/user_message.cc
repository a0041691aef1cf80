#include "vda5050/messages/user_message.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>

#include "base/json.h"
#include "base/text.h"
#include "vda5050/rules/text_rules.h"

namespace fleetpub::vda5050 {
namespace {

using base::FindArray;
using base::FindMember;
using base::JsonString;
using base::Printable;
using base::StringMember;
using Value = base::JsonValue;

struct Topic {
  std::string_view name;
  Version since;
};

constexpr std::array<Topic, 4> kMessageTopics = {{{"order", Version::k110},
                                                  {"instantActions", Version::k110},
                                                  {"zoneSet", Version::k300},
                                                  {"responses", Version::k300}}};

constexpr std::array<std::string_view, 5> kHeader = {"headerId", "timestamp", "version",
                                                     "manufacturer", "serialNumber"};

Version SinceWhen(std::string_view name) {
  for (const Topic& topic : kMessageTopics) {
    if (topic.name == name) return topic.since;
  }
  return Version::k110;
}

bool IsHeader(std::string_view name) {
  return std::find(kHeader.begin(), kHeader.end(), name) != kHeader.end();
}

struct OwnHeader {
  std::string_view version;
  std::string_view manufacturer;
  std::string_view serial_number;
};

// A patch level of the dialect's version stays as it is written.
OwnHeader HeaderFor(const RobotAddress& robot, const Dialect& dialect, const Value& message) {
  const bool is_its = VersionSaidBy(message) == SpokenVersion{dialect.version, true};
  const std::string_view usual =
      is_its ? StringMember(message, "version") : GetFacts(dialect.version).name;
  return {base::NonEmptyOr(dialect.header_version, usual),
          base::NonEmptyOr(dialect.header_manufacturer, robot.manufacturer),
          base::NonEmptyOr(dialect.header_serial, robot.serial_number)};
}

// A message for one robot must not reach another by a slip of the command line.
Status CheckHeader(const Value& message, const OwnHeader& own, const RobotAddress& robot,
                   Version version) {
  const auto spoken = VersionSaidBy(message);
  const std::array<std::pair<std::string_view, std::string_view>, 3> fields = {
      {{"version", own.version},
       {"manufacturer", own.manufacturer},
       {"serialNumber", own.serial_number}}};
  for (const auto& [name, expected] : fields) {
    const Value* said = FindMember(message, name);
    if (said == nullptr || (said->IsString() && base::ToView(*said) == expected)) continue;
    if (name == "version" && spoken && spoken->version == version) continue;
    return Fail(ErrorKind::kInvalid,
                fmt::format("{}: the message's {} is {}, not \"{}\": is it meant for another "
                            "robot? --restamp replaces it",
                            robot.ToString(), name, Printable(base::ToJson(*said)), expected));
  }
  return {};
}

// Nothing else is spoken without a word.
void WarnOfVersion(const Value& message, const Dialect& dialect,
                   std::vector<std::string>& warnings) {
  const Value* said = FindMember(message, "version");
  if (said == nullptr) {
    if (!dialect.assumed) return;
    warnings.push_back(fmt::format("the message states no version: {} is assumed; --vda states one",
                                   GetFacts(dialect.version).name));
    return;
  }
  const auto spoken = VersionSaidBy(message);
  if (spoken && spoken->is_release) return;  // ours, or to be replaced
  const std::string text =
      said->IsString() ? std::string(base::ToView(*said)) : base::ToJson(*said);
  if (text == dialect.header_version) return;
  warnings.push_back("the message's version " + NoReleaseText(text, dialect.version) +
                     "; --vda states another");
}

// An array of actions under the name that other robots expect is not to go unseen: some would carry
// out what is neither checked nor waited for.
Status CheckActionsKey(const Value& message, const RobotAddress& robot, std::string_view key) {
  const std::string_view other = key == "actions" ? "instantActions" : "actions";
  if (FindArray(message, other) == nullptr) return {};
  if (FindMember(message, key) != nullptr) {
    return Fail(ErrorKind::kInvalid,
                fmt::format("{}: the message has actions in \"{}\" and in \"{}\": leave only the "
                            "one that the robot reads, which is \"{}\" unless --actions-key says "
                            "otherwise",
                            robot.ToString(), key, other, key));
  }
  return Fail(ErrorKind::kInvalid,
              fmt::format("{}: the message has its actions in \"{}\", but they are expected in "
                          "\"{}\": rename it, or add --actions-key {} if the robot wants them so",
                          robot.ToString(), other, key, other));
}

// Everything behind the timestamp's opening quotation mark: our header, then the message's own
// members in their order.
std::string CopyRest(const Value& message, const OwnHeader& own) {
  std::string rest =
      fmt::format(R"(","version":{},"manufacturer":{},"serialNumber":{})", JsonString(own.version),
                  JsonString(own.manufacturer), JsonString(own.serial_number));
  for (const auto& member : message.GetObject()) {
    const std::string_view name = base::ToView(member.name);
    if (IsHeader(name)) continue;
    rest += fmt::format(",{}:{}", JsonString(name), base::ToJson(member.value));
  }
  return rest + "}";
}

// What the history shows: the actions of instantActions; of everything else, the thing itself.
std::vector<message::ActionRef> ListContents(const Value& message, std::string_view topic,
                                             std::string_view actions_key) {
  std::vector<message::ActionRef> contents;
  if (topic == "order") {
    contents.push_back({"order", std::string(StringMember(message, "orderId"))});
  } else if (topic == "zoneSet") {
    const Value* set = FindMember(message, "zoneSet");
    contents.push_back(
        {"zoneSet", set == nullptr ? "" : std::string(StringMember(*set, "zoneSetId"))});
  } else {
    const bool actions = topic == "instantActions";
    const Value* list = FindArray(message, actions ? actions_key : "responses");
    if (list == nullptr) return contents;
    for (const Value& entry : list->GetArray()) {
      contents.push_back({std::string(StringMember(entry, actions ? "actionType" : "grantType")),
                          std::string(StringMember(entry, actions ? "actionId" : "requestId"))});
    }
  }
  return contents;
}

}  // namespace

Result<std::string_view> PublishedTopic(std::string_view text) {
  for (const Topic& topic : kMessageTopics) {
    if (base::EqualsIgnoringCase(topic.name, text)) return topic.name;
  }
  return Fail(
      ErrorKind::kUsage,
      fmt::format("'{}' is not a topic that fleet control publishes: order, instantActions, "
                  "zoneSet or responses",
                  Printable(text)));
}

std::optional<SpokenVersion> VersionSaidBy(const Value& message) {
  return VersionSpoken(StringMember(message, "version"), "");
}

Result<message::Command> BuildUserMessage(const RobotAddress& robot, const Dialect& dialect,
                                          std::string_view topic, const Value& message,
                                          HeaderMismatch on_mismatch,
                                          std::optional<std::uint32_t> header_id) {
  const VersionFacts& facts = GetFacts(dialect.version);
  const Version since = SinceWhen(topic);
  if (dialect.version < since) {
    return Fail(ErrorKind::kUsage, fmt::format("{} exists from version {} on, not in {}", topic,
                                               GetFacts(since).name, facts.name));
  }
  if (!message.IsObject()) return Fail(ErrorKind::kInvalid, "the message must be a JSON object");
  const OwnHeader own = HeaderFor(robot, dialect, message);
  if (on_mismatch == HeaderMismatch::kRefuse) {
    if (auto ok = CheckHeader(message, own, robot, dialect.version); !ok) return Fail(ok.error());
  }
  const std::string_view key = base::NonEmptyOr(dialect.actions_key, facts.actions_key);
  if (topic == "instantActions") {
    if (auto ok = CheckActionsKey(message, robot, key); !ok) return Fail(ok.error());
  }
  auto full = TopicFor(dialect.topics, dialect.version, robot, topic);
  if (!full) return Fail(std::move(full.error()));

  message::Command command;
  command.target = robot.ToString();
  command.protocol = "vda5050";
  command.version = facts.name;
  command.version_assumed = dialect.assumed && since != kVersions.back();  // else no other has it
  command.topic = std::move(*full);
  command.schema = fmt::format("vda5050/{}/{}", facts.name, topic);
  command.text_rules = TextRulesFor(topic, dialect.version);
  command.header_id = header_id;
  WarnOfNoRelease(dialect, command.warnings);
  if (command.version_assumed || !dialect.assumed) {
    WarnOfVersion(message, dialect, command.warnings);
  }
  if (topic == "instantActions" && key != facts.actions_key) {
    command.renamed_member = std::pair<std::string, std::string>(key, facts.actions_key);
  }
  command.actions = ListContents(message, topic, key);
  command.payload = {.before_id = R"({"headerId":)",
                     .before_time = R"(,"timestamp":")",
                     .rest = CopyRest(message, own)};
  return command;
}

std::vector<InstantAction> ActionsIn(const Value& message, const Dialect& dialect) {
  std::vector<InstantAction> actions;
  const Value* list = FindArray(
      message, base::NonEmptyOr(dialect.actions_key, GetFacts(dialect.version).actions_key));
  if (list == nullptr) return actions;
  for (const Value& entry : list->GetArray()) {
    InstantAction action{.type = std::string(StringMember(entry, "actionType")),
                         .id = std::string(StringMember(entry, "actionId")),
                         .descriptor = {},
                         .blocking_type = std::string(StringMember(entry, "blockingType")),
                         .parameters = {}};
    if (const Value* parameters = FindArray(entry, "actionParameters")) {
      for (const Value& parameter : parameters->GetArray()) {
        const Value* value = FindMember(parameter, "value");
        action.parameters.push_back({std::string(StringMember(parameter, "key")),
                                     value == nullptr ? "" : base::ToJson(*value)});
      }
    }
    actions.push_back(std::move(action));
  }
  return actions;
}

base::JsonDocument ResponsesMessage(const RequestResponse& response) {
  std::string json = fmt::format(R"({{"responses":[{{"requestId":{},"grantType":{})",
                                 JsonString(response.request_id), JsonString(response.grant_type));
  if (response.lease_expiry) {
    json += fmt::format(R"(,"leaseExpiry":"{}")", base::FormatTimestamp(*response.lease_expiry));
  }
  return std::move(*base::ParseJson(json + "}]}"));
}

}  // namespace fleetpub::vda5050
