// What the specification's text asks of an order (VDA 5050 1.1–2.1 §6.6, 3.0 §6.1).
#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <optional>
#include <set>

#include "base/json.h"
#include "base/text.h"
#include "vda5050/rules/action_rules.h"
#include "vda5050/rules/text_rules.h"

namespace fleetpub::vda5050 {
namespace {

using base::FindArray;
using base::FindMember;
using base::Printable;
using base::StringMember;
using Value = base::JsonValue;

std::optional<std::uint64_t> ReadSequenceId(const Value& leg) {
  const Value* id = FindMember(leg, "sequenceId");
  if (id == nullptr || !id->IsUint64()) return std::nullopt;
  return id->GetUint64();
}

// One node or edge, in the order in which the robot comes to it.
struct Leg {
  const Value& value;
  std::string path;
  bool is_node;

  [[nodiscard]] bool IsReleased() const { return base::IsTrueMember(value, "released"); }
};

std::vector<Leg> ReadLegs(const Value& nodes, const Value& edges) {
  std::vector<Leg> legs;
  for (rapidjson::SizeType i = 0; i < nodes.Size(); ++i) {
    if (i > 0) legs.push_back({edges[i - 1], fmt::format("/edges/{}", i - 1), false});
    legs.push_back({nodes[i], fmt::format("/nodes/{}", i), true});
  }
  return legs;
}

void CheckSequence(const std::vector<Leg>& legs, Findings& findings) {
  for (std::size_t i = 1; i < legs.size(); ++i) {
    const auto before = ReadSequenceId(legs[i - 1].value);
    const auto here = ReadSequenceId(legs[i].value);
    if (!before || !here || *here == *before + 1) continue;
    return AddError(findings, legs[i].path + "/sequenceId",
                    fmt::format("sequenceId must be {}, one more than that of {}: nodes and edges "
                                "share one sequence",
                                *before + 1, legs[i - 1].path));
  }
}

// The base, then the horizon; the base begins and ends with a node.
void CheckReleases(const std::vector<Leg>& legs, Findings& findings) {
  if (!legs.front().IsReleased()) {
    return AddError(findings, legs.front().path + "/released",
                    "the first node must be released: the base begins with it");
  }
  for (std::size_t i = 1; i < legs.size(); ++i) {
    const bool is_released = legs[i].IsReleased();
    if (is_released && !legs[i - 1].IsReleased()) {
      return AddError(findings, legs[i].path + "/released",
                      fmt::format("released behind {}, which is not: the base lies before the "
                                  "horizon",
                                  legs[i - 1].path));
    }
    if (!is_released && legs[i].is_node && legs[i - 1].IsReleased()) {
      return AddError(findings, legs[i].path + "/released",
                      fmt::format("{} is released but not the node it leads to: the base ends with "
                                  "a node",
                                  legs[i - 1].path));
    }
  }
}

// 3.0 has removed them; who sends them all the same means the same.
void CheckEnds(const std::vector<Leg>& legs, Version version, Findings& findings) {
  for (std::size_t i = 1; i + 1 < legs.size(); i += 2) {
    const std::array<std::pair<std::string_view, const Leg*>, 2> ends = {
        {{"startNodeId", &legs[i - 1]}, {"endNodeId", &legs[i + 1]}}};
    for (const auto& [key, node] : ends) {
      if (version >= Version::k300 && FindMember(legs[i].value, key) == nullptr) continue;
      const std::string_view id = StringMember(legs[i].value, key);
      const std::string_view expected = StringMember(node->value, "nodeId");
      if (id == expected) continue;
      AddError(findings, fmt::format("{}/{}", legs[i].path, key),
               fmt::format("{} is '{}', but {} is node '{}'", key, Printable(id), node->path,
                           Printable(expected)));
    }
  }
}

void CheckAction(const Value& action, const Leg& leg, const std::string& path, Version version,
                 Findings& findings) {
  const std::string_view type = StringMember(action, "actionType");
  const ActionSpec* spec = FindAction(version, type);
  if (spec == nullptr) return CheckUnknownType(type, path, version, findings);
  const bool allowed = leg.is_node ? spec->scopes.node : spec->scopes.edge;
  if (!allowed) {
    return AddError(findings, path + "/actionType",
                    fmt::format("{} is not an action for {} in version {}", type,
                                leg.is_node ? "a node" : "an edge", GetFacts(version).name));
  }
  CheckActionParameters(*spec, FindMember(action, "actionParameters"), path, findings);
}

void CheckActions(const Leg& leg, Version version, std::set<std::string_view>& ids,
                  Findings& findings) {
  const Value* actions = FindArray(leg.value, "actions");
  if (actions == nullptr) return;
  for (rapidjson::SizeType i = 0; i < actions->Size(); ++i) {
    const std::string path = fmt::format("{}/actions/{}", leg.path, i);
    CheckActionId(StringMember((*actions)[i], "actionId"), path, ids, findings);
    CheckAction((*actions)[i], leg, path, version, findings);
  }
}

}  // namespace

Findings CheckOrder(const Value& message, Version version) {
  Findings findings;
  const std::string_view order_id = StringMember(message, "orderId");
  if (order_id.empty()) AddError(findings, "/orderId", "orderId must not be empty");
  CheckIdCharacters(order_id, "", "orderId", findings);
  const Value* nodes = FindArray(message, "nodes");
  const Value* edges = FindArray(message, "edges");
  if (nodes == nullptr || edges == nullptr || nodes->Empty()) {
    AddError(findings, "/nodes", "an order has at least one node: where the robot is");
    return findings;
  }
  if (edges->Size() + 1 != nodes->Size()) {
    AddError(findings, "/edges",
             fmt::format("{} node{} are joined by {} edge{}, not by {}", nodes->Size(),
                         nodes->Size() == 1 ? "" : "s", nodes->Size() - 1,
                         nodes->Size() == 2 ? "" : "s", edges->Size()));
    return findings;
  }
  const std::vector<Leg> legs = ReadLegs(*nodes, *edges);
  CheckSequence(legs, findings);
  CheckReleases(legs, findings);
  CheckEnds(legs, version, findings);
  std::set<std::string_view> ids;
  for (const Leg& leg : legs) {
    const std::string_view name = leg.is_node ? "nodeId" : "edgeId";
    CheckIdCharacters(StringMember(leg.value, name), leg.path, name, findings);
    CheckActions(leg, version, ids, findings);
  }
  return findings;
}

}  // namespace fleetpub::vda5050
