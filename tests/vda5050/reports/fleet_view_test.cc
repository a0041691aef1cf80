#include "vda5050/reports/fleet_view.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

namespace fleetpub::vda5050 {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::IsNull;
using ::testing::NotNull;
using ::testing::SizeIs;

std::string Header(std::string_view version, int second) {
  return fmt::format(R"("headerId":1,"timestamp":"2026-01-02T03:04:{:02}.000Z","version":"{}")",
                     second, version);
}

std::string Connection(std::string_view version, std::string_view state, int second = 0) {
  return fmt::format(R"({{{},"connectionState":"{}"}})", Header(version, second), state);
}

std::string State(std::string_view version, std::string_view members, int second = 0) {
  return fmt::format(R"({{{},{}}})", Header(version, second), members);
}

class FleetViewTest : public ::testing::Test {
 protected:
  const RobotView* Live(std::string_view topic, std::string_view payload) {
    return view_.Deliver(topic, payload, Origin::kLive);
  }
  const RobotView* Retained(std::string_view topic, std::string_view payload) {
    return view_.Deliver(topic, payload, Origin::kRetained);
  }
  [[nodiscard]] std::vector<std::string> Robots() const {
    std::vector<std::string> names;
    for (const RobotView* robot : view_.robots()) names.push_back(robot->robot.ToString());
    return names;
  }

