#include "vda5050/reports/robot_messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "base/json.h"
#include "base/text.h"
#include "base/time.h"
#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::vda5050 {
namespace {

using Value = base::JsonValue;

std::string ToUpper(std::string_view text) {
  std::string upper(text);
  std::transform(upper.begin(), upper.end(), upper.begin(), [](char c) {
    return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  });
  return upper;
}

// The first of the names that is there and not null: a field's old name and its new one.
const Value* Member(const Value& object, std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names) {
    const Value* member = base::FindMember(object, name);
    if (member != nullptr && !member->IsNull()) return member;
  }
  return nullptr;
}

// A text, or what a robot wrote in place of one: an id as a number.
std::string ReadText(const Value& value) {
  if (value.IsString()) return std::string(base::ToView(value));
  return value.IsNumber() || value.IsBool() ? base::ToJson(value) : std::string();
}

std::string Text(const Value& object, std::initializer_list<std::string_view> names) {
  const Value* member = Member(object, names);
  return member == nullptr ? std::string() : ReadText(*member);
}

std::optional<double> Number(const Value& object, std::initializer_list<std::string_view> names) {
  const Value* member = Member(object, names);
  if (member == nullptr) return std::nullopt;
  if (member->IsNumber()) return member->GetDouble();
  if (!member->IsString()) return std::nullopt;
  const std::string_view text = base::ToView(*member);
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool is_number = error == std::errc() && end == text.data() + text.size();
  return is_number && std::isfinite(number) ? std::optional(number) : std::nullopt;
}

std::optional<bool> Truth(const Value& object, std::initializer_list<std::string_view> names) {
  const Value* member = Member(object, names);
  if (member == nullptr) return std::nullopt;
  if (member->IsBool()) return member->GetBool();
  const std::string text = ReadText(*member);
  if (base::EqualsIgnoringCase(text, "true")) return true;
  if (base::EqualsIgnoringCase(text, "false")) return false;
  return std::nullopt;
}

template <typename Whole = std::uint32_t>
std::optional<Whole> Counter(const Value& object, std::string_view name) {
  constexpr double kMost =
      sizeof(Whole) > 4 ? 9e18 : static_cast<double>(std::numeric_limits<std::uint32_t>::max());
  const auto number = Number(object, {name});
  const bool fits = number && *number >= 0 && *number == std::floor(*number) && *number <= kMost;
  return fits ? std::optional(static_cast<Whole>(*number)) : std::nullopt;
}

std::size_t Limit(const Value& object, std::initializer_list<std::string_view> names) {
  constexpr double kNoLimit = 1e15;  // far above any; keeps the conversion defined
  const auto number = Number(object, names);
  return number && *number >= 1 && *number < kNoLimit ? static_cast<std::size_t>(*number) : 0;
}

// The array's elements through `read`, objects or not; nothing when there is no array.
template <typename T>
std::vector<T> List(const Value* array, T (*read)(const Value&)) {
  std::vector<T> list;
  if (array == nullptr || !array->IsArray()) return list;
  list.reserve(array->Size());
  for (const Value& element : array->GetArray()) list.push_back(read(element));
  return list;
}

bool IsArray(const Value* value) { return value != nullptr && value->IsArray(); }

ActionState ReadActionState(const Value& entry) {
  return {.id = Text(entry, {"actionId"}),
          .type = Text(entry, {"actionType"}),
          .status = ToUpper(Text(entry, {"actionStatus"})),
          .result = Text(entry, {"actionResult", "resultDescription"})};
}

ErrorReference ReadReference(const Value& entry) {
  return {Text(entry, {"referenceKey"}), Text(entry, {"referenceValue"})};
}

// The text itself, or of its translations (from 3.0) the English one, else the first.
std::string Translated(const Value& entry, std::string_view name, std::string_view translations) {
  std::string text = Text(entry, {name});
  const Value* others = Member(entry, {translations});
  if (!text.empty() || !IsArray(others)) return text;
  for (const Value& other : others->GetArray()) {
    std::string translation = Text(other, {"translationValue"});
    const bool is_english = base::ToLower(Text(other, {"translationKey"})).starts_with("en");
    if (text.empty() || is_english) text = std::move(translation);
    if (is_english) break;
  }
  return text;
}

RobotError ReadError(const Value& entry) {
  return {
      .type = Text(entry, {"errorType"}),
      .level = ToUpper(Text(entry, {"errorLevel"})),
      .description = Translated(entry, "errorDescription", "errorDescriptionTranslations"),
      .hint = Translated(entry, "errorHint", "errorHintTranslations"),
      .references = List(Member(entry, {"errorReferences"}), ReadReference),
  };
}

