#include "cli/output/fleet_table.h"

#include <gmock/gmock.h>

#include "base/json.h"

namespace fleetpub::cli {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using vda5050::RobotState;
using vda5050::RobotView;

RobotView Robot() {
  RobotView robot;
  robot.robot = {"KIT", "0001"};
  robot.interface_name = "uagv";
  robot.topic_level = "v2";
  robot.version = vda5050::Version::k210;
  robot.header_version = "v2.1";
  robot.connection_state = "ONLINE";
  robot.connection_timestamp = "2026-01-02T03:04:05.678Z";
  RobotState state;
  state.operating_mode = "AUTOMATIC";
  state.driving = false;
  state.paused = true;
  state.battery_charge = 79.6;
  state.charging = true;
  state.errors = {{.type = "a", .level = "WARNING", .description = "slow"},
                  {.type = "b", .level = "FATAL", .description = ""}};
  robot.state = state;
  return robot;
}

std::vector<std::string> Texts(const Row& row) {
  std::vector<std::string> texts;
  for (const Cell& cell : row) texts.push_back(cell.text);
  return texts;
}

base::WallTime Time(std::string_view text) { return base::ParseDateTime(text).value(); }

TEST(FleetTable, ShowsARobotInOneRow) {
  const auto now = Time("2026-01-02T03:07:10Z");
  EXPECT_THAT(Texts(FleetRow(Robot(), now)),
              ElementsAre("KIT/0001", "2.1.0", "ONLINE", "3 min", "AUTOMATIC", "no", "yes",
                          "80% charging", "none", "2 FATAL"));
  EXPECT_EQ(FleetRow(Robot(), now).size(), FleetColumns().size());
}

TEST(FleetTable, ShowsADashForWhatIsNotKnown) {
  RobotView robot;
  robot.robot = {"KIT", "0001"};
  EXPECT_THAT(Texts(FleetRow(robot, {})),
              ElementsAre("KIT/0001", "-", "-", "-", "-", "-", "-", "-", "-", "-"));
  robot.state = RobotState{};
  EXPECT_THAT(Texts(FleetRow(robot, {})),
              ElementsAre("KIT/0001", "-", "-", "-", "-", "-", "-", "-", "none", "0"));
}

TEST(FleetTable, MakesWhatARobotSaysPrintableAndShort) {
  RobotView robot = Robot();
  robot.robot.serial_number = "\xC2\x9B";
  robot.connection_state = "\x1b[2J";
  robot.state->order_id = std::string(100, 'o');
  const auto texts = Texts(FleetRow(robot, {}));
  EXPECT_EQ(texts[0], "KIT/%C2%9B");
  EXPECT_EQ(texts[2], "\\x1b[2J");
  EXPECT_LT(texts[8].size(), 50U);
}

TEST(FleetTable, ShowsWhatAnOperatorNeedsInEightyColumns) {
  RobotView robot = Robot();
  robot.state->order_id = "order-2026-01-02-17";
  const std::vector<Row> rows = {FleetRow(robot, Time("2026-01-02T03:07:10Z"))};
  const Output output({});
  EXPECT_THAT(
      TableLines(FleetColumns(), rows, 80, output),
      ElementsAre(
          "TARGET    CONNECTION  MODE       PAUSED  BATTERY       ORDER             ERRORS",
          "KIT/0001  ONLINE      AUTOMATIC  yes     80% charging  order-2026-01-0…  2 FATAL"));
  EXPECT_THAT(
      TableLines(FleetColumns(), rows, 40, output),
      ElementsAre("TARGET    CONNECTION  PAUSED  ERRORS", "KIT/0001  ONLINE      yes     2 FATAL"));
}

TEST(FleetTable, NamesTheColumnsInALineThatStandsAlone) {
  EXPECT_EQ(FleetLine(Robot(), Output({})),
            "KIT/0001  2.1.0  ONLINE  AUTOMATIC  driving no  paused yes  battery 80% charging  "
            "order none  errors 2 FATAL");
}

TEST(FleetTable, WritesJsonWithStableNames) {
  EXPECT_EQ("{" + FleetJson(Robot()) + "}",
            R"({"target":"KIT/0001","manufacturer":"KIT","serialNumber":"0001","version":"2.1.0",)"
            R"("headerVersion":"v2.1","interface":"uagv","topicLevel":"v2",)"
            R"("connectionState":"ONLINE","connectionTimestamp":"2026-01-02T03:04:05.678Z",)"
            R"("operatingMode":"AUTOMATIC","driving":false,"paused":true,"batteryCharge":79.6,)"
            R"("charging":true,"orderId":"","errors":[)"
            R"({"errorType":"a","errorLevel":"WARNING","errorDescription":"slow"},)"
            R"({"errorType":"b","errorLevel":"FATAL","errorDescription":""}]})");
}

TEST(FleetTable, WritesNullForWhatIsNotKnown) {
  RobotView robot;
  robot.robot = {"KIT", "\"\x1b"};
  const auto json = base::ParseJson("{" + FleetJson(robot) + "}");
  ASSERT_TRUE(json);
  for (const char* name : {"version", "connectionState", "paused", "errors"}) {
    EXPECT_TRUE((*json)[name].IsNull()) << name;
  }
  EXPECT_EQ(base::StringMember(*json, "serialNumber"), "\"\x1b");
  EXPECT_STREQ((*json)["batteryCharge"].GetString(), "unknown") << "jq: null is less than 20";
  robot.state = RobotState{};
  EXPECT_THAT(FleetJson(robot),
              AllOf(HasSubstr(R"("paused":null)"), HasSubstr(R"("batteryCharge":"unknown")")));
  EXPECT_THAT(FleetJson(robot), Not(HasSubstr(R"("errors":null)")));
}

TEST(FleetTable, ShowsAFullListOfInstantActions) {
  RobotView robot = Robot();
  EXPECT_THAT(FleetJson(robot), Not(HasSubstr("instantActionsFull")));
  robot.state->errors = {{.type = "INSTANT_ACTION_STATES_FULL", .level = "URGENT"}};
  EXPECT_THAT(FleetJson(robot), HasSubstr(R"("instantActionsFull":true)"));
  EXPECT_THAT(FleetLine(robot, Output({})), HasSubstr("errors 1 URGENT, list full"));
}

TEST(FleetTable, TellsAgesAsPeopleDo) {
  using namespace std::chrono_literals;
  const std::pair<std::chrono::seconds, const char*> cases[] = {
      {0s, "0 s"}, {59s, "59 s"}, {60s, "1 min"}, {3599s, "59 min"}, {3600s, "1 h"}, {49h, "2 d"}};
  for (const auto& [age, text] : cases) EXPECT_EQ(AgeText(age), text);
}

}  // namespace
}  // namespace fleetpub::cli
