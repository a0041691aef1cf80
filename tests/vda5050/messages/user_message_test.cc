#include "vda5050/messages/user_message.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "base/json.h"

namespace fleetpub::vda5050 {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

const RobotAddress kRobot{"KIT", "0001"};

base::JsonDocument Parsed(std::string_view text) {
  auto document = base::ParseJson(text);
  if (!document) throw std::runtime_error(document.error().message);
  return std::move(*document);
}

Result<message::Command> Build(std::string_view topic, std::string_view message,
                               const Dialect& dialect = {},
                               HeaderMismatch foreign = HeaderMismatch::kRefuse) {
  return BuildUserMessage(kRobot, dialect, topic, Parsed(message), foreign);
}

std::string Sent(const message::Command& command) {
  return command.payload.Render(7, *base::ParseDateTime("2026-11-22T20:00:00.5Z"));
}

TEST(UserMessage, GetsTheHeaderThatIsMissing) {
  const auto command = Build("order", R"({"orderId":"o","nodes":[1.5,2]})");
  ASSERT_TRUE(command);
  EXPECT_EQ(command->topic, "vda5050/v3/KIT/0001/order");
  EXPECT_EQ(command->schema, "vda5050/3.0.0/order");
  EXPECT_EQ(Sent(*command),
            R"({"headerId":7,"timestamp":"2026-11-22T20:00:00.500Z","version":"3.0.0",)"
            R"("manufacturer":"KIT","serialNumber":"0001","orderId":"o","nodes":[1.5,2]})");
}

TEST(UserMessage, IsStampedAnewWhateverItSays) {
  const auto command = Build("order", R"({"headerId":99,"timestamp":"yesterday","orderId":"o"})");
  ASSERT_TRUE(command);
  EXPECT_THAT(Sent(*command), AllOf(HasSubstr(R"("headerId":7,)"), HasSubstr("2026-11-22")));
  EXPECT_EQ(Sent(*command).find("99"), std::string::npos);
}

TEST(UserMessage, OfAnotherRobotOrVersionIsRefused) {
  for (const char* message : {R"({"serialNumber":"0002"})", R"({"manufacturer":"ACME"})",
                              R"({"version":"2.1.0"})", R"({"version":3})"}) {
    const auto command = Build("order", message);
    ASSERT_FALSE(command) << message;
    EXPECT_EQ(command.error().kind, ErrorKind::kInvalid);
    EXPECT_THAT(command.error().message, HasSubstr("--restamp"));
    EXPECT_TRUE(Build("order", message, {}, HeaderMismatch::kReplace)) << message;
  }
}

TEST(UserMessage, MayNameAPatchLevelOfItsVersion) {
  const auto command = Build("order", R"({"version":"2.0.4"})", {.version = Version::k200});
  ASSERT_TRUE(command);
  EXPECT_THAT(command->warnings, IsEmpty());
  EXPECT_THAT(Sent(*command), HasSubstr(R"("version":"2.0.4")"));
  EXPECT_FALSE(Build("order", R"({"version":"2.0.4"})", {.version = Version::k210}));
}

TEST(UserMessage, TellsOfAVersionThatIsNoRelease) {
  const auto command = Build("order", R"({"version":"V2.0"})", {.version = Version::k200});
  ASSERT_TRUE(command);
  EXPECT_THAT(command->warnings, ElementsAre(AllOf(HasSubstr("V2.0"), HasSubstr("2.0.0"))));
  EXPECT_THAT(Sent(*command), HasSubstr(R"("version":"2.0.0")"));
  const auto restamped = Build("order", R"({"version":"new"})", {}, HeaderMismatch::kReplace);
  ASSERT_TRUE(restamped);
  EXPECT_THAT(restamped->warnings, ElementsAre(AllOf(HasSubstr("new"), HasSubstr("3.0.0"))));
}

TEST(UserMessage, TellsWhichVersionWasAssumed) {
  const auto assumed = Build("order", "{}", {.version = Version::k210, .assumed = true});
  EXPECT_THAT(assumed.value().warnings, ElementsAre(HasSubstr("2.1.0 is assumed")));
  EXPECT_THAT(Build("order", "{}", {.version = Version::k210}).value().warnings, IsEmpty());
  EXPECT_THAT(Build("zoneSet", "{}", {.assumed = true}).value().warnings, IsEmpty());
}

TEST(UserMessage, NamesTheOptionWhenItsActionsBearTheOtherName) {
  const auto command =
      Build("instantActions", R"({"instantActions":[]})", {.version = Version::k200});
  ASSERT_FALSE(command);
  EXPECT_EQ(command.error().kind, ErrorKind::kInvalid);
  EXPECT_THAT(command.error().message, HasSubstr("--actions-key instantActions"));
  const auto old = Build("instantActions", R"({"actions":[]})", {.version = Version::k110});
  EXPECT_THAT(old.error().message, HasSubstr("--actions-key actions"));
  EXPECT_TRUE(Build("instantActions", R"({"instantActions":[]})",
                    {.version = Version::k200, .actions_key = "instantActions"}));
}

// What is under the other name would be neither checked nor waited for, and some robots carry it out.
TEST(UserMessage, HasItsActionsUnderOneNameOnly) {
  for (const char* key : {"", "actions", "instantActions"}) {
    const auto command = Build("instantActions", R"({"actions":[],"instantActions":[]})",
                               {.version = Version::k200, .actions_key = key});
    ASSERT_FALSE(command);
    EXPECT_EQ(command.error().kind, ErrorKind::kInvalid);
    EXPECT_THAT(command.error().message, HasSubstr("leave only the one"));
  }
}

TEST(UserMessage, MayCarryAHeaderThatTheDialectAsksFor) {
  EXPECT_TRUE(Build("order", R"({"serialNumber":"0002"})", {.header_serial = "0002"}));
}

TEST(UserMessage, IsForATopicThatTheVersionHas) {
  for (const char* topic : {"zoneSet", "responses"}) {
    const auto command = Build(topic, "{}", {.version = Version::k210});
    ASSERT_FALSE(command);
    EXPECT_THAT(command.error().message, HasSubstr("from version 3.0.0 on"));
    EXPECT_TRUE(Build(topic, "{}"));
  }
}

TEST(UserMessage, MustBeAnObject) {
  EXPECT_FALSE(Build("order", "[]"));
  EXPECT_FALSE(Build("order", "1"));
}

TEST(UserMessage, TellsWhatIsInIt) {
  const auto contents = [](std::string_view topic, std::string_view message) {
    const auto command = Build(topic, message);
    std::string text;
    for (const auto& item : command.value().actions) text += item.type + ":" + item.id + " ";
    return text;
  };
  EXPECT_EQ(contents("order", R"({"orderId":"o"})"), "order:o ");
  EXPECT_EQ(contents("zoneSet", R"({"zoneSet":{"zoneSetId":"z"}})"), "zoneSet:z ");
  EXPECT_EQ(contents("responses", R"({"responses":[{"requestId":"r","grantType":"QUEUED"}]})"),
            "QUEUED:r ");
  EXPECT_EQ(contents("instantActions",
                     R"({"actions":[{"actionType":"a","actionId":"1"},{"actionType":"b"}]})"),
            "a:1 b: ");
}

TEST(PublishedTopic, KnowsWhatFleetControlPublishes) {
  EXPECT_EQ(PublishedTopic("ZONESET").value(), "zoneSet");
  EXPECT_THAT(PublishedTopic("state").error().message, HasSubstr("order, instantActions"));
}

TEST(ResponsesMessage, IsOneAnswer) {
  const auto lease = *base::ParseDateTime("2026-11-22T20:00:30Z");
  EXPECT_EQ(base::ToJson(ResponsesMessage({"r\"1", "GRANTED", lease})),
            R"({"responses":[{"requestId":"r\"1","grantType":"GRANTED",)"
            R"("leaseExpiry":"2026-11-22T20:00:30.000Z"}]})");
  EXPECT_EQ(base::ToJson(ResponsesMessage({"r", "QUEUED", {}})),
            R"({"responses":[{"requestId":"r","grantType":"QUEUED"}]})");
}