RobotInformation ReadInformation(const Value& entry) {
  return {.type = Text(entry, {"infoType"}),
          .level = ToUpper(Text(entry, {"infoLevel"})),
          .description = Text(entry, {"infoDescriptor", "infoDescription"}),
          .references = List(Member(entry, {"infoReferences"}), ReadReference)};
}

RobotLoad ReadLoad(const Value& entry) {
  return {.id = Text(entry, {"loadId"}),
          .type = Text(entry, {"loadType"}),
          .position = Text(entry, {"loadPosition"}),
          .weight = Number(entry, {"weight"})};
}

std::optional<RobotPosition> ReadPosition(const Value& message) {
  const Value* position = Member(message, {"mobileRobotPosition", "agvPosition"});
  if (position == nullptr || !position->IsObject()) return std::nullopt;
  return RobotPosition{.x = Number(*position, {"x"}),
                       .y = Number(*position, {"y"}),
                       .theta = Number(*position, {"theta"}),
                       .map_id = Text(*position, {"mapId"}),
                       .localized = Truth(*position, {"localized", "positionInitialized"})};
}

std::optional<std::size_t> Length(const Value& message, std::string_view name) {
  const Value* array = Member(message, {name});
  if (!IsArray(array)) return std::nullopt;
  return array->Size();
}

ZoneSetState ReadZoneSet(const Value& entry) {
  return {Text(entry, {"zoneSetId"}), Text(entry, {"mapId"}),
          ToUpper(Text(entry, {"zoneSetStatus"}))};
}

RobotRequest ReadRequest(const Value& entry) {
  return {.id = Text(entry, {"requestId"}),
          .type = ToUpper(Text(entry, {"requestType"})),
          .status = ToUpper(Text(entry, {"requestStatus"})),
          .zone_id = Text(entry, {"zoneId"}),
          .zone_set_id = Text(entry, {"zoneSetId"}),
          .edge_id = Text(entry, {"edgeId"}),
          .sequence_id = Counter(entry, "sequenceId")};
}

FactsheetParameter ReadParameter(const Value& entry) {
  return {.key = Text(entry, {"key"}),
          .value_type = ToUpper(Text(entry, {"valueDataType"})),
          .is_optional = Truth(entry, {"isOptional"})};
}

std::string ReadUpperCase(const Value& entry) { return ToUpper(ReadText(entry)); }

// A list of names; some write them in one text: `NODE, INSTANT`.
std::vector<std::string> Names(const Value* value) {
  if (value == nullptr || !value->IsString()) return List(value, ReadUpperCase);
  std::string text = ToUpper(base::ToView(*value));
  std::replace_if(
      text.begin(), text.end(), [](char c) { return !(c >= 'A' && c <= 'Z') && c != '_'; }, ' ');
  auto names = base::Split(text, ' ');
  std::erase(names, "");
  return names;
}

FactsheetAction ReadFactsheetAction(const Value& entry) {
  const Value* parameters = Member(entry, {"actionParameters"});
  return {.type = Text(entry, {"actionType"}),
          .scopes = Names(Member(entry, {"actionScopes"})),
          .parameters = List(parameters, ReadParameter),
          .has_parameters = IsArray(parameters),
          .blocking_types = Names(Member(entry, {"blockingTypes"}))};
}

OptionalParameter ReadOptionalParameter(const Value& entry) {
  return {.name = Text(entry, {"parameter"}),
          .is_required = ToUpper(Text(entry, {"support"})) == "REQUIRED"};
}

FactsheetLimits ReadLimits(const Value& limits) {
  static const Value kNone(rapidjson::kObjectType);
  const Value* strings = Member(limits, {"maximumStringLengths", "maxStringLens"});
  const Value* arrays = Member(limits, {"maximumArrayLengths", "maxArrayLens"});
  const Value& lengths = strings == nullptr ? kNone : *strings;
  const Value& counts = arrays == nullptr ? kNone : *arrays;
  return {
      .message_length = Limit(lengths, {"maximumMessageLength", "msgLen"}),
      .topic_serial_length = Limit(lengths, {"maximumTopicSerialLength", "topicSerialLen"}),
      .topic_element_length = Limit(lengths, {"maximumTopicElementLength", "topicElemLen"}),
      .id_length = Limit(lengths, {"maximumIdLength", "idLen"}),
      .id_numerical_only = Truth(lengths, {"idNumericalOnly"}).value_or(false),
      .instant_actions = Limit(counts, {"instantActions"}),
      .action_parameters = Limit(counts, {"actions.actionsParameters"}),
      .order_nodes = Limit(counts, {"order.nodes"}),
      .order_edges = Limit(counts, {"order.edges"}),
      .node_actions = Limit(counts, {"node.actions"}),
      .edge_actions = Limit(counts, {"edge.actions"}),
      .trajectory_knots = Limit(counts, {"trajectory.knotVector"}),
      .trajectory_points = Limit(counts, {"trajectory.controlPoints"}),
      .base_nodes = Limit(counts, {"state.nodeStates"}),
  };
}

