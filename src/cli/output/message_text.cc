#include "cli/output/message_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "base/json.h"
#include "base/text.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::cli {
namespace {

using base::FindArray;
using base::FindMember;
using base::JsonValue;
using base::StringMember;
using base::UintMember;
using vda5050::Shown;
using Statements = std::vector<Statement>;

constexpr std::size_t kLongestWord = 40;
constexpr std::size_t kLongestShown = 100;

std::string Word(std::string_view text) { return Shown(text, kLongestWord); }

// The node that the robot comes to next.
std::string_view FindNextNode(const JsonValue& message, const vda5050::RobotState& state) {
  const JsonValue* nodes = FindArray(message, "nodeStates");
  if (nodes == nullptr) return {};
  for (const JsonValue& node : nodes->GetArray()) {
    const auto sequence = UintMember(node, "sequenceId");
    if (state.last_node_sequence_id && sequence && *sequence <= *state.last_node_sequence_id) {
      continue;
    }
    return StringMember(node, "nodeId");
  }
  return {};
}

// What a robot that is well does not say.
void AddTrouble(const vda5050::RobotState& state, Statements& said) {
  if (vda5050::IsEmergencyStopped(state)) {
    said.push_back({"stop", "EMERGENCY STOP " + Word(state.emergency_stop), "no emergency stop"});
  }
  if (state.field_violation == true) {
    said.push_back({"field", "FIELD VIOLATION", "no field violation"});
  }
  for (const vda5050::RobotError& error : state.errors) {
    const std::string name = "error " + Word(error.type);
    said.push_back(
        {name,
         fmt::format(
             "{} {}{}", name, Word(error.level),
             error.description.empty() ? "" : " (" + Shown(error.description, kLongestShown) + ")"),
         name + " is over"});
  }
}

void AddActions(const vda5050::RobotState& state, Statements& said) {
  for (const auto* list :
       {&state.action_states, &state.instant_action_states, &state.zone_action_states}) {
    for (const vda5050::ActionState& action : *list) {
      if (action.status == "WAITING") continue;
      const std::string name = Word(action.type.empty() ? action.id : action.type);
      said.push_back({"action " + action.id, name + " " + Word(action.status), ""});
    }
  }
}

void AddState(const JsonValue& message, Statements& said) {
  const vda5050::RobotState state = vda5050::ReadState(message);
  const std::string_view next = FindNextNode(message, state);
  const bool has_last = !state.last_node_id.empty();
  const std::string last = has_last ? "at " + Word(state.last_node_id) : "";
  const std::string place =
      next.empty() || next == state.last_node_id
          ? last
          : fmt::format("{}→ {}", has_last ? Word(state.last_node_id) + " " : "", Word(next));
  if (!place.empty()) said.push_back({"place", place, ""});
  const bool has_order = !state.order_id.empty() && state.nodes_left.value_or(0) > 0;
  if (has_order) {
    const auto update = state.order_update_id.value_or(0);
    said.push_back({"order",
                    fmt::format("order {}{}", Word(state.order_id),
                                update == 0 ? "" : fmt::format(" update {}", update)),
                    "no order"});
  }
  if (state.paused == true || state.driving) {
    said.push_back({"motion", std::string(vda5050::DescribeMotion(state)), ""});
  }
  if (!state.operating_mode.empty() && state.operating_mode != "AUTOMATIC") {
    said.push_back({"mode", "mode " + Word(state.operating_mode), "mode AUTOMATIC"});
  }
  if (state.battery_charge) {
    said.push_back({"battery", fmt::format("battery {:.0f}%", *state.battery_charge), ""});
  }
  if (state.charging == true) said.push_back({"charging", "charging", "not charging"});
  AddActions(state, said);
  for (const vda5050::RobotRequest& request : state.requests) {
    said.push_back(
        {"request " + request.id,
         fmt::format("asks {} {} {}", Word(request.id), Word(request.type), Word(request.status)),
         ""});
  }
  AddTrouble(state, said);
}

void AddOrder(const JsonValue& message, Statements& said) {
  const auto update = UintMember(message, "orderUpdateId").value_or(0);
  said.push_back({"order",
                  fmt::format("order {}{}", Word(StringMember(message, "orderId")),
                              update == 0 ? "" : fmt::format(" update {}", update)),
                  ""});
  const JsonValue* nodes = FindArray(message, "nodes");
  if (nodes == nullptr || nodes->Empty()) return;
  constexpr rapidjson::SizeType kShown = 6;
  std::string way;
  std::size_t released = 0;
  for (rapidjson::SizeType i = 0; i < nodes->Size(); ++i) {
    const JsonValue& node = (*nodes)[i];
    if (base::IsTrueMember(node, "released")) ++released;
    const bool is_shown = i + 1 < kShown || i + 1 == nodes->Size();
    if (is_shown) way += (i == 0 ? "" : " → ") + Word(StringMember(node, "nodeId"));
    if (i + 1 == kShown && nodes->Size() > kShown) way += " → …";
  }
  said.push_back({"way", way, ""});
  if (released < nodes->Size()) {
    said.push_back({"base", fmt::format("{} of {} nodes released", released, nodes->Size()), ""});
  }
}

void AddEntries(const JsonValue& message, std::string_view list, std::string_view first,
                std::string_view second, Statements& said) {
  const JsonValue* entries = FindArray(message, list);
  if (entries == nullptr) return;
  for (const JsonValue& entry : entries->GetArray()) {
    said.push_back(
        {std::string(StringMember(entry, second)),
         fmt::format("{} {}", Word(StringMember(entry, first)), Word(StringMember(entry, second))),
         ""});
  }
}

void AddFactsheet(const JsonValue& message, Statements& said) {
  const vda5050::Factsheet sheet = vda5050::ReadFactsheet(message);
  if (!sheet.specification.series.empty()) {
    said.push_back({"series", "series " + Word(sheet.specification.series), ""});
  }
  if (!sheet.header.version.empty()) {
    said.push_back({"version", "version " + Word(sheet.header.version), ""});
  }
  said.push_back({"actions", fmt::format("{} actions", sheet.actions.size()), ""});
}

void AddPosition(const JsonValue& message, Statements& said) {
  const auto& position = vda5050::ReadState(message).position;
  if (!position || !position->x || !position->y) return;
  said.push_back({"position",
                  fmt::format("x {:.2f}  y {:.2f}{}", *position->x, *position->y,
                              position->map_id.empty() ? "" : "  map " + Word(position->map_id)),
                  ""});
}

void AddZoneSet(const JsonValue& message, Statements& said) {
  const JsonValue* set = FindMember(message, "zoneSet");
  if (set == nullptr) return;
  const JsonValue* zones = FindArray(*set, "zones");
  said.push_back({"zoneSet",
                  fmt::format("{} with {} zones", Word(StringMember(*set, "zoneSetId")),
                              zones == nullptr ? 0 : zones->Size()),
                  ""});
}

void AddByTopic(std::string_view topic, const JsonValue& message, Statements& said) {
  if (topic == "state") return AddState(message, said);
  if (topic == "order") return AddOrder(message, said);
  if (topic == "factsheet") return AddFactsheet(message, said);
  if (topic == "visualization") return AddPosition(message, said);
  if (topic == "zoneSet") return AddZoneSet(message, said);
  if (topic == "responses") {
    return AddEntries(message, "responses", "grantType", "requestId", said);
  }
  if (topic == "instantActions") {
    const bool is_new = FindArray(message, "actions") != nullptr;
    return AddEntries(message, is_new ? "actions" : "instantActions", "actionType", "actionId",
                      said);
  }
  const auto connection = vda5050::ReadConnection(message);
  said.push_back({"connection", Word(connection.connection_state), ""});
}

// A message of SoAR (header, payload), or whatever it is: its texts and numbers.
void AddMembers(const JsonValue& message, Statements& said) {
  const JsonValue* payload = FindMember(message, "payload");
  const JsonValue& told = payload != nullptr && payload->IsObject() ? *payload : message;
  constexpr std::size_t kMost = 6;
  for (const auto& [name, value] : told.GetObject()) {
    if (value.IsObject() || value.IsArray() || said.size() == kMost) continue;
    const std::string key = Word(base::ToView(name));
    said.push_back({key,
                    fmt::format("{} {}", key,
                                value.IsString() ? Shown(base::ToView(value), kLongestShown)
                                                 : base::ToJson(value)),
                    ""});
  }
}

}  // namespace

