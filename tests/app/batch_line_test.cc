#include "app/batch_line.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

namespace fleetpub::app {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsNull;
using ::testing::NotNull;
using ::testing::SizeIs;

// Of robots that are not asked, unless somebody wants that.
Result<LineCommands> Parsed(std::string_view text, LineDefaults defaults = {.check = false}) {
  LineOrigin origin;
  return LineParser(std::move(defaults), "").Parse(text, origin);
}

TEST(BatchLine, MakesAnActionForEachTarget) {
  const auto line = Parsed(R"({"target":["K/1","K/2"],"action":"initPosition","vda":"2.1",)"
                           R"("parameters":{"x":1.5,"y":-2,"theta":0,"mapId":"m",)"
                           R"("lastNodeId":"n"}})");
  ASSERT_TRUE(line) << line.error().message;
  ASSERT_THAT(line->commands, SizeIs(2));
  EXPECT_EQ(line->commands[1].command->topic, "uagv/v2/K/2/instantActions");
  EXPECT_THAT(line->commands[1].command->payload.rest, HasSubstr(R"({"key":"y","value":-2})"));
  EXPECT_NE(line->commands[0].command->actions[0].id, line->commands[1].command->actions[0].id);
  EXPECT_THAT(line->commands[0].command->tracker, IsNull());
}

TEST(BatchLine, SpeaksToEachRobotInItsOwnWay) {
  LineDefaults defaults{.check = false};
  defaults.address = [](std::string_view word) -> Result<AddressedRobot> {
    vda5050::Dialect dialect;
    dialect.version = vda5050::Version::k210;
    const bool is_automatic = word == "asks";
    return AddressedRobot{
        {"K", "1"}, std::make_shared<const vda5050::Dialect>(dialect), is_automatic};
  };
  const auto line = Parsed(R"({"target":"agv1","action":"startPause"})", defaults);
  ASSERT_TRUE(line) << line.error().message;
  EXPECT_EQ(line->commands[0].command->topic, "uagv/v2/K/1/instantActions");
  const auto asks = R"({"target":"asks","action":"startPause")" + std::string();
  const auto asked = Parsed(asks + "}", defaults);
  ASSERT_TRUE(asked) << asked.error().message;
  EXPECT_FALSE(asked->commands[0].command) << "its version is not known yet";
  EXPECT_TRUE(asked->commands[0].robot.automatic);
  const auto named = Parsed(asks + R"(,"vda":"3.0.0"})", defaults);
  ASSERT_TRUE(named) << named.error().message;
  EXPECT_EQ(named->commands[0].command->topic, "vda5050/v3/K/1/instantActions");
  EXPECT_THAT(
      Parsed(R"({"target":["agv1","K/1"],"action":"startPause"})", defaults).error().message,
      HasSubstr("names K/1 twice"));
}

TEST(BatchLine, TakesPreparedMessagesAndSoar) {
  const auto message = Parsed(R"({"target":"K/1","topic":"responses","payload":)"
                              R"({"responses":[{"requestId":"r","grantType":"GRANTED"}]}})");
  ASSERT_TRUE(message) << message.error().message;
  EXPECT_EQ(message->commands[0].command->topic, "vda5050/v3/K/1/responses");
  const auto soar = Parsed(R"({"target":"soar.noc.autosub.ah1","soar":"acknowledgement",)"
                           R"("payload":{"acknowledged_message_ID":)"
                           R"("0f4cbbc5-57d4-4a1f-9b6c-6c8b6a9a1b11","status":"executed",)"
                           R"("approved":true}})");
  ASSERT_TRUE(soar) << soar.error().message;
  EXPECT_EQ(soar->commands[0].command->topic, "soar/noc/autosub/ah1/from_platform/acknowledgement");
}

TEST(BatchLine, LeavesWhatIsCheckedUntilTheRobotWasAsked) {
  const std::string line = R"({"target":["K/1","K/2"],"action":"cancelOrder","headerId":7)";
  const auto checked = Parsed(line + "}", {});
  ASSERT_TRUE(checked) << checked.error().message;
  ASSERT_THAT(checked->commands, SizeIs(2));
  EXPECT_FALSE(checked->commands[1].command);
  ASSERT_THAT(checked->commands[1].message, NotNull());
  EXPECT_EQ(checked->commands[1].robot.robot.serial_number, "2");
  EXPECT_EQ(checked->commands[1].header_id, 7U);
  const auto asked = Parsed(line + R"(,"vda":"auto"})");
  ASSERT_TRUE(asked) << asked.error().message;
  EXPECT_FALSE(asked->commands[0].command) << "without a check, its version is wanted all the same";
  EXPECT_TRUE(asked->commands[0].robot.automatic);
}

TEST(BatchLine, CallsActionsAsTheCommandLineDoes) {
  const auto type = [](std::string_view action) {
    const auto line =
        Parsed(R"({"target":"K/1","action":")" + std::string(action) + R"(","vda":"2.1"})");
    return line ? line->commands[0].command->actions[0].type : "refused: " + line.error().message;
  };
  EXPECT_EQ(type("pause"), "startPause");
  EXPECT_EQ(type("cancelorder"), "cancelOrder");
  EXPECT_EQ(type("beepLoudly"), "beepLoudly") << "a manufacturer's own";
  EXPECT_THAT(type("stratPause"), AllOf(HasSubstr("refused"), HasSubstr("did you mean")));
  EXPECT_EQ(type(R"(stratPause","exact":true,"id":"1)"), "stratPause");
  EXPECT_EQ(type(R"(pause","exact":true,"id":"1)"), "pause");
}

TEST(BatchLine, KeepsRobotsApartThatATemplateDoesNot) {
  LineDefaults defaults{.check = false};
  defaults.address = [](std::string_view word) -> Result<AddressedRobot> {
    vda5050::Dialect dialect;
    dialect.topics.topic_template =
        word == "K/2" ? "x/{manufacturer}/{serial}/instantAction" : "amr/{serial}/{topic}";
    return AddressedRobot{vda5050::ParseRobotAddress(word).value(),
                          std::make_shared<const vda5050::Dialect>(dialect), false};
  };
  LineParser parser(defaults, "");
  LineOrigin origin;
  const auto parse = [&](std::string_view target, std::string_view more = "") {
    return parser.Parse(fmt::format(R"({{"target":"{}","action":"pause"{}}})", target, more),
                        origin);
  };
  EXPECT_TRUE(parse("K/1"));
  EXPECT_TRUE(parse("K/1"));
  EXPECT_TRUE(parse("K/2"));
  EXPECT_THAT(parse("L/1").error().message, AllOf(HasSubstr("K/1"), HasSubstr("L/1")))
      << "of another line";
  EXPECT_THAT(parse("K/2", R"(,"wait":true)").error().message, HasSubstr("{topic}"));
}

TEST(BatchLine, WaitsAsTheLineSaysElseAsAllDo) {
  LineDefaults waits{.check = false};
  waits.wait_for = vda5050::WaitFor::kFinished;
  const auto with = [](std::string_view wait) {
    return R"({"target":"K/1","action":"startPause")" + std::string(wait) + "}";
  };
  EXPECT_THAT(Parsed(with(""))->commands[0].command->tracker, IsNull());
  EXPECT_THAT(Parsed(with(R"(,"wait":"accepted")"))->commands[0].command->tracker, NotNull());
  EXPECT_THAT(Parsed(with(""), waits)->commands[0].command->tracker, NotNull());
  EXPECT_THAT(Parsed(with(R"(,"wait":false)"), waits)->commands[0].command->tracker, IsNull());
}

TEST(BatchLine, SaysWhatIsWrong) {
  const std::pair<const char*, const char*> cases[] = {
      {"", "not valid JSON at column 1"},
      {"[]", "must be a JSON object"},
      {R"({"target":"K/1"})", "is missing"},
      {R"({"action":"x"})", "target is missing"},
      {R"({"target":"K/1","action":"x","topic":"order","payload":{}})", "exclude each other"},
      {R"({"target":"K/1","topic":"order"})", "needs a payload"},
      {R"({"target":"K/1","action":"x","restamp":true})", "restamp needs a topic"},
      {R"({"tarket":"K/1","action":"x"})", "did you mean target?"},
      {R"({"target":"K/1","action":"x","zzzzzz":1})", "a line has id, target"},
      {R"({"target":"K/1","action":"x","action":"y"})", "appears twice"},
      {R"({"target":"K/#","action":"x"})", "K/#"},
      {R"({"target":[],"action":"x"})", "target must be a text"},
      {R"({"target":["K/1","K/1"],"action":"x"})", "names K/1 twice"},
      {R"({"target":["K/1","K/2"],"action":"x","actionId":"a"})", "one target"},
      {R"({"target":"K/1","action":"x","id":true})", "id must be a text or a number"},
      {R"({"target":"K/1","action":"x","headerId":-1})", "headerId must be a whole number"},
      {R"({"target":"K/1","action":"x","wait":"often"})", "wait must be"},
      {R"({"target":"K/1","action":"pick"})", "never an instant action"},
      {R"({"target":"K/1","topic":"state","payload":{}})", "not a topic that fleet control"},
      {R"({"target":"a.b.c","soar":"plan","payload":{}})", "mission_plan"},
      {R"({"target":"a.b.c","soar":"observation","payload":{},"vda":"3"})", "belongs to VDA 5050"},
  };
  for (const auto& [line, reason] : cases) {
    const auto parsed = Parsed(line);
    ASSERT_FALSE(parsed) << line;
    EXPECT_THAT(parsed.error().message, HasSubstr(reason)) << line;
  }
}

TEST(BatchLine, KnowsTheCallersIdEvenOfABadLine) {
  LineParser parser({}, "");
  LineOrigin origin;
  EXPECT_FALSE(parser.Parse(R"({"id":"a\n1","target":"K/1","actoin":"x"})", origin));
  EXPECT_EQ(origin.id, R"("a\n1")");
  EXPECT_EQ(origin.target, "K/1");
}

}  // namespace
}  // namespace fleetpub::app
