// What the text of 3.0 asks of zone sets and of responses (§6.4).
#include <fmt/format.h>

#include <set>
#include <utility>

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

constexpr std::size_t kCornersOfAPolygon = 3;

std::size_t DifferentVertices(const Value& zone) {
  std::set<std::pair<double, double>> corners;
  const Value* vertices = FindArray(zone, "vertices");
  if (vertices == nullptr) return 0;
  for (const Value& vertex : vertices->GetArray()) {
    const Value* x = FindMember(vertex, "x");
    const Value* y = FindMember(vertex, "y");
    if (x != nullptr && y != nullptr && x->IsNumber() && y->IsNumber()) {
      corners.emplace(x->GetDouble(), y->GetDouble());
    }
  }
  return corners.size();
}

void CheckZoneActions(const Value& zone, const std::string& path, std::set<std::string_view>& ids,
                      Findings& findings) {
  for (const std::string_view list : {"entryActions", "duringActions", "exitActions"}) {
    const Value* actions = FindArray(zone, list);
    if (actions == nullptr) continue;
    for (rapidjson::SizeType i = 0; i < actions->Size(); ++i) {
      const Value& action = (*actions)[i];
      if (FindMember(action, "actionId") == nullptr) continue;  // the robot makes one at each visit
      CheckActionId(StringMember(action, "actionId"), fmt::format("{}/{}/{}", path, list, i), ids,
                    findings);
    }
  }
}

void CheckLease(const Value& response, const std::string& path, base::WallTime now,
                Findings& findings) {
  const Value* lease = FindMember(response, "leaseExpiry");
  if (lease == nullptr) return;
  const std::string place = path + "/leaseExpiry";
  const std::string_view grant = StringMember(response, "grantType");
  if (grant != "GRANTED") {
    return AddError(
        findings, place,
        fmt::format("leaseExpiry belongs to GRANTED only, not to {}", Printable(grant)));
  }
  const auto expiry = base::ParseDateTime(StringMember(response, "leaseExpiry"));
  if (!expiry) {
    AddError(findings, place, "leaseExpiry must be a time such as 2026-11-22T20:15:00.000Z");
  } else if (*expiry <= now) {
    AddError(findings, place, "leaseExpiry has passed already");
  } else if (!StringMember(response, "leaseExpiry").ends_with('Z')) {
    AddWarning(findings, place, "leaseExpiry is not in UTC: its end must be Z");
  }
}

}  // namespace

Findings CheckZoneSet(const Value& message) {
  Findings findings;
  const Value* set = FindMember(message, "zoneSet");
  const Value* zones = set == nullptr ? nullptr : FindArray(*set, "zones");
  if (zones == nullptr) return findings;
  const std::string_view set_id = StringMember(*set, "zoneSetId");
  if (set_id.empty()) AddError(findings, "/zoneSet/zoneSetId", "zoneSetId must not be empty");
  CheckIdCharacters(set_id, "/zoneSet", "zoneSetId", findings);
  std::set<std::string_view> zone_ids;
  std::set<std::string_view> action_ids;
  for (rapidjson::SizeType i = 0; i < zones->Size(); ++i) {
    const Value& zone = (*zones)[i];
    const std::string path = fmt::format("/zoneSet/zones/{}", i);
    const std::string_view id = StringMember(zone, "zoneId");
    if (!zone_ids.insert(id).second) {
      AddError(findings, path + "/zoneId",
               fmt::format("zoneId '{}' is used by two zones: ids must be unique", Printable(id)));
    }
    CheckIdCharacters(id, path, "zoneId", findings);
    if (DifferentVertices(zone) < kCornersOfAPolygon) {
      AddError(findings, path + "/vertices", "a zone is a polygon of at least three vertices");
    }
    CheckZoneActions(zone, path, action_ids, findings);
  }
  return findings;
}

Findings CheckResponses(const Value& message, base::WallTime now) {
  Findings findings;
  const Value* responses = FindArray(message, "responses");
  if (responses == nullptr || responses->Empty()) {
    AddError(findings, "/responses", "there must be at least one response");
    return findings;
  }
  std::set<std::string_view> requests;
  for (rapidjson::SizeType i = 0; i < responses->Size(); ++i) {
    const Value& response = (*responses)[i];
    const std::string path = fmt::format("/responses/{}", i);
    const std::string_view id = StringMember(response, "requestId");
    if (id.empty()) {
      AddError(findings, path + "/requestId", "requestId must not be empty");
    } else if (!requests.insert(id).second) {
      AddError(findings, path + "/requestId",
               fmt::format("request '{}' is answered twice", Printable(id)));
    }
    CheckLease(response, path, now, findings);
  }
  return findings;
}

}  // namespace fleetpub::vda5050
