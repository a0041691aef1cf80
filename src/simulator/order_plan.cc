#include "simulator/order_plan.h"

#include <algorithm>
#include <array>

#include "base/json.h"
#include "base/json_members.h"
#include "base/text.h"
#include "simulator/inspection.h"

namespace fleetpub::simulator {
namespace {

using base::FindArray;
using base::FindMember;
using base::NumberMember;
using base::StringMember;
using vda5050::kAllVersions;
using vda5050::kFrom20;
using vda5050::kFrom21;
using vda5050::kFrom30;
using vda5050::kUpTo21;
using vda5050::Version;
using Value = base::JsonValue;

// Under the first of its names that is there.
std::optional<double> ReadNumber(const Value& object, std::string_view name,
                                 std::string_view other) {
  const auto number = NumberMember(object, name);
  return number ? number : NumberMember(object, other);
}

bool ReadFlag(const Value& object, std::string_view name) {
  const Value* flag = FindMember(object, name);
  return flag != nullptr && flag->IsBool() && flag->GetBool();
}

Blocking ReadBlocking(const Value& action) {
  const std::string_view word = StringMember(action, "blockingType");
  if (word == "NONE") return Blocking::kNone;
  if (word == "SOFT") return Blocking::kSoft;
  return word == "SINGLE" ? Blocking::kSingle : Blocking::kHard;
}

void AddActions(const Value& leg, std::uint32_t sequence_id, const ProtocolTerms& terms,
                std::vector<OrderAction>& actions) {
  const Value* array = FindArray(leg, "actions");
  if (array == nullptr) return;
  for (const Value& action : array->GetArray()) {
    OrderAction read;
    read.id = StringMember(action, "actionId");
    read.type = StringMember(action, "actionType");
    read.descriptor = StringMember(action, terms.action_descriptor);
    read.parameters = ReadParameters(action);
    read.blocking = ReadBlocking(action);
    read.is_retriable = terms.HasRetriable() && ReadFlag(action, "retriable");
    read.sequence_id = sequence_id;
    actions.push_back(std::move(read));
  }
}

Leg ReadLeg(const Value& leg, std::string_view id) {
  return {std::string(StringMember(leg, id)), base::UintMember(leg, "sequenceId").value_or(0),
          ReadFlag(leg, "released")};
}

// A radius up to 2.1, an ellipse from 3.0.
void ReadDeviation(const Value& position, Place& place) {
  place.deviation_theta = NumberMember(position, "allowedDeviationTheta").value_or(0);
  place.deviation_a = ReadNumber(position, "allowedDeviationXY", "allowedDeviationXy").value_or(0);
  place.deviation_b = place.deviation_a;
  const Value* ellipse = FindMember(position, "allowedDeviationXY");
  if (ellipse == nullptr || !ellipse->IsObject()) return;
  place.deviation_a = NumberMember(*ellipse, "a").value_or(0);
  place.deviation_b = NumberMember(*ellipse, "b").value_or(0);
  place.deviation_angle = NumberMember(*ellipse, "theta").value_or(0);
}

std::optional<Place> ReadPlace(const Value& node) {
  const Value* position = FindMember(node, "nodePosition");
  if (position == nullptr) return std::nullopt;
  Place place{.x = NumberMember(*position, "x").value_or(0),
              .y = NumberMember(*position, "y").value_or(0),
              .theta = NumberMember(*position, "theta"),
              .map_id = std::string(StringMember(*position, "mapId"))};
  ReadDeviation(*position, place);
  return place;
}

EdgeLeg ReadEdge(const Value& edge, const ProtocolTerms& terms) {
  EdgeLeg leg{ReadLeg(edge, "edgeId")};
  leg.max_speed = ReadNumber(edge, "maxSpeed", "maximumSpeed");
  leg.length = ReadNumber(edge, "length", "distance");
  leg.orientation = NumberMember(edge, "orientation");
  leg.is_global =
      terms.version == Version::k110 || StringMember(edge, "orientationType") == "GLOBAL";
  const Value* trajectory = FindMember(edge, "trajectory");
  const Value* points = trajectory == nullptr ? nullptr : FindArray(*trajectory, "controlPoints");
  if (points == nullptr) return leg;
  for (const Value& point : points->GetArray()) {
    leg.via.push_back({NumberMember(point, "x").value_or(0), NumberMember(point, "y").value_or(0)});
  }
  return leg;
}

// It has no mast, no rails, no limit to how fast it turns, and drives forwards.
constexpr auto kMembers = std::to_array<OptionalMember>({
    {"order.orderDescription", kFrom30, true},
    {"order.zoneSetId", kUpTo21, true},
    {"order.nodes.nodeDescription", kUpTo21, true},
    {"order.nodes.nodeDescriptor", kFrom30, true},
    {"order.nodes.nodePosition", kAllVersions, true},
    {"order.nodes.nodePosition.theta", kAllVersions, true},
    {"order.nodes.nodePosition.allowedDeviationXY", kAllVersions, true},
    {"order.nodes.nodePosition.allowedDeviationTheta", kAllVersions, true},
    {"order.nodes.nodePosition.mapDescription", kUpTo21, true},
    {"order.nodes.actions.actionDescription", kUpTo21, true},
    {"order.nodes.actions.actionDescriptor", kFrom30, true},
    {"order.nodes.actions.actionParameters", kAllVersions, true},
    {"order.nodes.actions.retriable", kFrom30, true},
    {"order.edges.edgeDescription", kUpTo21, true},
    {"order.edges.edgeDescriptor", kFrom30, true},
    {"order.edges.maxSpeed", kUpTo21, true},
    {"order.edges.maximumSpeed", kFrom30, true},
    {"order.edges.maxHeight", kUpTo21, false},
    {"order.edges.maximumMobileRobotHeight", kFrom30, false},
    {"order.edges.minHeight", kUpTo21, false},
    {"order.edges.minimumLoadHandlingDeviceHeight", kFrom30, false},
    {"order.edges.orientation", kAllVersions, true},
    {"order.edges.orientationType", kFrom20, true},
    {"order.edges.direction", kAllVersions, false},
    {"order.edges.rotationAllowed", kUpTo21, true},
    {"order.edges.reachOrientationBeforeEntering", kFrom30, false},
    {"order.edges.maxRotationSpeed", kAllVersions, false},  // 3.0's schema has kept the old name
    {"order.edges.maximumRotationSpeed", kFrom30, false},
    {"order.edges.trajectory", kAllVersions, true},
    {"order.edges.distance", {Version::k110, Version::k110}, true},
    {"order.edges.length", kAllVersions, true},
    {"order.edges.corridor", kFrom21, true},
    {"order.edges.actions.actionDescription", kUpTo21, true},
    {"order.edges.actions.actionDescriptor", kFrom30, true},
    {"order.edges.actions.actionParameters", kAllVersions, true},
    {"order.edges.actions.retriable", kFrom30, true},
});

// `order.edges.maxSpeed`: the first level is the message, arrays count item by item.
bool Has(const Value& value, std::string_view path) {
  const std::string_view name = path.substr(0, path.find('.'));
  const Value* member = FindMember(value, name);
  if (member == nullptr || name.size() == path.size()) return member != nullptr;
  const std::string_view rest = path.substr(name.size() + 1);
  if (!member->IsArray()) return Has(*member, rest);
  return std::any_of(member->Begin(), member->End(),
                     [&](const Value& item) { return Has(item, rest); });
}

}  // namespace

OrderPlan ReadOrder(const Value& message, const ProtocolTerms& terms) {
  OrderPlan plan;
  plan.order.id = StringMember(message, "orderId");
  plan.order.update_id = base::UintMember(message, "orderUpdateId").value_or(0);
  plan.order.zone_set_id = StringMember(message, "zoneSetId");
  const Value* nodes = FindArray(message, "nodes");
  const Value* edges = FindArray(message, "edges");
  if (nodes == nullptr || edges == nullptr) return plan;
  for (rapidjson::SizeType i = 0; i < nodes->Size(); ++i) {
    if (i > 0 && i <= edges->Size()) {
      plan.order.edges.push_back(ReadEdge((*edges)[i - 1], terms));
      AddActions((*edges)[i - 1], plan.order.edges.back().sequence_id, terms, plan.actions);
    }
    plan.order.nodes.push_back({ReadLeg((*nodes)[i], "nodeId"), ReadPlace((*nodes)[i])});
    const NodeLeg& node = plan.order.nodes.back();
    AddActions((*nodes)[i], node.sequence_id, terms, plan.actions);
    if (node.released) plan.order.decision_point = node;
  }
  plan.order.edge_count = plan.order.edges.size();
  return plan;
}

Order ExampleOrder() {
  constexpr double kLong = 1e7;  // m
  Order order{.id = "order-1",
              .nodes = {{{"node-1", 2}}, {{"node-2", 4}}},
              .edges = {{{"edge-1", 1}}, {{"edge-2", 3}}}};
  for (EdgeLeg& edge : order.edges) edge.length = kLong;
  order.edge_count = order.edges.size();
  order.decision_point = order.nodes.back();
  return order;
}

std::vector<OptionalMember> ListOptionalMembers(Version version) {
  std::vector<OptionalMember> members;
  for (const OptionalMember& member : kMembers) {
    if (member.versions.Contains(version)) members.push_back(member);
  }
  return members;
}

std::vector<std::string_view> FindUnsupported(const Value& message, Version version) {
  std::vector<std::string_view> found;
  for (const OptionalMember& member : ListOptionalMembers(version)) {
    const std::string_view path = member.path.substr(member.path.find('.') + 1);
    if (!member.is_supported && Has(message, path)) found.push_back(member.path);
  }
  return found;
}

}  // namespace fleetpub::simulator
