#include "cli/output/fleet_metrics.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>
#include <memory>

#include "base/text.h"

namespace fleetpub::cli {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using vda5050::ListedRobot;
using vda5050::LiveState;
using vda5050::RobotEntry;

base::WallTime Time(std::string_view text) { return base::ParseDateTime(text).value(); }
const base::WallTime kNow = Time("2026-01-02T03:04:15Z");

ListedRobot Robot(const vda5050::RobotAddress& address, std::optional<LiveState> state) {
  RobotEntry entry;
  entry.base = std::make_shared<const vda5050::Dialect>();
  entry.connection = vda5050::ConnectionMessage{.header = {}, .connection_state = "ONLINE"};
  if (state) entry.state = std::make_shared<const LiveState>(*std::move(state));
  return {address, entry};
}

LiveState Well() {
  LiveState state;
  state.header.timestamp = "2026-01-02T03:04:05.500Z";
  state.operating_mode = "AUTOMATIC";
  state.battery_charge = 62.5;
  state.charging = false;
  state.driving = true;
  state.emergency_stop = "NONE";
  state.field_violation = false;
  state.nodes_left = 3;
  state.edges_left = 2;
  return state;
}

std::string Metrics(const std::vector<ListedRobot>& robots,
                    const std::optional<app::ConfirmTimes>& times = {}) {
  std::vector<const ListedRobot*> pointers;
  for (const ListedRobot& robot : robots) pointers.push_back(&robot);
  std::string text;
  WriteFleetMetrics(pointers, kNow, times, [&](std::string_view more) { text += more; });
  return text;
}

TEST(FleetMetrics, TellWhatIsKnownOfARobot) {
  const std::string text = Metrics({Robot({"KIT", "0001"}, Well())});
  for (const char* line :
       {"fleetpub_robot_info{robot=\"KIT/0001\",manufacturer=\"KIT\",serial_number=\"0001\",",
        "fleetpub_robot_problem{robot=\"KIT/0001\"} 0\n",
        "fleetpub_robot_connection_state{robot=\"KIT/0001\",state=\"ONLINE\"} 1\n",
        "fleetpub_robot_operating_mode{robot=\"KIT/0001\",mode=\"AUTOMATIC\"} 1\n",
        "fleetpub_robot_state_age_seconds{robot=\"KIT/0001\"} 9.5\n",
        "fleetpub_robot_battery_charge_ratio{robot=\"KIT/0001\"} 0.625\n",
        "fleetpub_robot_charging{robot=\"KIT/0001\"} 0\n",
        "fleetpub_robot_driving{robot=\"KIT/0001\"} 1\n",
        "fleetpub_robot_emergency_stop{robot=\"KIT/0001\"} 0\n",
        "fleetpub_robot_field_violation{robot=\"KIT/0001\"} 0\n",
        "fleetpub_robot_order_nodes_remaining{robot=\"KIT/0001\"} 3\n",
        "fleetpub_robot_order_edges_remaining{robot=\"KIT/0001\"} 2\n"}) {
    EXPECT_THAT(text, HasSubstr(std::string("\n") + line));
  }
  EXPECT_THAT(text, Not(HasSubstr("robot_paused{"))) << "it does not say so";
  EXPECT_THAT(text, Not(HasSubstr("confirmation")));
  EXPECT_THAT(text, EndsWith("\n# EOF\n"));
}

TEST(FleetMetrics, OfASilentRobotAreItsConnectionOnly) {
  const std::string text = Metrics({Robot({"KIT", "0001"}, std::nullopt)});
  EXPECT_THAT(text, HasSubstr("state=\"ONLINE\"} 1\n"));
  for (const char* name : {"battery", "operating_mode", "errors", "age"}) {
    EXPECT_THAT(text,
                Not(ContainsRegex(std::string("\nfleetpub_robot_[a-z_]*") + name + "[a-z_]*\\{")));
  }
}

TEST(FleetMetrics, CountErrorsByLevel) {
  LiveState state = Well();
  state.errors = {{.type = "a", .level = "WARNING"},
                  {.type = "b", .level = "WARNING"},
                  {.type = "c", .level = "FATAL"},
                  {.type = "d", .level = "FUNNY"},
                  {.type = "e", .level = ""}};
  state.errors_left_out = 4;
  const std::string text = Metrics({Robot({"KIT", "0001"}, state)});
  for (const char* line :
       {"WARNING\"} 2\n", "URGENT\"} 0\n", "CRITICAL\"} 0\n", "FATAL\"} 1\n", "OTHER\"} 6\n"}) {
    EXPECT_THAT(
        text, HasSubstr(std::string("\nfleetpub_robot_errors{robot=\"KIT/0001\",level=\"") + line));
  }
  EXPECT_THAT(text, HasSubstr("fleetpub_robot_problem{robot=\"KIT/0001\"} 1\n"));
}

TEST(FleetMetrics, KeepEachFamilyTogetherInTheOrderOfTheRobots) {
  const std::string text =
      Metrics({Robot({"A", "1"}, Well()), Robot({"B", "1"}, Well()), Robot({"B", "2"}, Well())});
  EXPECT_THAT(text, HasSubstr("driving{robot=\"A/1\"} 1\nfleetpub_robot_driving{robot=\"B/1\"} "
                              "1\nfleetpub_robot_driving{robot=\"B/2\"} 1\n# HELP "));
}

TEST(FleetMetrics, HoldWhatHostileRobotsSay) {
  LiveState state = Well();
  const double values[] = {std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity(),
                           std::numeric_limits<double>::quiet_NaN()};
  for (const double value : values) {
    state.battery_charge = value;
    EXPECT_THAT(Metrics({Robot({"KIT", "0001"}, state)}), Not(HasSubstr("charge_ratio{")));
  }
  state.battery_charge = -1e300;
  state.operating_mode = "X\"} 1\nevil 1";
  state.header.timestamp = "9999-12-31T23:59:59Z";
  ListedRobot robot = Robot({"K\"I\\T",
                             "\xe2\x80\xae"
                             "1"},
                            state);
  robot.second.connection->connection_state = "\n";
  const std::string text = Metrics({robot});
  EXPECT_THAT(text, ContainsRegex("\\} -1[.0-9]*e\\+298\n"));
  EXPECT_THAT(text, HasSubstr("mode=\"OTHER\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("state=\"OTHER\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("age_seconds{robot=\"K%22I%5CT/%E2%80%AE1\"} "));
  EXPECT_THAT(text, HasSubstr("manufacturer=\"K\\\"I\\\\T\"")) << "escaped";
  EXPECT_THAT(text, HasSubstr("serial_number=\"\\\\u202e1\""));
  EXPECT_THAT(text, AllOf(Not(HasSubstr("evil")), Not(HasSubstr("\xe2\x80\xae"))));
  EXPECT_THAT(text, ContainsRegex("age_seconds\\{[^\n]*\\} 0\n")) << "its clock is ahead";
  for (const std::string& line : base::Split(text, '\n')) {
    EXPECT_TRUE(line.empty() || line.starts_with("# ") || line.starts_with("fleetpub_")) << line;
  }
}

TEST(FleetMetrics, AreWrittenInPiecesHoweverManyRobotsThereAre) {
  const ListedRobot robot = Robot({"KIT", "0001"}, Well());
  const std::vector<const ListedRobot*> robots(2'000, &robot);
  std::size_t largest = 0;
  WriteFleetMetrics(robots, kNow, {},
                    [&](std::string_view more) { largest = std::max(largest, more.size()); });
  EXPECT_LT(largest, 1'000U);
}

TEST(FleetMetrics, SummariseTheTimesToConfirm) {
  std::vector<double> times;
  for (int i = 100; i >= 1; --i) times.push_back(i);
  const std::string text =
      Metrics({}, app::ConfirmTimes{{"instantActions", times}, {"order", {0.25}}});
  const std::string name = "\nfleetpub_command_confirmation_seconds";
  EXPECT_THAT(text, HasSubstr("# TYPE fleetpub_command_confirmation_seconds summary\n"));
  EXPECT_THAT(text, HasSubstr(name + "{topic=\"instantActions\",quantile=\"0.5\"} 50\n"));
  EXPECT_THAT(text, HasSubstr(name + "{topic=\"instantActions\",quantile=\"0.99\"} 99\n"));
  EXPECT_THAT(text, HasSubstr(name + "_sum{topic=\"instantActions\"} 5050\n"));
  EXPECT_THAT(text, HasSubstr(name + "_count{topic=\"instantActions\"} 100\n"));
  EXPECT_THAT(text, HasSubstr(name + "{topic=\"order\",quantile=\"0.99\"} 0.25\n"));
  EXPECT_THAT(Metrics({}, app::ConfirmTimes()), Not(HasSubstr("quantile")));
}

}  // namespace
}  // namespace fleetpub::cli
