// What each predefined action does to a virtual robot.
#include "simulator/virtual_robot.h"

#include <fmt/format.h>

#include "simulator/conversation.h"
#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::simulator {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using vda5050::Parameter;
using vda5050::Version;

class VirtualRobots : public EachVersion {};

INSTANTIATE_TEST_SUITE_P(Versions, VirtualRobots, ::testing::ValuesIn(vda5050::kVersions),
                         VersionName);

std::vector<Parameter> Map(const std::string& id, const std::string& version) {
  return {{"mapId", '"' + id + '"'}, {"mapVersion", '"' + version + '"'}};
}

std::vector<Parameter> MapDownload(const std::string& id, const std::string& version) {
  auto parameters = Map(id, version);
  parameters.push_back({"mapDownloadLink", R"("https://maps.example/m")"});
  return parameters;
}

TEST_P(VirtualRobots, PauseAndGoOn) {
  Conversation robot(Plain());
  EXPECT_EQ(robot.Of(robot.Do("startPause")), "FINISHED");
  EXPECT_EQ(robot.At("/paused"), "true");
  EXPECT_EQ(robot.Of(robot.Do("stopPause")), "FINISHED");
  EXPECT_EQ(robot.At("/paused"), "false");
}

TEST_P(VirtualRobots, Charge) {
  Conversation robot(Plain());
  const char* charging = Is30() ? "/powerSupply/charging" : "/batteryState/charging";
  EXPECT_EQ(robot.Of(robot.Do("startCharging")), "FINISHED");
  EXPECT_EQ(robot.At(charging), "true");
  EXPECT_EQ(robot.Of(robot.Do("stopCharging")), "FINISHED");
  EXPECT_EQ(robot.At(charging), "false");
}

TEST_P(VirtualRobots, TakeOverAPosition) {
  Conversation robot(Plain());
  const auto id = robot.Do("initPosition", {{"x", "1.5"},
                                            {"y", "-2"},
                                            {"theta", "0.5"},
                                            {"mapId", R"("hall-1")"},
                                            {"lastNodeId", R"("n1")"}});
  EXPECT_EQ(robot.Of(id), "FINISHED");
  const std::string position = "/" + std::string(words().position);
  EXPECT_EQ(robot.At((position + "/x").c_str()), "1.5");
  EXPECT_EQ(robot.At((position + "/y").c_str()), "-2.0");
  EXPECT_EQ(robot.At((position + "/theta").c_str()), "0.5");
  EXPECT_EQ(robot.At((position + "/mapId").c_str()), R"("hall-1")");
  EXPECT_EQ(robot.At("/lastNodeId"), R"("n1")");
}

TEST_P(VirtualRobots, CancelTheirOrder) {
  Settings settings = Plain();
  settings.with_order = true;
  Conversation robot(settings);
  EXPECT_EQ(robot.At("/driving"), "true");
  EXPECT_EQ(robot.Of(robot.Do("cancelOrder")), "FINISHED");
  EXPECT_EQ(robot.At("/driving"), "false");
  EXPECT_EQ(robot.At("/nodeStates"), "[]");
  EXPECT_EQ(robot.At("/edgeStates"), "[]");
  EXPECT_EQ(robot.At("/orderId"), R"("order-1")");
  EXPECT_EQ(robot.At("/errors"), "[]");
}

TEST_P(VirtualRobots, HaveNoOrderToCancel) {
  Conversation robot(Plain());
  const auto id = robot.Do("cancelOrder");
  EXPECT_THAT(robot.Of(id), StartsWith("FAILED"));
  EXPECT_EQ(robot.At("/errors/0/errorType"),
            Is30() ? R"("NO_ORDER_TO_CANCEL")" : R"("noOrderToCancel")");
  EXPECT_EQ(robot.At("/errors/0/errorReferences/0/referenceKey"), R"("actionId")");
  EXPECT_EQ(robot.At("/errors/0/errorReferences/0/referenceValue"), '"' + id + '"');
  EXPECT_EQ(robot.At("/errors/0/errorLevel"), R"("WARNING")");
  robot.Do("startPause");
  EXPECT_NE(robot.At("/errors/0"), "") << "it stays until the next order";
}

TEST_P(VirtualRobots, AnswerRequests) {
  Conversation robot(Plain());
  EXPECT_EQ(robot.Of(robot.Do("stateRequest")), "FINISHED");
  EXPECT_EQ(robot.Of(robot.Do("logReport", {{"reason", R"("noise")"}})), "FINISHED: log-id-2.txt");
  const auto factsheets = robot.Times("factsheet");
  const auto id = robot.Do("factsheetRequest");
  const bool known = words().HasFactsheet();
  EXPECT_EQ(robot.Of(id), known ? "FINISHED" : "");
  EXPECT_EQ(robot.Times("factsheet"), factsheets + (known ? 1 : 0));
}

class VirtualRobotsWithMaps : public EachVersion {};

INSTANTIATE_TEST_SUITE_P(Versions, VirtualRobotsWithMaps,
                         ::testing::Values(Version::k210, Version::k300), VersionName);

TEST_P(VirtualRobotsWithMaps, KeepThem) {
  Conversation robot(Plain());
  EXPECT_EQ(robot.Of(robot.Do("downloadMap", MapDownload("map-1", "2"))), "FINISHED");
  EXPECT_EQ(robot.At("/maps/1/mapStatus"), R"("DISABLED")");
  EXPECT_THAT(robot.Of(robot.Do("downloadMap", MapDownload("map-1", "2"))), StartsWith("FAILED"));
  EXPECT_EQ(robot.At("/errors/0/errorType"), Is30() ? R"("DUPLICATE_MAP")" : R"("duplicateMap")");
  EXPECT_EQ(robot.Of(robot.Do("enableMap", Map("map-1", "2"))), "FINISHED");
  EXPECT_EQ(robot.At("/maps/0/mapStatus"), R"("DISABLED")");
  EXPECT_EQ(robot.At("/maps/1/mapStatus"), R"("ENABLED")");
  EXPECT_THAT(robot.Of(robot.Do("deleteMap", Map("map-1", "2"))), HasSubstr("in use"));
  EXPECT_EQ(robot.Of(robot.Do("deleteMap", Map("map-1", "1"))), "FINISHED");
  EXPECT_EQ(robot.At("/maps/1"), "");
  EXPECT_THAT(robot.Of(robot.Do("enableMap", Map("map-1", "1"))), HasSubstr("not there"));
}

class VirtualRobot30 : public ::testing::Test {
 protected:
  Settings settings_{.version = Version::k300};
};

TEST_F(VirtualRobot30, KeepsZoneSets) {
  Conversation robot(settings_);
  const std::vector<Parameter> set = {{"zoneSetId", R"("z1")"}};
  auto download = set;
  download.push_back({"zoneSetDownloadLink", R"("https://zones.example/z1")"});
  EXPECT_EQ(robot.Of(robot.Do("downloadZoneSet", download)), "FINISHED");
  EXPECT_EQ(robot.At("/zoneSets/0"),
            R"({"zoneSetId":"z1","mapId":"map-1","zoneSetStatus":"DISABLED"})");
  EXPECT_THAT(robot.Of(robot.Do("downloadZoneSet", download)), StartsWith("FAILED"));
  EXPECT_EQ(robot.At("/errors/0/errorType"), R"("DUPLICATE_ZONE_SET")");
  EXPECT_EQ(robot.Of(robot.Do("enableZoneSet", set)), "FINISHED");
  EXPECT_EQ(robot.At("/zoneSets/0/zoneSetStatus"), R"("ENABLED")");
  EXPECT_THAT(robot.Of(robot.Do("deleteZoneSet", set)), HasSubstr("in use"));
}

TEST_F(VirtualRobot30, HibernatesAndWakesUp) {
  settings_.with_order = true;
  Conversation robot(settings_);
  const auto sleep = robot.Do("startHibernation");
  EXPECT_EQ(robot.Of(sleep), "FINISHED") << "in its last state";
  EXPECT_EQ(robot.At("/nodeStates"), "[]");
  EXPECT_EQ(robot.Connections(), "ONLINE HIBERNATING");
  const auto states = robot.Times("state");
  robot.Do("startPause");
  robot.Wait(std::chrono::hours(1));
  EXPECT_EQ(robot.Times("state"), states) << "it is silent and deaf";
  const auto wake = robot.Do("stopHibernation");
  EXPECT_EQ(robot.Connections(), "ONLINE HIBERNATING ONLINE");
  EXPECT_EQ(robot.Of(wake), "FINISHED");
  EXPECT_EQ(robot.At("/paused"), "false");
}

TEST_F(VirtualRobot30, ShutsDownWhenIdle) {
  settings_.with_order = true;
  Conversation robot(settings_);
  EXPECT_THAT(robot.Of(robot.Do("shutdown")), HasSubstr("not idle"));
  robot.Do("cancelOrder");
  EXPECT_EQ(robot.Of(robot.Do("shutdown")), "FINISHED");
  EXPECT_EQ(robot.Connections(), "ONLINE OFFLINE");
  EXPECT_TRUE(robot.robot().gone());
  const auto states = robot.Times("state");
  robot.Do("startPause");
  robot.End();
  EXPECT_EQ(robot.Times("state"), states);
  EXPECT_EQ(robot.Connections(), "ONLINE OFFLINE");
}

TEST_F(VirtualRobot30, ForgetsEndedInstantActions) {
  Conversation robot(settings_);
  const auto pause = robot.Do("startPause");
  const auto clear = robot.Do("clearInstantActions");
  EXPECT_EQ(robot.Of(pause), "");
  EXPECT_EQ(robot.Of(clear), "FINISHED");
  EXPECT_EQ(robot.Of(robot.Do("clearZoneActions")), "FINISHED");
}

TEST_F(VirtualRobot30, SaysWhenItsListIsFull) {
  settings_.list_limit = 2;
  Conversation robot(settings_);
  const auto first = robot.Do("startPause");
  EXPECT_EQ(robot.At("/errors"), "[]");
  robot.Do("stopPause");
  EXPECT_EQ(robot.At("/errors/0/errorType"), R"("INSTANT_ACTION_STATES_FULL")");
  EXPECT_EQ(robot.At("/errors/0/errorLevel"), R"("URGENT")");
  const auto refused = robot.Do("startCharging");
  EXPECT_EQ(robot.Of(refused), "") << "there is no room for it";
  EXPECT_EQ(robot.At("/powerSupply/charging"), "false");
  EXPECT_EQ(robot.Of(first), "FINISHED") << "it keeps what it has";
  EXPECT_EQ(robot.Of(robot.Do("clearInstantActions")), "FINISHED");
  EXPECT_EQ(robot.At("/errors"), "[]");
  EXPECT_EQ(robot.At("/instantActionStates/1"), "");
}

TEST_F(VirtualRobot30, ReleasesWhatWaitsForATrigger) {
  Conversation robot(settings_);
  EXPECT_THAT(robot.Of(robot.Do("trigger")), StartsWith("FAILED"));
  robot.Hear("order", R"({"headerId":0,"timestamp":"2026-01-02T03:04:05.678Z","version":"3.0.0",
      "manufacturer":"KIT","serialNumber":"0001","orderId":"o1","orderUpdateId":0,
      "nodes":[{"nodeId":"n1","sequenceId":0,"released":true,"actions":[{"actionId":"w",
        "actionType":"waitForTrigger","blockingType":"HARD","actionParameters":
        [{"key":"triggerType","value":["FLEET_CONTROL"]}]}]}],"edges":[]})");
  EXPECT_EQ(robot.Of("w"), "RUNNING");
  EXPECT_EQ(robot.Of(robot.Do("trigger")), "FINISHED");
  EXPECT_EQ(robot.Of("w"), "FINISHED");
}

TEST_F(VirtualRobot30, RetriesAndGivesUp) {
  settings_.retriable.insert("startCharging");
  Conversation robot(settings_);
  const auto first = robot.Do("startCharging");
  EXPECT_THAT(robot.Of(first), StartsWith("RETRIABLE"));
  EXPECT_EQ(robot.Of(robot.Do("retry", {{"actionId", '"' + first + '"'}})), "FINISHED");
  EXPECT_EQ(robot.Of(first), "FINISHED");
  EXPECT_EQ(robot.At("/powerSupply/charging"), "true");
  const auto second = robot.Do("startCharging");
  EXPECT_EQ(robot.Of(robot.Do("skipRetry", {{"actionId", '"' + second + '"'}})), "FINISHED");
  EXPECT_THAT(robot.Of(second), StartsWith("FAILED"));
  EXPECT_THAT(robot.Of(robot.Do("retry", {{"actionId", '"' + second + '"'}})),
              StartsWith("FAILED"));
}

TEST_F(VirtualRobot30, CancelsOnlyTheOrderThatIsNamed) {
  settings_.with_order = true;
  Conversation robot(settings_);
  EXPECT_THAT(robot.Of(robot.Do("cancelOrder", {{"orderId", R"("other")"}})), StartsWith("FAILED"));
  EXPECT_EQ(robot.At("/driving"), "true");
  EXPECT_EQ(robot.Of(robot.Do("cancelOrder", {{"orderId", R"("order-1")"}})), "FINISHED");
}

TEST_F(VirtualRobot30, InstallsCertificates) {
  Conversation robot(settings_);
  EXPECT_EQ(robot.Of(robot.Do("updateCertificate",
                              {{"service", R"("MQTT")"},
                               {"keyDownloadLink", R"("https://ca.example/key")"},
                               {"certificateDownloadLink", R"("https://ca.example/cert")"}})),
            "FINISHED");
}

TEST_P(VirtualRobots, CarryOutARepeatedActionOnce) {
  Conversation robot(Plain());
  robot.Do("same", "startPause", {});
  robot.Do("stopPause");
  const auto states = robot.Times("state");
  robot.Do("same", "startPause", {});
  EXPECT_EQ(robot.At("/paused"), "false");
  EXPECT_EQ(robot.Times("state"), states + 1) << "but it is answered";
}

std::string MakeOrder(vda5050::Version version, const std::string& id, int update) {
  return fmt::format(
      R"({{"headerId":3,"timestamp":"2026-01-02T03:04:05.678Z","version":"{}","manufacturer":"KIT",
      "serialNumber":"0001","orderId":"{}","orderUpdateId":{},
      "nodes":[{{"nodeId":"n1","sequenceId":0,"released":true,"actions":[]}},
      {{"nodeId":"n2","sequenceId":2,"released":true,"actions":[{{"actionId":"a1",
        "actionType":"detectObject","blockingType":"HARD"}}]}}],
      "edges":[{{"edgeId":"e1","sequenceId":1,"released":true,"startNodeId":"n1",
        "endNodeId":"n2","actions":[]}}]}})",
      vda5050::GetFacts(version).name, id, update);
}

TEST_P(VirtualRobots, TakeAnOrderAndFinishIt) {
  Settings settings = Plain();
  settings.order_time = std::chrono::seconds(3);
  Conversation robot(settings);
  const auto pause = robot.Do("startPause");
  robot.Do("stopPause");
  robot.Hear("order", MakeOrder(GetParam(), "o1", 0));
  EXPECT_EQ(robot.At("/orderId"), R"("o1")");
  EXPECT_EQ(robot.At("/driving"), "true");
  EXPECT_EQ(robot.At("/nodeStates/0/nodeId"), R"("n2")");
  EXPECT_EQ(robot.Of("a1"), "WAITING");
  EXPECT_EQ(robot.Of(pause).empty(), !Is30()) << "up to 2.1 a new order clears ended actions";
  robot.Wait(std::chrono::seconds(3));
  EXPECT_EQ(robot.At("/driving"), "false");
  EXPECT_EQ(robot.At("/lastNodeId"), R"("n2")");
  EXPECT_EQ(robot.Of("a1"), "RUNNING");
  robot.Wait(kActionTime);
  EXPECT_EQ(robot.Of("a1"), "FINISHED");
}

}  // namespace
}  // namespace fleetpub::simulator
