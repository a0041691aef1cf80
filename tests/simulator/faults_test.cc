// How virtual robots refuse, fail, dawdle and keep silent.
#include "simulator/conversation.h"

namespace fleetpub::simulator {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;
using ::testing::StartsWith;
using vda5050::Version;

class Faults : public EachVersion {};

INSTANTIATE_TEST_SUITE_P(Versions, Faults, ::testing::ValuesIn(vda5050::kVersions), VersionName);

std::string ErrorTypes(const Conversation& robot) {
  std::string types;
  const auto state = robot.Last("state");
  for (const auto& error : state["errors"].GetArray()) {
    types += (types.empty() ? "" : " ");
    types += base::StringMember(error, "errorType");
  }
  return types;
}

TEST_P(Faults, AnUnknownActionIsRefusedAsTheVersionSays) {
  Conversation robot(Plain());
  const auto id = robot.Do("beep");
  EXPECT_EQ(robot.Of(id).starts_with("FAILED"), Is30());
  EXPECT_EQ(ErrorTypes(robot), Is30() ? "INVALID_INSTANT_ACTION" : "instantActionError");
  EXPECT_THAT(robot.At("/errors/0/errorReferences"),
              HasSubstr(R"({"referenceKey":"actionId","referenceValue":")" + id + "\"}"));
  EXPECT_THAT(robot.At("/errors/0/errorDescription"), HasSubstr("beep"));
  robot.Do("startPause");
  EXPECT_EQ(ErrorTypes(robot), "") << "the next accepted action clears it";
}

TEST_P(Faults, AMissingOrWrongParameterIsRefused) {
  Conversation robot(Plain());
  robot.Do("initPosition", {{"x", R"("1")"}});
  EXPECT_THAT(robot.At("/errors/0/errorDescription"), HasSubstr("must be a number"));
  robot.Do("logReport");
  EXPECT_THAT(robot.At("/errors/1/errorDescription"), HasSubstr("needs the parameter reason"));
  EXPECT_THAT(robot.events(), SizeIs(4)) << "two messages, two faults";
}

TEST_P(Faults, BothStylesOfRejectionCanBeHad) {
  for (const RejectStyle style : {RejectStyle::kState, RejectStyle::kError}) {
    Settings settings = Plain();
    settings.reject = {"startPause"};
    settings.reject_style = style;
    Conversation robot(settings);
    const auto id = robot.Do("startPause");
    EXPECT_EQ(robot.Of(id).starts_with("FAILED"), style == RejectStyle::kState);
    EXPECT_NE(ErrorTypes(robot), "");
    EXPECT_EQ(robot.At("/paused"), "false");
  }
}

TEST_P(Faults, AnActionFailsOnDemandAndChangesNothing) {
  Settings settings = Plain();
  settings.fail = {"startPause"};
  Conversation robot(settings);
  EXPECT_EQ(robot.Of(robot.Do("startPause")), "FAILED: startPause failed, as asked for");
  EXPECT_EQ(robot.At("/paused"), "false");
}

TEST_P(Faults, AnActionTakesItsTime) {
  Settings settings = Plain();
  settings.delay = std::chrono::seconds(2);
  Conversation robot(settings);
  const auto pause = robot.Do("startPause");
  const auto log = robot.Do("logReport", {{"reason", R"("x")"}});
  EXPECT_EQ(robot.Of(pause), "RUNNING");
  EXPECT_EQ(robot.Of(log), "INITIALIZING");
  EXPECT_EQ(robot.At("/paused"), "false");
  robot.Wait(std::chrono::seconds(1));
  EXPECT_EQ(robot.Of(log), "RUNNING");
  robot.Wait(std::chrono::seconds(1));
  EXPECT_EQ(robot.Of(pause), "FINISHED");
  EXPECT_EQ(robot.At("/paused"), "true");
  EXPECT_THAT(robot.Of(log), StartsWith("FINISHED"));
}