// ── trackers ──

constexpr std::string_view kOrder =
    R"({"orderId":"o","orderUpdateId":2,"nodes":[{"nodeId":"n1"},
    {"nodeId":"n2","actions":[{"actionId":"a1"}]}],"edges":[{}]})";

class UserMessageTracker : public ::testing::Test {
 protected:
  void Follow(std::string_view topic, std::string_view message, WaitFor wait_for) {
    auto made = TrackUserMessage(kRobot, {}, topic, Parsed(message), wait_for);
    ASSERT_TRUE(made) << made.error().message;
    tracker_ = std::move(*made);
  }
  void FollowAndPublish(std::string_view topic, std::string_view message, WaitFor wait_for) {
    Follow(topic, message, wait_for);
    tracker_->Published(7);
  }
  void State(std::string_view payload, bool retained = false) {
    tracker_->Receive({"vda5050/v3/KIT/0001/state", payload, retained});
  }
  void Connection(std::string_view payload) {
    tracker_->Receive({"vda5050/v3/KIT/0001/connection", payload});
  }
  [[nodiscard]] std::string Ending() const {
    const auto& now = tracker_->progress();
    return now.ended ? std::string(message::GetName(now.status)) : "";
  }
  [[nodiscard]] std::string Told() const { return tracker_->progress().message; }