Statements DescribeMessage(const mqtt::Message& message, const vda5050::TopicLevels* levels) {
  if (message.payload.empty()) return {{"message", "no longer retained", ""}};
  const auto document = vda5050::ReadMessage(message.payload);
  if (!document && levels == nullptr) {
    return {{"message", Shown(message.payload, kLongestShown), ""}};
  }
  if (!document) return {{"message", "cannot be read: " + Shown(document.error().message), ""}};
  Statements said;
  if (levels == nullptr) {
    AddMembers(*document, said);
  } else {
    AddByTopic(levels->topic_name, *document, said);
  }
  return said;
}

Statements FindNews(const Statements& last, const Statements& now) {
  const auto has = [](const Statements& statements, const auto& is_same) {
    return std::any_of(statements.begin(), statements.end(), is_same);
  };
  Statements news;
  for (const Statement& one : now) {
    const bool is_old = has(last, [&](const Statement& other) {
      return other.about == one.about && other.text == one.text;
    });
    if (!is_old) news.push_back(one);
  }
  for (const Statement& one : last) {
    const bool is_gone =
        !has(now, [&](const Statement& other) { return other.about == one.about; });
    if (is_gone && !one.when_gone.empty()) news.push_back({one.about, one.when_gone, ""});
  }
  return news;
}

std::string JoinStatements(const Statements& statements) {
  std::string text;
  for (const Statement& one : statements) text += (text.empty() ? "" : "  ") + one.text;
  return text;
}

}  // namespace fleetpub::cli
