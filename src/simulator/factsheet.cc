#include "simulator/factsheet.h"

#include <fmt/format.h>

#include <algorithm>

#include "simulator/action_handlers.h"
#include "simulator/order_plan.h"
#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::simulator {
namespace {

using vda5050::ActionSpec;
using vda5050::ParameterSpec;
using vda5050::ParameterType;
using vda5050::Version;

// Everything but lists and times. `{}`: the most nodes of an order, the times, the optional
// members, the actions.
constexpr std::string_view kFactsheetUpTo21 =
    R"("typeSpecification":{{"seriesName":"fleetpub virtual robot","agvKinematic":"DIFF",)"
    R"("agvClass":"CARRIER","maxLoadMass":100,"localizationTypes":["NATURAL"],)"
    R"("navigationTypes":["VIRTUAL_LINE_GUIDED"]}},)"
    R"("physicalParameters":{{"speedMin":0.05,"speedMax":{},"accelerationMax":1,)"
    R"("decelerationMax":1,"heightMin":0.3,"heightMax":0.3,"width":0.6,"length":0.9}},)"
    R"("protocolLimits":{{"maxStringLens":{{}},"maxArrayLens":{{{}}},"timing":{{)"
    R"("minOrderInterval":0,"minStateInterval":{},"defaultStateInterval":{}{}}}}},)"
    R"("protocolFeatures":{{"optionalParameters":[{}],"agvActions":[{}]}},)"
    R"("agvGeometry":{{}},"loadSpecification":{{}})";

constexpr std::string_view kFactsheetFrom30 =
    R"("typeSpecification":{{"seriesName":"fleetpub virtual robot",)"
    R"("mobileRobotKinematics":"DIFFERENTIAL","mobileRobotClass":"CARRIER","maximumLoadMass":100,)"
    R"("localizationTypes":["NATURAL"],"navigationTypes":["VIRTUAL_LINE_GUIDED"]}},)"
    R"("physicalParameters":{{"minimumSpeed":0.05,"maximumSpeed":{},"maximumAcceleration":1,)"
    R"("maximumDeceleration":1,"minimumHeight":0.3,"maximumHeight":0.3,"width":0.6,)"
    R"("length":0.9}},)"
    R"("protocolLimits":{{"maximumStringLengths":{{}},"maximumArrayLengths":{{{}}},"timing":{{)"
    R"("minimumOrderInterval":0,"minimumStateInterval":{},"defaultStateInterval":{}{}}}}},)"
    R"("protocolFeatures":{{"optionalParameters":[{}],"mobileRobotActions":[{}]}},)"
    R"("mobileRobotGeometry":{{}},"loadSpecification":{{}})";

constexpr double kFastest = 2;  // m/s, unless it is told to be faster

void Append(std::string& list, std::string_view item) {
  if (!list.empty()) list += ',';
  list += item;
}

std::string_view GetDataType(ParameterType type) {
  switch (type) {
    case ParameterType::kString:
      return "STRING";
    case ParameterType::kLength:
    case ParameterType::kAngle:
      return "NUMBER";
    case ParameterType::kStringArray:
      return "ARRAY";
  }
  return "STRING";
}

// No zone has an action for it.
std::string ScopesJson(const vda5050::Scopes& scopes) {
  std::string list;
  if (scopes.instant) Append(list, R"("INSTANT")");
  if (scopes.node) Append(list, R"("NODE")");
  if (scopes.edge) Append(list, R"("EDGE")");
  return list;
}

std::string ActionJson(const ActionSpec& action, Version version) {
  std::string parameters;
  for (const ParameterSpec& spec : action.parameters) {
    Append(parameters, fmt::format(R"({{"key":"{}","valueDataType":"{}","isOptional":{}}})",
                                   spec.name, GetDataType(spec.type), !spec.required));
  }
  std::string json =
      fmt::format(R"({{"actionType":"{}","actionScopes":[{}],"actionParameters":[{}])", action.type,
                  ScopesJson(action.scopes), parameters);
  // Not in 2.0; in 2.1 the published schema lets no array pass.
  if (version >= Version::k300) {
    const bool in_order = action.scopes.node || action.scopes.edge;
    const bool may_stop = in_order && IsInterruptible(action.type);
    json += fmt::format(R"(,"blockingTypes":["NONE"{}],"pauseAllowed":{},"cancelAllowed":{})",
                        in_order ? R"(,"SOFT","SINGLE","HARD")" : "", may_stop, may_stop);
  }
  return json + "}";
}

std::string MembersJson(Version version) {
  std::string list;
  for (const OptionalMember& member : ListOptionalMembers(version)) {
    if (!member.is_supported) continue;
    Append(list, fmt::format(R"({{"parameter":"{}","support":"SUPPORTED"}})", member.path));
  }
  return list;
}

double ToSeconds(std::chrono::milliseconds time) {
  return std::chrono::duration<double>(time).count();
}

}  // namespace

std::string FactsheetBody(const Settings& settings) {
  const Version version = settings.version;
  if (version < Version::k200) return {};
  std::string actions;
  if (!settings.Has(Fault::kFactsheetWithoutActions)) {
    for (const ActionSpec* action : vda5050::ListActions(version)) {
      Append(actions, ActionJson(*action, version));
    }
  }
  const std::string limit =
      settings.order_limit > 0 ? fmt::format(R"("order.nodes":{})", settings.order_limit) : "";
  const std::string visualization = settings.visualization_interval.count() > 0
                                        ? fmt::format(R"(,"visualizationInterval":{})",
                                                      ToSeconds(settings.visualization_interval))
                                        : "";
  const double shortest = ToSeconds(settings.min_state_interval);
  const double usual = ToSeconds(settings.state_interval);
  const double speed = std::max(kFastest, settings.speed);
  const std::string members = MembersJson(version);
  return version >= Version::k300 ? fmt::format(kFactsheetFrom30, speed, limit, shortest, usual,
                                                visualization, members, actions)
                                  : fmt::format(kFactsheetUpTo21, speed, limit, shortest, usual,
                                                visualization, members, actions);
}

}  // namespace fleetpub::simulator