  std::unique_ptr<message::ResponseTracker> tracker_;
};

TEST_F(UserMessageTracker, OfAnOrderIsTheStateThatShowsIt) {
  FollowAndPublish("order", kOrder, WaitFor::kAccepted);
  State(R"({"orderId":"other","orderUpdateId":2})");
  EXPECT_EQ(Ending(), "");
  State(R"({"orderId":"o","orderUpdateId":1})");
  EXPECT_EQ(Ending(), "") << "an earlier update";
  State(R"({"orderId":"o","orderUpdateId":2})");
  EXPECT_EQ(Ending(), "ACCEPTED");
}

TEST_F(UserMessageTracker, IsNeverWhatWasThereBefore) {
  Follow("order", kOrder, WaitFor::kAccepted);
  State(R"({"orderId":"o","orderUpdateId":2})");
  EXPECT_EQ(Ending(), "");
  tracker_->Published(7);
  State(R"({"orderId":"o","orderUpdateId":2})", true);
  EXPECT_EQ(Ending(), "") << "retained";
}

TEST_F(UserMessageTracker, OfAnOrderFinishesWhenAllIsDone) {
  FollowAndPublish("order", kOrder, WaitFor::kFinished);
  State(R"({"orderId":"o","orderUpdateId":2,"nodeStates":[{}],"edgeStates":[]})");
  EXPECT_EQ(Ending(), "");
  EXPECT_TRUE(tracker_->progress().seen);
  State(R"({"orderId":"o","orderUpdateId":2,"nodeStates":[],"edgeStates":[],"lastNodeId":"n2",
      "actionStates":[{"actionId":"a1","actionStatus":"RUNNING"}]})");
  EXPECT_EQ(Ending(), "") << "an action is still running";
  State(R"({"orderId":"o","orderUpdateId":2,"nodeStates":[],"edgeStates":[],"lastNodeId":"n2",
      "actionStates":[{"actionId":"a1","actionStatus":"FINISHED"}]})");
  EXPECT_EQ(Ending(), "FINISHED");
}

TEST_F(UserMessageTracker, OfAnOrderFailsWithItsActions) {
  FollowAndPublish("order", kOrder, WaitFor::kFinished);
  State(R"({"orderId":"o","orderUpdateId":2,"nodeStates":[],"edgeStates":[],"lastNodeId":"n2",
      "actionStates":[{"actionId":"a1","actionType":"pick","actionStatus":"FAILED",
      "actionResult":"no load"}]})");
  EXPECT_EQ(Ending(), "FAILED");
  EXPECT_EQ(Told(), "action pick failed: no load");
}

