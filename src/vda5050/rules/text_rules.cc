#include "vda5050/rules/text_rules.h"

#include <fmt/format.h>

#include <set>

#include "base/json.h"
#include "base/text.h"
#include "vda5050/catalogue/catalogue.h"
#include "vda5050/rules/action_rules.h"

namespace fleetpub::vda5050 {
namespace {

using base::FindMember;
using base::StringMember;
using Value = base::JsonValue;

std::string WhyNotInstant(const ActionSpec* action, std::string_view type, Version version) {
  const std::string_view name = GetFacts(version).name;
  const std::string_view here = NameIn(version, type);
  if (here != type) {
    return fmt::format("{} is called {} in version {}", type, here, name);
  }
  const std::string versions = VersionsWithInstant(type);
  if (versions.empty()) {
    return fmt::format(
        "{} is never an instant action: it belongs to the nodes and edges of an order", type);
  }
  return fmt::format("{} is {} in version {}: it is one in {}", type,
                     action == nullptr ? "not a predefined action" : "not an instant action", name,
                     versions);
}

void CheckAction(const Value& action, const std::string& path, Version version,
                 Findings& findings) {
  const std::string_view type = StringMember(action, "actionType");
  if (type.empty()) AddError(findings, path + "/actionType", "actionType must not be empty");
  const ActionSpec* spec = FindAction(version, type);
  if (spec != nullptr && spec->scopes.instant) {
    return CheckActionParameters(*spec, FindMember(action, "actionParameters"), path, findings);
  }
  const auto predefined = ActionCalled(type);
  const bool exact = predefined && (*predefined == type || NameIn(version, *predefined) == type ||
                                    NameIn(Version::k110, *predefined) == type);
  if (exact) {
    AddError(findings, path + "/actionType", WhyNotInstant(spec, type, version));
  } else {
    CheckUnknownType(type, path, version, findings);
  }
}

}  // namespace

Findings CheckInstantActions(const Value& message, Version version) {
  const std::string_view array = GetFacts(version).actions_key;
  Findings findings;
  const Value* actions = FindMember(message, array);
  if (actions == nullptr || !actions->IsArray() || actions->Empty()) {
    AddError(findings, "/" + std::string(array), "there must be at least one action");
    return findings;
  }
  std::set<std::string_view> ids;
  for (rapidjson::SizeType i = 0; i < actions->Size(); ++i) {
    const std::string path = fmt::format("/{}/{}", array, i);
    CheckActionId(StringMember((*actions)[i], "actionId"), path, ids, findings);
    CheckAction((*actions)[i], path, version, findings);
  }
  return findings;
}

message::TextRules TextRulesFor(std::string_view topic, Version version) {
  if (topic == "instantActions") {
    return [version](const Value& message) { return CheckInstantActions(message, version); };
  }
  if (topic == "order") {
    return [version](const Value& message) { return CheckOrder(message, version); };
  }
  if (topic == "zoneSet") return CheckZoneSet;
  if (topic == "responses") {
    return
        [](const Value& message) { return CheckResponses(message, base::WallTime::clock::now()); };
  }
  return {};
}

}  // namespace fleetpub::vda5050
