#include "cli/output/fleet_table.h"

#include <gmock/gmock.h>

#include "base/json.h"

namespace fleetpub::cli {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using vda5050::LiveState;

struct Robot {
  vda5050::RobotAddress address{"KIT", "0001"};
  vda5050::RobotEntry entry;
  LiveState state;
  [[nodiscard]] vda5050::ListedRobot Listed(bool speaks = true) const {
    vda5050::ListedRobot listed(address, entry);
    if (speaks) listed.second.state = std::make_shared<const LiveState>(state);
    return listed;
  }
};

Robot Unknown() {
  Robot robot;
  robot.entry.base = std::make_shared<const vda5050::Dialect>();
  return robot;
}

Robot Busy() {
  Robot robot = Unknown();
  robot.entry.place = "uagv/v2";
  vda5050::Dialect own;
  own.version = vda5050::Version::k210;
  robot.entry.own = std::make_shared<const vda5050::Dialect>(own);
  robot.entry.said_version = "v2.1";
  robot.entry.connection = vda5050::ConnectionMessage{
      .header = {.timestamp = "2026-01-02T03:04:05.678Z"}, .connection_state = "ONLINE"};
  robot.state.operating_mode = "AUTOMATIC";
  robot.state.driving = false;
  robot.state.paused = true;
  robot.state.battery_charge = 79.6;
  robot.state.charging = true;
  robot.state.errors = {{.type = "a", .level = "WARNING", .description = "slow"},
                        {.type = "b", .level = "FATAL", .description = ""}};
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
  EXPECT_THAT(Texts(FleetRow(Busy().Listed(), now)),
              ElementsAre("KIT/0001", "2.1.0", "ONLINE", "3 min", "AUTOMATIC", "no", "yes",
                          "80% charging", "none", "2 FATAL"));
  EXPECT_EQ(FleetRow(Busy().Listed(), now).size(), FleetColumns().size());
}

TEST(FleetTable, ShowsADashForWhatIsNotKnown) {
  const Robot robot = Unknown();
  EXPECT_THAT(Texts(FleetRow(robot.Listed(false), {})),
              ElementsAre("KIT/0001", "-", "-", "-", "-", "-", "-", "-", "-", "-"));
  EXPECT_THAT(Texts(FleetRow(robot.Listed(), {})),
              ElementsAre("KIT/0001", "-", "-", "-", "-", "-", "-", "-", "none", "0"));
}

TEST(FleetTable, MakesWhatARobotSaysPrintableAndShort) {
  Robot robot = Busy();
  robot.address.serial_number = "\xC2\x9B";
  robot.entry.connection->connection_state = "\x1b[2J";
  robot.state.order_id = std::string(100, 'o');
  const auto texts = Texts(FleetRow(robot.Listed(), {}));
  EXPECT_EQ(texts[0], "KIT/%C2%9B");
  EXPECT_EQ(texts[2], "\\x1b[2J");
  EXPECT_LT(texts[8].size(), 50U);
}

TEST(FleetTable, ShowsWhatAnOperatorNeedsInEightyColumns) {
  Robot robot = Busy();
  robot.state.order_id = "order-2026-01-02-17";
  const std::vector<Row> rows = {FleetRow(robot.Listed(), Time("2026-01-02T03:07:10Z"))};
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
  EXPECT_EQ(FleetLine(Busy().Listed(), Output({})),
            "KIT/0001  2.1.0  ONLINE  AUTOMATIC  driving no  paused yes  battery 80% charging  "
            "order none  errors 2 FATAL");
}

TEST(FleetTable, WritesJsonWithStableNames) {
  EXPECT_EQ("{" + FleetJson(Busy().Listed()) + "}",
            R"({"target":"KIT/0001","manufacturer":"KIT","serialNumber":"0001","version":"2.1.0",)"
            R"("headerVersion":"v2.1","interface":"uagv","topicLevel":"v2",)"
            R"("connectionState":"ONLINE","connectionTimestamp":"2026-01-02T03:04:05.678Z",)"
            R"("operatingMode":"AUTOMATIC","driving":false,"paused":true,"batteryCharge":79.6,)"
            R"("charging":true,"orderId":"","errors":[)"
            R"({"errorType":"a","errorLevel":"WARNING","errorDescription":"slow"},)"
            R"({"errorType":"b","errorLevel":"FATAL","errorDescription":""}]})");
}

TEST(FleetTable, WritesNullForWhatIsNotKnown) {
  Robot robot = Unknown();
  robot.address = {"KIT", "\"\x1b"};
  const auto json = base::ParseJson("{" + FleetJson(robot.Listed(false)) + "}");
  ASSERT_TRUE(json);
  for (const char* name : {"version", "connectionState", "paused", "errors"}) {
    EXPECT_TRUE((*json)[name].IsNull()) << name;
  }
  EXPECT_EQ(base::StringMember(*json, "serialNumber"), "\"\x1b");
  EXPECT_STREQ((*json)["batteryCharge"].GetString(), "unknown") << "jq: null is less than 20";
  EXPECT_THAT(FleetJson(robot.Listed()),
              AllOf(HasSubstr(R"("paused":null)"), HasSubstr(R"("batteryCharge":"unknown")")));
  EXPECT_THAT(FleetJson(robot.Listed()), Not(HasSubstr(R"("errors":null)")));
}

TEST(FleetTable, ShowsAFullListOfInstantActions) {
  Robot robot = Busy();
  EXPECT_THAT(FleetJson(robot.Listed()), Not(HasSubstr("instantActionsFull")));
  robot.state.errors = {{.type = "INSTANT_ACTION_STATES_FULL", .level = "URGENT"}};
  EXPECT_THAT(FleetJson(robot.Listed()), HasSubstr(R"("instantActionsFull":true)"));
  EXPECT_THAT(FleetLine(robot.Listed(), Output({})), HasSubstr("errors 1 URGENT, list full"));
}

TEST(FleetTable, TellsAgesAsPeopleDo) {
  using namespace std::chrono_literals;
  const std::pair<std::chrono::seconds, const char*> cases[] = {
      {0s, "0 s"}, {59s, "59 s"}, {60s, "1 min"}, {3599s, "59 min"}, {3600s, "1 h"}, {49h, "2 d"}};
  for (const auto& [age, text] : cases) EXPECT_EQ(AgeText(age), text);
}

}  // namespace
}  // namespace fleetpub::cli