TEST_F(UserMessageTracker, OfAnOrderThatWasCancelledIsNoSuccess) {
  FollowAndPublish("order", kOrder, WaitFor::kFinished);
  State(R"({"orderId":"o","orderUpdateId":2,"nodeStates":[{}],"edgeStates":[]})");
  State(R"({"orderId":"o","orderUpdateId":2,"nodeStates":[],"edgeStates":[],"lastNodeId":"n1"})");
  EXPECT_EQ(Ending(), "FAILED");
  EXPECT_THAT(Told(), AllOf(HasSubstr("n1"), HasSubstr("n2")));
}

TEST_F(UserMessageTracker, OfAnOrderThatAnotherReplacesIsVanished) {
  FollowAndPublish("order", kOrder, WaitFor::kFinished);
  State(R"({"orderId":"o","orderUpdateId":2,"nodeStates":[{}],"edgeStates":[]})");
  State(R"({"orderId":"p","orderUpdateId":0})");
  EXPECT_EQ(Ending(), "VANISHED");
}

TEST_F(UserMessageTracker, OfAnOrderIsRefusedByANewErrorThatNamesIt) {
  Follow("order", kOrder, WaitFor::kAccepted);
  constexpr std::string_view kOld =
      R"({"errors":[{"errorType":"old","errorReferences":[{"referenceKey":"orderId",
      "referenceValue":"o"}]}]})";
  State(kOld);
  tracker_->Published(7);
  State(kOld);
  EXPECT_EQ(Ending(), "") << "an error of before";
  State(R"({"orderId":"o","orderUpdateId":2,"errors":[{"errorType":"orderError",
      "errorDescription":"no route","errorReferences":[{"referenceKey":"orderId",
      "referenceValue":"o"},{"referenceKey":"orderUpdateId","referenceValue":"2"}]}]})");
  EXPECT_EQ(Ending(), "REJECTED") << "though it shows an order of this id";
  EXPECT_THAT(Told(), ::testing::EndsWith("orderError: no route"));
}

TEST_F(UserMessageTracker, TellsWhatDoesNotCountAndGoesOn) {
  FollowAndPublish("order", kOrder, WaitFor::kAccepted);
  State(R"({"orderId":"o","orderUpdateId":2,"serialNumber":"0002"})");
  EXPECT_EQ(Ending(), "");
  EXPECT_THAT(Told(), HasSubstr("KIT/0002"));
  State(R"({"orderId":"o","x":)" + std::string(80, '[') + std::string(80, ']') + "}");
  EXPECT_EQ(Ending(), "");
  EXPECT_THAT(Told(), AllOf(HasSubstr("64 levels"), Not(HasSubstr("KIT/0002"))));
  State(R"({"orderId":"o","orderUpdateId":2,"serialNumber":"0001"})");
  EXPECT_EQ(Ending(), "ACCEPTED");
}

TEST_F(UserMessageTracker, OfAnOrderTakesNoOtherActionForItsOwn) {
  FollowAndPublish("order", R"({"orderId":"o","orderUpdateId":2,
      "nodes":[{"nodeId":"n2","actions":[{"actionId":"a1","actionType":"drop"}]}]})",
                   WaitFor::kFinished);
  constexpr std::string_view kDone =
      R"({{"orderId":"o","orderUpdateId":2,"nodeStates":[],"edgeStates":[],"lastNodeId":"n2",
      "actionStates":[{{"actionId":"a1","actionType":"{}","actionStatus":"{}"}}]}})";
  State(fmt::format(kDone, "pick", "FINISHED"));
  EXPECT_EQ(Ending(), "");
  EXPECT_THAT(Told(), HasSubstr("another action, pick"));
  State(fmt::format(kDone, "drop", "FINISHED"));
  EXPECT_EQ(Ending(), "FINISHED");
  FollowAndPublish("order", kOrder, WaitFor::kFinished);
  State(R"({"orderId":"o","orderUpdateId":2,"nodeStates":[],"edgeStates":[],"lastNodeId":"n2",
      "actionStates":[{"actionId":"a1","actionStatus":"FINISHED"},
      {"actionId":"a1","actionStatus":"FAILED"}]})");
  EXPECT_EQ(Ending(), "FAILED") << "a contradiction";
}

