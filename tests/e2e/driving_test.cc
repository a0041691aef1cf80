// Virtual robots that drive: our own commands follow them, and a master control that we did not
// write (tests/peers/master_control.mjs) drives them.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Driving : public EndToEnd {
 protected:
  // 6 m, with an action at the end.
  [[nodiscard]] std::string OrderFile() const {
    constexpr std::string_view kOrder = R"({"version":"3.0.0","orderId":"o-1","orderUpdateId":0,
      "nodes":[{"nodeId":"n1","sequenceId":0,"released":true,"actions":[],
        "nodePosition":{"x":1,"y":2,"mapId":"map-1"}},
       {"nodeId":"n2","sequenceId":2,"released":true,"actions":[],
        "nodePosition":{"x":4,"y":2,"mapId":"map-1"}},
       {"nodeId":"n3","sequenceId":4,"released":true,"actions":[
         {"actionId":"a","actionType":"detectObject","blockingType":"HARD"}],
        "nodePosition":{"x":4,"y":5,"theta":1.5,"mapId":"map-1"}}],
      "edges":[{"edgeId":"e1","sequenceId":1,"released":true,"actions":[],
        "startNodeId":"n1","endNodeId":"n2"},
       {"edgeId":"e2","sequenceId":3,"released":true,"actions":[],
        "startNodeId":"n2","endNodeId":"n3"}]})";
    return operator_.home().Write("order.json", kOrder).string();
  }
};

TEST_F(Driving, IsFollowedToItsEnd) {
  const auto robot = Robot({"KIT/0001", "--position", "1,2,0", "--time-scale", "20"});
  const Subscriber states(broker_, "vda5050/v3/KIT/0001/state");
  const Finished sent =
      Fleetpub({"publish", "order", "KIT/0001", "-f", OrderFile(), "--wait-for", "finished"});
  EXPECT_EQ(sent.exit_code, 0) << sent.output << sent.errors;
  std::vector<std::string> passed;
  const auto messages = states.Await(4);
  for (const auto& message : messages) {
    const auto state = Json(message.payload);
    const std::string node = state["lastNodeId"].GetString();
    if (passed.empty() || passed.back() != node) passed.push_back(node);
  }
  EXPECT_THAT(passed, ElementsAre("n1", "n2", "n3"));
  const auto last = Json(messages.back().payload);
  EXPECT_TRUE(last["nodeStates"].Empty());
  EXPECT_FALSE(last["driving"].GetBool());
  EXPECT_STREQ(last["actionStates"][0]["actionStatus"].GetString(), "FINISHED");
  EXPECT_DOUBLE_EQ(last["mobileRobotPosition"]["y"].GetDouble(), 5);
}

TEST_F(Driving, StartsOnlyWhereTheRobotIs) {
  const auto robot = Robot({"KIT/0001", "--position", "40,2,0"});
  const Finished sent = Fleetpub({"publish", "order", "KIT/0001", "-f", OrderFile(), "--wait"});
  EXPECT_EQ(sent.exit_code, 5) << sent.output;
  EXPECT_THAT(sent.output, HasSubstr("out of reach"));
}

TEST_F(Driving, GetsStuckOnDemandAndCanBeCancelled) {
  const auto robot =
      Robot({"KIT/0001", "--position", "1,2,0", "--time-scale", "50", "--fault", "stuck",
             "--visualization-interval", "50ms", "--state-interval", "200ms"});
  const Subscriber shown(broker_, "vda5050/v3/KIT/0001/visualization");
  EXPECT_EQ(Fleetpub({"publish", "order", "KIT/0001", "-f", OrderFile(), "--wait"}).exit_code, 0);
  EXPECT_EQ(Fleetpub({"await", "KIT/0001", "state", "driving=false", "lastNodeId=n1",
                      "/mobileRobotPosition/x=2.5", "-W", "60s"})
                .exit_code,
            0);
  EXPECT_FALSE(shown.Await(2).empty());
  EXPECT_EQ(Fleetpub({"cancel", "KIT/0001", "--wait", "--yes"}).exit_code, 0);
}

TEST_F(Driving, LeavesTheLastWillLateOrNeverOnDemand) {
  const auto late = Robot({"KIT/0001", "--fault", "late-will"});
  EXPECT_TRUE(broker_.AwaitLog(", k600")) << "the broker waits so long for a sign of life";
  const auto mute = Robot({"KIT/0002", "--fault", "no-will"});
  const auto third = Robot({"KIT/0003"});
  const Subscriber connections(broker_, "+/+/+/+/connection", 1);
  EXPECT_EQ(connections.Await(3).size(), 3U);
  mute->Signal(SIGKILL);
  third->Signal(SIGKILL);
  const auto broken = connections.Await(4);
  ASSERT_EQ(broken.size(), 4U);
  EXPECT_THAT(broken.back().topic, HasSubstr("KIT/0003"));
}

TEST_F(Driving, RefusesOptionsThatMakeNoSense) {
  struct Case {
    std::vector<std::string> arguments;
    const char* why;
  };
  for (const auto& [arguments, why] :
       {Case{{"--fault", "bad-temper"}, "stuck"}, Case{{"--speed", "0"}, "--speed"},
        Case{{"--time-scale", "-1"}, "--time-scale"},
        Case{{"--mode-change", "MANUAL"}, "10s:MANUAL"},
        Case{{"--mode-change", "1s:TEACHIN"}, "3.0.0"},
        Case{{"--protocol", "soar", "--speed", "2"}, "soar"}}) {
    std::vector<std::string> all = {"simulate", "KIT/0001"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const Finished run = Fleetpub(all);
    EXPECT_EQ(run.exit_code, 2) << arguments.back();
    EXPECT_THAT(run.errors, HasSubstr(why));
  }
}

class DrivenByOthers : public EndToEnd, public ::testing::WithParamInterface<const char*> {};

INSTANTIATE_TEST_SUITE_P(Versions, DrivenByOthers, ::testing::Values("1.1.0", "2.0.0"),
                         [](const auto& version) { return version.index == 0 ? "V110" : "V200"; });

TEST_P(DrivenByOthers, GoesThroughFiveHundredRandomOrdersWithUpdates) {
  const auto robots =
      Robot({"LIB/0001", "--count", "10", "--vda", GetParam(), "--time-scale", "1000"});
  const Finished run =
      testing::Run({.arguments = {"node", FLEETPUB_SOURCE_DIR "/tests/peers/master_control.mjs",
                                  broker_.Url(), GetParam(), "LIB", "10", "50"}});
  EXPECT_THAT(run.output, HasSubstr("driven: 500 orders")) << run.errors;
}

}  // namespace
}  // namespace fleetpub::testing
