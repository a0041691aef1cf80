#include "vda5050/tracking/action_tracker.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "vda5050/tracking/tracker_support.h"

namespace fleetpub::vda5050 {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

// ── topics ──

TEST_F(ResponseTracker, ListensToStateAndConnection) {
  Follow("startPause");
  EXPECT_THAT(tracker_->Topics(),
              ElementsAre("vda5050/v3/KIT/0001/state", "vda5050/v3/KIT/0001/connection"));
}

TEST_F(ResponseTracker, ListensToTheFactsheetWhenItIsAskedFor) {
  Follow("factsheetRequest", WaitFor::kFinished, Version::k210);
  EXPECT_THAT(tracker_->Topics(),
              ElementsAre("uagv/v2/KIT/0001/state", "uagv/v2/KIT/0001/connection",
                          "uagv/v2/KIT/0001/factsheet"));
}

TEST_F(ResponseTracker, CannotBeForATopicThatCannotBe) {
  const auto made = TrackInstantAction(kRobot, {.topics = {.interface_name = "#"}},
                                       {"startPause", "a1", "", "", {}});
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().kind, ErrorKind::kUsage);
}

TEST_F(ResponseTracker, PassesOverOtherTopicsAndRubbish) {
  FollowAndPublish("startPause");
  const std::string finished =
      fmt::format(R"({{"instantActionStates":[{}]}})", Entry(kId, "FINISHED"));
  tracker_->Receive({.topic = "vda5050/v3/KIT/0002/state", .payload = finished});
  Hear("order", finished);
  for (const std::string_view rubbish : {"", "x", "[]", "{"}) {
    Hear("state", rubbish);
    Hear("connection", rubbish);
  }
  EXPECT_FALSE(HasEnded());
  EXPECT_THAT(Told(), HasSubstr("sent no state"));
}

// ── what confirms nothing ──

TEST_F(ResponseTracker, TellsWhyAStateCannotBeRead) {
  const std::string deep = R"({"instantActionStates":[)" + Entry(kId, "FINISHED") + R"(],"x":)" +
                           std::string(70, '[') + std::string(70, ']') + "}";
  const std::string large = R"({"x":")" + std::string(std::size_t{17} << 20U, 'a') + R"("})";
  for (const auto& [payload, word] : {std::pair(deep, "64 levels"), std::pair(large, "too large"),
                                      std::pair(std::string("{"), "not valid JSON")}) {
    FollowAndPublish("startPause");
    Hear("state", payload);
    EXPECT_FALSE(HasEnded());
    EXPECT_THAT(Told(), AllOf(HasSubstr("did not count"), HasSubstr(word)));
  }
  Hear("state", "");
  HearActions(Entry(kId, "FINISHED"));
  EXPECT_EQ(Ending(), "FINISHED") << "the next one counts";
}

TEST_F(ResponseTracker, TakesNoWordFromAnotherRobotsHeader) {
  const auto state = [](std::string_view header) {
    return fmt::format(R"({},"instantActionStates":[{}])", header, Entry(kId, "FINISHED"));
  };
  for (const std::string_view other : {R"("manufacturer":"KIT","serialNumber":"0002")",
                                       R"("manufacturer":"ACME")", R"("serialNumber":2)"}) {
    FollowAndPublish("startPause");
    HearState(state(other));
    EXPECT_FALSE(HasEnded()) << other;
    EXPECT_THAT(Told(), AllOf(HasSubstr("its header names"), HasSubstr("--header-serial")));
  }
  for (const std::string_view own : {R"("manufacturer":"KIT","serialNumber":"0001")",
                                     R"("manufacturer":"kit")", R"("serialNumber":null)"}) {
    FollowAndPublish("startPause");
    HearState(state(own));
    EXPECT_EQ(Ending(), "FINISHED") << own;
  }
}

TEST_F(ResponseTracker, TakesNoConnectionOrFactsheetFromAnotherRobotsHeader) {
  FollowAndPublish("shutdown");
  Hear("connection", R"({"serialNumber":"0002","connectionState":"OFFLINE"})");
  EXPECT_FALSE(HasEnded());
  EXPECT_THAT(Told(), HasSubstr("KIT/0002"));
  Hear("connection", R"({"serialNumber":"0001","connectionState":"OFFLINE"})");
  EXPECT_EQ(Ending(), "FINISHED");
  FollowAndPublish("factsheetRequest");
  Hear("factsheet", R"({"manufacturer":"ACME"})");
  EXPECT_FALSE(HasEnded());
}

