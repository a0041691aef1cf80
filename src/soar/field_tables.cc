// The tables of soar/field.h: the members that the message format 1.0 defines.
#include "soar/field.h"

namespace fleetpub::soar {
namespace {

using enum FieldType;

constexpr Field kLatitude = {"latitude", kNumber, "degrees north, -90 to 90", true, {"lat"}};
constexpr Field kLongitude = {"longitude", kNumber, "degrees east, -180 to 180", true, {"lon"}};
constexpr Field kPlatformId = {"platform_ID", kInteger, "number of the platform", true};

constexpr std::array kAcknowledgementFields = {
    Field{"acknowledged_message_ID",
          kText,
          "message_ID of the message that is acknowledged",
          true,
          {"message_id"}},
    Field{"status",
          kText,
          "how far it has come: c2_received, operator_approved_and_sent, executed",
          true,
          {},
          {},
          {"c2_received", "operator_approved_and_sent", "executed"}},
};

constexpr std::array kMissionPlanFields = {
    Field{"autonomy_engine_plan_ID", kInteger, "number of the plan", true, {"plan_id"}},
    kPlatformId,
};

constexpr std::array kObservationFields = {
    kPlatformId,
    Field{"region_surveyed", kJson, "the region, GeoJSON; @FILE reads a file"},
    Field{"additional_data", kJson, "anything else, JSON; @FILE reads a file"},
};

constexpr std::array kPlanningConfigurationFields = {
    Field{"planning_config_ID",
          kInteger,
          "number of the configuration [the file's]",
          false,
          {"config_id"}},
};

constexpr std::array kPlatformStatusFields = {
    kPlatformId,
    Field{"status_source",
          kText,
          "who says so: usbl, onboard_platform",
          true,
          {},
          {},
          {"usbl", "onboard_platform"}},
    Field{"platform_timestamp", kDateTime, "when it was so [now]"},
    kLatitude,
    kLongitude,
    Field{"depth", kNumber, "target depth in metres"},
    Field{"altitude", kNumber, "target altitude in metres"},
    Field{"heading", kNumber, "degrees clockwise from north"},
    Field{"current_pitch", kNumber, "pitch"},
    Field{"speed_over_ground", kNumber, "speed over ground"},
    Field{"thrust_applied", kNumber, "thrust"},
    Field{"water_current_velocity", kNumber, "speed of the current"},
    Field{"battery_remaining_capacity", kNumber, "battery, per cent", false, {"battery"}},
    Field{"platform_state", kText, "what it does: STOP, IDLE, ABORT ..."},
    Field{"health_status", kText, "what its diagnosis says"},
    Field{"autonomy_engine_plan_ID", kInteger, "last plan that it carried out", false, {"plan_id"}},
    Field{"mission_track_ID", kInteger, "leg of the plan that it is on"},
    Field{"mission_action_ID", kInteger, "action of the plan that it is at"},
    Field{"range_to_go", kNumber, "distance to the next waypoint"},
    Field{"localisation_error", kNumber, "error at the last USBL fix"},
    Field{"usbl_fix_seconds_ago", kNumber, "age of the last USBL fix in seconds"},
    Field{"transmission_mode",
          kText,
          "how the status came: acoustics, iridium, wifi, starlink",
          false,
          {},
          {},
          {"acoustics", "iridium", "wifi", "starlink"}},
    Field{"sensor_serial", kText, "serial number of its sensor", false, {}, "sensor_config"},
    Field{"sensor_on", kBoolean, "whether the sensor is on", false, {}, "sensor_config"},
    Field{"additional_data",
          kJson,
          "anything else on the sensor, JSON; @FILE reads a file",
          false,
          {"sensor_data"},
          "sensor_config"},
};

constexpr std::array kWaypointFields = {
    Field{"latitude_waypoint", kNumber, "degrees north", true, {"lat", "latitude"}},
    Field{"longitude_waypoint", kNumber, "degrees east", true, {"lon", "longitude"}},
    Field{"depth", kNumber, "metres below the surface"},
    Field{"altitude", kNumber, "metres above the sea floor"},
    Field{"action", kText, "move, payload, dive, send_hits, scanline, scanpoint, or another"},
    Field{"activate_payload", kBoolean, "switch the sensor on or off"},
    Field{"send_environmental_data", kBoolean, "send observations"},
    Field{"flight_style", kText, "a mode of the platform, such as orbit"},
};

constexpr std::array kPointFields = {
    kLatitude,
    kLongitude,
    Field{"quality_of_point", kNumber, "quality of the point", false, {"quality"}},
};

}  // namespace

std::span<const Field> ListFields(MessageType type) {
  switch (type) {
    case MessageType::kAcknowledgement:
      return kAcknowledgementFields;
    case MessageType::kMissionPlan:
      return kMissionPlanFields;
    case MessageType::kObservation:
      return kObservationFields;
    case MessageType::kPlanningConfiguration:
      return kPlanningConfigurationFields;
    case MessageType::kPlatformStatus:
      return kPlatformStatusFields;
  }
  return {};
}

std::span<const Field> WaypointFields() { return kWaypointFields; }
std::span<const Field> PointFields() { return kPointFields; }

}  // namespace fleetpub::soar
