// The table itself. Comments on it: the specification's own table of predefined actions, per
// version.
#include <array>

#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::vda5050 {
namespace {

using enum ParameterType;
using enum Version;

constexpr bool kRequired = true;
constexpr bool kOptional = false;
constexpr bool kIdempotent = true;
constexpr bool kNotIdempotent = false;

constexpr Scopes kInstant{.instant = true};
constexpr Scopes kInstantOrNode{.instant = true, .node = true};
constexpr Scopes kNode{.node = true};
constexpr Scopes kNodeOrEdge{.node = true, .edge = true};
constexpr Scopes kNodeOrZone{.node = true, .zone = true};
constexpr Scopes kNodeEdgeOrZone{.node = true, .edge = true, .zone = true};

constexpr std::array<ParameterSpec, 5> kPosition = {{
    {"x", kLength, kRequired, "metres in the map's coordinate system", "1.5"},
    {"y", kLength, kRequired, "metres in the map's coordinate system", "-2"},
    {"theta", kAngle, kRequired, "orientation in radians, -π to π, or as 90deg", "1.57"},
    {"mapId", kString, kRequired, "the map that the coordinates belong to", "hall-1"},
    {"lastNodeId", kString, kRequired, "the node that the robot stands on or passed last", "n1"},
}};
constexpr std::array<ParameterSpec, 1> kReason = {{
    {"reason", kString, kRequired, "why the log is wanted", "slow"},
}};
constexpr std::array<ParameterSpec, 2> kMap = {{
    {"mapId", kString, kRequired, "the map", "hall-1"},
    {"mapVersion", kString, kRequired, "its version", "3"},
}};
constexpr std::array<ParameterSpec, 4> kMapDownload = {{
    {"mapId", kString, kRequired, "the map", "hall-1"},
    {"mapVersion", kString, kRequired, "its version", "3"},
    {"mapDownloadLink", kString, kRequired, "where the robot fetches it",
     "https://maps.example/hall-1"},
    {"mapHash", kString, kOptional, "its checksum"},
}};
constexpr std::array<ParameterSpec, 1> kZoneSet = {{
    {"zoneSetId", kString, kRequired, "the zone set", "zones-1"},
}};
constexpr std::array<ParameterSpec, 3> kZoneSetDownload = {{
    {"zoneSetId", kString, kRequired, "the zone set", "zones-1"},
    {"zoneSetDownloadLink", kString, kRequired, "where the robot fetches it",
     "https://maps.example/zones-1"},
    {"zoneSetHash", kString, kOptional, "its checksum"},
}};
constexpr std::array<ParameterSpec, 1> kWakeUp = {{
    {"wakeUpTime", kString, kOptional, "when the robot wakes by itself"},
}};
constexpr std::array<ParameterSpec, 1> kTargetAction = {{
    {"actionId", kString, kRequired, "the action in state RETRIABLE", "a7"},
}};
constexpr std::array<ParameterSpec, 1> kOrder = {{
    {"orderId", kString, kOptional, "cancel only this order"},
}};
constexpr std::array<ParameterSpec, 4> kCertificate = {{
    {"service", kString, kRequired, "what it is for: MQTT", "MQTT"},
    {"keyDownloadLink", kString, kRequired, "where the robot fetches its key",
     "https://pki.example/agv1.key"},
    {"certificateDownloadLink", kString, kRequired, "where the robot fetches its certificate",
     "https://pki.example/agv1.pem"},
    {"certificateAuthorityDownloadLink", kString, kOptional, "where it fetches the authority's"},
}};
constexpr std::array<ParameterSpec, 8> kLoadUpTo21 = {{
    {"lhd", kString, kOptional, "the load handling device"},
    {"stationType", kString, kRequired, "kind of station"},
    {"stationName", kString, kOptional, "name of the station"},
    {"loadType", kString, kRequired, "kind of load"},
    {"loadId", kString, kOptional, "the load"},
    {"height", kLength, kOptional, "of the load's bottom above the floor, metres"},
    {"depth", kLength, kOptional, "of the forks, metres"},
    {"side", kString, kOptional, "of the robot"},
}};
constexpr std::array<ParameterSpec, 7> kDropUpTo21 = {{
    {"lhd", kString, kOptional, "the load handling device"},
    {"stationType", kString, kOptional, "kind of station"},
    {"stationName", kString, kOptional, "name of the station"},
    {"loadType", kString, kOptional, "kind of load"},
    {"loadId", kString, kOptional, "the load"},
    {"height", kLength, kOptional, "of the load's bottom above the floor, metres"},
    {"depth", kLength, kOptional, "of the forks, metres"},
}};
constexpr std::array<ParameterSpec, 8> kPickFrom30 = {{
    {"lhd", kString, kOptional, "the load handling device"},
    {"stationType", kString, kOptional, "kind of station"},
    {"stationName", kString, kOptional, "name of the station"},
    {"loadType", kString, kOptional, "kind of load"},
    {"loadId", kString, kOptional, "the load"},
    {"height", kLength, kOptional, "of the load's bottom above the floor, metres"},
    {"depth", kLength, kOptional, "of the forks, metres"},
    {"side", kString, kOptional, "of the robot"},
}};
constexpr std::array<ParameterSpec, 1> kObject = {{
    {"objectType", kString, kOptional, "kind of object"},
}};
constexpr std::array<ParameterSpec, 2> kStation = {{
    {"stationType", kString, kOptional, "kind of station"},
    {"stationName", kString, kOptional, "name of the station"},
}};
constexpr std::array<ParameterSpec, 1> kTrigger = {{
    {"triggerType", kString, kRequired, "what it waits for"},
}};
constexpr std::array<ParameterSpec, 1> kTriggers = {{
    {"triggerType", kStringArray, kRequired, "what it waits for: FLEET_CONTROL, LOCAL"},
}};
constexpr std::span<const ParameterSpec> kNone{};

// In the order of the 3.0 table. A row that 3.0 changed stands twice, the older one first.
constexpr auto kActions = std::to_array<ActionSpec>({
    {"startPause", kAllVersions, kInstant, kNone, "stopPause", "paused", kIdempotent,
     "stop and hold"},
    {"stopPause", kAllVersions, kInstant, kNone, "startPause", "paused", kIdempotent,
     "go on after a pause"},
    {"startHibernation", kFrom30, kInstant, kWakeUp, "stopHibernation", "", kIdempotent,
     "save power: connected, but silent"},
    {"stopHibernation", kFrom30, kInstant, kNone, "startHibernation", "", kIdempotent, "wake up"},
    {"shutdown", kFrom30, kInstant, kNone, "", "", kIdempotent,
     "shut down; the robot must be idle"},
    {"startCharging", kUpTo21, kInstantOrNode, kNone, "stopCharging", "batteryState.charging",
     kIdempotent, "charge the battery"},
    {"startCharging", kFrom30, kInstantOrNode, kNone, "stopCharging", "powerSupply.charging",
     kIdempotent, "charge the battery"},
    {"stopCharging", kUpTo21, kInstantOrNode, kNone, "startCharging", "batteryState.charging",
     kIdempotent, "end charging"},
    {"stopCharging", kFrom30, kInstantOrNode, kNone, "startCharging", "powerSupply.charging",
     kIdempotent, "end charging"},
    {"initPosition",
     {k110, k200},
     kInstantOrNode,
     kPosition,
     "",
     "agvPosition.x, agvPosition.y, agvPosition.theta, agvPosition.mapId, lastNodeId",
     kIdempotent,
     "tell the robot where it is"},
    {"initPosition",
     {k210, k210},
     kInstantOrNode,
     kPosition,
     "",
     "agvPosition.x, agvPosition.y, agvPosition.theta, agvPosition.mapId, lastNodeId, maps",
     kIdempotent,
     "tell the robot where it is"},
    {"initializePosition", kFrom30, kInstantOrNode, kPosition, "",
     "mobileRobotPosition.x, mobileRobotPosition.y, mobileRobotPosition.theta, "
     "mobileRobotPosition.mapId, lastNodeId, maps",
     kIdempotent, "tell the robot where it is"},
    {"enableMap", kFrom21, kInstantOrNode, kMap, "", "maps", kIdempotent, "use a downloaded map"},
    {"downloadMap", kFrom21, kInstant, kMapDownload, "", "maps", kIdempotent, "fetch a map"},
    {"deleteMap", kFrom21, kInstant, kMap, "", "maps", kIdempotent, "remove a map"},
    {"downloadZoneSet", kFrom30, kInstant, kZoneSetDownload, "", "zoneSets", kIdempotent,
     "fetch a zone set"},
    {"enableZoneSet", kFrom30, kInstantOrNode, kZoneSet, "", "zoneSets", kIdempotent,
     "use a downloaded zone set"},
    {"deleteZoneSet", kFrom30, kInstant, kZoneSet, "", "zoneSets", kIdempotent,
     "remove a zone set"},
    {"clearInstantActions", kFrom30, kInstantOrNode, kNone, "", "instantActionStates", kIdempotent,
     "forget ended instant actions"},
    {"clearZoneActions", kFrom30, kInstantOrNode, kNone, "", "zoneActionStates", kIdempotent,
     "forget ended zone actions"},
    {"stateRequest", kAllVersions, kInstant, kNone, "", "", kIdempotent, "report the state now"},
    {"logReport", kAllVersions, kInstant, kReason, "", "", kIdempotent, "write a log and name it"},
    {"pick", kUpTo21, kNodeOrEdge, kLoadUpTo21, "drop", "load", kNotIdempotent, "take a load"},
    {"pick", kFrom30, kNodeOrEdge, kPickFrom30, "drop", "load", kNotIdempotent, "take a load"},
    {"drop", kAllVersions, kNodeOrEdge, kDropUpTo21, "pick", "load", kNotIdempotent,
     "put a load down"},
    {"detectObject", kUpTo21, kNodeOrEdge, kObject, "", "", kIdempotent, "look for an object"},
    {"detectObject", kFrom30, kNodeEdgeOrZone, kObject, "", "", kIdempotent, "look for an object"},
    {"finePositioning", kUpTo21, kNodeOrEdge, kStation, "", "", kIdempotent, "position exactly"},
    {"finePositioning", kFrom30, kNodeEdgeOrZone, kStation, "", "", kIdempotent,
     "position exactly"},
    {"waitForTrigger", kUpTo21, kNode, kTrigger, "", "", kIdempotent, "wait for a trigger"},
    {"waitForTrigger", kFrom30, kNodeOrZone, kTriggers, "", "", kIdempotent, "wait for a trigger"},
    {"trigger", kFrom30, kInstant, kNone, "", "", kIdempotent, "release what waits for a trigger"},
    {"retry", kFrom30, kInstant, kTargetAction, "", "", kIdempotent, "try a failed action again"},
    {"skipRetry", kFrom30, kInstant, kTargetAction, "", "", kIdempotent,
     "let a failed action fail for good"},
    {"cancelOrder", kUpTo21, kInstant, kNone, "", "", kIdempotent, "give up the order"},
    {"cancelOrder", kFrom30, kInstant, kOrder, "", "", kIdempotent, "give up the order"},
    {"factsheetRequest", kFrom20, kInstant, kNone, "", "", kIdempotent, "send the factsheet"},
    {"updateCertificate", kFrom30, kInstant, kCertificate, "", "", kIdempotent,
     "fetch and install a certificate"},
});

}  // namespace

std::span<const ActionSpec> AllActions() { return kActions; }

}  // namespace fleetpub::vda5050
