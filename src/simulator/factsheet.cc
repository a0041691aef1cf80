#include "simulator/factsheet.h"

#include <fmt/format.h>

#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::simulator {
namespace {

using vda5050::ActionSpec;
using vda5050::ParameterSpec;
using vda5050::ParameterType;
using vda5050::Version;

// Everything but the actions and the interval. `{}`: first the interval in seconds, then the
// actions.
constexpr std::string_view kUpTo21 =
    R"("typeSpecification":{{"seriesName":"fleetpub virtual robot","agvKinematic":"DIFF",)"
    R"("agvClass":"CARRIER","maxLoadMass":100,"localizationTypes":["NATURAL"],)"
    R"("navigationTypes":["AUTONOMOUS"]}},)"
    R"("physicalParameters":{{"speedMin":0.05,"speedMax":2,"accelerationMax":1,)"
    R"("decelerationMax":1,"heightMin":0.3,"heightMax":0.3,"width":0.6,"length":0.9}},)"
    R"("protocolLimits":{{"maxStringLens":{{}},"maxArrayLens":{{}},"timing":{{)"
    R"("minOrderInterval":0,"minStateInterval":0,"defaultStateInterval":{}}}}},)"
    R"("protocolFeatures":{{"optionalParameters":[],"agvActions":[{}]}},)"
    R"("agvGeometry":{{}},"loadSpecification":{{}})";

constexpr std::string_view kFrom30 =
    R"("typeSpecification":{{"seriesName":"fleetpub virtual robot",)"
    R"("mobileRobotKinematics":"DIFFERENTIAL","mobileRobotClass":"CARRIER","maximumLoadMass":100,)"
    R"("localizationTypes":["NATURAL"],"navigationTypes":["AUTONOMOUS"]}},)"
    R"("physicalParameters":{{"minimumSpeed":0.05,"maximumSpeed":2,"maximumAcceleration":1,)"
    R"("maximumDeceleration":1,"minimumHeight":0.3,"maximumHeight":0.3,"width":0.6,)"
    R"("length":0.9}},)"
    R"("protocolLimits":{{"maximumStringLengths":{{}},"maximumArrayLengths":{{}},"timing":{{)"
    R"("minimumOrderInterval":0,"minimumStateInterval":0,"defaultStateInterval":{}}}}},)"
    R"("protocolFeatures":{{"optionalParameters":[],"mobileRobotActions":[{}]}},)"
    R"("mobileRobotGeometry":{{}},"loadSpecification":{{}})";

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

std::string ScopesJson(const vda5050::Scopes& scopes) {
  std::string list;
  if (scopes.instant) Append(list, R"("INSTANT")");
  if (scopes.node) Append(list, R"("NODE")");
  if (scopes.edge) Append(list, R"("EDGE")");
  if (scopes.zone) Append(list, R"("ZONE")");
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
    json += R"(,"blockingTypes":["NONE"],"pauseAllowed":false,"cancelAllowed":false)";
  }
  return json + "}";
}

}  // namespace

std::string FactsheetBody(Version version, std::chrono::milliseconds state_interval) {
  if (version < Version::k200) return {};
  std::string actions;
  for (const ActionSpec* action : vda5050::ListActions(version)) {
    if (action->scopes.instant) Append(actions, ActionJson(*action, version));
  }
  const double seconds = std::chrono::duration<double>(state_interval).count();
  return version >= Version::k300 ? fmt::format(kFrom30, seconds, actions)
                                  : fmt::format(kUpTo21, seconds, actions);
}

}  // namespace fleetpub::simulator
