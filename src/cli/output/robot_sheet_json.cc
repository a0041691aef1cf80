#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/json.h"
#include "base/json_members.h"
#include "cli/output/robot_sheet.h"

namespace fleetpub::cli {
namespace {

using app::RobotSheet;
using base::Put;
using base::PutArray;
using base::PutText;
using vda5050::RobotState;
using Json = base::JsonWriter;

void PutNull(Json& json, std::string_view key) {
  PutText(json, key);
  json.Null();
}

void PutOrNull(Json& json, std::string_view key, std::string_view text) {
  if (text.empty()) return PutNull(json, key);
  Put(json, key, text);
}

void PutOrNull(Json& json, std::string_view key, std::optional<bool> value) {
  if (!value) return PutNull(json, key);
  Put(json, key, *value);
}

// jq takes null for less than every number; a text is greater.
template <typename Number>
void PutOrUnknown(Json& json, std::string_view key, const std::optional<Number>& value) {
  if (!value) return Put(json, key, std::string_view("unknown"));
  if constexpr (std::is_floating_point_v<Number>) {
    Put(json, key, *value);
  } else {
    Put(json, key, static_cast<std::uint32_t>(*value));
  }
}

void PutIfThere(Json& json, std::string_view key, std::string_view text) {
  if (!text.empty()) Put(json, key, text);
}

// A message, which is JSON.
void PutMessage(Json& json, std::string_view key, const std::string& message) {
  if (message.empty()) return PutNull(json, key);
  PutText(json, key);
  json.RawValue(message.data(), message.size(), rapidjson::kObjectType);
}

void PutTexts(Json& json, std::string_view key, const std::vector<std::string>& texts) {
  PutText(json, key);
  json.StartArray();
  for (const std::string& text : texts) PutText(json, text);
  json.EndArray();
}

void PutReferences(Json& json, std::string_view key,
                   const std::vector<vda5050::ErrorReference>& references) {
  PutArray(json, key, references, [&](const vda5050::ErrorReference& reference) {
    Put(json, "referenceKey", reference.key);
    Put(json, "referenceValue", reference.value);
  });
}

void PutPosition(Json& json, const RobotState& state) {
  if (state.position) {
    base::PutObject(json, "position", [&] {
      PutOrUnknown(json, "x", state.position->x);
      PutOrUnknown(json, "y", state.position->y);
      PutOrUnknown(json, "theta", state.position->theta);
      PutOrNull(json, "mapId", state.position->map_id);
      PutOrNull(json, "localized", state.position->localized);
    });
  } else {
    PutNull(json, "position");
  }
  PutOrNull(json, "lastNodeId", state.last_node_id);
  PutOrUnknown(json, "lastNodeSequenceId", state.last_node_sequence_id);
}

void PutOrder(Json& json, const RobotState& state) {
  Put(json, "orderId", state.order_id);
  PutOrUnknown(json, "orderUpdateId", state.order_update_id);
  PutOrUnknown(json, "nodesLeft", state.nodes_left);
  PutOrUnknown(json, "edgesLeft", state.edges_left);
}

void PutActions(Json& json, std::string_view key, const std::vector<vda5050::ActionState>& list) {
  PutArray(json, key, list, [&](const vda5050::ActionState& action) {
    Put(json, "actionId", action.id);
    Put(json, "actionType", action.type);
    Put(json, "actionStatus", action.status);
    PutIfThere(json, "actionResult", action.result);
  });
}

void PutErrors(Json& json, const RobotState& state) {
  PutArray(json, "errors", state.errors, [&](const vda5050::RobotError& error) {
    Put(json, "errorType", error.type);
    Put(json, "errorLevel", error.level);
    Put(json, "errorDescription", error.description);
    PutIfThere(json, "errorHint", error.hint);
    PutReferences(json, "errorReferences", error.references);
  });
  PutArray(json, "information", state.information, [&](const vda5050::RobotInformation& info) {
    Put(json, "infoType", info.type);
    Put(json, "infoLevel", info.level);
    Put(json, "infoDescription", info.description);
    PutReferences(json, "infoReferences", info.references);
  });
}

void PutLoads(Json& json, const RobotState& state) {
  if (!state.loads) return PutNull(json, "loads");
  PutArray(json, "loads", *state.loads, [&](const vda5050::RobotLoad& load) {
    Put(json, "loadId", load.id);
    Put(json, "loadType", load.type);
    Put(json, "loadPosition", load.position);
    PutOrUnknown(json, "weight", load.weight);
  });
}

// Of a state that is not known every member says so.
void PutState(Json& json, const std::optional<RobotState>& known) {
  const RobotState& state = known ? *known : RobotState();
  PutOrNull(json, "operatingMode", state.operating_mode);
  PutOrNull(json, "emergencyStop", state.emergency_stop);
  PutOrNull(json, "fieldViolation", state.field_violation);
  PutOrNull(json, "driving", state.driving);
  PutOrNull(json, "paused", state.paused);
  PutOrUnknown(json, "batteryCharge", state.battery_charge);
  PutOrNull(json, "charging", state.charging);
  PutOrUnknown(json, "batteryVoltage", state.battery_voltage);
  PutOrUnknown(json, "batteryHealth", state.battery_health);
  PutOrUnknown(json, "range", state.range);
  PutPosition(json, state);
  if (!known) {
    for (const std::string_view key : {"orderId", "actionStates", "instantActionStates",
                                       "zoneActionStates", "errors", "information", "loads"}) {
      PutNull(json, key);
    }
    return;
  }
  PutOrder(json, state);
  PutActions(json, "actionStates", state.action_states);
  PutActions(json, "instantActionStates", state.instant_action_states);
  PutActions(json, "zoneActionStates", state.zone_action_states);
  PutErrors(json, state);
  PutLoads(json, state);
}

void PutSpecification(Json& json, const RobotSheet& robot) {
  if (!robot.factsheet) {
    PutNull(json, "specification");
    return PutNull(json, "supportedActions");
  }
  base::PutObject(json, "specification", [&, &is = robot.factsheet->specification] {
    PutOrNull(json, "seriesName", is.series);
    PutOrNull(json, "seriesDescription", is.series_description);
    PutOrNull(json, "robotClass", is.robot_class);
    PutOrNull(json, "kinematics", is.kinematics);
    PutOrUnknown(json, "maximumLoadMass", is.maximum_load);
    PutOrUnknown(json, "maximumSpeed", is.maximum_speed);
    PutOrUnknown(json, "length", is.length);
    PutOrUnknown(json, "width", is.width);
    PutOrUnknown(json, "maximumHeight", is.maximum_height);
  });
  std::vector<std::string> types;
  for (const auto& action : robot.factsheet->actions) types.push_back(action.type);
  PutTexts(json, "supportedActions", types);
}

void PutCommands(Json& json, const RobotSheet& robot) {
  if (!robot.commands_fault.empty()) {
    PutNull(json, "commands");
    return Put(json, "commandsFault", robot.commands_fault);
  }
  PutArray(json, "commands", robot.commands, [&](const ledger::Record& record) {
    PutText(json, "id");
    json.Int64(record.id);
    Put(json, "time", base::FormatTimestamp(record.recorded_at));
    Put(json, "user", record.user);
    Put(json, "host", record.host);
    Put(json, "broker", record.broker);
    Put(json, "topic", record.topic);
    PutArray(json, "actions", record.actions, [&](const message::ActionRef& action) {
      Put(json, "type", action.type);
      Put(json, "id", action.id);
    });
    Put(json, "status", record.status);
    PutIfThere(json, "message", record.detail);
  });
}

void PutConnection(Json& json, const RobotSheet& robot) {
  const vda5050::ConnectionMessage none;
  const vda5050::ConnectionMessage& connection = robot.connection ? *robot.connection : none;
  PutOrNull(json, "connectionState", connection.connection_state);
  PutOrNull(json, "connectionTimestamp", connection.header.timestamp);
  PutIfThere(json, "connectionFault", connection.fault);
}

}  // namespace

std::string RobotSheetJson(const RobotSheet& sheet) {
  base::JsonBuffer buffer;
  Json json(buffer);
  json.StartObject();
  Put(json, "target", sheet.robot.ToString());
  Put(json, "manufacturer", sheet.robot.manufacturer);
  Put(json, "serialNumber", sheet.robot.serial_number);
  PutOrNull(json, "version",
            sheet.version ? vda5050::GetFacts(*sheet.version).name : std::string_view());
  PutOrNull(json, "headerVersion", sheet.said_version);
  PutOrNull(json, "place", sheet.place);
  PutConnection(json, sheet);
  PutOrNull(json, "stateTimestamp",
            sheet.state ? std::string_view(sheet.state->header.timestamp) : std::string_view());
  Put(json, "stateIsRetained", sheet.state_is_retained);
  PutIfThere(json, "stateFault", sheet.state_fault);
  PutState(json, sheet.state);
  PutSpecification(json, sheet);
  PutIfThere(json, "factsheetFault", sheet.factsheet_fault);
  PutCommands(json, sheet);
  PutMessage(json, "connection", sheet.connection_json);
  PutMessage(json, "state", sheet.state_json);
  PutMessage(json, "factsheet", sheet.factsheet_json);
  json.EndObject();
  return {buffer.GetString(), buffer.GetSize()};
}

}  // namespace fleetpub::cli