RobotSpecification ReadSpecification(const Value& message) {
  RobotSpecification specification;
  if (const Value* type = Member(message, {"typeSpecification"})) {
    specification.series = Text(*type, {"seriesName"});
    specification.series_description = Text(*type, {"seriesDescription"});
    specification.robot_class = Text(*type, {"mobileRobotClass", "agvClass"});
    specification.kinematics =
        Text(*type, {"mobileRobotKinematics", "mobileRobotKinematic", "agvKinematic"});
    specification.maximum_load = Number(*type, {"maximumLoadMass", "maxLoadMass"});
  }
  if (const Value* physical = Member(message, {"physicalParameters"})) {
    specification.maximum_speed = Number(*physical, {"maximumSpeed", "speedMax"});
    specification.length = Number(*physical, {"length"});
    specification.width = Number(*physical, {"width"});
    specification.maximum_height = Number(*physical, {"maximumHeight", "heightMax"});
  }
  return specification;
}

template <typename T>
Result<T> ReadPayload(std::string_view payload, T (*read)(const Value&)) {
  const auto message = ReadMessage(payload);
  if (!message) return Fail(message.error());
  return read(*message);
}

// Robots often leave the type out, and may use the name that another version has for it.
bool IsOfType(const ActionState& entry, std::string_view type) {
  return type.empty() || entry.type.empty() ||
         base::EqualsIgnoringCase(NameIn(Version::k300, entry.type), NameIn(Version::k300, type));
}

// How far an entry has come: of two for one action, the one that says more. Of a contradiction, the
// one that is no false success.
int RankStatus(std::string_view status) {
  constexpr std::array<std::string_view, 7> kOrder = {
      "WAITING", "INITIALIZING", "PAUSED", "RUNNING", "RETRIABLE", "FINISHED", "FAILED"};
  const auto* const found = std::find(kOrder.begin(), kOrder.end(), status);
  return found == kOrder.end() ? -1 : static_cast<int>(found - kOrder.begin());
}

// Upper case, then one of the spellings on the left is the one on the right.
template <std::size_t size>
std::string Normalised(
    std::string_view text,
    const std::array<std::pair<std::string_view, std::string_view>, size>& spellings) {
  std::string upper = ToUpper(text);
  std::string letters = upper;
  letters.erase(std::remove_if(letters.begin(), letters.end(),
                               [](char c) { return c == '_' || c == '-' || c == ' '; }),
                letters.end());
  for (const auto& [spelling, normal] : spellings) {
    if (letters == spelling) return std::string(normal);
  }
  return upper;
}

}  // namespace

MessageHeader ReadHeader(const Value& message) {
  return {.header_id = Counter(message, "headerId"),
          .count = Counter<std::uint64_t>(message, "headerId"),
          .timestamp = Text(message, {"timestamp"}),
          .version = Text(message, {"version"}),
          .manufacturer = Text(message, {"manufacturer"}),
          .serial_number = Text(message, {"serialNumber"})};
}

std::optional<base::WallTime> ReadTime(const MessageHeader& header) {
  std::string text = header.timestamp;
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  constexpr std::int64_t kYears = 9'000'000'000'000;  // so many ms fit a WallTime
  const bool is_number = error == std::errc() && end == text.data() + text.size();
  if (is_number && number >= 0 && number < kYears) {
    return base::WallTime(std::chrono::milliseconds(number));
  }
  constexpr std::size_t kDate = 10;
  if (text.size() > kDate && text[kDate] == ' ') text[kDate] = 'T';
  const std::size_t offset = text.find_first_of("Zz+-", kDate);
  if (offset == std::string::npos) {
    text += 'Z';
  } else if (text.size() == offset + 5) {
    text.insert(offset + 3, ":");  // +0100
  }
  return base::ParseDateTime(text);
}

