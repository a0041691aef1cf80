#include "cli/output/robot_sheet.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "base/json.h"
#include "base/text.h"
#include "base/width.h"

namespace fleetpub::cli {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using vda5050::Version;

constexpr std::string_view kConnected = "2026-01-02T03:04:05.678Z";
constexpr std::string_view kSaid = "2026-01-02T03:07:00.000Z";

base::WallTime Time(std::string_view text) { return base::ParseDateTime(text).value(); }

app::RobotSheet Healthy() {
  app::RobotSheet sheet{.robot = {"KIT", "0001"},
                        .version = Version::k210,
                        .said_version = "2.1.0",
                        .place = "uagv/v2",
                        .is_alive = true};
  sheet.connection = vda5050::ConnectionMessage{.header = {.timestamp = std::string(kConnected)},
                                                .connection_state = "ONLINE"};
  sheet.state = vda5050::ReadState(R"({"timestamp": "2026-01-02T03:07:00.000Z",
    "operatingMode": "AUTOMATIC", "driving": true, "paused": false, "orderId": "o-7",
    "orderUpdateId": 2, "lastNodeId": "n2", "lastNodeSequenceId": 2,
    "nodeStates": [{"nodeId": "n3", "sequenceId": 4}, {"nodeId": "n4", "sequenceId": 6}],
    "edgeStates": [{"sequenceId": 3}, {"sequenceId": 5}],
    "agvPosition": {"x": 1.5, "y": -2, "theta": 0.25, "mapId": "hall", "positionInitialized": true},
    "batteryState": {"batteryCharge": 79.6, "charging": true, "batteryVoltage": 48.1, "reach": 900},
    "safetyState": {"eStop": "NONE", "fieldViolation": false},
    "actionStates": [{"actionId": "a1", "actionType": "pick", "actionStatus": "FINISHED"},
      {"actionId": "a3", "actionType": "drop", "actionStatus": "WAITING"},
      {"actionId": "a2", "actionType": "beep", "actionStatus": "RUNNING"}],
    "loads": [{"loadId": "L1", "loadType": "EPAL", "weight": 12.5}], "errors": []})")
                    .value();
  auto factsheet = vda5050::ReadFactsheet(R"({
    "typeSpecification": {"seriesName": "S9", "agvClass": "FORKLIFT", "agvKinematic": "THREEWHEEL",
      "maxLoadMass": 1200},
    "physicalParameters": {"speedMax": 1.8, "length": 2.1, "width": 1, "heightMax": 2},
    "protocolFeatures": {"agvActions": [{"actionType": "startPause"}, {"actionType": "beep"}]}})");
  sheet.factsheet = std::make_shared<vda5050::Factsheet>(*std::move(factsheet));
  sheet.commands.push_back({.recorded_at = Time(kSaid),
                            .user = "ada",
                            .host = "ops",
                            .actions = {{"stopPause", "x"}},
                            .status = "FAILED",
                            .detail = "wheel blocked"});
  return sheet;
}

std::vector<std::string> Lines(const app::RobotSheet& sheet, Extent extent = Extent::kWhole,
                               std::size_t width = 80) {
  return RobotSheetLines(sheet, extent, width, Time("2026-01-02T03:07:10Z"), Output({}));
}

// Local times are wherever the tests run.
std::string Local(std::string_view time) { return base::FormatLocal(Time(time)); }

std::string Text(const std::vector<std::string>& lines) { return base::Join(lines, "\n"); }

TEST(RobotSheet, ShowsARobotThatIsWell) {
  EXPECT_THAT(
      Lines(Healthy()),
      ElementsAre(
          "KIT/0001",  //
          "  connection   ONLINE since " + Local(kConnected) + " (3 min ago)",
          "  version      2.1.0 at uagv/v2", "  state        from " + Local(kSaid) + " (10 s ago)",
          "  mode         AUTOMATIC", "  safety       no emergency stop, no field violation",
          "  position     x 1.5, y -2, theta 0.25 on map hall; last node n2",
          "  order        o-7 update 2: node 2 of 4, driving",
          "  actions      RUNNING beep a2",  //
          "               WAITING drop a3",  //
          "  errors       none",             //
          "  loads        L1, EPAL, 12.5 kg",
          "  battery      79.6 %, charging, 48.1 V, range 900 m",
          "  information  none",  //
          "  factsheet    S9, FORKLIFT, carries 1200 kg",
          "               THREEWHEEL, 2.1 x 1 x 2 m, up to 1.8 m/s",
          "               actions: startPause, beep",
          "  commands     " + Local(kSaid) + " stopPause FAILED: wheel blocked, by ada@ops"));
}

