// The messages of a virtual robot have what its version requires.
#include <map>
#include <set>

#include "simulator/conversation.h"
#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::simulator {
namespace {

using vda5050::Version;

class RobotMessages : public EachVersion {};

INSTANTIATE_TEST_SUITE_P(Versions, RobotMessages, ::testing::ValuesIn(vda5050::kVersions),
                         VersionName);

using Names = std::vector<std::string>;

const Names kHeader = {"headerId", "timestamp", "version", "manufacturer", "serialNumber"};
// What the published schemas require beside the header, and what we promise beyond that.
const Names kState = {"orderId",      "orderUpdateId", "lastNodeId",  "lastNodeSequenceId",
                      "driving",      "operatingMode", "nodeStates",  "edgeStates",
                      "actionStates", "errors",        "safetyState", "paused"};
const std::map<Version, Names> kStateOf = {
    {Version::k110, {"batteryState", "agvPosition", "information"}},
    {Version::k200, {"batteryState", "agvPosition", "information"}},
    {Version::k210, {"batteryState", "agvPosition", "maps"}},
    {Version::k300,
     {"powerSupply", "mobileRobotPosition", "maps", "zoneSets", "instantActionStates",
      "zoneActionStates"}}};
const std::map<Version, Names> kParts = {
    {Version::k110, {"/batteryState/batteryCharge", "/safetyState/eStop", "/agvPosition/x"}},
    {Version::k200, {"/batteryState/charging", "/agvPosition/positionInitialized"}},
    {Version::k210, {"/maps/0/mapId", "/maps/0/mapVersion", "/maps/0/mapStatus"}},
    {Version::k300,
     {"/powerSupply/stateOfCharge", "/powerSupply/charging", "/mobileRobotPosition/localized",
      "/safetyState/activeEmergencyStop", "/safetyState/fieldViolation"}}};

void ExpectMembers(const base::JsonValue& message, const Names& names) {
  for (const std::string& name : names) EXPECT_TRUE(message.HasMember(name)) << name;
}

// What is wrong with a message by the schema of its topic.
std::string Faults(schema::Registry& registry, Version version, std::string_view topic,
                   const base::JsonValue& message) {
  std::string name = "vda5050/";
  name.append(vda5050::GetFacts(version).name).append("/").append(topic);
  std::string faults;
  for (const auto& [path, what] : registry.Find(name).value()->Validate(message)) {
    faults += path + " " + what + "; ";
  }
  return faults;
}

TEST_P(RobotMessages, SatisfyTheirSchemas) {
  Settings settings = Plain();
  settings.with_order = true;
  settings.fail = {"logReport"};
  settings.reject = {"stateRequest"};
  settings.delay = std::chrono::seconds(1);
  Conversation robot(settings);
  robot.Do("logReport", {{"reason", R"("test")"}});
  robot.Do("startPause");
  robot.Do("stateRequest");
  robot.Hear("instantActions", "{}");
  robot.Wait(std::chrono::seconds(2));
  robot.Do("cancelOrder");
  robot.Wait(std::chrono::seconds(2));
  robot.End();
  schema::Registry registry;
  std::set<std::string> topics;
  for (const Utterance& one : robot.said()) {
    topics.emplace(one.topic);
    const auto message = base::ParseJson(one.payload);
    EXPECT_EQ(Faults(registry, GetParam(), one.topic, *message), "") << one.payload;
  }
  EXPECT_EQ(topics.size(), GetParam() == Version::k110 ? 2U : 3U);
}

TEST_P(RobotMessages, RehearseTroubleInTheNamesOfTheVersion) {
  Settings settings = Plain();
  settings.with_order = true;
  settings.order_time = std::chrono::seconds(1);
  settings.initial.battery = 9;
  settings.initial.emergency_stop = "REMOTE";
  settings.initial.field_violation = true;
  settings.initial.last_node_id = "n9";
  settings.initial.position = {3, 4, -1, "yard"};
  settings.initial.errors = {{.type = "motorFault",
                              .description = "hot",
                              .references = {},
                              .until = Until::kEnd,
                              .level = "FATAL"}};
  Conversation robot(settings);
  for (int i = 0; i < 20; ++i) robot.Do("beep" + std::to_string(i));
  robot.Wait(std::chrono::seconds(2));
  robot.Do("startPause");
  const auto state = robot.Last("state");
  schema::Registry registry;
  EXPECT_EQ(Faults(registry, GetParam(), "state", state), "");
  EXPECT_EQ(robot.At(Is30() ? "/powerSupply/stateOfCharge" : "/batteryState/batteryCharge"), "9.0");
  EXPECT_EQ(robot.At(Is30() ? "/safetyState/activeEmergencyStop" : "/safetyState/eStop"),
            R"("REMOTE")");
  EXPECT_EQ(robot.At("/safetyState/fieldViolation"), "true");
  EXPECT_EQ(robot.At("/lastNodeId"), R"("n9")");
  EXPECT_EQ(robot.At(Is30() ? "/mobileRobotPosition/mapId" : "/agvPosition/mapId"), R"("yard")");
  EXPECT_EQ(robot.At("/errors/0/errorType"), R"("motorFault")") << "it stays";
  EXPECT_EQ(robot.At("/driving"), "false");
  EXPECT_NE(robot.At("/nodeStates"), "[]") << "nor does it arrive";
}

TEST_P(RobotMessages, TheLastWillSaysThatTheConnectionBroke) {
  Conversation robot(Plain());
  robot.End();
  schema::Registry registry;
  const auto will = base::ParseJson(robot.will());
  ASSERT_TRUE(will);
  EXPECT_EQ(Faults(registry, GetParam(), "connection", *will), "");
  EXPECT_EQ(base::StringMember(*will, "connectionState"),
            Is30() ? "CONNECTION_BROKEN" : "CONNECTIONBROKEN");
  EXPECT_EQ(robot.Connections(), "ONLINE OFFLINE");
}

TEST_P(RobotMessages, StateHasWhatItsVersionRequires) {
  const Conversation robot(Plain());
  const auto state = robot.Last("state");
  ExpectMembers(state, kHeader);
  ExpectMembers(state, kState);
  ExpectMembers(state, kStateOf.at(GetParam()));
  for (const std::string& pointer : kParts.at(GetParam())) {
    EXPECT_NE(robot.At(pointer.c_str()), "") << pointer;
  }
  EXPECT_EQ(state.HasMember("instantActionStates"), Is30());
  EXPECT_EQ(state.HasMember("maps"), GetParam() >= Version::k210);
}

TEST_P(RobotMessages, FactsheetListsEveryActionOfItsVersion) {
  const Conversation robot(Plain());
  const auto factsheet = robot.Last("factsheet");
  if (GetParam() == Version::k110) {
    EXPECT_TRUE(factsheet.IsNull());
    return;
  }
  ExpectMembers(factsheet, kHeader);
  ExpectMembers(factsheet,
                {"typeSpecification", "physicalParameters", "protocolLimits", "protocolFeatures",
                 "loadSpecification", Is30() ? "mobileRobotGeometry" : "agvGeometry"});
  const auto& features = factsheet["protocolFeatures"];
  std::set<std::string_view> listed;
  for (const auto& action : features[Is30() ? "mobileRobotActions" : "agvActions"].GetArray()) {
    listed.insert(base::StringMember(action, "actionType"));
    EXPECT_FALSE(action["actionScopes"].Empty());
    EXPECT_EQ(action.HasMember("cancelAllowed"), Is30());
  }
  std::set<std::string_view> expected;
  for (const auto* action : vda5050::ListActions(GetParam())) {
    expected.insert(action->type);
  }
  EXPECT_EQ(listed, expected);
}

TEST(Factsheet, SaysWhichParametersAreOptional) {
  const Conversation robot(Settings{.version = Version::k300});
  const auto factsheet = robot.Last("factsheet");
  for (const auto& action : factsheet["protocolFeatures"]["mobileRobotActions"].GetArray()) {
    if (base::StringMember(action, "actionType") != "downloadMap") continue;
    EXPECT_EQ(base::ToJson(action["actionParameters"][3]),
              R"({"key":"mapHash","valueDataType":"STRING","isOptional":true})");
    EXPECT_FALSE(action["actionParameters"][0]["isOptional"].GetBool());
    return;
  }
  FAIL() << "downloadMap is not listed";
}

TEST_P(RobotMessages, CountHeaderIdsPerTopic) {
  Conversation robot(Plain());
  robot.Do("startPause");
  EXPECT_EQ(robot.At("/headerId"), "1");
  EXPECT_EQ(robot.Last("connection")["headerId"].GetInt(), 1);  // 0 is the last will's
}

TEST_P(RobotMessages, ComeAtTheIntervalWhenNothingHappens) {
  Settings settings = Plain();
  settings.state_interval = std::chrono::seconds(5);
  Conversation robot(settings);
  robot.Wait(std::chrono::milliseconds(4'999));
  EXPECT_EQ(robot.Times("state"), 1U);
  robot.Wait(std::chrono::milliseconds(1));
  EXPECT_EQ(robot.Times("state"), 2U);
  robot.Do("startPause");
  EXPECT_EQ(robot.Times("state"), 3U);
}

}  // namespace
}  // namespace fleetpub::simulator
