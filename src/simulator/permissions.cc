#include "simulator/permissions.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/json.h"
#include "base/text.h"

namespace fleetpub::simulator {
namespace {

using base::FindArray;
using base::FindMember;
using base::StringMember;
using Value = base::JsonValue;

std::vector<Point> ReadCorners(const Value& zone) {
  std::vector<Point> corners;
  if (const Value* vertices = FindArray(zone, "vertices")) {
    for (const Value& vertex : vertices->GetArray()) {
      corners.push_back({base::NumberMember(vertex, "x").value_or(0),
                         base::NumberMember(vertex, "y").value_or(0)});
    }
  }
  return corners;
}

// A ray from the point crosses the outline an odd number of times.
bool IsInside(const Point& point, const std::vector<Point>& corners) {
  bool inside = false;
  for (std::size_t i = 0, j = corners.size() - 1; i < corners.size(); j = i++) {
    const Point& a = corners[i];
    const Point& b = corners[j];
    const bool crosses = (a.y > point.y) != (b.y > point.y);
    if (crosses && point.x < (b.x - a.x) * (point.y - a.y) / (b.y - a.y) + a.x) inside = !inside;
  }
  return inside;
}

bool LeadsInto(const Value& order, const ReleaseZone& zone, std::string_view map_id) {
  const Value* nodes = FindArray(order, "nodes");
  if (nodes == nullptr) return false;
  return std::any_of(nodes->Begin(), nodes->End(), [&](const Value& node) {
    const Value* position = FindMember(node, "nodePosition");
    return position != nullptr && StringMember(*position, "mapId") == map_id &&
           IsInside({base::NumberMember(*position, "x").value_or(0),
                     base::NumberMember(*position, "y").value_or(0)},
                    zone.corners);
  });
}

bool NeedsRelease(const Value& edge) {
  const Value* corridor = FindMember(edge, "corridor");
  const Value* required = corridor == nullptr ? nullptr : FindMember(*corridor, "releaseRequired");
  return required != nullptr && required->IsBool() && required->GetBool();
}

void Ask(Request request, RobotState& state) {
  const bool is_asked =
      std::any_of(state.requests.begin(), state.requests.end(), [&](const Request& known) {
        return known.zone_id == request.zone_id && known.zone_set_id == request.zone_set_id &&
               known.edge_id == request.edge_id && known.sequence_id == request.sequence_id;
      });
  if (is_asked) return;
  request.id = fmt::format("request-{}", ++state.requests_made);
  state.requests.push_back(std::move(request));
}

void Apply(const Value& response, Request& request) {
  const std::string_view grant = StringMember(response, "grantType");
  if (grant == "GRANTED") {
    request.status = "GRANTED";
    request.lease_expiry = base::ParseDateTime(StringMember(response, "leaseExpiry"));
  } else if (grant == "REVOKED") {
    request.status = "REVOKED";
  }
  // QUEUED: it waits as before.
}

}  // namespace

std::string AcceptZoneSet(const Value& message, RobotState& state) {
  const Value* set = FindMember(message, "zoneSet");
  if (set == nullptr) return "zoneSet is missing";
  ZoneSet taken{std::string(StringMember(*set, "zoneSetId")),
                std::string(StringMember(*set, "mapId")),
                false,
                {}};
  for (const ZoneSet& known : state.zone_sets) {
    if (known.id == taken.id) return fmt::format("zone set {} is there already", taken.id);
  }
  if (const Value* zones = FindArray(*set, "zones")) {
    for (const Value& zone : zones->GetArray()) {
      if (StringMember(zone, "zoneType") != "RELEASE") continue;
      taken.release_zones.push_back({std::string(StringMember(zone, "zoneId")), ReadCorners(zone)});
    }
  }
  state.zone_sets.push_back(std::move(taken));
  return {};
}

void AskForPermissions(const Value& order, RobotState& state) {
  for (const ZoneSet& set : state.zone_sets) {
    if (!set.enabled) continue;
    for (const ReleaseZone& zone : set.release_zones) {
      if (LeadsInto(order, zone, set.map_id)) {
        Ask({.type = "ACCESS", .zone_id = zone.id, .zone_set_id = set.id}, state);
      }
    }
  }
  const Value* edges = FindArray(order, "edges");
  if (edges == nullptr) return;
  for (const Value& edge : edges->GetArray()) {
    if (!NeedsRelease(edge)) continue;
    Ask({.type = "CORRIDOR",
         .edge_id = std::string(StringMember(edge, "edgeId")),
         .sequence_id =
             static_cast<std::uint32_t>(base::NumberMember(edge, "sequenceId").value_or(0))},
        state);
  }
}

std::vector<std::string> TakeResponses(const Value& message, RobotState& state) {
  std::vector<std::string> unknown;
  const Value* responses = FindArray(message, "responses");
  if (responses == nullptr) return unknown;
  for (const Value& response : responses->GetArray()) {
    const std::string_view id = StringMember(response, "requestId");
    const auto request = std::find_if(state.requests.begin(), state.requests.end(),
                                      [&](const Request& r) { return r.id == id; });
    if (request == state.requests.end()) {
      unknown.emplace_back(id);
    } else {
      Apply(response, *request);
    }
  }
  return unknown;
}

std::optional<base::WallTime> NextExpiry(const RobotState& state) {
  std::optional<base::WallTime> next;
  for (const Request& request : state.requests) {
    if (request.status != "GRANTED" || !request.lease_expiry) continue;
    next = std::min(next.value_or(*request.lease_expiry), *request.lease_expiry);
  }
  return next;
}

bool ExpireLeases(RobotState& state, base::WallTime now) {
  bool any = false;
  for (Request& request : state.requests) {
    if (request.status != "GRANTED" || !request.lease_expiry || now < *request.lease_expiry) {
      continue;
    }
    request.status = "EXPIRED";
    any = true;
  }
  return any;
}

}  // namespace fleetpub::simulator