bool IsBefore(const MessageHeader& a, const MessageHeader& b) {
  const auto time_a = ReadTime(a);
  const auto time_b = ReadTime(b);
  if (!a.count || !b.count || !time_a || !time_b) return false;
  return *a.count <= *b.count && *time_a <= *time_b && (*a.count < *b.count || *time_a < *time_b);
}

RobotState ReadState(const Value& message) {
  RobotState state;
  state.header = ReadHeader(message);
  const Value* actions = Member(message, {"actionStates"});
  const Value* instant_actions = Member(message, {"instantActionStates"});
  state.action_states = List(actions, ReadActionState);
  state.has_action_states = IsArray(actions);
  state.instant_action_states = List(instant_actions, ReadActionState);
  state.has_instant_action_states = IsArray(instant_actions);
  state.zone_action_states = List(Member(message, {"zoneActionStates"}), ReadActionState);
  state.errors = List(Member(message, {"errors"}), ReadError);
  state.operating_mode = NormalisedMode(Text(message, {"operatingMode"}));
  state.paused = Truth(message, {"paused"});
  state.driving = Truth(message, {"driving"});
  if (const Value* power = Member(message, {"powerSupply", "batteryState"})) {
    state.battery_charge = Number(*power, {"stateOfCharge", "batteryCharge"});
    state.charging = Truth(*power, {"charging"});
    state.battery_voltage = Number(*power, {"batteryVoltage"});
    state.battery_health = Number(*power, {"batteryHealth"});
    state.range = Number(*power, {"range", "reach"});
  }
  if (const Value* safety = Member(message, {"safetyState"})) {
    state.emergency_stop = NormalisedEmergencyStop(Text(*safety, {"activeEmergencyStop", "eStop"}));
    state.field_violation = Truth(*safety, {"fieldViolation"});
  }
  state.order_id = Text(message, {"orderId"});
  state.order_update_id = Counter(message, "orderUpdateId");
  state.nodes_left = Length(message, "nodeStates");
  state.edges_left = Length(message, "edgeStates");
  if (const Value* nodes = Member(message, {"nodeStates"}); IsArray(nodes)) {
    for (const Value& node : nodes->GetArray()) {
      const auto sequence_id = Counter(node, "sequenceId");
      if (!sequence_id) continue;
      state.nodes.push_back(
          {Text(node, {"nodeId"}), *sequence_id, Truth(node, {"released"}).value_or(true)});
    }
  }
  state.new_base_request = Truth(message, {"newBaseRequest"});
  state.last_node_id = Text(message, {"lastNodeId"});
  state.last_node_sequence_id = Counter(message, "lastNodeSequenceId");
  state.position = ReadPosition(message);
  state.zone_sets = List(Member(message, {"zoneSets"}), ReadZoneSet);
  state.requests = List(Member(message, {"zoneRequests"}), ReadRequest);
  for (RobotRequest& request : List(Member(message, {"edgeRequests"}), ReadRequest)) {
    state.requests.push_back(std::move(request));
  }
  const Value* loads = Member(message, {"loads"});
  if (IsArray(loads)) state.loads = List(loads, ReadLoad);
  state.information = List(Member(message, {"information", "informations"}), ReadInformation);
  return state;
}

ConnectionMessage ReadConnection(const Value& message) {
  return {ReadHeader(message), NormalisedConnectionState(Text(message, {"connectionState"}))};
}

Factsheet ReadFactsheet(const Value& message) {
  Factsheet factsheet;
  factsheet.header = ReadHeader(message);
  if (const Value* limits = Member(message, {"protocolLimits"})) {
    factsheet.limits = ReadLimits(*limits);
  }
  if (const Value* features = Member(message, {"protocolFeatures"})) {
    factsheet.actions =
        List(Member(*features, {"mobileRobotActions", "agvActions"}), ReadFactsheetAction);
    const Value* optional = Member(*features, {"optionalParameters"});
    factsheet.optional_parameters = List(optional, ReadOptionalParameter);
    factsheet.has_optional_parameters = IsArray(optional);
  }
  factsheet.specification = ReadSpecification(message);
  return factsheet;
}

Result<base::JsonDocument> ReadMessage(std::string_view payload) {
  auto message = base::ParseJsonLeniently(payload);
  if (!message || message->IsObject()) return message;
  return Fail(ErrorKind::kInvalid,
              message->IsArray() ? "it is an array, no JSON object" : "it is no JSON object");
}

