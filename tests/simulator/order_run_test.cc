// How a robot drives an order, does its actions, and how that is seen in its states.
#include "simulator/order_run.h"

#include "simulator/order_story.h"

namespace fleetpub::simulator {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;
using vda5050::Version;

INSTANTIATE_TEST_SUITE_P(Versions, OrderRuns, ::testing::ValuesIn(vda5050::kVersions), VersionName);

// ---- Driving ----

TEST_P(OrderRuns, DriveNodeByNodeWithOneStateEach) {
  Conversation robot(Plain());
  Order(robot, {.stops = {{"n1"}, {"n2"}, {"n3"}}});
  robot.Wait(seconds(20));
  EXPECT_THAT(Story(robot),
              ElementsAre("n1:0 n2 e2 drives", "n2:2 n1 e1 drives", "n3:4 n0 e0 stands"));
}

TEST_P(OrderRuns, TakeAnOrderOfOneNode) {
  Conversation robot(Plain());
  Order(robot, {.stops = {{"n1", true, Act("a", "HARD")}}});
  EXPECT_EQ(robot.At("/nodeStates"), "[]");
  EXPECT_EQ(Actions(robot), "a RUNNING");
  robot.Wait(kActionTime);
  EXPECT_EQ(Actions(robot), "a FINISHED");
  EXPECT_EQ(robot.At("/lastNodeId"), R"("n1")");
  EXPECT_EQ(robot.At("/orderId"), R"("o1")");
}

TEST_P(OrderRuns, MoveAlongPositionsAtTheirSpeed) {
  Settings settings = Plain();
  settings.speed = 2;
  Conversation robot(settings);
  Order(robot,
        {.stops = {{"n1", true, "", At(10, 5)}, {"n2", true, "", At(10, 15, R"(,"theta":3)")}}});
  robot.Wait(seconds(2));
  robot.Do("stateRequest");
  EXPECT_DOUBLE_EQ(Number(robot, "x"), 10);
  EXPECT_DOUBLE_EQ(Number(robot, "y"), 9);
  EXPECT_NEAR(Number(robot, "theta"), 1.5708, 1e-3);
  EXPECT_EQ(robot.At("/distanceSinceLastNode"), "4.0");
  EXPECT_EQ(robot.At("/velocity/vx"), "2.0");
  robot.Wait(seconds(3));
  EXPECT_DOUBLE_EQ(Number(robot, "y"), 15);
  EXPECT_DOUBLE_EQ(Number(robot, "theta"), 3) << "before the node is reported";
  EXPECT_EQ(robot.At("/nodeStates"), "[]");
}

TEST_P(OrderRuns, KeepTheSpeedOfTheEdge) {
  Settings settings = Plain();
  settings.speed = 2;
  Conversation robot(settings);
  Order(robot,
        {.stops = {{"n1", true, "", At(0, 0)},
                   {"n2", true, "", At(4, 0), "", R"(,"maxSpeed":0.5,"maximumSpeed":0.5)"}}});
  robot.Wait(milliseconds(7999));
  EXPECT_EQ(robot.At("/driving"), "true");
  robot.Wait(milliseconds(1));
  EXPECT_EQ(robot.At("/driving"), "false");
}

TEST_P(OrderRuns, FollowTheirTrajectoryAndOrientation) {
  Conversation robot(Plain());
  Order(robot, {.stops = {{"n1", true, "", At(0, 0)},
                          {"n2", true, "", At(3, 4), "",
                           R"(,"orientation":3.14159,"trajectory":{"degree":1,
                "knotVector":[0,0,0.5,1,1],"controlPoints":[{"x":0,"y":0,"weight":1,
                "orientation":0},{"x":3,"y":0,"weight":1,"orientation":0},{"x":3,"y":4,"weight":1,
                "orientation":0}]})"}}});
  robot.Wait(seconds(5));
  robot.Do("stateRequest");
  EXPECT_NEAR(Number(robot, "x"), 3, 1e-3);
  EXPECT_NEAR(Number(robot, "y"), 2, 1e-3);
  const double backwards = GetParam() == Version::k110 ? 3.14159 : 3.14159 / 2 - 3.14159;
  EXPECT_NEAR(Number(robot, "theta"), backwards, 1e-2) << "1.1 knows the map's angles only";
}

TEST_P(OrderRuns, TakeTheirTimeWhereNothingSaysHowFarItIs) {
  Settings settings = Plain();
  settings.edge_time = seconds(4);
  settings.time_scale = 2;
  Conversation robot(settings);
  Order(robot, {.stops = {{"n1"}, {"n2"}, {"n3", true, "", "", "", R"(,"length":3)"}}});
  robot.Wait(seconds(2));
  EXPECT_EQ(robot.At("/lastNodeId"), R"("n2")");
  robot.Wait(milliseconds(1500));
  // 1.1's schema calls it distance; the text says length.
  EXPECT_EQ(robot.At("/lastNodeId"), R"("n3")");
}

TEST_P(OrderRuns, SpreadAnOrderOverItsTime) {
  Settings settings = Plain();
  settings.order_time = seconds(6);
  Conversation robot(settings);
  Order(robot, {.stops = {{"n1"}, {"n2"}, {"n3"}, {"n4"}}});
  robot.Wait(seconds(4));
  EXPECT_EQ(robot.At("/lastNodeId"), R"("n3")");
  robot.Wait(seconds(2));
  EXPECT_EQ(robot.At("/nodeStates"), "[]");
}

TEST_P(OrderRuns, TellNodesOfTheSameNameApart) {
  Conversation robot(Plain());
  Order(robot, {.stops = {{"n1"}, {"n2"}, {"n1"}, {"n2", true, Act("a", "HARD")}}});
  robot.Wait(kEdge * 2);
  EXPECT_EQ(robot.At("/lastNodeSequenceId"), "4");
  EXPECT_EQ(Actions(robot), "a WAITING");
  robot.Wait(kEdge + kActionTime);
  EXPECT_EQ(Actions(robot), "a FINISHED");
}

TEST_P(OrderRuns, UseTheirBatteryAndChargeIt) {
  Settings settings = Plain();
  settings.time_scale = 1000;
  settings.initial.battery = 50;
  Conversation robot(settings);
  const char* charge = Is30() ? "/powerSupply/stateOfCharge" : "/batteryState/batteryCharge";
  Order(robot, {.stops = {{"n1"},
                          {"n2", true, "", "", "", R"(,"length":2880,"distance":2880)"},
                          {"n3", true, Act("c", "HARD", "startCharging"), "", "",
                           R"(,"length":0,"distance":0)"}}});
  robot.Wait(seconds(3));
  EXPECT_EQ(Actions(robot), "c FINISHED");
  EXPECT_NEAR(std::stod(robot.At(charge)), 40, 0.5) << "48 minutes of eight hours";
  robot.Wait(milliseconds(360));
  robot.Do("stateRequest");
  EXPECT_GT(std::stod(robot.At(charge)), 45);
}

TEST_P(OrderRuns, ShowThemselvesBetweenStates) {
  Settings settings = Plain();
  settings.visualization_interval = seconds(1);
  Conversation robot(settings);
  Order(robot, {.stops = {{"n1", true, "", At(0, 0)}, {"n2", true, "", At(100, 0)}}});
  for (int i = 0; i < 5; ++i) robot.Wait(seconds(1));
  EXPECT_EQ(robot.Times("visualization"), 5U);
  const auto message = robot.Last("visualization");
  EXPECT_DOUBLE_EQ(
      base::JsonPointer((std::string(Position()) + "/x").c_str()).Get(message)->GetDouble(), 5);
  EXPECT_EQ(message.HasMember("referenceStateHeaderId"), Is30());
  schema::Registry registry;
  const std::string name =
      fmt::format("vda5050/{}/visualization", vda5050::GetFacts(GetParam()).name);
  EXPECT_THAT(registry.Find(name).value()->Validate(message), SizeIs(0));
}

// ---- Base, horizon, updates: the figures of the text ----

const std::vector<Stop> kFigure = {{"n1"}, {"n2"}, {"n3"}, {"n4", false}, {"n5", false}};

TEST_P(OrderRuns, StopWhereTheBaseEnds) {
  Conversation robot(Plain());
  Order(robot, {.stops = kFigure});
  EXPECT_EQ(Ahead(robot, "nodeStates"), "2 4 6h 8h");
  EXPECT_EQ(Ahead(robot, "edgeStates"), "1 3 5h 7h");
  EXPECT_EQ(robot.At("/newBaseRequest"), "false");
  robot.Wait(kEdge);
  EXPECT_EQ(robot.At("/newBaseRequest"), "true") << "one node before it is short";
  robot.Wait(kEdge * 5);
  EXPECT_EQ(Ahead(robot, "nodeStates"), "6h 8h");
  EXPECT_EQ(Ahead(robot, "edgeStates"), "5h 7h");
  EXPECT_EQ(robot.At("/driving"), "false");
  EXPECT_EQ(robot.At("/newBaseRequest"), "true");
  EXPECT_EQ(robot.At("/lastNodeId"), R"("n3")");
}

TEST_P(OrderRuns, DriveOnWithoutAStopWhenTheUpdateComesInTime) {
  Conversation robot(Plain());
  Order(robot, {.stops = kFigure});
  robot.Wait(kEdge);
  Order(robot, {"o1", 1, {{"n3"}, {"n4"}, {"n5"}, {"n6", false}}, 4});
  EXPECT_EQ(Ahead(robot, "nodeStates"), "4 6 8 10h");
  EXPECT_EQ(Ahead(robot, "edgeStates"), "3 5 7 9h");
  EXPECT_EQ(robot.At("/newBaseRequest"), "false");
  robot.Wait(kEdge * 9);
  for (const std::string& line : Story(robot)) {
    EXPECT_THAT(line, HasSubstr(line.substr(0, 2) == "n5" ? "stands" : "drives"));
  }
  EXPECT_EQ(robot.At("/lastNodeId"), R"("n5")");
}

TEST_P(OrderRuns, ReplaceTheHorizonByAnotherWay) {
  Conversation robot(Plain());
  Order(robot, {.stops = {{"n1"}, {"n2"}, {"n3", false, Act("h", "HARD")}}});
  EXPECT_EQ(Actions(robot), "h WAITING") << "of the horizon, too";
  Order(robot, {"o1", 1, {{"n2"}, {"m3", true, Act("i", "NONE")}, {"m4", false}}, 2});
  EXPECT_EQ(Ahead(robot, "nodeStates"), "2 4 6h");
  EXPECT_EQ(robot.At("/nodeStates/1/nodeId"), R"("m3")");
  EXPECT_EQ(Actions(robot), "i WAITING");
}

TEST_P(OrderRuns, DropTheHorizonForAnUpdateOfOneNode) {
  Conversation robot(Plain());
  Order(robot, {.stops = kFigure});
  robot.Wait(kEdge * 5);
  Order(robot, {"o1", 1, {{"n3"}}, 4});
  EXPECT_EQ(robot.At("/nodeStates"), "[]");
  EXPECT_EQ(robot.At("/edgeStates"), "[]");
  EXPECT_EQ(robot.At("/newBaseRequest"), "false");
  Order(robot, {"o2", 0, {{"n3"}, {"n9"}}});
  EXPECT_EQ(robot.At("/orderId"), R"("o2")") << "it is idle";
}

TEST_P(OrderRuns, DoTheActionsOfTheStitchedNodeOnce) {
  Conversation robot(Plain());
  const Stop stitch = {"n2", true, Act("a", "HARD")};
  Order(robot, {.stops = {{"n1"}, stitch, {"n3", false}}});
  robot.Wait(kEdge + kActionTime);
  EXPECT_EQ(Actions(robot), "a FINISHED");
  Order(robot, {"o1", 1, {stitch, {"n3", true, Act("b", "NONE")}}, 2});
  EXPECT_EQ(Actions(robot), "a FINISHED, b WAITING");
  robot.Wait(kEdge * 3);
  EXPECT_EQ(Actions(robot), "a FINISHED, b FINISHED");
}

// Figure 7 of 3.0: new actions where it stands come with a loop edge.
TEST_P(OrderRuns, DoNewActionsWhereTheyStandAtALoop) {
  Conversation robot(Plain());
  const Stop end = {"n2", true, Act("a", "HARD"), At(1, 0)};
  Order(robot, {.stops = {{"n1", true, "", At(0, 0)}, end}});
  robot.Wait(seconds(2));
  Order(robot, {"o1", 1, {end, {"n2", true, Act("b", "HARD"), At(1, 0)}}, 2});
  robot.Wait(seconds(2));
  EXPECT_EQ(robot.At("/lastNodeSequenceId"), "4");
  EXPECT_EQ(Actions(robot), "a FINISHED, b FINISHED");
}

TEST_P(OrderRuns, ForgetActionsWithANewOrderOnly) {
  Conversation robot(Plain());
  Order(robot, {.stops = {{"n1", true, Act("a", "NONE")}}});
  robot.Wait(kActionTime);
  Order(robot, {"o1", 1, {{"n1"}, {"n2"}}});
  EXPECT_EQ(Actions(robot), "a FINISHED");
  robot.Wait(kEdge);
  Order(robot, {"o2", 0, {{"n2"}, {"n3"}}});
  EXPECT_EQ(Actions(robot), "");
}

// ---- Actions ----

TEST_P(OrderRuns, StandForHardAndDriveForNone) {
  Conversation robot(Plain());
  Order(robot,
        {.stops = {{"n1", true, Act("a", "NONE") + "," + Act("b", "HARD") + "," + Act("c", "NONE")},
                   {"n2"}}});
  for (int i = 0; i < 25; ++i) robot.Wait(milliseconds(100));
  EXPECT_THAT(Queue(robot), ElementsAre("stands: a RUNNING, b WAITING, c WAITING",
                                        "stands: a FINISHED, b RUNNING, c WAITING",
                                        "drives: a FINISHED, b FINISHED, c RUNNING",
                                        "drives: a FINISHED, b FINISHED, c FINISHED",
                                        "stands: a FINISHED, b FINISHED, c FINISHED"));
}

TEST_P(OrderRuns, DoSoftActionsTogetherStanding) {
  Conversation robot(Plain());
  Order(robot, {.stops = {{"n1", true, Act("a", "SOFT") + "," + Act("b", "SOFT")}, {"n2"}}});
  EXPECT_EQ(Queue(robot).back(), "stands: a RUNNING, b RUNNING");
  robot.Wait(kActionTime);
  EXPECT_EQ(Queue(robot).back(), "drives: a FINISHED, b FINISHED");
}

TEST(OrderRunsOf30, DoSingleActionsAloneDriving) {
  Conversation robot(Settings{.version = Version::k300});
  robot.Hear("order",
             Write({.stops = {{"n1", true, Act("a", "SINGLE") + "," + Act("b", "NONE")}, {"n2"}}},
                   Version::k300));
  EXPECT_EQ(Queue(robot).back(), "drives: a RUNNING, b WAITING");
  robot.Wait(kActionTime);
  EXPECT_EQ(Queue(robot).back(), "drives: a FINISHED, b RUNNING");
}

TEST_P(OrderRuns, LetEdgeActionsWaitUntilTheyDriveOn) {
  Conversation robot(Plain());
  Order(robot, {.stops = {{"n1", true, Act("a", "HARD")}, {"n2", true, "", "", Act("e", "NONE")}}});
  EXPECT_EQ(Queue(robot).back(), "stands: a RUNNING, e WAITING");
  robot.Wait(kActionTime);
  EXPECT_EQ(Queue(robot).back(), "drives: a FINISHED, e RUNNING");
}

TEST_P(OrderRuns, DoHardEdgeActionsBeforeTheEdge) {
  Conversation robot(Plain());
  Order(robot, {.stops = {{"n1"}, {"n2", true, "", "", Act("e", "HARD")}}});
  EXPECT_EQ(Queue(robot).back(), "stands: e RUNNING");
  robot.Wait(kActionTime);
  EXPECT_EQ(Queue(robot).back(), "drives: e FINISHED");
}

TEST_P(OrderRuns, EndEdgeActionsWithTheEdge) {
  Settings settings = Plain();
  settings.delay = seconds(60);
  Conversation robot(settings);
  Order(robot, {.stops = {{"n1", true, Act("a", "NONE")}, {"n2", true, "", "", Act("e", "NONE")}}});
  robot.Wait(kEdge);
  EXPECT_EQ(Queue(robot).back(), "stands: a RUNNING, e FINISHED") << "a node's may outlive it";
}

TEST_P(OrderRuns, PickAndDropTheirLoads) {
  Conversation robot(Plain());
  const std::string what = R"(,"actionParameters":[{"key":"loadType","value":"EPAL"},
      {"key":"loadId","value":"L1"},{"key":"stationType","value":"floor"}])";
  Order(robot, {.stops = {{"n1", true, Act("p", "HARD", "pick", what)},
                          {"n2", true, Act("d", "HARD", "drop", what)}}});
  robot.Wait(kActionTime);
  EXPECT_EQ(robot.At("/loads"), R"([{"loadId":"L1","loadType":"EPAL"}])");
  robot.Wait(kEdge + kActionTime);
  EXPECT_EQ(robot.At("/loads"), "[]");
  EXPECT_EQ(Actions(robot), "p FINISHED, d FINISHED");
}

TEST_P(OrderRuns, KeepTheOrderWhenAnActionFails) {
  Settings settings = Plain();
  settings.fail = {"pick"};
  Conversation robot(settings);
  Order(robot, {.stops = {{"n1", true, Act("p", "HARD", "pick", R"(,"actionParameters":[
      {"key":"loadType","value":"EPAL"},{"key":"stationType","value":"floor"}])")},
                          {"n2"}}});
  robot.Wait(kActionTime);
  EXPECT_EQ(Actions(robot), "p FAILED");
  EXPECT_EQ(robot.At("/nodeStates/0/nodeId"), R"("n2")");
  EXPECT_THAT(robot.At("/errors/0/errorReferences"), HasSubstr(R"("p")"));
  EXPECT_EQ(robot.At("/errors/0/errorLevel"), Is30() ? R"("CRITICAL")" : R"("WARNING")");
  EXPECT_EQ(robot.At("/driving"), Is30() ? "false" : "true");
  robot.Do("cancelOrder");
  Order(robot, {"o2", 0, {{"n1"}, {"n2"}}});
  EXPECT_EQ(robot.At("/driving"), "true");
}

TEST(OrderRunsOf30, TryAgainWhatIsRetriable) {
  for (const bool skips : {false, true}) {
    Settings settings{.version = Version::k300, .retriable = {"detectObject"}};
    Conversation robot(settings);
    robot.Hear(
        "order",
        Write({.stops = {{"n1", true, Act("a", "NONE", "detectObject", R"(,"retriable":true)")},
                         {"n2"}}},
              Version::k300));
    robot.Wait(kActionTime);
    EXPECT_EQ(Queue(robot).back(), "stands: a RETRIABLE") << "the order waits";
    robot.Hear("order", Write({"o2", 0, {{"n1"}}}, Version::k300));
    EXPECT_EQ(robot.At("/errors/0/errorType"), R"("OTHER_ORDER_ACTIVE")");
    robot.Do(skips ? "skipRetry" : "retry", {{"actionId", R"("a")"}});
    robot.Wait(kActionTime);
    EXPECT_EQ(Queue(robot).back(), skips ? "drives: a FAILED" : "drives: a FINISHED");
  }
}

TEST_P(OrderRuns, WaitForATrigger) {
  Conversation robot(Plain());
  const std::string who = Is30() ? R"(["FLEET_CONTROL"])" : R"("button")";
  Order(robot,
        {.stops = {{"n1", true,
                    Act("w", "HARD", "waitForTrigger",
                        R"(,"actionParameters":[{"key":"triggerType","value":)" + who + "}]")},
                   {"n2"}}});
  robot.Wait(seconds(3));
  EXPECT_EQ(Queue(robot).back(), Is30() ? "stands: w RUNNING" : "stands: w FINISHED");
  if (!Is30()) return;  // no message triggers it
  robot.Do("trigger");
  EXPECT_EQ(Queue(robot).back(), "drives: w FINISHED");
}

// ---- When a state is due ----

TEST_P(OrderRuns, PutWhatBelongsTogetherIntoOneState) {
  Conversation robot(Plain());
  const auto states = robot.Times("state");
  Order(robot, {.stops = {{"n1"}, {"n2", true, Act("a", "HARD"), "", Act("e", "NONE")}, {"n3"}}});
  EXPECT_EQ(robot.Times("state"), states + 1) << "accepted, driving, e RUNNING";
  robot.Wait(kActionTime);
  EXPECT_EQ(robot.Times("state"), states + 2) << "e FINISHED";
  robot.Wait(kEdge - kActionTime);
  EXPECT_EQ(robot.Times("state"), states + 3) << "node and edge gone, standing, a RUNNING";
}

TEST_P(OrderRuns, LeaveTimeBetweenStates) {
  Settings settings = Plain();
  settings.min_state_interval = seconds(1);
  Conversation robot(settings);
  for (int i = 0; i < 5; ++i) robot.Do("stateRequest");
  EXPECT_EQ(robot.Times("state"), 1U);
  robot.Wait(milliseconds(999));
  EXPECT_EQ(robot.Times("state"), 1U);
  robot.Wait(milliseconds(1));
  EXPECT_EQ(robot.Times("state"), 2U);
}

TEST_P(OrderRuns, SayOnlyWhatSatisfiesTheSchema) {
  Settings settings = Plain();
  settings.visualization_interval = seconds(1);
  Conversation robot(settings);
  Order(robot,
        {.stops = {
             {"n1", true, Act("a", "SOFT"), At(0, 0)}, {"n2", true, "", At(3, 4)}, {"n3", false}}});
  robot.Hear("order", Write({"o1", 3, {{"nx"}}, 4}, GetParam()));
  for (int i = 0; i < 10; ++i) robot.Wait(seconds(1));
  robot.Do("cancelOrder");
  schema::Registry registry;
  for (const Utterance& one : robot.said()) {
    const std::string name =
        fmt::format("vda5050/{}/{}", vda5050::GetFacts(GetParam()).name, one.topic);
    EXPECT_THAT(registry.Find(name).value()->Validate(*base::ParseJson(one.payload)), SizeIs(0))
        << one.payload;
  }
}

}  // namespace
}  // namespace fleetpub::simulator
