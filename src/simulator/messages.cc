#include "simulator/messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>

#include "base/json.h"
#include "base/json_members.h"

namespace fleetpub::simulator {
namespace {

constexpr double kPerMetre = 1e4;  // steps in which places are told; of angles, per rad

using Json = base::JsonWriter;

using base::Put;
using base::PutArray;
using base::PutObject;

template <typename Legs>
void PutLegs(Json& json, std::string_view key, std::string_view id, const Legs& legs) {
  PutArray(json, key, legs, [&](const Leg& leg) {
    Put(json, id, leg.id);
    Put(json, "sequenceId", leg.sequence_id);
    Put(json, "released", leg.released);
  });
}

std::string LowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

double Rounded(double value, double steps) { return std::round(value * steps) / steps; }

void PutAction(Json& json, const ActionState& action, const ProtocolTerms& terms,
               const Faults& faults) {
  Put(json, "actionId", action.id);
  Put(json, "actionType", action.type);
  if (!action.descriptor.empty()) Put(json, terms.action_descriptor, action.descriptor);
  const std::string_view status = GetName(action.status);
  if (faults.Has(Fault::kLowerCase)) {
    Put(json, "actionStatus", LowerCase(status));
  } else {
    Put(json, "actionStatus", status);
  }
  if (!action.result.empty()) Put(json, terms.action_result, action.result);
}

void PutActions(Json& json, const RobotState& state, const ProtocolTerms& terms,
                const Faults& faults) {
  std::vector<const ActionState*> actions;
  for (const OrderAction& action : state.order_actions) {
    const bool is_horizon = action.sequence_id > state.order.decision_point.sequence_id;
    if (!is_horizon || !faults.Has(Fault::kOmitHorizonActions)) actions.push_back(&action);
  }
  const bool apart = terms.own_instant_states && !faults.Has(Fault::kInstantInActionStates);
  if (!apart) {
    for (const ActionState& action : state.instant_actions) actions.push_back(&action);
  }
  PutArray(json, "actionStates", actions,
           [&](const ActionState* action) { PutAction(json, *action, terms, faults); });
  if (!terms.own_instant_states) return;
  const std::vector<ActionState> none;
  const auto put = [&](const ActionState& action) { PutAction(json, action, terms, faults); };
  PutArray(json, "instantActionStates", apart ? state.instant_actions : none, put);
  PutArray(json, "zoneActionStates", none, put);
}

void PutErrors(Json& json, const std::vector<RobotError>& errors, const Faults& faults) {
  const References none;
  PutArray(json, "errors", errors, [&](const RobotError& error) {
    Put(json, "errorType", error.type);
    const References& references = faults.Has(Fault::kNoReferences) ? none : error.references;
    PutArray(json, "errorReferences", references, [&](const auto& reference) {
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

void PutPosition(Json& json, const Position& position, const ProtocolTerms& terms,
                 const Faults& faults) {
  const double unit = faults.Has(Fault::kDegrees) ? 180 / std::numbers::pi : 1;
  const double most = std::numbers::pi * unit;  // which rounding would exceed
  PutObject(json, terms.position, [&] {
    Put(json, "x", Rounded(position.x, kPerMetre));
    Put(json, "y", Rounded(position.y, kPerMetre));
    Put(json, "theta", std::clamp(Rounded(position.theta * unit, kPerMetre), -most, most));
    Put(json, "mapId", position.map_id);
    Put(json, terms.initialized, true);
  });
}

// In the robot's own axes.
void PutVelocity(Json& json, const RobotState& state) {
  PutObject(json, "velocity", [&] {
    Put(json, "vx", Rounded(state.speed * std::cos(state.speed_angle), kPerMetre));
    Put(json, "vy", Rounded(state.speed * std::sin(state.speed_angle), kPerMetre));
    Put(json, "omega", 0.0);
  });
}

void PutLoads(Json& json, const RobotState& state) {
  PutArray(json, "loads", state.loads, [&](const Load& load) {
    if (!load.id.empty()) Put(json, "loadId", load.id);
    if (!load.type.empty()) Put(json, "loadType", load.type);
  });
}

void PutPowerAndSafety(Json& json, const RobotState& state, const ProtocolTerms& terms) {
  PutObject(json, terms.power, [&] {
    Put(json, terms.charge, Rounded(state.battery, 10));
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
  std::string timestamp = base::FormatTimestamp(time);
  if (!header.has_zone) timestamp.pop_back();
  return fmt::format(
      R"({{"headerId":{},"timestamp":"{}","version":{},"manufacturer":{},"serialNumber":{},{}}})",
      header_id, timestamp, base::JsonString(header.version), base::JsonString(header.manufacturer),
      base::JsonString(header.serial_number), body);
}

std::string ConnectionBody(std::string_view connection_state) {
  return fmt::format(R"("connectionState":"{}")", connection_state);
}

std::string StateBody(const RobotState& state, const ProtocolTerms& terms, const Faults& faults) {
  base::JsonBuffer buffer;
  Json json(buffer);
  json.StartObject();
  Put(json, "orderId", state.order.id);
  Put(json, "orderUpdateId", state.order.update_id);
  Put(json, "lastNodeId", state.last_node_id);
  Put(json, "lastNodeSequenceId", state.last_node_sequence_id);
  if (state.distance_since_last_node) {
    Put(json, "distanceSinceLastNode", Rounded(*state.distance_since_last_node, kPerMetre));
  }
  Put(json, "driving", state.driving);
  Put(json, "paused", state.paused);
  Put(json, "newBaseRequest", state.new_base_request);
  Put(json, "operatingMode", state.operating_mode);
  PutLegs(json, "nodeStates", "nodeId", state.order.nodes);
  PutLegs(json, "edgeStates", "edgeId", state.order.edges);
  PutPosition(json, state.position, terms, faults);
  PutVelocity(json, state);
  PutMaps(json, state, terms);
  PutRequests(json, state, terms);
  PutActions(json, state, terms, faults);
  PutPowerAndSafety(json, state, terms);
  PutErrors(json, state.errors, faults);
  PutLoads(json, state);
  PutArray(json, "information", std::vector<int>(), [](int) {});
  json.EndObject();
  return {buffer.GetString() + 1, buffer.GetSize() - 2};
}

std::string VisualizationBody(const RobotState& state, const ProtocolTerms& terms,
                              std::optional<std::uint32_t> state_header_id) {
  base::JsonBuffer buffer;
  Json json(buffer);
  json.StartObject();
  if (state_header_id && terms.visualization_refers) {
    Put(json, "referenceStateHeaderId", *state_header_id);
  }
  PutPosition(json, state.position, terms, {});
  PutVelocity(json, state);
  json.EndObject();
  return {buffer.GetString() + 1, buffer.GetSize() - 2};
}

}  // namespace fleetpub::simulator
