#include "cli/output/robot_detail.h"

#include <gmock/gmock.h>

#include "base/width.h"

namespace fleetpub::cli {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

vda5050::ListedRobot Robot() {
  vda5050::ListedRobot robot({"KIT", "0001"}, {});
  robot.second.base = std::make_shared<const vda5050::Dialect>();
  robot.second.place = "uagv/v2";
  return robot;
}

TEST(RobotLines, SayAllThatIsKnown) {
  auto robot = Robot();
  vda5050::LiveState state;
  state.emergency_stop = "MANUAL";
  state.order_id = "o-1";
  state.nodes_left = 3;
  state.position = vda5050::RobotPosition{.x = 1, .y = 2, .map_id = "hall", .localized = false};
  state.action_states = {{.id = "a", .type = "pick", .status = "RUNNING"}};
  state.errors = {{.type = "stuck", .level = "FATAL", .description = "wheel", .hint = "push"}};
  robot.second.state = std::make_shared<const vda5050::LiveState>(state);
  const auto lines = RobotLines(robot, {}, std::chrono::seconds(4), 80, Output({}));
  for (const char* text : {"uagv/v2", "E-STOP", "MANUAL", "o-1", "to go 3", "map hall",
                           "not localized", "pick RUNNING", "stuck: wheel", "push", "4 s old"}) {
    EXPECT_THAT(lines, Contains(HasSubstr(text)));
  }
}

TEST(RobotLines, SayThatNoStateWasHeard) {
  EXPECT_THAT(RobotLines(Robot(), {}, {}, 80, Output({})), Contains(HasSubstr("none was heard")));
}

TEST(RobotLines, GoOnBelowAndBreakNoTerminal) {
  auto robot = Robot();
  vda5050::LiveState state;
  state.errors = {{.type = "\x1b[2J", .level = "FATAL", .description = std::string(90, 'x')}};
  robot.second.state = std::make_shared<const vda5050::LiveState>(state);
  for (const std::size_t width : {40U, 13U, 1U}) {
    for (const std::string& line : RobotLines(robot, {}, {}, width, Output({}))) {
      EXPECT_LE(base::MeasureWidth(line), width) << line;
      EXPECT_THAT(line, Not(HasSubstr("\x1b")));
    }
  }
}

}  // namespace
}  // namespace fleetpub::cli