  FleetView view_{TopicScheme{}, {}};
};

TEST_F(FleetViewTest, KnowsARobotByItsConnection) {
  const RobotView* robot =
      Retained("uagv/v2/KIT/1/connection", Connection("2.0.0", "CONNECTIONBROKEN"));
  ASSERT_THAT(robot, NotNull());
  EXPECT_EQ(robot->robot.ToString(), "KIT/1");
  EXPECT_EQ(robot->version, Version::k200);
  EXPECT_EQ(robot->interface_name, "uagv");
  EXPECT_EQ(robot->topic_level, "v2");
  EXPECT_EQ(robot->connection_state, "CONNECTION_BROKEN");
  EXPECT_EQ(robot->connection_timestamp, "2026-01-02T03:04:00.000Z");
  EXPECT_FALSE(robot->IsOnline());
  EXPECT_FALSE(robot->state);
}

TEST_F(FleetViewTest, KnowsARobotThatOnlySendsStates) {
  const RobotView* robot = Live("vda5050/v3/KIT/1/state", State("3.0.0", R"("paused":true)"));
  ASSERT_THAT(robot, NotNull());
  EXPECT_EQ(robot->version, Version::k300);
  EXPECT_EQ(robot->connection_state, "");
  EXPECT_EQ(robot->state->paused, true);
}

TEST_F(FleetViewTest, JoinsWhatBelongsToOneRobotAndOrdersByAddress) {
  Retained("vda5050/v3/KIT/2/connection", Connection("3.0.0", "ONLINE"));
  Retained("vda5050/v3/KIT/1/connection", Connection("3.0.0", "ONLINE"));
  Retained("uagv/v2/ACME/9/connection", Connection("2.1.0", "OFFLINE"));
  Live("vda5050/v3/KIT/1/state", State("3.0.0", R"("driving":false)"));
  EXPECT_THAT(Robots(), ElementsAre("ACME/9", "KIT/1", "KIT/2"));
  EXPECT_TRUE(view_.robots()[1]->IsOnline());
  EXPECT_EQ(view_.robots()[1]->state->driving, false);
}

TEST_F(FleetViewTest, PrefersTheConnectionThatIsOnline) {
  Retained("uagv/v2/KIT/1/connection", Connection("2.1.0", "OFFLINE", 9));
  Retained("vda5050/v3/KIT/1/connection", Connection("3.0.0", "ONLINE", 1));
  ASSERT_THAT(view_.robots(), SizeIs(1));
  EXPECT_EQ(view_.robots()[0]->version, Version::k300);
  Live("vda5050/v3/KIT/1/connection", Connection("3.0.0", "OFFLINE", 10));
  EXPECT_EQ(view_.robots()[0]->connection_state, "OFFLINE");
}

TEST_F(FleetViewTest, ForgetsAConnectionThatIsDeleted) {
  Retained("vda5050/v3/KIT/1/connection", Connection("3.0.0", "ONLINE"));
  const RobotView* robot = Live("vda5050/v3/KIT/1/connection", "");
  ASSERT_THAT(robot, NotNull());
  EXPECT_EQ(robot->connection_state, "");
  EXPECT_THAT(Live("vda5050/v3/KIT/1/connection", ""), IsNull());
}

TEST_F(FleetViewTest, ShowsNobodyByARetainedState) {
  const RobotView* robot = Retained("uagv/v2/KIT/1/state", State("2.1.0", R"("paused":true)", 5));
  ASSERT_THAT(robot, NotNull()) << "there is a robot";
  EXPECT_EQ(robot->version, Version::k210);
  EXPECT_FALSE(robot->state) << "how it is, nobody knows";
  EXPECT_FALSE(robot->HasSpoken());
  Live("uagv/v2/KIT/1/state", State("2.1.0", R"("paused":false)", 1));
  Retained("uagv/v2/KIT/1/state", State("2.1.0", R"("paused":true)", 9));
  EXPECT_EQ(view_.robots().front()->state->paused, false);
}

TEST_F(FleetViewTest, TakesNoOlderStateThatArrivesLate) {
  const auto paused = [&] { return view_.robots().front()->state->paused; };
  Live("uagv/v2/KIT/1/state", State("2.1.0", R"("paused":true)", 5));
  EXPECT_THAT(Live("uagv/v2/KIT/1/state", State("2.1.0", R"("paused":false)", 4)), IsNull());
  EXPECT_EQ(paused(), true);
  Live("uagv/v2/KIT/1/connection", Connection("2.1.0", "ONLINE", 3));
  Live("uagv/v2/KIT/1/state", State("2.1.0", R"("paused":false)", 3));
  EXPECT_EQ(paused(), false) << "it has begun anew";
}

TEST_F(FleetViewTest, ShowsARobotWhereItSpeaksAndNamesTheOtherPlace) {
  Retained("uagv/v2/KIT/1/connection", Connection("2.1.0", "ONLINE", 50));
  Retained("vda5050/v3/KIT/1/connection", Connection("3.0.0", "ONLINE", 1));
  EXPECT_EQ(view_.robots().front()->also_at, "vda5050/v3");
  Live("vda5050/v3/KIT/1/state", State("3.0.0", R"("operatingMode":"AUTOMATIC")", 2));
  const RobotView* robot = view_.robots().front();
  EXPECT_EQ(robot->version, Version::k300);
  EXPECT_EQ(robot->also_at, "uagv/v2");
  EXPECT_EQ(robot->connection_timestamp, "2026-01-02T03:04:01.000Z");
  EXPECT_THAT(Live("uagv/v2/KIT/1/state", State("2.1.0", R"("operatingMode":"MANUAL")", 51)),
              IsNull());
  EXPECT_EQ(robot->state->operating_mode, "AUTOMATIC") << "nothing is mixed";
  Live("vda5050/v3/KIT/1/connection", Connection("3.0.0", "OFFLINE", 3));
  EXPECT_EQ(robot->version, Version::k210);
  EXPECT_FALSE(robot->state);
}

TEST_F(FleetViewTest, TellsThatAConnectionCannotBeRead) {
  const RobotView* robot =
      Retained("uagv/v2/KIT/1/connection", R"([{"connectionState":"ONLINE"}])");
  ASSERT_THAT(robot, NotNull());
  EXPECT_NE(robot->connection_fault, "");
  EXPECT_FALSE(robot->IsOnline());
  Live("uagv/v2/KIT/1/connection", Connection("2.1.0", "ONLINE"));
  EXPECT_EQ(view_.robots().front()->connection_fault, "");
}

TEST_F(FleetViewTest, PassesOverWhatTellsNothing) {
  EXPECT_THAT(Live("vda5050/v3/KIT/1/connection", ""), IsNull());
  for (const char* payload : {"", "{", "[]", "\xFF"}) {
    EXPECT_THAT(Live("vda5050/v3/KIT/1/state", payload), IsNull()) << payload;
  }
  EXPECT_THAT(Live("vda5050/v3/KIT/1/order", State("3.0.0", R"("a":1)")), IsNull());
  EXPECT_THAT(Live("a/b/c", Connection("3.0.0", "ONLINE")), IsNull());
  EXPECT_THAT(Robots(), IsEmpty());
}

TEST_F(FleetViewTest, TellsThatAStateCannotBeRead) {
  Live("vda5050/v3/KIT/1/connection", Connection("3.0.0", "ONLINE"));
  const RobotView* robot = Live("vda5050/v3/KIT/1/state",
                                R"({"x":)" + std::string(65, '[') + std::string(65, ']') + "}");
  ASSERT_THAT(robot, NotNull());
  EXPECT_THAT(robot->state_fault, ::testing::HasSubstr("64 levels"));
  EXPECT_TRUE(robot->HasSpoken());
  Live("vda5050/v3/KIT/1/state", State("3.0.0", R"("paused":true)"));
  EXPECT_EQ(view_.robots().front()->state_fault, "");
}

TEST_F(FleetViewTest, ShowsARobotOfAnUnknownVersion) {
  const RobotView* robot = Live("x/v9/KIT/1/connection", Connection("9.1.0", "ONLINE"));
  ASSERT_THAT(robot, NotNull());
  EXPECT_EQ(robot->version, std::nullopt);
  EXPECT_EQ(robot->header_version, "9.1.0");
}

TEST(FleetView, SubscribesToWhatItsPatternMeans) {
  const FleetView all({}, {});
  EXPECT_THAT(*all.Filters(), ElementsAre("+/+/+/+/state", "+/+/+/+/connection"));
  const FleetView one({.interface_name = "agv"}, {*ParseRobotPattern("KIT/0*")});
  EXPECT_THAT(*one.Filters(), ElementsAre("agv/+/KIT/+/state", "agv/+/KIT/+/connection"));
}

TEST(FleetView, KeepsToItsPattern) {
  FleetView view({.interface_name = "agv"}, {*ParseRobotPattern("KIT/0*")});
  const std::string payload = Connection("3.0.0", "ONLINE");
  EXPECT_THAT(view.Deliver("agv/v3/KIT/1/connection", payload, Origin::kLive), IsNull());
  const RobotView* robot = view.Deliver("agv/v3/KIT/01/connection", payload, Origin::kLive);
  ASSERT_THAT(robot, NotNull());
  EXPECT_EQ(robot->interface_name, "agv");
}

// What 20,000 robots with long errors take.
TEST(FleetView, KeepsNoMoreThanItCan) {
  FleetView view({}, {});
  const std::string error = R"({"errorType":"stuck","errorLevel":"FATAL","errorDescription":")" +
                            std::string(50'000, 'x') +
                            R"("},{"errorType":"dull","errorLevel":"WARNING"})";
  const auto state = [&](std::string_view errors) {
    return State("3.0.0", fmt::format(R"("errors":[{}])", errors));
  };
  const auto topic = [](int robot) { return fmt::format("vda5050/v3/KIT/{}/state", robot); };
  constexpr int kRobots = 600;
  for (int robot = 0; robot < kRobots; ++robot) {
    ASSERT_THAT(view.Deliver(topic(robot), state(error), Origin::kLive), NotNull());
  }
  std::size_t kept = 0;
  for (const RobotView* robot : view.robots()) kept += robot->state->errors[0].description.size();
  EXPECT_LT(kept, 21U << 20);
  EXPECT_GT(kept, 15U << 20);
  EXPECT_GT(view.abridged(), 100U);
  const RobotView* last = view.Deliver(topic(kRobots - 1), state(error), Origin::kLive);
  EXPECT_THAT(last->state->errors, SizeIs(1));
  EXPECT_EQ(last->state->errors[0].level, "FATAL");
  EXPECT_EQ(last->errors_left_out, 1U);
  // What is no longer said makes room.
  for (int robot = 0; robot < kRobots; ++robot) {
    view.Deliver(topic(robot), state(""), Origin::kLive);
  }
  EXPECT_EQ(view.abridged(), 0U);
  EXPECT_THAT(view.Deliver(topic(1), state(error), Origin::kLive)->state->errors, SizeIs(2));
}

TEST(WorstError, IsTheOneWhoseLevelWeighsMost) {
  EXPECT_THAT(WorstError({}), IsNull());
  const std::vector<RobotError> errors = {{.type = "a", .level = "ODD"},
                                          {.type = "b", .level = "URGENT"},
                                          {.type = "c", .level = "CRITICAL"},
                                          {.type = "d", .level = "WARNING"}};
  EXPECT_EQ(WorstError(errors)->type, "c");
}

}  // namespace
}  // namespace fleetpub::vda5050