TEST_F(ResponseTracker, KnowsTheNameThatTheDialectGivesTheRobot) {
  const Dialect dialect{.header_serial = "AGV-1"};
  tracker_ = *TrackInstantAction(kRobot, dialect, {"startPause", std::string(kId), "", "", {}});
  prefix_ = "vda5050/v3/KIT/0001/";
  Publish();
  HearState(fmt::format(R"("serialNumber":"AGV-1","actionStates":[{}])", Entry(kId, "FINISHED")));
  EXPECT_EQ(Ending(), "FINISHED");
}

TEST_F(ResponseTracker, TakesAnActionOfAnotherTypeForAnotherAction) {
  for (const std::string_view status : {"FINISHED", "FAILED", "RUNNING"}) {
    FollowAndPublish("startPause");
    HearActions(Entry(kId, status, R"(,"actionType":"startCharging")"));
    HearActions("");
    EXPECT_EQ(Ending(), "WAITING") << status;
    EXPECT_THAT(Told(), HasSubstr("startCharging"));
  }
  HearActions(Entry(kId, "FINISHED", R"(,"actionType":"startCharging")") + "," +
              Entry(kId, "FINISHED", R"(,"actionType":"STARTPAUSE")"));
  EXPECT_EQ(Ending(), "FINISHED");
  FollowAndPublish("initializePosition");
  HearActions(Entry(kId, "FINISHED", R"(,"actionType":"initPosition")"));
  EXPECT_EQ(Ending(), "FINISHED") << "the older versions' name for it";
}

TEST_F(ResponseTracker, DoesNotTakeTheListingAsAnotherActionForVanishing) {
  FollowAndPublish("startPause");
  HearActions(Entry(kId, "RUNNING"));
  HearActions(Entry(kId, "RUNNING", R"(,"actionType":"startCharging")"));
  EXPECT_EQ(Ending(), "WAITING");
}

TEST_F(ResponseTracker, TakesAContradictionForAFailure) {
  for (const bool failed_first : {true, false}) {
    FollowAndPublish("startPause");
    const std::string failed = Entry(kId, "FAILED");
    const std::string finished = Entry(kId, "FINISHED");
    HearState(fmt::format(R"("actionStates":[{}],"instantActionStates":[{}])",
                          failed_first ? failed : finished, failed_first ? finished : failed));
    EXPECT_EQ(Ending(), "FAILED");
    EXPECT_THAT(Told(), HasSubstr("FINISHED too"));
  }
  FollowAndPublish("startPause");
  HearActions(Entry(kId, "FINISHED") + "," + Entry(kId, "FAILED"));
  EXPECT_EQ(Ending(), "FAILED");
}

// ── FINISHED ──

TEST_F(ResponseTracker, EndsWithFinished) {
  FollowAndPublish("startPause");
  HearActions(Entry(kId, "FINISHED"));
  EXPECT_EQ(Ending(), "FINISHED");
  EXPECT_TRUE(Now().seen);
  EXPECT_EQ(Told(), "");
}

TEST_F(ResponseTracker, FindsTheActionInEitherArrayOfEveryVersion) {
  for (const Version version : kVersions) {
    for (const std::string array : {"actionStates", "instantActionStates"}) {
      Follow("cancelOrder", WaitFor::kFinished, version);
      if (version == Version::k110) prefix_ = "uagv/v1/KIT/0001/";
      Publish();
      HearState(
          fmt::format(R"("{}":[{},{}])", array, Entry(kOther, "FAILED"), Entry(kId, "finished")));
      EXPECT_EQ(Ending(), "FINISHED") << GetFacts(version).name << " " << array;
    }
  }
}

TEST_F(ResponseTracker, WaitsThroughEveryOtherStatus) {
  FollowAndPublish("startPause");
  for (const std::string_view status :
       {"WAITING", "INITIALIZING", "RUNNING", "PAUSED", "running", "DREAMING", ""}) {
    HearActions(Entry(kId, status));
    EXPECT_EQ(Ending(), "WAITING") << status;
    EXPECT_TRUE(Now().seen);
  }
  HearActions(Entry(kId, "FINISHED"));
  EXPECT_EQ(Ending(), "FINISHED");
}