app::RobotSheet InTrouble() {
  app::RobotSheet sheet = Healthy();
  vda5050::RobotState& state = *sheet.state;
  state.operating_mode = "MANUAL";
  state.driving = false;
  state.paused = true;
  state.emergency_stop = "REMOTE";
  state.field_violation = true;
  state.battery_charge = 7;
  state.charging = false;
  state.errors = {{.type = "slow", .level = "WARNING", .description = "", .hint = ""},
                  {.type = "motorFault",
                   .level = "FATAL",
                   .description = "motor 2 is too hot to turn, whatever is asked of it\x1b[2J",
                   .hint = "let it cool for an hour",
                   .references = {{"nodeId", "n3"}}}};
  state.information = {{.type = "door", .level = "INFO", .description = "open", .references = {}}};
  return sheet;
}

TEST(RobotSheet, ShowsTroubleWorstFirstWithHintAndReferences) {
  const auto lines = Lines(InTrouble());
  EXPECT_THAT(Text(lines),
              AllOf(HasSubstr("\n  mode         MANUAL\n"),
                    HasSubstr("\n  safety       EMERGENCY STOP REMOTE, FIELD VIOLATION\n"),
                    HasSubstr("node 2 of 4, paused\n"),
                    HasSubstr("\n  battery      7 %, not charging, 48.1 V, range 900 m\n"),
                    HasSubstr("\n  information  INFO door: open\n")));
  EXPECT_THAT(
      Text(lines),
      HasSubstr("\n  errors       FATAL motorFault: motor 2 is too hot to turn, whatever is "
                "asked\n               of it\\x1b[2J; hint: let it cool for an hour; about "
                "nodeId n3\n               WARNING slow\n"));
  for (const std::string& line : lines) EXPECT_LE(base::MeasureWidth(line), 80U) << line;
}

TEST(RobotSheet, SaysWhatIsNotKnownOfARobotThatIsAway) {
  app::RobotSheet sheet{
      .robot = {"KIT", "9"}, .version = Version::k110, .said_version = "", .place = "uagv/v1"};
  sheet.connection = vda5050::ConnectionMessage{.header = {.timestamp = std::string(kConnected)},
                                                .connection_state = "OFFLINE"};
  EXPECT_THAT(Text(Lines(sheet)),
              AllOf(HasSubstr("OFFLINE since " + Local(kConnected)),
                    HasSubstr("  state        not"), HasSubstr("none: 1.1 has none"),
                    HasSubstr("none in this ledger"), Not(HasSubstr("battery  "))));
  // The past is no present, but better than nothing.
  sheet.state = Healthy().state;
  sheet.state_is_retained = true;
  EXPECT_THAT(Text(Lines(sheet)), AllOf(HasSubstr("  state        retained, from " + Local(kSaid)),
                                        HasSubstr("last node n2")));
}

TEST(RobotSheet, DatesNoBrokenConnectionByItsLastWill) {
  app::RobotSheet sheet = Healthy();
  sheet.connection->connection_state = "CONNECTION_BROKEN";
  EXPECT_THAT(Text(Lines(sheet)),
              AllOf(HasSubstr("CONNECTION_BROKEN; connected at"), Not(HasSubstr("BROKEN since"))));
  sheet.connection.reset();
  sheet.speaks = true;
  EXPECT_THAT(Text(Lines(sheet)), HasSubstr("no connection message, but it sends states"));
}

TEST(RobotSheet, SaysWhatAStateLeavesOut) {
  app::RobotSheet sheet = Healthy();
  sheet.state = vda5050::ReadState("{}").value();
  sheet.factsheet = std::make_shared<vda5050::Factsheet>();
  EXPECT_THAT(Text(Lines(sheet)),
              AllOf(HasSubstr("mode         not said"), HasSubstr("emergency stop not reported"),
                    HasSubstr("position     not said; last node none"),
                    HasSubstr("order        none, driving not reported"),
                    HasSubstr("loads        not said"), HasSubstr("charge not said"),
                    HasSubstr("actions not said")));
}

