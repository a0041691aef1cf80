#include "cli/output/message_text.h"

#include <gmock/gmock.h>

namespace fleetpub::cli {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

std::vector<Statement> Describe(std::string_view topic_name, std::string payload) {
  const vda5050::TopicLevels levels{.robot = {"KIT", "0001"},
                                    .topic_name = std::string(topic_name)};
  return DescribeMessage({.topic = "t", .payload = std::move(payload)}, &levels);
}

std::string Text(std::string_view topic_name, std::string payload) {
  return JoinStatements(Describe(topic_name, std::move(payload)));
}

TEST(MessageText, SaysWhatEachTopicSays) {
  const std::pair<std::pair<const char*, const char*>, const char*> cases[] = {
      {{"connection", R"({"connectionState":"CONNECTIONBROKEN"})"}, "CONNECTION_BROKEN"},
      {{"order",
        R"({"orderId":"o","orderUpdateId":2,"nodes":[{"nodeId":"a","released":true},{"nodeId":"b","released":false}]})"},
       "order o update 2  a → b  1 of 2 nodes released"},
      {{"instantActions", R"({"instantActions":[{"actionType":"beep","actionId":"x"}]})"},
       "beep x"},
      {{"responses", R"({"responses":[{"requestId":"r","grantType":"GRANTED"}]})"}, "GRANTED r"},
      {{"zoneSet", R"({"zoneSet":{"zoneSetId":"hall","zones":[{},{}]}})"}, "hall with 2 zones"},
      {{"visualization", R"({"mobileRobotPosition":{"x":1.5,"y":-2,"theta":0,"mapId":"m"}})"},
       "x 1.50  y -2.00  map m"},
      {{"factsheet", R"({"version":"2.1.0","typeSpecification":{"seriesName":"S"}})"},
       "series S  version 2.1.0  0 actions"},
      {{"state", R"({"lastNodeId":"n4","nodeStates":[],"driving":false})"}, "at n4  standing"},
      {{"state",
        R"({"lastNodeId":"","nodeStates":[{"nodeId":"n1","sequenceId":0}],"paused":true})"},
       "→ n1  paused"},
  };
  for (const auto& [message, text] : cases) EXPECT_EQ(Text(message.first, message.second), text);
}

TEST(MessageText, SaysOfALongOrderItsEnds) {
  std::string nodes;
  for (int i = 0; i < 50; ++i) {
    nodes += fmt::format(R"({}{{"nodeId":"n{}","released":true}})", i == 0 ? "" : ",", i);
  }
  EXPECT_EQ(Text("order", R"({"orderId":"o","nodes":[)" + nodes + "]}"),
            "order o  n0 → n1 → n2 → n3 → n4 → … → n49");
}

TEST(MessageText, SaysThatARobotIsInTrouble) {
  const std::string text =
      Text("state",
           R"({"safetyState":{"eStop":"MANUAL","fieldViolation":true},"operatingMode":"MANUAL",)"
           R"("errors":[{"errorType":"motor","errorLevel":"FATAL","errorDescription":"hot"}]})");
  for (const char* part : {"EMERGENCY STOP", "FIELD VIOLATION", "error motor FATAL (hot)"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
}

TEST(MessageText, LetsNoRobotWriteToTheTerminal) {
  for (const char* topic : {"state", "order", "connection", "instantActions"}) {
    const std::string text = Text(
        topic, R"({"orderId":"\u001b[2J","lastNodeId":"\u001b]0;","connectionState":"\u001b",)"
               R"("actions":[{"actionType":"\u001b","actionId":"\n"}],"nodes":[{"nodeId":"\r"}]})");
    EXPECT_THAT(text, Not(HasSubstr("\x1b")));
    EXPECT_THAT(text, Not(HasSubstr("\n")));
  }
  EXPECT_THAT(Text("state", "\x1b[2J"), Not(HasSubstr("\x1b")));
}

TEST(MessageText, ReadsWhatIsNoMessageOfVda5050) {
  const auto soar = DescribeMessage(
      {.topic = "soar/a", .payload = R"({"header":{},"payload":{"level":"executed","n":[1]}})"},
      nullptr);
  EXPECT_EQ(JoinStatements(soar), "level executed");
  EXPECT_EQ(JoinStatements(DescribeMessage({.topic = "a", .payload = "hi\x07"}, nullptr)),
            "hi\\x07");
  EXPECT_EQ(Text("state", ""), "no longer retained");
  EXPECT_THAT(Text("state", "[1]"), HasSubstr("cannot be read"));
}

TEST(FindNews, TellsWhatIsNewAndWhatIsOver) {
  const auto before = Describe("state", R"({"driving":true,"batteryState":{"batteryCharge":50},)"
                                        R"("errors":[{"errorType":"e","errorLevel":"FATAL"}]})");
  const auto after =
      Describe("state", R"({"driving":false,"batteryState":{"batteryCharge":50},"errors":[]})");
  EXPECT_THAT(FindNews(before, before), IsEmpty());
  EXPECT_THAT(FindNews({}, before), SizeIs(before.size()));
  EXPECT_EQ(JoinStatements(FindNews(before, after)), "standing  error e is over");
}

}  // namespace
}  // namespace fleetpub::cli
