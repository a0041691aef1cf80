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
              ElementsAre("KIT/0001", "2.1.0", "ONLINE", "3 min", "AUTOMATIC", "-", "no", "yes",
                          "80% chg", "none", "2 FATAL b"));
  EXPECT_EQ(FleetRow(Busy().Listed(), now).size(), FleetColumns().size());
}

TEST(FleetTable, ShowsADashForWhatIsNotKnown) {
  const Robot robot = Unknown();
  EXPECT_THAT(Texts(FleetRow(robot.Listed(false), {})),
              ElementsAre("KIT/0001", "-", "-", "-", "-", "-", "-", "-", "-", "-", "-"));
  EXPECT_THAT(Texts(FleetRow(robot.Listed(), {})),
              ElementsAre("KIT/0001", "-", "-", "-", "-", "-", "-", "-", "-", "none", "0"));
}

TEST(FleetTable, MakesWhatARobotSaysPrintableAndShort) {
  Robot robot = Busy();
  robot.address.serial_number = "\xC2\x9B";
  robot.entry.connection->connection_state = "\x1b[2J";
  robot.state.order_id = std::string(100, 'o');
  const auto texts = Texts(FleetRow(robot.Listed(), {}));
  EXPECT_EQ(texts[0], "KIT/%C2%9B");
  EXPECT_EQ(texts[2], "\\x1b[2J");
  EXPECT_LT(texts[9].size(), 50U);
}

TEST(FleetTable, ShowsWhatAnOperatorNeedsInEightyColumns) {
  Robot robot = Busy();
  robot.state.order_id = "order-2026-01-02-17";
  robot.state.emergency_stop = "NONE";
  robot.state.errors[1] = {
      .type = "motorFault", .level = "FATAL", .description = "the left wheel is stuck"};
  const std::vector<Row> rows = {FleetRow(robot.Listed(), Time("2026-01-02T03:07:10Z"))};
  const Output output({});
  EXPECT_THAT(
      TableLines(FleetColumns(), rows, 80, output),
      ElementsAre(
          "TARGET    CONNECTION  MODE       SAFETY  PAUSED  BATTERY  ERRORS",
          "KIT/0001  ONLINE      AUTOMATIC  ok      yes     80% chg  2 FATAL motorFault: t…"));
  EXPECT_THAT(TableLines(FleetColumns(), rows, 160, output)[1],
              HasSubstr("2 FATAL motorFault: the left wheel is stuck"));
  EXPECT_THAT(TableLines(FleetColumns(), rows, 44, output),
              ElementsAre("TARGET    CONNECTION  SAFETY  ERRORS",
                          "KIT/0001  ONLINE      ok      2 FATAL motorF"));
}

TEST(FleetTable, ShowsLongNamesInEightyColumnsWithModeAndSafety) {
  Robot robot = Busy();
  robot.address = {"long-manufacturer", "serial-0017"};
  robot.entry.connection->connection_state = "CONNECTION_BROKEN";
  robot.state.operating_mode = "SEMIAUTOMATIC";
  robot.state.emergency_stop = "AUTOACK";
  const std::vector<Row> rows = {FleetRow(robot.Listed(), {})};
  // One column less: a table that passes leaves the last one free.
  EXPECT_THAT(TableLines(FleetColumns(), rows, 79, Output({}))[1],
              AllOf(HasSubstr("BROKEN"), HasSubstr("SEMIAUTO…"), HasSubstr("E-STOP"),
                    HasSubstr("80% chg"), HasSubstr("2 FATAL b")));
}

TEST(FleetTable, ShowsWhatStopsARobotForSafety) {
  Robot robot = Busy();
  const auto safety = [&] { return FleetRow(robot.Listed(), {})[5]; };
  EXPECT_EQ(safety().text, "-");
  robot.state.field_violation = false;
  EXPECT_EQ(safety().text, "ok");
  robot.state.field_violation = true;
  EXPECT_EQ(safety().text, "FIELD");
  EXPECT_EQ(safety().tone, Tone::kBad);
  robot.state.emergency_stop = "MANUAL";
  EXPECT_EQ(safety().text, "E-STOP");
  EXPECT_THAT(FleetJson(robot.Listed()),
              HasSubstr(R"("safety":{"emergencyStop":"MANUAL","fieldViolation":true})"));
}

