#include "soar/text_rules.h"

#include <gmock/gmock.h>

#include <array>

#include "base/file.h"
#include "base/json.h"

namespace fleetpub::soar {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

base::JsonDocument Messages() {
  const auto text = base::ReadFile(FLEETPUB_SOURCE_DIR "/tests/data/soar/messages.json");
  return std::move(base::ParseJson(text.value()).value());
}

// The good message of this type with the value at the pointer replaced; `path: message` for each
// finding.
std::vector<std::string> Findings(const char* type, const std::string& pointer = "",
                                  std::string_view json = "") {
  auto messages = Messages();
  auto& message = messages[type];
  if (!pointer.empty()) {
    const auto value = base::ParseJson(json);
    base::JsonPointer(pointer).Set(message, *value, messages.GetAllocator());
  }
  std::vector<std::string> found;
  for (const auto& finding : CheckMessage(message, Strictness::kWarn)) {
    EXPECT_FALSE(finding.is_error);
    found.push_back(finding.violation.path + " " + finding.violation.message);
  }
  return found;
}

TEST(SoarTextRules, AreSatisfiedByTheGoodMessages) {
  for (const char* type : {"acknowledgement", "mission_plan", "observation",
                           "planning_configuration", "platform_status"}) {
    EXPECT_THAT(Findings(type), IsEmpty()) << type;
  }
}

struct Case {
  const char* type;
  const char* pointer;
  std::string_view json;
  std::string_view finding;
};

TEST(SoarTextRules, WarnOfWhatMakesNoSense) {
  constexpr std::array kCases = {
      Case{"mission_plan", "/payload/plan/0/latitude_waypoint", "90.5",
           "/payload/plan/0/latitude_waypoint plan[0].latitude_waypoint: 90.5 is not between -90 "
           "and 90: are latitude and longitude swapped?"},
      Case{"mission_plan", "/payload/plan/0/latitude_waypoint", "-1000",
           "-1000 is not between -90 and 90"},
      Case{"mission_plan", "/payload/plan/0/longitude_waypoint", "180.1", "-180 and 180"},
      Case{"mission_plan", "/payload/plan/0/action", R"("scanlin")", "did you mean scanline?"},
      Case{"mission_plan", "/payload/plan", "[]", "/payload/plan plan: it is empty"},
      Case{"observation", "/payload/points_of_interest/0/latitude", "178.2",
           "points_of_interest[0].latitude: 178.2"},
      Case{"platform_status", "/payload/longitude", "-181", "longitude: -181"},
      Case{"platform_status", "/payload/heading", "361", "between 0 and 360"},
      Case{"platform_status", "/payload/battery_remaining_capacity", "101", "between 0 and 100"},
      Case{"planning_configuration", "/payload/squads", "[]", "squads: it is empty"},
      Case{"planning_configuration", "/payload/squads/0/no_of_platforms", "3",
           "3 is not the number of its platforms, 1"},
      Case{"planning_configuration", "/payload/squads/0/platforms/0/emergency/latitude_waypoint",
           "91", "platforms[0].emergency.latitude_waypoint: 91"},
      Case{"planning_configuration", "/payload/squads/0/platforms/0/min_velocity", "2",
           "2 is above max_velocity, 0.9"},
      Case{"planning_configuration", "/payload/exclusion_zones/0/geometry_coordinates",
           "[[[1,2],[3,4],[5,6]]]", "a zone has four points, not 3"},
      Case{"planning_configuration", "/payload/exclusion_zones/0/geometry_coordinates", "[]",
           "it is empty"},
      Case{"planning_configuration", "/payload/exclusion_zones/0/geometry_coordinates", "[7]",
           "a ring is an array"},
      Case{"planning_configuration",
           "/payload/squads/0/region_of_interest/geometry_coordinates/0/1", "[50.3,\"x\"]",
           "a point is [longitude, latitude]"},
      Case{"planning_configuration",
           "/payload/squads/0/region_of_interest/geometry_coordinates/0/1", "[4,95]",
           "[4, 95] is not a longitude"},
      Case{"mission_plan", "/header/delivery_type", R"("broadcast")", "/header/delivery_type"},
      Case{"mission_plan", "/header/destination", R"("soar.a.b.c.to_platform.observation")",
           "it ends in observation, the payload is a mission_plan"},
  };
  for (const auto& [type, pointer, json, finding] : kCases) {
    EXPECT_THAT(Findings(type, pointer, json), ElementsAre(HasSubstr(finding))) << pointer;
  }
}

TEST(SoarTextRules, TakeTheLimitsAndAClosedRing) {
  EXPECT_THAT(Findings("platform_status", "/payload/latitude", "-90"), IsEmpty());
  EXPECT_THAT(Findings("platform_status", "/payload/longitude", "180"), IsEmpty());
  EXPECT_THAT(Findings("mission_plan", "/payload/plan/0/action", R"("hover_and_sing")"), IsEmpty());
  EXPECT_THAT(Findings("planning_configuration", "/payload/exclusion_zones/0/geometry_coordinates",
                       "[[[1,2],[3,4],[5,6],[7,8],[1,2]]]"),
              IsEmpty());
}

TEST(SoarTextRules, KnowAPlatformOnlyOnce) {
  auto messages = Messages();
  auto& payload = messages["planning_configuration"]["payload"];
  base::JsonValue twin(payload["squads"][0], messages.GetAllocator());
  payload["squads"].PushBack(twin, messages.GetAllocator());
  std::vector<std::string> found;
  for (const auto& finding : CheckMessage(payload, Strictness::kRefuse)) {
    EXPECT_TRUE(finding.is_error);
    found.push_back(finding.violation.message);
  }
  EXPECT_THAT(found, ElementsAre("squads[1].squad_ID: 23 stands at /squads/0/squad_ID already",
                                 "squads[1].platforms[0].platform_ID: 7 stands at "
                                 "/squads/0/platforms/0/platform_ID already"));
}

TEST(SoarTextRules, PassOverWhatAnotherSchemaLetPass) {
  for (const char* json : {"{}", "[]", "7", R"({"payload":7,"header":[]})",
                           R"({"payload":{"message_type":"mission_plan","plan":7}})",
                           R"({"message_type":"mission_plan","plan":[7,[],{"action":1}]})",
                           R"({"message_type":"planning_configuration","squads":[7,{"platforms":1}],
                               "exclusion_zones":[[],{"geometry_coordinates":{}}]})"}) {
    EXPECT_THAT(CheckMessage(*base::ParseJson(json), Strictness::kWarn), IsEmpty()) << json;
  }
}

}  // namespace
}  // namespace fleetpub::soar
