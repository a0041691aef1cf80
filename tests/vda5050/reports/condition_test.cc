#include "vda5050/reports/condition.h"

#include <gmock/gmock.h>

#include "base/json.h"

namespace fleetpub::vda5050 {
namespace {

using ::testing::HasSubstr;

constexpr std::string_view kState = R"({
  "paused": true, "operatingMode": "AUTOMATIC", "orderId": "42", "lastNodeId": "", "version": null,
  "orderUpdateId": 7, "errors": [], "a.b": 1, "a/b": 2,
  "loads": [{"loadId": "pallet", "weight": 12.5}],
  "batteryState": {"batteryCharge": 80, "charging": false},
  "agvPosition": {"x": -1.5, "positionInitialized": true}})";

// What the message says instead, or "" when the condition is satisfied.
std::string CommandStatus(std::string_view condition, std::string_view message = kState) {
  const auto parsed = ParseCondition(condition);
  if (!parsed) return "refused: " + parsed.error().message;
  const auto document = base::ParseJson(message);
  return Unmet(*parsed, document.value()).value_or("");
}

TEST(Condition, IsSatisfiedByWhatTheMessageSays) {
  for (const char* condition : {"paused=true",
                                "paused==true",
                                " paused = true ",
                                "paused!=false",
                                "operatingMode=AUTOMATIC",
                                "operatingMode=\"AUTOMATIC\"",
                                "operatingMode!=MANUAL",
                                "orderId=42",
                                "orderId!=43",
                                "lastNodeId=",
                                "lastNodeId=\"\"",
                                "version=null",
                                "orderUpdateId=7",
                                "orderUpdateId=7.0",
                                "errors=[]",
                                "/batteryState/charging=false",
                                "/batteryState/batteryCharge>=80",
                                "/batteryState/batteryCharge<=80",
                                "/batteryState/batteryCharge>79.5",
                                "/batteryState/batteryCharge<8.1e1",
                                "/batteryState={\"charging\":false,\"batteryCharge\":80}",
                                "/loads/0/loadId=pallet",
                                "/loads/0/weight>12",
                                "/a~1b=2",
                                "/a.b=1",
                                "battery>=80",
                                "charging=false",
                                "x<-1",
                                "localized=true"}) {
    EXPECT_EQ(CommandStatus(condition), "") << condition;
  }
}

TEST(Condition, TellsWhatTheMessageSaysInstead) {
  const std::pair<const char*, const char*> cases[] = {
      {"paused=false", "paused is true"},
      {"paused!=true", "paused is true"},
      {"paused=TRUE", "paused is true"},
      {"paused=1", "paused is true"},
      {"paused>0", "paused is true"},
      {"operatingMode=manual", "operatingMode is \"AUTOMATIC\""},
      {"orderId=\"43\"", "orderId is \"42\""},
      {"orderId>41", "orderId is \"42\""},
      {"orderUpdateId=\"7\"", "orderUpdateId is 7"},
      {"errors=", "errors is []"},
      {"battery>80", "battery is 80"},
      {"battery<80", "battery is 80"},
      {"/loads/1/loadId=pallet", "there is no /loads/1/loadId"},
      {"driving=true", "there is no driving"},
      {"driving!=true", "there is no driving"},
      {"theta>0", "there is no theta"},
  };
  for (const auto& [condition, status] : cases) EXPECT_EQ(CommandStatus(condition), status);
}

TEST(Condition, FindsAliasesInEveryVersion) {
  constexpr std::string_view kNewer =
      R"({"powerSupply":{"stateOfCharge":55.5,"charging":true},"mobileRobotPosition":{"mapId":"m"}})";
  EXPECT_EQ(CommandStatus("battery=55.5", kNewer), "");
  EXPECT_EQ(CommandStatus("charging=true", kNewer), "");
  EXPECT_EQ(CommandStatus("mapId=m", kNewer), "");
  EXPECT_EQ(CommandStatus("battery=1", R"({"battery":1,"powerSupply":{"stateOfCharge":2}})"), "");
}

TEST(Condition, ShowsWhatARobotSaysPrintablyAndShort) {
  const std::string message = R"({"a":"\u001b[2J)" + std::string(500, 'x') + "\"}";
  const std::string status = CommandStatus("a=b", message);
  EXPECT_EQ(status.find('\x1b'), std::string::npos);
  EXPECT_LT(status.size(), 120U);
}

