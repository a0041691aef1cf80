// What interrupts a robot that drives: pausing, cancelling, modes, a lost connection.
#include "simulator/order_story.h"

namespace fleetpub::simulator {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::ElementsAre;

class Interruptions : public OrderRuns {};

INSTANTIATE_TEST_SUITE_P(Versions, Interruptions, ::testing::ValuesIn(vda5050::kVersions),
                         VersionName);

TEST_P(Interruptions, FreezeWhileTheyArePaused) {
  Conversation robot(Plain());
  Order(robot, {.stops = {{"n1", true, Act("a", "NONE")}, {"n2"}, {"n3"}}});
  robot.Wait(milliseconds(100));
  robot.Do("startPause");
  EXPECT_EQ(Queue(robot).back(), "stands: a PAUSED");
  robot.Wait(seconds(29));
  EXPECT_EQ(robot.At("/lastNodeId"), R"("n1")");
  robot.Do("stopPause");
  EXPECT_EQ(Queue(robot).back(), "drives: a RUNNING");
  robot.Wait(milliseconds(100));
  EXPECT_EQ(Queue(robot).back(), "drives: a FINISHED");
  robot.Wait(milliseconds(1799));
  EXPECT_EQ(robot.At("/lastNodeId"), R"("n1")");
  robot.Wait(milliseconds(1));
  EXPECT_EQ(robot.At("/lastNodeId"), R"("n2")");
}

TEST_P(Interruptions, TakeOrdersWhilePausedButDoNotDrive) {
  Conversation robot(Plain());
  robot.Do("startPause");
  Order(robot, {.stops = {{"n1", true, Act("a", "NONE")}, {"n2"}}});
  EXPECT_EQ(Queue(robot).back(), "stands: a WAITING");
  robot.Do("cancelOrder");
  EXPECT_EQ(Queue(robot).back(), "stands: a FAILED");
}

TEST_P(Interruptions, CancelInSteps) {
  Conversation robot(Plain());
  Order(robot, {.stops = {{"n1", true, Act("a", "NONE")}, {"n2", true, Act("b", "HARD")}}});
  robot.Wait(milliseconds(100));
  const auto states = robot.Times("state");
  const auto id = robot.Do("cancelOrder");
  EXPECT_EQ(robot.Times("state"), states + 2);
  std::vector<std::string> story;
  for (auto one = robot.said().end() - 2; one != robot.said().end(); ++one) {
    const auto state = *base::ParseJson(one->payload);
    const auto* cancel = base::FindArray(state, Is30() ? "instantActionStates" : "actionStates");
    story.push_back(std::string(base::StringMember((*cancel)[cancel->Size() - 1], "actionStatus")) +
                    (state["driving"].GetBool() ? " drives" : " stands"));
  }
  EXPECT_THAT(story, ElementsAre("RUNNING stands", "FINISHED stands"));
  EXPECT_EQ(robot.At("/nodeStates"), "[]");
  EXPECT_EQ(robot.At("/edgeStates"), "[]");
  EXPECT_EQ(robot.At("/orderId"), R"("o1")");
  EXPECT_EQ(robot.At("/lastNodeId"), R"("n1")");
  EXPECT_EQ(robot.Of("a"), "FAILED");
  EXPECT_EQ(robot.Of("b"), "FAILED");
  EXPECT_EQ(robot.Of(id), "FINISHED");
}

TEST_P(Interruptions, TellThatTheyCancelHoweverRarelyTheySpeak) {
  Settings settings = Plain();
  settings.min_state_interval = seconds(1);
  Conversation robot(settings);
  robot.Wait(seconds(1));
  Order(robot, {.stops = {{"n1"}, {"n2"}, {"n3"}}});
  const auto id = robot.Do("cancelOrder");
  robot.Wait(seconds(1));
  EXPECT_EQ(robot.Of(id), "RUNNING");
  robot.Wait(seconds(1));
  EXPECT_EQ(robot.Of(id), "FINISHED");
}

TEST_P(Interruptions, CancelOnlyAfterALoadIsSafe) {
  Conversation robot(Plain());
  Order(robot, {.stops = {{"n1", true, Act("p", "HARD", "pick", R"(,"actionParameters":[
      {"key":"loadType","value":"EPAL"},{"key":"stationType","value":"floor"}])")},
                          {"n2"}}});
  const auto id = robot.Do("cancelOrder");
  EXPECT_EQ(robot.Of(id), "RUNNING");
  EXPECT_NE(robot.At("/nodeStates"), "[]");
  robot.Wait(kActionTime);
  EXPECT_EQ(robot.Of(id), "FINISHED");
  EXPECT_EQ(robot.Of("p"), "FINISHED");
  EXPECT_EQ(robot.At("/nodeStates"), "[]");
}

TEST_P(Interruptions, GoOnFromWhereTheyWereCancelled) {
  const std::string wide =
      Is30() ? R"(,"allowedDeviationXY":{"a":9,"b":9,"theta":0})" : R"(,"allowedDeviationXY":9)";
  const std::vector<Stop> starts = {{"here", true, "", At(4, 0)}, {"n1", true, "", At(0, 0, wide)}};
  for (const Stop& start : starts) {
    Conversation robot(Plain());
    Order(robot, {.stops = {{"n1", true, "", At(0, 0)}, {"n2", true, "", At(10, 0)}}});
    robot.Wait(seconds(4));
    robot.Do("cancelOrder");
    EXPECT_DOUBLE_EQ(Number(robot, "x"), 4);
    Order(robot, {"o2", 0, {start, {"n2", true, "", At(10, 0)}}});
    robot.Wait(seconds(6));
    EXPECT_EQ(robot.At("/lastNodeId"), R"("n2")");
  }
}

TEST_P(Interruptions, EndWhenTheModeTakesThemAway) {
  struct Case {
    const char* mode;
    bool ends;
    bool forgets;
  };
  const std::vector<Case> cases =
      Is30() ? std::vector<Case>{{"MANUAL", true, false},      {"STARTUP", true, false},
                                 {"SERVICE", true, true},      {"TEACH_IN", true, true},
                                 {"INTERVENED", false, false}, {"SEMIAUTOMATIC", false, false}}
             : std::vector<Case>{{"MANUAL", true, false}, {"SEMIAUTOMATIC", false, false}};
  for (const auto& [mode, ends, forgets] : cases) {
    SCOPED_TRACE(mode);
    Settings settings = Plain();
    settings.mode_changes = {{seconds(1), mode}, {seconds(10), "AUTOMATIC"}};
    Conversation robot(settings);
    Order(robot, {.stops = {{"n1"}, {"n2", true, Act("a", "HARD")}}});
    robot.Wait(seconds(1));
    EXPECT_EQ(robot.At("/operatingMode"), '"' + std::string(mode) + '"');
    EXPECT_EQ(robot.At("/nodeStates") == "[]", ends);
    EXPECT_EQ(robot.Of("a"), ends ? "FAILED" : "WAITING");
    EXPECT_EQ(robot.At("/orderId"), R"("o1")");
    EXPECT_EQ(robot.At("/lastNodeId"), forgets ? R"("")" : R"("n1")");
    robot.Wait(seconds(10));
    robot.Wait(seconds(10));
    EXPECT_EQ(robot.Of("a"), ends ? "FAILED" : "FINISHED");
  }
}

TEST_P(Interruptions, DriveTheBaseToItsEndWithoutAConnection) {
  Conversation robot(Plain());
  Order(robot, {.stops = {{"n1"}, {"n2"}, {"n3"}, {"n4", false}}});
  robot.Reconnect(seconds(60));
  EXPECT_EQ(robot.Connections(), "ONLINE ONLINE");
  EXPECT_EQ(robot.At("/lastNodeId"), R"("n3")");
  EXPECT_EQ(Ahead(robot, "nodeStates"), "6h");
}

}  // namespace
}  // namespace fleetpub::simulator