TEST_F(ResponseTracker, TellsTheResultOfAFinishedAction) {
  Follow("logReport", WaitFor::kFinished, Version::k210);
  Publish();
  HearState(fmt::format(R"("actionStates":[{}])",
                        Entry(kId, "FINISHED", R"(,"resultDescription":"log-7.zip")")));
  EXPECT_EQ(Told(), "log-7.zip");
  FollowAndPublish("logReport");
  HearActions(Entry(kId, "FINISHED", R"(,"actionResult":"log-8.zip")"));
  EXPECT_EQ(Told(), "log-8.zip");
}

TEST_F(ResponseTracker, ShowsNothingThatMovesACursorAndNoNovels) {
  FollowAndPublish("logReport");
  HearActions(Entry(kId, "FINISHED",
                    fmt::format(R"(,"actionResult":"\u001b[2J\n{}")", std::string(5000, 'x'))));
  EXPECT_THAT(Told(), HasSubstr("\\x1b[2J\\n"));
  EXPECT_LT(Told().size(), 300U);
}

TEST_F(ResponseTracker, IsShortWhateverNumberOfErrorsThereIs) {
  FollowAndPublish("beep");
  std::string errors;
  for (int i = 0; i < 50; ++i) {
    errors +=
        (i == 0 ? "" : ",") + Error(fmt::format("{}{}", std::string(500, 'E'), i), "actionId", kId);
    errors += "," + Error(fmt::format("E{}{}", i, std::string(500, 'E')), "actionId", kId);
  }
  HearErrors(errors);
  EXPECT_EQ(Ending(), "REJECTED");
  EXPECT_LT(Told().size(), 510U);
}

TEST_F(ResponseTracker, KeepsItsVerdict) {
  FollowAndPublish("startPause");
  HearActions(Entry(kId, "FINISHED"));
  HearActions(Entry(kId, "FAILED"));
  HearConnection("OFFLINE");
  EXPECT_EQ(Ending(), "FINISHED");
}

TEST_F(ResponseTracker, ConfirmsByAStateThatBreaksItsSchema) {
  FollowAndPublish("startPause");
  HearState(fmt::format(R"("headerId":-5,"errors":7,"operatingMode":[],"actionStates":[null,{}])",
                        Entry(kId, "FINISHED", R"(,"extra":{})")));
  EXPECT_EQ(Ending(), "FINISHED");
}

TEST_F(ResponseTracker, TakesStatesWhoseHeaderIdFallsBack) {
  FollowAndPublish("startPause");
  HearState(R"("headerId":500,"timestamp":"2026-01-02T03:04:05.678Z")");
  HearState(
      fmt::format(R"("headerId":0,"timestamp":"2026-01-02T03:04:06.678Z","actionStates":[{}])",
                  Entry(kId, "FINISHED")));
  EXPECT_EQ(Ending(), "FINISHED");
}

// ── what confirms nothing ──

TEST_F(ResponseTracker, IsNotConfirmedByRetainedMessages) {
  for (const std::string type : {"shutdown", "stopHibernation", "factsheetRequest"}) {
    FollowAndPublish(type);
    HearActions(Entry(kId, "FINISHED"), "", kRetained);
    HearErrors(Error("E", "actionId", kId), kRetained);
    HearConnection("OFFLINE", kRetained);
    HearConnection("ONLINE", kRetained);
    Hear("factsheet", R"({"version":"3.0.0"})", kRetained);
    EXPECT_EQ(Ending(), "WAITING") << type;
    EXPECT_FALSE(Now().seen);
  }
}

TEST_F(ResponseTracker, IsNotConfirmedByWhatWasReceivedBeforePublishing) {
  for (const std::string type : {"shutdown", "stopHibernation", "factsheetRequest"}) {
    Follow(type);
    HearActions(Entry(kId, "FINISHED"));
    HearErrors(Error("E", "actionId", kId));
    HearConnection("OFFLINE");
    HearConnection("ONLINE");
    Hear("factsheet", R"({"version":"3.0.0"})");
    EXPECT_EQ(Ending(), "WAITING") << type;
    Publish();
    EXPECT_EQ(Ending(), "WAITING") << type;
    EXPECT_FALSE(Now().seen);
  }
}

TEST_F(ResponseTracker, IsNotConfirmedByAnEarlierActionOfTheSameId) {
  Follow("startPause", WaitFor::kFinished, Version::k300, "pause-1");
  HearActions(Entry("pause-1", "FINISHED"));
  Publish();
  HearActions(Entry("pause-1", "FINISHED"));
  EXPECT_EQ(Ending(), "WAITING");
  EXPECT_THAT(Told(), HasSubstr("had listed this actionId as FINISHED before"));
  HearActions(Entry("pause-1", "RUNNING"));
  HearActions(Entry("pause-1", "FINISHED"));
  EXPECT_EQ(Ending(), "FINISHED");
}

// ── FAILED, RETRIABLE ──

TEST_F(ResponseTracker, EndsWithFailedAndTheRobotsWords) {
  FollowAndPublish("startPause");
  HearActions(Entry(kId, "FAILED", R"(,"actionResult":"brake stuck")"));
  EXPECT_EQ(Ending(), "FAILED");
  EXPECT_EQ(Told(), "brake stuck");
}

TEST_F(ResponseTracker, SaysWhenTheRobotGaveNoReason) {
  FollowAndPublish("startPause");
  HearActions(Entry(kId, "FAILED"));
  EXPECT_EQ(Told(), "the robot gave no reason");
}

TEST_F(ResponseTracker, TellsWhyThereWasNothingToCancel) {
  FollowAndPublish("cancelOrder");
  HearActions(Entry(kId, "FAILED"),
              Error("NO_ORDER_TO_CANCEL", "actionId", kId,
                    R"(,"errorDescription":"no active order","errorHint":"nothing to do")"));
  EXPECT_EQ(Ending(), "NO_ORDER");
  EXPECT_EQ(Told(), "NO_ORDER_TO_CANCEL: no active order; hint: nothing to do");
}

TEST_F(ResponseTracker, SaysWhatASilentRobotOf20MayExpect) {
  Follow("startPause", WaitFor::kFinished, Version::k200);
  Publish();
  EXPECT_THAT(Told(), HasSubstr("--actions-key instantActions"));
  HearState(R"("actionStates":[])");
  EXPECT_THAT(Told(), HasSubstr("--actions-key instantActions"));
  HearState(fmt::format(R"("actionStates":[{}])", Entry(kId, "RUNNING")));
  EXPECT_THAT(Told(), Not(HasSubstr("--actions-key")));
  Follow("startPause", WaitFor::kFinished, Version::k210);
  Publish();
  EXPECT_THAT(Told(), Not(HasSubstr("--actions-key")));
}

TEST_F(ResponseTracker, RemembersTheErrorOfAnEarlierState) {
  // ros_amr_interop shows an error in exactly one state.
  FollowAndPublish("startPause");
  HearActions(Entry(kId, "RUNNING"), Error("actionFailed", "action_id", kId));
  HearActions(Entry(kId, "FAILED"));
  EXPECT_EQ(Ending(), "FAILED");
  EXPECT_EQ(Told(), "actionFailed");
}

TEST_F(ResponseTracker, LeavesOutOthersErrors) {
  FollowAndPublish("cancelOrder");
  HearActions(Entry(kId, "FAILED"), Error("NO_ORDER_TO_CANCEL", "actionId", kOther));
  EXPECT_EQ(Told(), "the robot gave no reason");
}

TEST_F(ResponseTracker, EndsWithRetriableAndSaysWhatToDo) {
  FollowAndPublish("startCharging");
  HearActions(Entry(kId, "RETRIABLE", R"(,"actionResult":"no contact")"));
  EXPECT_EQ(Ending(), "RETRIABLE");
  EXPECT_THAT(Told(), AllOf(HasSubstr(fmt::format("retry --actionId {}", kId)),
                            HasSubstr("skipRetry"), HasSubstr("no contact")));
}

// ── rejection ──

TEST_F(ResponseTracker, EndsWithRejectedByAnErrorAlone) {
  // vda-5050-lib and libVDA5050++ list no action that they refuse.
  for (const std::string key : {"actionId", "action.actionId", "action_id", "thing"}) {
    FollowAndPublish("beep");
    HearErrors(Error("instantActionError", key, kId, R"(,"errorDescription":"no such action")"));
    EXPECT_EQ(Ending(), "REJECTED") << key;
    EXPECT_TRUE(Now().seen);
    EXPECT_EQ(Told(), "instantActionError: no such action");
  }
}

TEST_F(ResponseTracker, IsRejectedByAnErrorThatStandsInOneStateOnly) {
  FollowAndPublish("beep");
  HearErrors("");
  HearErrors(Error("actionNotFound", "action_id", kId));
  HearErrors("");
  EXPECT_EQ(Ending(), "REJECTED");
}

TEST_F(ResponseTracker, IsNotRejectedByAnErrorWhileTheRobotListsTheAction) {
  // libVDA5050++ answers a QoS 1 duplicate with an error for an action that is running.
  FollowAndPublish("startPause");
  HearActions(Entry(kId, "RUNNING"), Error("orderError", "action.actionId", kId));
  EXPECT_EQ(Ending(), "WAITING");
  EXPECT_THAT(Told(), HasSubstr("orderError"));
  HearActions(Entry(kId, "FINISHED"), Error("orderError", "action.actionId", kId));
  EXPECT_EQ(Ending(), "FINISHED");
}

TEST_F(ResponseTracker, IsNeverRejectedByATypeAlone) {
  FollowAndPublish("cancelOrder");
  HearErrors(Error("NO_ORDER_TO_CANCEL", "actionId", kOther) + "," +
             R"({"errorType":"INVALID_INSTANT_ACTION"})");
  EXPECT_EQ(Ending(), "WAITING");
  EXPECT_FALSE(Now().seen);
}

TEST_F(ResponseTracker, IsNotRejectedByAnOldErrorOfTheSameId) {
  Follow("beep", WaitFor::kFinished, Version::k300, "beep-1");
  HearErrors(Error("E", "actionId", "beep-1"));
  Publish();
  HearErrors(Error("E", "actionId", "beep-1"));
  EXPECT_EQ(Ending(), "WAITING");
}

std::string AboutMessage(std::uint32_t header_id) {
  return fmt::format(
      R"({{"errorType":"validationError","errorReferences":[)"
      R"({{"referenceKey":"topic","referenceValue":"instantActions"}},)"
      R"({{"referenceKey":"headerId","referenceValue":"{}"}}],"errorDescription":"version"}})",
      header_id);
}

TEST_F(ResponseTracker, IsProbablyRejectedByANewErrorWithItsHeaderId) {
  // vda-5050-lib, when it dislikes the header.
  FollowAndPublish("startPause");
  HearErrors(AboutMessage(kHeaderId));
  EXPECT_EQ(Ending(), "REJECTED");
  EXPECT_THAT(Told(), AllOf(HasSubstr("probably ours, by its header id: validationError: version"),
                            HasSubstr("no earlier state is known")));
}

TEST_F(ResponseTracker, IsNotRejectedByAnErrorWithAnothersHeaderId) {
  FollowAndPublish("startPause");
  HearErrors(AboutMessage(kHeaderId - 1));
  HearErrors(Error("orderError", "headerId", fmt::to_string(kHeaderId)));
  EXPECT_EQ(Ending(), "WAITING");
}

TEST_F(ResponseTracker, IsNotRejectedByAnErrorThatHadItsHeaderIdBefore) {
  for (const bool retained : {false, true}) {
    Follow("startPause");
    HearErrors(AboutMessage(kHeaderId), retained);
    Publish();
    HearErrors(AboutMessage(kHeaderId));
    EXPECT_EQ(Ending(), "WAITING");
    HearActions(Entry(kId, "FINISHED"), AboutMessage(kHeaderId));
    EXPECT_EQ(Ending(), "FINISHED");
  }
}

TEST_F(ResponseTracker, KnowsTheHeaderIdsOfEveryRepetition) {
  FollowAndPublish("startPause");
  Publish(kHeaderId + 1);
  HearErrors(AboutMessage(kHeaderId));
  EXPECT_EQ(Ending(), "REJECTED");
}

TEST_F(ResponseTracker, IsNotRejectedByItsHeaderIdWhileTheRobotListsTheAction) {
  FollowAndPublish("startPause");
  HearActions(Entry(kId, "RUNNING"), AboutMessage(kHeaderId));
  EXPECT_EQ(Ending(), "WAITING");
}

TEST_F(ResponseTracker, TellsNewErrorsWithoutAnIdAsPossiblyRelated) {
  Follow("startPause");
  HearErrors(R"({"errorType":"lowBattery"})");
  Publish();
  HearErrors(R"({"errorType":"lowBattery"},{"errorType":"ActionTypeMismatch"})");
  HearErrors("");
  EXPECT_EQ(Ending(), "WAITING");
  EXPECT_THAT(Told(), AllOf(HasSubstr("possibly related: ActionTypeMismatch"),
                            Not(HasSubstr("lowBattery"))));
}

// ── vanished ──

TEST_F(ResponseTracker, EndsWithVanishedWhenItIsNoLongerListed) {
  FollowAndPublish("cancelOrder");
  HearActions(Entry(kId, "RUNNING"));
  HearActions(Entry(kOther, "RUNNING"));
  EXPECT_EQ(Ending(), "VANISHED");
  EXPECT_THAT(Told(), HasSubstr("no longer lists it, which last was RUNNING"));
}

TEST_F(ResponseTracker, DoesNotVanishBeforeItWasListed) {
  FollowAndPublish("cancelOrder");
  HearActions("");
  HearActions("");
  EXPECT_EQ(Ending(), "WAITING");
  EXPECT_FALSE(Now().seen);
}

TEST_F(ResponseTracker, DoesNotVanishByAStateWithoutTheArray) {
  FollowAndPublish("cancelOrder");
  HearActions(Entry(kId, "RUNNING"));
  HearState(R"("actionStates":[])");
  HearState(R"("instantActionStates":null)");
  EXPECT_EQ(Ending(), "WAITING");
}

TEST_F(ResponseTracker, DoesNotVanishByAnOlderState) {
  const auto state = [&](int header_id, int second, const std::string& entries) {
    HearState(fmt::format(
        R"("headerId":{},"timestamp":"2026-01-02T03:04:{:02}.678Z","actionStates":[{}])", header_id,
        second, entries));
  };
  FollowAndPublish("cancelOrder");
  state(7, 10, Entry(kId, "RUNNING"));
  state(6, 9, "");  // delivered again
  EXPECT_EQ(Ending(), "WAITING");
  state(0, 11, "");  // restarted
  EXPECT_EQ(Ending(), "VANISHED");
}

TEST_F(ResponseTracker, VanishesAfterANewConnectionWhateverTheClockSays) {
  FollowAndPublish("cancelOrder");
  HearState(
      fmt::format(R"("headerId":7,"timestamp":"2026-01-02T03:04:05.678Z","actionStates":[{}])",
                  Entry(kId, "RUNNING")));
  HearConnection("ONLINE");
  HearState(R"("headerId":0,"timestamp":"1970-01-01T00:00:05.678Z","actionStates":[])");
  EXPECT_EQ(Ending(), "VANISHED");
}

TEST_F(ResponseTracker, IsRejectedRatherThanVanishedWhenAnErrorSaysSo) {
  FollowAndPublish("beep");
  HearActions(Entry(kId, "WAITING"));
  HearErrors(Error("unknownActionType", "actionId", kId));
  EXPECT_EQ(Ending(), "REJECTED");
}

// ── what to tell when time is up ──

TEST_F(ResponseTracker, TellsWhetherItWasSeenAndWhatTheRobotLastSaid) {
  FollowAndPublish("startPause");
  EXPECT_EQ(Told(), "the robot has sent no state since");
  HearState(R"("timestamp":"2026-01-02T03:04:05.678Z","operatingMode":"AUTOMATIC")");
  EXPECT_EQ(Told(),
            "the robot has not listed the action; its last state is of 2026-01-02T03:04:05.678Z");
  HearState(fmt::format(
      R"("timestamp":"2026-01-02T03:04:06.678Z","actionStates":[{}],"operatingMode":"AUTOMATIC")",
      Entry(kId, "RUNNING", R"(,"resultDescription":"lowering")")));
  EXPECT_EQ(Told(),
            "the action last was RUNNING; lowering; its last state is of "
            "2026-01-02T03:04:06.678Z");
}

TEST_F(ResponseTracker, TellsAChangeOfMode) {
  Follow("startPause");
  HearState(R"("operatingMode":"SERVICE")", kRetained);  // the past
  HearState(R"("operatingMode":"AUTOMATIC")");
  Publish();
  HearState(R"("operatingMode":"MANUAL")");
  EXPECT_THAT(Told(), HasSubstr("the robot went from AUTOMATIC to MANUAL"));
  HearActions(Entry(kId, "FAILED"));
  EXPECT_EQ(Told(), "the robot went from AUTOMATIC to MANUAL");
}

TEST_F(ResponseTracker, TellsAModeInWhichARobotObeysNobody) {
  FollowAndPublish("startPause");
  HearState(R"("operatingMode":"service")");
  EXPECT_THAT(Told(), HasSubstr("the robot is in SERVICE"));
}

}  // namespace
}  // namespace fleetpub::vda5050
