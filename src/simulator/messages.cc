#include "simulator/messages.h"

#include <fmt/format.h>

#include "base/json.h"
#include "base/json_members.h"

namespace fleetpub::simulator {
namespace {

using Json = base::JsonWriter;

using base::Put;
using base::PutArray;
using base::PutObject;

void PutLegs(Json& json, std::string_view key, std::string_view id, const std::vector<Leg>& legs) {
  PutArray(json, key, legs, [&](const Leg& leg) {
    Put(json, id, leg.id);
    Put(json, "sequenceId", leg.sequence_id);
    Put(json, "released", leg.released);
  });
}

void PutAction(Json& json, const ActionState& action, const ProtocolTerms& terms) {
  Put(json, "actionId", action.id);
  Put(json, "actionType", action.type);
  if (!action.descriptor.empty()) Put(json, terms.action_descriptor, action.descriptor);
  Put(json, "actionStatus", GetName(action.status));
  if (!action.result.empty()) Put(json, terms.action_result, action.result);
}

void PutActions(Json& json, const RobotState& state, const ProtocolTerms& terms) {
  const auto put = [&](const ActionState& action) { PutAction(json, action, terms); };
  if (terms.own_instant_states) {
    PutArray(json, "actionStates", state.order_actions, put);
    PutArray(json, "instantActionStates", state.instant_actions, put);
    PutArray(json, "zoneActionStates", std::vector<ActionState>(), put);
    return;
  }
  std::vector<ActionState> all = state.order_actions;
  all.insert(all.end(), state.instant_actions.begin(), state.instant_actions.end());
  PutArray(json, "actionStates", all, put);
}

void PutErrors(Json& json, const std::vector<RobotError>& errors) {
  PutArray(json, "errors", errors, [&](const RobotError& error) {
    Put(json, "errorType", error.type);
    PutArray(json, "errorReferences", error.references, [&](const auto& reference) {
      Put(json, "referenceKey", reference.first);
      Put(json, "referenceValue", reference.second);
    });
    Put(json, "errorDescription", error.description);
    Put(json, "errorLevel", error.level);
  });
}

void PutMaps(Json& json, const RobotState& state, const ProtocolTerms& terms) {
  const auto status = [](bool enabled) -> std::string_view {
    return enabled ? "ENABLED" : "DISABLED";
  };
  if (terms.HasMaps()) {
    PutArray(json, "maps", state.maps, [&](const Map& map) {
      Put(json, "mapId", map.id);
      Put(json, "mapVersion", map.version);
      Put(json, "mapStatus", status(map.enabled));
    });
  }
  if (terms.HasZoneSets()) {
    PutArray(json, "zoneSets", state.zone_sets, [&](const ZoneSet& set) {
      Put(json, "zoneSetId", set.id);
      Put(json, "mapId", set.map_id);
      Put(json, "zoneSetStatus", status(set.enabled));
    });
  }
}

void PutRequests(Json& json, const RobotState& state, const ProtocolTerms& terms) {
  if (!terms.HasZoneSets()) return;
  for (const bool for_zones : {true, false}) {
    std::vector<Request> requests = state.requests;
    std::erase_if(requests, [&](const Request& r) { return r.edge_id.empty() != for_zones; });
    PutArray(json, for_zones ? "zoneRequests" : "edgeRequests", requests, [&](const Request& r) {
      Put(json, "requestId", r.id);
      Put(json, "requestType", r.type);
      if (for_zones) {
        Put(json, "zoneId", r.zone_id);
        Put(json, "zoneSetId", r.zone_set_id);
      } else {
        Put(json, "edgeId", r.edge_id);
        Put(json, "sequenceId", r.sequence_id);
      }
      Put(json, "requestStatus", r.status);
    });
  }
}

void PutPosition(Json& json, const Position& position, const ProtocolTerms& terms) {
  PutObject(json, terms.position, [&] {
    Put(json, "x", position.x);
    Put(json, "y", position.y);
    Put(json, "theta", position.theta);
    Put(json, "mapId", position.map_id);
    Put(json, terms.initialized, true);
  });
}

void PutPowerAndSafety(Json& json, const RobotState& state, const ProtocolTerms& terms) {
  PutObject(json, terms.power, [&] {
    Put(json, terms.charge, static_cast<double>(state.battery));
    Put(json, "charging", state.charging);
  });
  PutObject(json, "safetyState", [&] {
    Put(json, terms.emergency_stop, state.emergency_stop);
    Put(json, "fieldViolation", state.field_violation);
  });
}

}  // namespace

std::string Message(const Header& header, std::uint32_t header_id, base::WallTime time,
                    std::string_view body) {
  return fmt::format(
      R"({{"headerId":{},"timestamp":"{}","version":{},"manufacturer":{},"serialNumber":{},{}}})",
      header_id, base::FormatTimestamp(time), base::JsonString(header.version),
      base::JsonString(header.manufacturer), base::JsonString(header.serial_number), body);
}

std::string ConnectionBody(std::string_view connection_state) {
  return fmt::format(R"("connectionState":"{}")", connection_state);
}

std::string StateBody(const RobotState& state, const ProtocolTerms& terms) {
  base::JsonBuffer buffer;
  Json json(buffer);
  json.StartObject();
  Put(json, "orderId", state.order.id);
  Put(json, "orderUpdateId", state.order.update_id);
  Put(json, "lastNodeId", state.last_node_id);
  Put(json, "lastNodeSequenceId", state.last_node_sequence_id);
  Put(json, "driving", state.Driving());
  Put(json, "paused", state.paused);
  Put(json, "operatingMode", state.operating_mode);
  PutLegs(json, "nodeStates", "nodeId", state.order.nodes);
  PutLegs(json, "edgeStates", "edgeId", state.order.edges);
  PutPosition(json, state.position, terms);
  PutMaps(json, state, terms);
  PutRequests(json, state, terms);
  PutActions(json, state, terms);
  PutPowerAndSafety(json, state, terms);
  PutErrors(json, state.errors);
  PutArray(json, "loads", std::vector<int>(), [](int) {});
  PutArray(json, "information", std::vector<int>(), [](int) {});
  json.EndObject();
  return {buffer.GetString() + 1, buffer.GetSize() - 2};
}

}  // namespace fleetpub::simulator