TEST_F(UserMessageTracker, EndsWithTheRobotsConnection) {
  FollowAndPublish("order", kOrder, WaitFor::kFinished);
  Connection(R"({"connectionState":"ONLINE"})");
  EXPECT_EQ(Ending(), "");
  Connection(R"({"connectionState":"CONNECTION_BROKEN"})");
  EXPECT_EQ(Ending(), "OFFLINE");
}

TEST_F(UserMessageTracker, OfAZoneSetIsItsEntry) {
  FollowAndPublish("zoneSet", R"({"zoneSet":{"zoneSetId":"z"}})", WaitFor::kFinished);
  State(R"({"zoneSets":[{"zoneSetId":"y"}]})");
  EXPECT_EQ(Ending(), "");
  State(R"({"zoneSets":[{"zoneSetId":"z","zoneSetStatus":"DISABLED"}]})");
  EXPECT_EQ(Ending(), "FINISHED");
}

TEST_F(UserMessageTracker, OfAResponseIsTheRequestsStatus) {
  FollowAndPublish("responses", R"({"responses":[{"requestId":"r","grantType":"GRANTED"}]})",
                   WaitFor::kFinished);
  State(R"({"edgeRequests":[{"requestId":"r","requestStatus":"REQUESTED"}]})");
  EXPECT_EQ(Ending(), "");
  State(R"({"edgeRequests":[{"requestId":"r","requestStatus":"GRANTED"}]})");
  EXPECT_EQ(Ending(), "FINISHED");
}

TEST_F(UserMessageTracker, OfAResponseThatNoStateShowsIsRefused) {
  const auto made = TrackUserMessage(
      kRobot, {}, "responses", Parsed(R"({"responses":[{"requestId":"r","grantType":"QUEUED"}]})"),
      WaitFor::kFinished);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().kind, ErrorKind::kUsage);
}

TEST_F(UserMessageTracker, OfSeveralActionsEndsWithTheLast) {
  constexpr std::string_view kTwo =
      R"({"actions":[{"actionType":"a","actionId":"1"},{"actionType":"b","actionId":"2"}]})";
  FollowAndPublish("instantActions", kTwo, WaitFor::kFinished);
  State(R"({"instantActionStates":[{"actionId":"1","actionStatus":"FINISHED"}]})");
  EXPECT_EQ(Ending(), "");
  State(R"({"instantActionStates":[{"actionId":"1","actionStatus":"FINISHED"},
      {"actionId":"2","actionStatus":"FINISHED"}]})");
  EXPECT_EQ(Ending(), "FINISHED");
}

TEST_F(UserMessageTracker, OfSeveralActionsEndsWithTheFirstThatFails) {
  FollowAndPublish("instantActions",
                   R"({"actions":[{"actionType":"a","actionId":"1"},
                   {"actionType":"b","actionId":"2"}]})",
                   WaitFor::kFinished);
  State(R"({"instantActionStates":[{"actionId":"2","actionStatus":"FAILED"}]})");
  EXPECT_EQ(Ending(), "FAILED");
}

TEST_F(UserMessageTracker, PassesOverRubbish) {
  FollowAndPublish("order", kOrder, WaitFor::kAccepted);
  for (const std::string_view rubbish : {"", "x", "[]", R"({"orderId":7})"}) {
    State(rubbish);
    Connection(rubbish);
  }
  EXPECT_EQ(Ending(), "");
}

}  // namespace
}  // namespace fleetpub::vda5050