TEST(RobotSheet, KeepsABlockOfSeveralShort) {
  const auto well = Lines(Healthy(), Extent::kBlock);
  EXPECT_LE(well.size(), 9U);
  EXPECT_THAT(well, Each(Not(HasSubstr("factsheet"))));
  EXPECT_THAT(Text(Lines(InTrouble(), Extent::kBlock)),
              AllOf(HasSubstr("EMERGENCY STOP"), HasSubstr("FATAL motorFault")));
}

TEST(RobotSheet, TellsFactsheetsByWhatTheyLackAndAdd) {
  app::RobotSheet sheet = Healthy();
  vda5050::Factsheet factsheet;
  for (const char* type :
       {"cancelOrder", "deleteMap", "downloadMap", "enableMap", "initPosition", "factsheetRequest",
        "logReport", "startCharging", "startPause", "stateRequest", "stopPause", "scan"}) {
    factsheet.actions.push_back(
        {.type = type, .scopes = {}, .parameters = {}, .blocking_types = {}});
  }
  sheet.factsheet = std::make_shared<vda5050::Factsheet>(factsheet);
  EXPECT_THAT(Text(Lines(sheet, Extent::kWhole, 200)),
              HasSubstr("actions: all 12 instant ones of 2.1.0 but stopCharging; also scan"));
}

TEST(RobotSheetJson, HasNormalisedMembersAndTheMessagesAsTheyWere) {
  app::RobotSheet sheet = InTrouble();
  sheet.state_json = R"({"own":[1,2.50],"operatingMode":"manual"})";
  const auto json = base::ParseJson(RobotSheetJson(sheet));
  ASSERT_TRUE(json);
  const auto& object = *json;
  EXPECT_STREQ(object["target"].GetString(), "KIT/0001");
  EXPECT_STREQ(object["connectionState"].GetString(), "ONLINE");
  EXPECT_STREQ(object["operatingMode"].GetString(), "MANUAL");
  EXPECT_STREQ(object["emergencyStop"].GetString(), "REMOTE");
  EXPECT_TRUE(object["fieldViolation"].GetBool());
  EXPECT_EQ(object["errors"].Size(), 2U);
  EXPECT_STREQ(object["errors"][1]["errorHint"].GetString(), "let it cool for an hour");
  EXPECT_EQ(object["position"]["y"].GetDouble(), -2);
  EXPECT_EQ(object["nodesLeft"].GetUint(), 2U);
  EXPECT_EQ(object["loads"][0]["weight"].GetDouble(), 12.5);
  EXPECT_STREQ(object["specification"]["robotClass"].GetString(), "FORKLIFT");
  EXPECT_EQ(object["supportedActions"].Size(), 2U);
  EXPECT_STREQ(object["commands"][0]["actions"][0]["type"].GetString(), "stopPause");
  EXPECT_THAT(RobotSheetJson(sheet), HasSubstr(",\"state\":" + sheet.state_json + ","));
  EXPECT_TRUE(object["factsheet"].IsNull());
}

TEST(RobotSheetJson, SaysOfEveryMemberThatItIsNotKnown) {
  app::RobotSheet sheet{.robot = {"KIT", "9"}};
  sheet.commands_fault = "the ledger is locked";
  const auto json = base::ParseJson(RobotSheetJson(sheet));
  ASSERT_TRUE(json);
  for (const char* name :
       {"version", "connectionState", "operatingMode", "emergencyStop", "orderId", "errors",
        "loads", "position", "specification", "state", "commands"}) {
    ASSERT_TRUE(json->HasMember(name)) << name;
    EXPECT_TRUE((*json)[name].IsNull()) << name;
  }
  EXPECT_STREQ((*json)["batteryCharge"].GetString(), "unknown");
  EXPECT_STREQ((*json)["commandsFault"].GetString(), "the ledger is locked");
}

}  // namespace
}  // namespace fleetpub::cli