TEST_P(Faults, ASilentRobotObeysButReportsNoState) {
  Settings settings = Plain();
  settings.silent = true;
  Conversation robot(settings);
  robot.Do("startPause");
  robot.Wait(std::chrono::hours(1));
  EXPECT_EQ(robot.Times("state"), 0U);
  EXPECT_TRUE(robot.robot().state().paused);
  EXPECT_EQ(robot.Connections(), "ONLINE");
}

TEST_P(Faults, InManualModeActionsAreRefused) {
  Settings settings = Plain();
  settings.operating_mode = "MANUAL";
  Conversation robot(settings);
  robot.Do("startPause");
  EXPECT_EQ(robot.At("/operatingMode"), R"("MANUAL")");
  EXPECT_EQ(robot.At("/paused"), "false");
  EXPECT_THAT(robot.At("/errors/0/errorDescription"), HasSubstr("operating mode MANUAL"));
}

TEST(FaultsOf30, WhoIntervenesMayCancelTheOrder) {
  Conversation robot(
      Settings{.version = Version::k300, .operating_mode = "INTERVENED", .with_order = true});
  EXPECT_THAT(robot.Of(robot.Do("startPause")), StartsWith("FAILED"));
  EXPECT_EQ(robot.Of(robot.Do("cancelOrder")), "FINISHED");
}

struct Broken {
  const char* payload;
  const char* why;
};

constexpr Broken kBroken[] = {
    {"", "not valid JSON"},
    {"{", "not valid JSON"},
    {R"({"headerId":5})", "required but missing"},
    {R"([1])", "must be an object"},
};

TEST_P(Faults, ABrokenMessageIsRefusedAsAWhole) {
  for (const auto& [payload, why] : kBroken) {
    Conversation robot(Plain());
    robot.Hear("instantActions", payload);
    ASSERT_THAT(robot.events(), SizeIs(1));
    EXPECT_EQ(robot.events().front().kind, Event::Kind::kFault);
    EXPECT_THAT(robot.events().front().text, HasSubstr(why));
    EXPECT_EQ(ErrorTypes(robot), Is30() ? "VALIDATION_FAILURE" : "validationError");
    EXPECT_EQ(robot.At("/errors/0/errorReferences/0/referenceValue"), R"("instantActions")");
  }
}

TEST_P(Faults, AMessageOfAnotherVersionIsRefusedWithItsHeaderId) {
  Conversation robot(Plain());
  const vda5050::InstantAction action{"startPause", "a", "", "", {}};
  const auto command = vda5050::BuildInstantActions(
      {"KIT", "0001"}, {.version = GetParam(), .header_version = "9.9.9"}, {&action, 1});
  robot.Hear("instantActions", command->payload.Render(42, base::WallTime::clock::now()));
  EXPECT_EQ(robot.At("/paused"), "false");
  EXPECT_THAT(robot.At("/errors/0/errorReferences"),
              HasSubstr(R"({"referenceKey":"headerId","referenceValue":"42"})"));
}

TEST(FaultsOf20, TheArrayCanHaveItsOldName) {
  Settings settings{.version = Version::k200};
  settings.actions_key = "instantActions";
  Conversation robot(settings);
  const vda5050::InstantAction action{"startPause", "a", "", "", {}};
  const auto command = vda5050::BuildInstantActions(
      {"KIT", "0001"}, {.version = Version::k200, .actions_key = "instantActions"}, {&action, 1});
  robot.Hear("instantActions", command->payload.Render(1, base::WallTime::clock::now()));
  EXPECT_EQ(robot.At("/paused"), "true");
}

TEST_P(Faults, OnlySoMuchIsRemembered) {
  Conversation robot(Plain());
  std::string last;
  for (int i = 0; i < 500; ++i) last = robot.Do("startPause");
  EXPECT_EQ(robot.Of(last), "FINISHED");
  EXPECT_THAT(robot.robot().state().instant_actions, SizeIs(::testing::Lt(30U)));
  for (int i = 0; i < 50; ++i) robot.Do("beep");
  EXPECT_THAT(robot.robot().state().errors, SizeIs(::testing::Lt(20U)));
}

}  // namespace
}  // namespace fleetpub::simulator