TEST(Condition, IsRefusedWithTheRightForm) {
  const std::pair<const char*, const char*> cases[] = {
      {"paused", "has no operator"},
      {"paused", "quotation marks"},
      {"", "has no operator"},
      {"!paused", "has no operator"},
      {"=true", "names no member"},
      {" >=3", "names no member"},
      {"/a~2=1", "not a JSON Pointer"},
      {"/a~=1", "not a JSON Pointer"},
      {"batteryState/charging=true", "write /batteryState/charging"},
      {"batteryState.charging=true", "write /batteryState/charging"},
      {"battery>=full", "compares numbers: write 'battery>=80'"},
      {"battery<", "compares numbers"},
      {"battery<\"8\"", "compares numbers"},
      {"battery<20%", "write 'battery<20'"},
      {"battery=>90", "write 'battery>=90'"},
      {"x=<-1.5", "write 'x<=-1.5'"},
      {"paused=!true", "write 'paused!=true'"},
      {"a=\xFF", "not valid UTF-8"},
  };
  for (const auto& [text, reason] : cases) {
    const auto condition = ParseCondition(text);
    ASSERT_FALSE(condition) << text;
    EXPECT_EQ(condition.error().kind, ErrorKind::kUsage);
    EXPECT_THAT(condition.error().message, HasSubstr(reason));
  }
}

TEST(Unmet, DoesNotCompareWholeNumbersThatADoubleConfuses) {
  const auto message =
      *base::ParseJson(R"({"code":12345678901234567890124,"text":"123456789012345678901234"})");
  EXPECT_TRUE(Unmet(*ParseCondition("code=12345678901234567890123"), message));
  EXPECT_TRUE(Unmet(*ParseCondition("code!=12345678901234567890123"), message));
  EXPECT_FALSE(Unmet(*ParseCondition("text=123456789012345678901234"), message));
}

TEST(CheckCondition, RefusesSlipsOfThePen) {
  const std::tuple<const char*, const char*, const char*> cases[] = {
      {"pausd=true", "state", "paused=true"},
      {"bateryy<20", "state", "battery<20"},
      {"lastNodeid=n1", "state", "lastNodeId=n1"},
      {"paused=ture", "state", "paused=true"},
      {"operatingMode!=AUTOMATC", "state", "operatingMode!=AUTOMATIC"},
      {"conectionState=ONLINE", "connection", "connectionState=ONLINE"},
      {"connectionState=ONLIN", "connection", "connectionState=ONLINE"},
  };
  for (const auto& [text, topic, meant] : cases) {
    const auto doubt = CheckCondition(*ParseCondition(text), topic);
    ASSERT_FALSE(doubt) << text;
    EXPECT_EQ(doubt.error().kind, ErrorKind::kUsage);
    EXPECT_THAT(doubt.error().message, HasSubstr(std::string("did you mean ") + meant));
  }
}

TEST(CheckCondition, SaysWhichTopicHasTheMember) {
  const auto doubt = CheckCondition(*ParseCondition("connectionState=ONLINE"), "state");
  ASSERT_FALSE(doubt);
  EXPECT_THAT(doubt.error().message, HasSubstr("connection has"));
}

TEST(CheckCondition, WarnsOfWhatNoReleaseKnows) {
  const auto doubt = [](std::string_view text, std::string_view topic) {
    return CheckCondition(*ParseCondition(text), topic).value_or("refused");
  };
  EXPECT_THAT(doubt("wobble=3", "state"), HasSubstr("wobble"));
  EXPECT_THAT(doubt("operatingMode=DANCING", "state"), HasSubstr("AUTOMATIC"));
  for (const char* text : {"paused=true", "paused!=false", "battery<20", "/pausd=true", "x>=1",
                           "operatingMode=automatic", "agvPosition=null", "headerId>3",
                           "mobileRobotPosition!=1", "orderId=\"\"", "localized=true"}) {
    EXPECT_EQ(doubt(text, "state"), "") << text;
  }
  EXPECT_EQ(doubt("connectionState=connectionbroken", "connection"), "");
  EXPECT_EQ(doubt("version=3.0.0", "connection"), "");
  EXPECT_EQ(doubt("anything=1", "a topic without schema"), "");
}

TEST(Unmet, TakesTheSpellingsThatRobotsUse) {
  const auto is_met = [](std::string_view condition, std::string_view message) {
    return !Unmet(*ParseCondition(condition), *base::ParseJson(message));
  };
  EXPECT_TRUE(is_met("connectionState=ONLINE", R"({"connectionState":"online"})"));
  EXPECT_TRUE(
      is_met("connectionState=CONNECTION_BROKEN", R"({"connectionState":"ConnectionBroken"})"));
  EXPECT_TRUE(is_met("/connectionState=offline", R"({"connectionState":"DISCONNECTED"})"));
  EXPECT_FALSE(is_met("connectionState!=OFFLINE", R"({"connectionState":"DISCONNECTED"})"));
  EXPECT_TRUE(is_met("operatingMode=TEACH_IN", R"({"operatingMode":"TEACHIN"})"));
  EXPECT_FALSE(is_met("orderId=o", R"({"orderId":"O"})")) << "an id is what it is";
}

}  // namespace
}  // namespace fleetpub::vda5050
