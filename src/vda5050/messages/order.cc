#include "vda5050/messages/order.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/text.h"

namespace fleetpub::vda5050 {
namespace {

using base::JsonString;
using base::Printable;

constexpr std::string_view kNodes = "order.nodes";
constexpr std::string_view kNodePosition = "order.nodes.nodePosition";
constexpr std::string_view kEdges = "order.edges";

constexpr std::array<std::string_view, 4> Always(std::string_view name) {
  return {name, name, name, name};
}
constexpr std::array<std::string_view, 4> Until30(std::string_view name, std::string_view newer) {
  return {name, name, name, newer};
}

// 1.1 writes `lenght` in its text and `distance` in its schema, 3.0 maximumRotationSpeed in its text
// and maxRotationSpeed in its schema: there the text is followed.
constexpr auto kMembers = std::to_array<OrderMember>({
    {kNodes, "nodeDescription", Until30("nodeDescription", "nodeDescriptor"), false},
    {kNodes, "nodePosition", Always("nodePosition"), false},
    {kNodePosition, "theta", Always("theta"), false},
    {kNodePosition,
     "allowedDeviationXY",
     {"allowedDeviationXy", "allowedDeviationXY", "allowedDeviationXY", "allowedDeviationXY"},
     false},
    {kNodePosition, "allowedDeviationTheta", Always("allowedDeviationTheta"), false},
    {kEdges, "edgeDescription", Until30("edgeDescription", "edgeDescriptor"), false},
    {kEdges, "maxSpeed", Until30("maxSpeed", "maximumSpeed"), true},
    {kEdges, "maxRotationSpeed", Until30("maxRotationSpeed", "maximumRotationSpeed"), true},
    {kEdges, "maxHeight", Until30("maxHeight", "maximumMobileRobotHeight"), true},
    {kEdges, "minHeight", Until30("minHeight", "minimumLoadHandlingDeviceHeight"), true},
    {kEdges, "orientation", Always("orientation"), true},
    {kEdges,
     "orientationType",
     {"", "orientationType", "orientationType", "orientationType"},
     true},
    {kEdges, "rotationAllowed", Until30("rotationAllowed", "reachOrientationBeforeEntering"),
     false},
    {kEdges, "length", {"distance", "length", "length", "length"}, false},
    {kEdges, "trajectory", Always("trajectory"), true},
});

const OrderMember& FindOrderMember(std::string_view key) {
  return *std::find_if(kMembers.begin(), kMembers.end(),
                       [&](const OrderMember& member) { return member.key == key; });
}

std::string Number(double value) { return fmt::format("{}", value); }

// Within ±π.
double Normalized(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

}  // namespace

std::span<const OrderMember> OrderMembers() { return kMembers; }

OrderWriter::OrderWriter(Version version, const Factsheet* factsheet, std::set<std::string> without)
    : version_(version), factsheet_(factsheet), without_(std::move(without)) {}

void OrderWriter::Refuse(std::string reason) {
  if (std::find(refusals_.begin(), refusals_.end(), reason) == refusals_.end()) {
    refusals_.push_back(std::move(reason));
  }
}

void OrderWriter::CheckId(std::string_view id, std::string_view of) {
  if (factsheet_ == nullptr) return;
  const FactsheetLimits& limits = factsheet_->limits;
  if (limits.id_length > 0 && id.size() > limits.id_length) {
    Refuse(fmt::format("the name of {} has {} characters, and the robot takes {}", of, id.size(),
                       limits.id_length));
  }
  const bool is_number = id.find_first_not_of("0123456789") == std::string_view::npos;
  if (limits.id_numerical_only && !is_number) {
    Refuse(fmt::format("the robot takes ids of digits only, and {} has others", of));
  }
}

// What a factsheet does not list is not supported; a robot without such a list says nothing. That
// a place is somewhere every robot of a map takes.
void OrderWriter::Add(std::string& json, std::string_view key, const std::string& value,
                      std::string_view of) {
  if (value.empty()) return;
  const OrderMember& member = FindOrderMember(key);
  const std::string_view name = member.names[static_cast<std::size_t>(version_)];
  if (name.empty()) return;
  const bool is_unwanted = std::any_of(member.names.begin(), member.names.end(), [&](auto other) {
    return !other.empty() && without_.contains(std::string(other));
  });
  if (is_unwanted) return;
  std::string path = fmt::format("{}.{}", member.list, name);
  const bool is_taken =
      factsheet_ == nullptr || !factsheet_->has_optional_parameters || key == "nodePosition" ||
      std::any_of(factsheet_->optional_parameters.begin(), factsheet_->optional_parameters.end(),
                  [&](const OptionalParameter& listed) { return listed.name == path; });
  if (is_taken) {
    json += fmt::format(R"({}"{}":{})", json.ends_with('{') ? "" : ",", name, value);
    written_.insert(std::move(path));
    return;
  }
  left_out_.insert(path);
  if (!member.is_binding) return;
  Refuse(
      fmt::format("{} has {}, which the robot's factsheet does not list: it would drive without; "
                  "--without {} leaves it out",
                  of, name, name));
}

void OrderWriter::Add(std::string& json, std::string_view key, const std::optional<double>& value,
                      std::string_view of) {
  if (value) Add(json, key, Number(*value), of);
}

void OrderWriter::CheckRequired(std::string_view list, std::string_view of) {
  if (factsheet_ == nullptr) return;
  for (const OptionalParameter& parameter : factsheet_->optional_parameters) {
    if (!parameter.is_required || !parameter.name.starts_with(list)) continue;
    const bool is_ours = std::any_of(kMembers.begin(), kMembers.end(), [&](const auto& member) {
      return parameter.name ==
             fmt::format("{}.{}", member.list, member.names[static_cast<std::size_t>(version_)]);
    });
    if (!is_ours || written_.contains(parameter.name)) continue;
    Refuse(
        fmt::format("the robot's factsheet requires {}, which is not known of {}: a layout may "
                    "say it. --layout FILE",
                    Printable(parameter.name), of));
  }
}

std::string OrderWriter::WriteNode(const OrderNode& node, std::uint32_t sequence_id,
                                   bool released) {
  const std::string of = "node " + Printable(node.id);
  CheckId(node.id, of);
  written_.clear();
  std::string json = fmt::format(R"({{"nodeId":{},"sequenceId":{},"released":{})",
                                 JsonString(node.id), sequence_id, released);
  if (!node.description.empty()) Add(json, "nodeDescription", JsonString(node.description), of);
  AddPosition(json, node);
  json += R"(,"actions":)" + WriteActions(node.actions, "NODE", of) + "}";
  CheckRequired(kNodes, of);
  return json;
}

void OrderWriter::AddPosition(std::string& json, const OrderNode& node) {
  if (!node.position) return;
  const OrderPosition& position = *node.position;
  const std::string of = "node " + Printable(node.id);
  std::string text = fmt::format(R"({{"x":{},"y":{})", Number(position.x), Number(position.y));
  if (position.theta) Add(text, "theta", Number(Normalized(*position.theta)), of);
  if (const auto& radius = position.deviation_xy) {
    Add(text, "allowedDeviationXY",
        version_ >= Version::k300 ? fmt::format(R"({{"a":{0},"b":{0},"theta":0}})", Number(*radius))
                                  : Number(*radius),
        of);
  }
  Add(text, "allowedDeviationTheta", position.deviation_theta, of);
  text += fmt::format(R"(,"mapId":{}}})", JsonString(position.map_id));
  Add(json, "nodePosition", text, of);
}

std::string OrderWriter::WriteEdge(const OrderEdge& edge, std::uint32_t sequence_id, bool released,
                                   std::string_view start, std::string_view end) {
  const std::string of = "edge " + Printable(edge.id);
  CheckId(edge.id, of);
  written_.clear();
  std::string json = fmt::format(R"({{"edgeId":{},"sequenceId":{},"released":{})",
                                 JsonString(edge.id), sequence_id, released);
  if (version_ < Version::k300) {
    json += fmt::format(R"(,"startNodeId":{},"endNodeId":{})", JsonString(start), JsonString(end));
  }
  if (!edge.description.empty()) Add(json, "edgeDescription", JsonString(edge.description), of);
  Add(json, "maxSpeed", edge.max_speed, of);
  Add(json, "maxHeight", edge.max_height, of);
  Add(json, "minHeight", edge.min_height, of);
  AddOrientation(json, edge);
  Add(json, "maxRotationSpeed", edge.max_rotation_speed, of);
  AddTrajectory(json, edge);
  Add(json, "length", edge.length, of);
  json += R"(,"actions":)" + WriteActions(edge.actions, "EDGE", of) + "}";
  CheckRequired(kEdges, of);
  return json;
}

// 1.1 knows global orientations only. From 3.0 global ones, and turning before an edge, are for
// robots that drive in any direction.
void OrderWriter::AddOrientation(std::string& json, const OrderEdge& edge) {
  const std::string of = "edge " + Printable(edge.id);
  const std::string& kinematics = factsheet_ == nullptr ? "" : factsheet_->specification.kinematics;
  const bool is_omnidirectional = kinematics.find("OMNI") != std::string::npos;
  if (edge.orientation && version_ == Version::k110 && edge.is_tangential) {
    if (edge.heading && !edge.trajectory) {
      Add(json, "orientation", Number(Normalized(*edge.heading + *edge.orientation)), of);
    } else if (*edge.orientation != 0) {
      Refuse(
          fmt::format("{} has an orientation along a curve, which version 1.1.0 cannot say. "
                      "--without orientation leaves it out",
                      of));
    }
  } else if (edge.orientation) {
    // Forwards along the path is what every robot does unasked.
    const bool is_usual = edge.is_tangential && *edge.orientation == 0;
    std::string probe = "{";
    if (!is_usual) {
      if (version_ >= Version::k300 && !edge.is_tangential && !kinematics.empty() &&
          !is_omnidirectional) {
        Refuse(
            fmt::format("{} has a global orientation, which from 3.0 is for omnidirectional "
                        "robots, and this one is {}. --without orientation leaves it out",
                        of, Printable(kinematics)));
      }
      Add(probe, "orientation", Number(Normalized(*edge.orientation)), of);
      Add(probe, "orientationType", edge.is_tangential ? R"("TANGENTIAL")" : R"("GLOBAL")", of);
    }
    if (probe.size() > 1) json += "," + probe.substr(1);
  }
  if (!edge.rotation_allowed) return;
  if (version_ < Version::k300) {
    Add(json, "rotationAllowed", *edge.rotation_allowed ? "true" : "false", of);
  } else if (is_omnidirectional && !*edge.rotation_allowed) {
    Add(json, "rotationAllowed", "true", of);
  }
}

void OrderWriter::AddTrajectory(std::string& json, const OrderEdge& edge) {
  if (!edge.trajectory) return;
  const OrderTrajectory& curve = *edge.trajectory;
  std::string knots;
  for (const double knot : curve.knots) knots += (knots.empty() ? "" : ",") + Number(knot);
  std::string points;
  for (const OrderControlPoint& point : curve.points) {
    points += fmt::format(R"({}{{"x":{},"y":{},"weight":{}}})", points.empty() ? "" : ",",
                          Number(point.x), Number(point.y), Number(point.weight));
  }
  const std::string of = "edge " + Printable(edge.id);
  Add(json, "trajectory",
      fmt::format(R"({{"degree":{},"knotVector":[{}],"controlPoints":[{}]}})", curve.degree, knots,
                  points),
      of);
  if (factsheet_ == nullptr) return;
  const FactsheetLimits& limits = factsheet_->limits;
  const auto check = [&](std::size_t count, std::size_t limit, std::string_view what) {
    if (limit == 0 || count <= limit) return;
    Refuse(fmt::format("{} has {} {}, and the robot takes {}", of, count, what, limit));
  };
  check(curve.knots.size(), limits.trajectory_knots, "knots");
  check(curve.points.size(), limits.trajectory_points, "control points");
}

std::string OrderWriter::WriteActions(std::span<const InstantAction> actions,
                                      std::string_view scope, std::string_view of) {
  std::string json;
  for (const InstantAction& action : actions) {
    CheckAction(action, scope, of);
    json += (json.empty() ? "" : ",") +
            WriteAction(action, NameIn(version_, action.type), GetFacts(version_));
  }
  const std::size_t limit = factsheet_ == nullptr ? 0
                            : scope == "NODE"     ? factsheet_->limits.node_actions
                                                  : factsheet_->limits.edge_actions;
  if (limit > 0 && actions.size() > limit) {
    Refuse(fmt::format("{} has {} actions, and the robot takes {}", of, actions.size(), limit));
  }
  return "[" + json + "]";
}

void OrderWriter::CheckAction(const InstantAction& action, std::string_view scope,
                              std::string_view of) {
  if (factsheet_ == nullptr || factsheet_->actions.empty()) return;
  const std::string_view type = NameIn(version_, action.type);
  const FactsheetAction* listed = FindAction(*factsheet_, type);
  const auto has = [](const std::vector<std::string>& list, std::string_view word) {
    return list.empty() || std::find(list.begin(), list.end(), word) != list.end();
  };
  if (listed == nullptr) {
    Refuse(fmt::format("the robot's factsheet lists no action {} ({})", Printable(type), of));
  } else if (!has(listed->scopes, scope)) {
    Refuse(fmt::format("the robot does {} as {}, not on {} ({})", Printable(type),
                       base::Join(listed->scopes, ", "), scope == "NODE" ? "a node" : "an edge",
                       of));
  } else if (!has(listed->blocking_types, base::NonEmptyOr(action.blocking_type, "NONE"))) {
    Refuse(fmt::format("the robot takes {} with blockingType {}, not {} ({})", Printable(type),
                       base::Join(listed->blocking_types, " or "), action.blocking_type, of));
  }
}

std::string CheckOrderLimits(const Factsheet& factsheet, std::size_t nodes, std::size_t edges,
                             std::size_t base) {
  const FactsheetLimits& limits = factsheet.limits;
  const auto exceeds = [](std::size_t count, std::size_t limit) {
    return limit > 0 && count > limit;
  };
  if (exceeds(nodes, limits.order_nodes)) {
    return fmt::format("an order of {} nodes is more than the robot takes: {}", nodes,
                       limits.order_nodes);
  }
  if (exceeds(edges, limits.order_edges)) {
    return fmt::format("an order of {} edges is more than the robot takes: {}", edges,
                       limits.order_edges);
  }
  if (exceeds(base, limits.base_nodes)) {
    return fmt::format(
        "{} released nodes are more than the robot keeps: --release {} releases fewer", base,
        limits.base_nodes);
  }
  return "";
}

base::JsonDocument MakeOrder(std::string_view order_id, std::uint32_t update_id,
                             std::string_view zone_set_id, std::span<const std::string> nodes,
                             std::span<const std::string> edges) {
  std::string json =
      fmt::format(R"({{"orderId":{},"orderUpdateId":{})", JsonString(order_id), update_id);
  if (!zone_set_id.empty()) json += fmt::format(R"(,"zoneSetId":{})", JsonString(zone_set_id));
  json +=
      fmt::format(R"(,"nodes":[{}],"edges":[{}]}})", fmt::join(nodes, ","), fmt::join(edges, ","));
  return std::move(*base::ParseJson(json));
}

std::string ToParameterValue(const Factsheet* factsheet, std::string_view action_type,
                             std::string_view key, std::string_view text) {
  const FactsheetAction* action =
      factsheet == nullptr ? nullptr : FindAction(*factsheet, action_type);
  if (action == nullptr) return JsonString(text);
  const auto parameter =
      std::find_if(action->parameters.begin(), action->parameters.end(),
                   [&](const FactsheetParameter& listed) { return listed.key == key; });
  const std::string type = parameter == action->parameters.end() ? "" : parameter->value_type;
  if (type.empty() || type == "STRING") return JsonString(text);
  const auto value = base::ParseJson(text);
  const bool fits = value && (type == "BOOL"     ? value->IsBool()
                              : type == "OBJECT" ? value->IsObject()
                              : type == "ARRAY"  ? value->IsArray()
                                                 : value->IsNumber());
  return fits ? base::ToJson(*value) : JsonString(text);
}

}  // namespace fleetpub::vda5050