std::string ToOneLine(std::string_view payload) {
  const bool is_line = payload.find_first_of("\r\n\xEF") == std::string_view::npos;
  const auto message = ReadMessage(payload);
  if (!message) return "";
  return is_line && base::ParseJson(payload) ? std::string(payload) : base::ToJson(*message);
}

Result<RobotState> ReadState(std::string_view payload) {
  return ReadPayload<RobotState>(payload, ReadState);
}

Result<ConnectionMessage> ReadConnection(std::string_view payload) {
  return ReadPayload<ConnectionMessage>(payload, ReadConnection);
}

Result<Factsheet> ReadFactsheet(std::string_view payload) {
  return ReadPayload<Factsheet>(payload, ReadFactsheet);
}

std::string OtherSender(const MessageHeader& header, std::span<const RobotAddress> names) {
  const auto agrees = [](std::string_view said, std::string_view name) {
    return said.empty() || base::EqualsIgnoringCase(said, name);
  };
  const bool is_one = std::any_of(names.begin(), names.end(), [&](const RobotAddress& name) {
    return agrees(header.manufacturer, name.manufacturer) &&
           agrees(header.serial_number, name.serial_number);
  });
  if (is_one || names.empty()) return "";
  const auto said = [](const std::string& text, const std::string& otherwise) {
    return text.empty() ? otherwise : text;
  };
  return Shown(said(header.manufacturer, names.front().manufacturer) + "/" +
               said(header.serial_number, names.front().serial_number));
}

const ActionState* FindActionState(const RobotState& state, std::string_view id,
                                   std::string_view type) {
  const ActionState* found = nullptr;
  for (const auto* list : {&state.instant_action_states, &state.action_states}) {
    for (const ActionState& entry : *list) {
      if (entry.id != id || !IsOfType(entry, type)) continue;
      if (found == nullptr || RankStatus(entry.status) > RankStatus(found->status)) found = &entry;
    }
  }
  return found;
}

bool IsEmergencyStopped(const RobotState& state) {
  return !state.emergency_stop.empty() && state.emergency_stop != "NONE";
}

std::string_view DescribeMotion(const RobotState& state) {
  if (state.paused == true) return "paused";
  if (!state.driving) return "driving not reported";
  return *state.driving ? "driving" : "standing";
}

bool IsTerminal(std::string_view status) { return status == "FINISHED" || status == "FAILED"; }

const FactsheetAction* FindAction(const Factsheet& factsheet, std::string_view type) {
  const auto found =
      std::find_if(factsheet.actions.begin(), factsheet.actions.end(),
                   [&](const FactsheetAction& action) { return action.type == type; });
  return found == factsheet.actions.end() ? nullptr : &*found;
}

std::string NormalisedConnectionState(std::string_view text) {
  return Normalised<2>(text,
                       {{{"CONNECTIONBROKEN", "CONNECTION_BROKEN"}, {"DISCONNECTED", "OFFLINE"}}});
}

bool IsAway(std::string_view connection_state) {
  return connection_state == "OFFLINE" || connection_state == "CONNECTION_BROKEN" ||
         connection_state == "HIBERNATING";
}

std::string ConnectionText(const ConnectionMessage& connection) {
  constexpr std::size_t kTimestamp = 40;
  const std::string time = Shown(connection.header.timestamp, kTimestamp);
  const std::string& state = connection.connection_state;
  if (!connection.fault.empty()) return "not readable: " + connection.fault;
  return (state.empty() ? "without a connectionState" : Shown(state)) +
         (time.empty()                   ? ""
          : state == "CONNECTION_BROKEN" ? fmt::format(" (connected at {})", time)
                                         : " since " + time);
}

std::string NormalisedMode(std::string_view text) {
  // 1.1's text has both TEACHIN and TEACHING, 3.0's prose SEMI-AUTOMATIC.
  return Normalised<3>(
      text,
      {{{"SEMIAUTOMATIC", "SEMIAUTOMATIC"}, {"TEACHIN", "TEACH_IN"}, {"TEACHING", "TEACH_IN"}}});
}

std::string NormalisedEmergencyStop(std::string_view text) {
  return Normalised<1>(text, {{{"AUTOACK", "AUTOACK"}}});
}

std::string Shown(std::string_view text, std::size_t longest) {
  std::string shown = base::Printable(text);
  if (shown.size() <= longest) return shown;
  std::size_t end = longest;
  while (end > 0 && (static_cast<unsigned char>(shown[end]) & 0xC0U) == 0x80) --end;
  shown.resize(end);
  return shown + "…";
}

}  // namespace fleetpub::vda5050