TEST(FleetTable, TellsLeftoversOfTheDeadApart) {
  Robot robot = Busy();
  const auto last = [&] {
    return FleetRow(robot.Listed(false), Time("2026-01-05T03:07:10Z")).back();
  };
  robot.entry.last_said = Time("2026-01-02T03:04:05Z");
  robot.entry.connection->connection_state = "OFFLINE";
  EXPECT_EQ(last().text, "last seen 3 d ago");
  EXPECT_EQ(last().tone, Tone::kDim);
  EXPECT_THAT(FleetJson(robot.Listed(false)),
              HasSubstr(R"("lastSeen":"2026-01-02T03:04:05.000Z")"));
  robot.entry.connection->connection_state = "CONNECTION_BROKEN";
  EXPECT_THAT(last().text, HasSubstr("connected 3 d ago")) << "a last will's date";
  robot.entry.connection->connection_state = "ONLINE";
  EXPECT_EQ(last().text, "-");
  EXPECT_THAT(FleetJson(robot.Listed(false)), Not(HasSubstr("lastSeen")));
}

TEST(FleetTable, ColoursWhatMatters) {
  Robot robot = Busy();
  robot.state.battery_charge = 19;
  robot.state.operating_mode = "MANUAL";
  robot.state.errors.pop_back();
  const Row row = FleetRow(robot.Listed(), {});
  for (const std::size_t i : {4U, 7U, 8U, 10U}) EXPECT_EQ(row[i].tone, Tone::kWarn) << i;
  robot = Busy();
  robot.state.paused = false;
  const Row usual = FleetRow(robot.Listed(), {});
  for (const std::size_t i : {4U, 7U, 8U}) EXPECT_EQ(usual[i].tone, Tone::kPlain) << i;
  robot.state.errors.clear();
  const Cell silent = FleetRow(robot.Listed(), {}, std::chrono::minutes(2)).back();
  EXPECT_THAT(silent.text, HasSubstr("2 min"));
  EXPECT_EQ(silent.tone, Tone::kWarn);
}

TEST(FleetTable, SortsByWhatMatters) {
  std::vector<Robot> robots(4, Busy());
  const char* serials[] = {"1", "2", "3", "4"};
  for (std::size_t i = 0; i < 4; ++i) {
    robots[i].address.serial_number = serials[i];
    robots[i].state.errors.clear();
    robots[i].state.paused = false;
  }
  robots[0].entry.connection->connection_state = "OFFLINE";
  robots[0].entry.last_said = Time("2026-01-02T03:04:05Z");
  robots[2].state.emergency_stop = "REMOTE";
  robots[3].state.battery_charge = 3;
  std::vector<vda5050::ListedRobot> listed;
  for (const Robot& robot : robots) listed.push_back(robot.Listed());
  listed[1].second.state = nullptr;
  listed[1].second.last_said = Time("2026-01-02T03:04:09Z");
  const auto sorted = [&](SortBy by) {
    std::vector<const vda5050::ListedRobot*> some;
    for (const auto& robot : listed) some.push_back(&robot);
    SortRobots(some, by);
    std::string names;
    for (const auto* robot : some) names += robot->first.serial_number;
    return names;
  };
  EXPECT_EQ(sorted(SortBy::kName), "1234");
  EXPECT_EQ(sorted(SortBy::kTrouble), "3241") << "leftovers last";
  EXPECT_EQ(sorted(SortBy::kBattery), "4132") << "unknown last";
  listed[2].second.last_said = listed[3].second.last_said = Time("2026-01-03T03:04:05Z");
  EXPECT_EQ(sorted(SortBy::kAge), "1234");
  std::swap(listed[0].second.last_said, listed[3].second.last_said);
  EXPECT_EQ(sorted(SortBy::kAge), "4213");
}

TEST(FleetTable, NamesTheColumnsInALineThatStandsAlone) {
  EXPECT_EQ(
      FleetLine(Busy().Listed(), Output({})),
      "KIT/0001  2.1.0  ONLINE  AUTOMATIC  safety -  driving no  paused yes  battery 80% charging  "
      "order none  errors 2 FATAL b");
}

TEST(FleetTable, WritesJsonWithStableNames) {
  EXPECT_EQ("{" + FleetJson(Busy().Listed()) + "}",
            R"({"target":"KIT/0001","manufacturer":"KIT","serialNumber":"0001","version":"2.1.0",)"
            R"("headerVersion":"v2.1","interface":"uagv","topicLevel":"v2",)"
            R"("connectionState":"ONLINE","connectionTimestamp":"2026-01-02T03:04:05.678Z",)"
            R"("operatingMode":"AUTOMATIC","driving":false,"paused":true,"batteryCharge":79.6,)"
            R"("charging":true,"orderId":"",)"
            R"("safety":{"emergencyStop":null,"fieldViolation":null},"errors":[)"
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
