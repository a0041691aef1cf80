#include <fmt/format.h>
#include <gmock/gmock.h>

#include "vda5050/tracking/action_tracker.h"
#include "vda5050/tracking/tracker_support.h"

namespace fleetpub::vda5050 {
namespace {

using ::testing::HasSubstr;

// ── connection ──

TEST_F(ResponseTracker, EndsWithOfflineWhenTheRobotGoes) {
  for (const std::string state : {"OFFLINE", "CONNECTION_BROKEN", "CONNECTIONBROKEN", "offline"}) {
    FollowAndPublish("cancelOrder");
    HearActions(Entry(kId, "RUNNING"));
    HearConnection(state);
    EXPECT_EQ(Ending(), "OFFLINE") << state;
    EXPECT_THAT(Told(), HasSubstr("the action last was RUNNING"));
  }
}

TEST_F(ResponseTracker, EndsWithOfflineWhenTheRobotGoesToSleep) {
  FollowAndPublish("cancelOrder");
  HearConnection("HIBERNATING");
  EXPECT_EQ(Ending(), "OFFLINE");
  EXPECT_EQ(Told(), "the robot went HIBERNATING while we waited; it has sent no state since");
}

TEST_F(ResponseTracker, TellsThatARetainedMessageSaysOffline) {
  FollowAndPublish("startPause");
  HearConnection("OFFLINE", kRetained);
  EXPECT_EQ(Ending(), "WAITING");
  EXPECT_THAT(Told(), HasSubstr("it is OFFLINE"));
}

struct ConnectionCase {
  std::string type;
  std::string state;
  std::string ending;
};

TEST_F(ResponseTracker, EndsAsTheActionDoesWhenTheConnectionChanges) {
  const ConnectionCase cases[] = {
      {"shutdown", "OFFLINE", "FINISHED"},
      {"shutdown", "CONNECTION_BROKEN", "OFFLINE"},  // its last will: no coordinated shutdown
      {"shutdown", "ONLINE", "WAITING"},
      {"startHibernation", "HIBERNATING", "FINISHED"},
      {"startHibernation", "OFFLINE", "OFFLINE"},
      {"startHibernation", "CONNECTION_BROKEN", "OFFLINE"},
      {"stopHibernation", "ONLINE", "FINISHED"},
      {"stopHibernation", "OFFLINE", "WAITING"},
      {"stopHibernation", "CONNECTION_BROKEN", "WAITING"},
      {"stopHibernation", "HIBERNATING", "WAITING"},
      {"updateCertificate", "OFFLINE", "WAITING"},
      {"updateCertificate", "CONNECTION_BROKEN", "WAITING"},
      {"updateCertificate", "ONLINE", "WAITING"},
      {"startPause", "ONLINE", "WAITING"},
  };
  for (const auto& [type, state, ending] : cases) {
    FollowAndPublish(type);
    HearConnection(state);
    EXPECT_EQ(Ending(), ending) << type << " " << state;
  }
}

TEST_F(ResponseTracker, LetsTheRobotReconnectForANewCertificate) {
  FollowAndPublish("updateCertificate");
  HearActions(Entry(kId, "RUNNING"));
  HearConnection("CONNECTION_BROKEN");
  EXPECT_THAT(Told(), HasSubstr("it is CONNECTION_BROKEN"));
  HearConnection("ONLINE");
  HearActions(Entry(kId, "FINISHED"));
  EXPECT_EQ(Ending(), "FINISHED");
}

TEST_F(ResponseTracker, EndsHibernationAndShutdownByFinishedToo) {
  for (const std::string type : {"shutdown", "startHibernation", "stopHibernation"}) {
    FollowAndPublish(type);
    HearActions(Entry(kId, "FINISHED"));
    EXPECT_EQ(Ending(), "FINISHED") << type;
    FollowAndPublish(type);
    HearActions(Entry(kId, "FAILED"));
    EXPECT_EQ(Ending(), "FAILED") << type;
  }
}

// ── endings of their own ──

TEST_F(ResponseTracker, TakesTheStateThatListsAStateRequestForItsAnswer) {
  FollowAndPublish("stateRequest");
  HearActions(Entry(kId, "RUNNING"));
  EXPECT_EQ(Ending(), "FINISHED");
  FollowAndPublish("stateRequest");
  HearActions(Entry(kOther, "FINISHED"));
  EXPECT_EQ(Ending(), "WAITING");
}

TEST_F(ResponseTracker, EndsAFactsheetRequestByALiveFactsheet) {
  FollowAndPublish("factsheetRequest");
  Hear("factsheet", R"({"version":"3.0.0"})", kRetained);
  EXPECT_EQ(Ending(), "WAITING");
  Hear("factsheet", "rubbish");
  EXPECT_EQ(Ending(), "WAITING");
  Hear("factsheet", R"({"version":"3.0.0"})");
  EXPECT_EQ(Ending(), "FINISHED");
  EXPECT_TRUE(Now().seen);
}

TEST_F(ResponseTracker, DoesNotEndAFactsheetRequestWithoutTheFactsheet) {
  FollowAndPublish("factsheetRequest");
  HearActions(Entry(kId, "FINISHED"));
  HearActions("");
  EXPECT_EQ(Ending(), "WAITING");
  EXPECT_THAT(Told(), ::testing::HasSubstr("no factsheet"));
  Hear("factsheet", R"({"version":"3.0.0"})");
  EXPECT_EQ(Ending(), "FINISHED");
}

TEST_F(ResponseTracker, DoesNotCareForFactsheetsOtherwise) {
  FollowAndPublish("startPause");
  Hear("factsheet", R"({"version":"3.0.0"})");
  EXPECT_EQ(Ending(), "WAITING");
}

TEST_F(ResponseTracker, EndsClearInstantActionsWhenItsOwnEntryIsCleared) {
  FollowAndPublish("clearInstantActions");
  HearActions(Entry(kId, "RUNNING"));
  EXPECT_EQ(Ending(), "WAITING");
  HearActions("");
  EXPECT_EQ(Ending(), "FINISHED");
}

TEST_F(ResponseTracker, EndsClearInstantActionsWhenTheEndedOnesAreGone) {
  Follow("clearInstantActions");
  HearActions(Entry(kOther, "FINISHED") + "," + Entry("b", "RUNNING"));
  Publish();
  HearActions(Entry(kOther, "FINISHED") + "," + Entry("b", "RUNNING"));
  EXPECT_EQ(Ending(), "WAITING");
  HearActions(Entry("b", "RUNNING"));
  EXPECT_EQ(Ending(), "FINISHED");
}

TEST_F(ResponseTracker, TakesAClearedListForNothingElse) {
  FollowAndPublish("startPause");
  HearActions(Entry(kOther, "FINISHED"));
  HearActions("");
  EXPECT_EQ(Ending(), "WAITING");
  HearActions(Entry(kId, "RUNNING"));
  HearActions("");
  EXPECT_EQ(Ending(), "VANISHED");
}

TEST_F(ResponseTracker, DoesNotTakeAnEmptyListForAClearedOne) {
  Follow("clearInstantActions");
  HearActions(Entry(kOther, "FINISHED"), "", kRetained);  // who knows how old
  Publish();
  HearActions("");
  HearState(R"("actionStates":[])");
  EXPECT_EQ(Ending(), "WAITING");
}

TEST_F(ResponseTracker, TakesNoClearedListFromAnOlderState) {
  FollowAndPublish("clearInstantActions");
  const auto state = [&](int id, std::string_view time, std::string_view entries) {
    HearState(fmt::format(R"("headerId":{},"timestamp":"{}","instantActionStates":[{}])", id, time,
                          entries));
  };
  state(70, "2026-01-02T03:04:09.5Z", Entry(kOther, "FINISHED"));
  state(69, "2026-01-02T03:04:09.4Z", "");
  EXPECT_EQ(Ending(), "WAITING");
  state(71, "2026-01-02T03:04:09.6Z", "");
  EXPECT_EQ(Ending(), "FINISHED");
}

TEST_F(ResponseTracker, KnowsTheWordsForACoordinatedEnd) {
  for (const std::string_view word : {"DISCONNECTED", "offline", "Disconnected"}) {
    FollowAndPublish("shutdown");
    HearConnection(word);
    EXPECT_EQ(Ending(), "FINISHED") << word;
    FollowAndPublish("startPause");
    HearConnection(word);
    EXPECT_EQ(Ending(), "OFFLINE") << word;
  }
}

// ── accepted ──

TEST_F(ResponseTracker, EndsWithAcceptedWhenTheRobotListsIt) {
  for (const std::string_view status :
       {"WAITING", "INITIALIZING", "RUNNING", "PAUSED", "RETRIABLE", "FINISHED", "DREAMING"}) {
    FollowAndPublish("cancelOrder", WaitFor::kAccepted);
    HearActions("");
    EXPECT_EQ(Ending(), "WAITING");
    HearActions(Entry(kId, status));
    EXPECT_EQ(Ending(), "ACCEPTED") << status;
    EXPECT_EQ(Told(), fmt::format("the robot lists it as {}", status));
  }
}

TEST_F(ResponseTracker, IsNotAcceptedWhenItFailedOrWasRejected) {
  FollowAndPublish("cancelOrder", WaitFor::kAccepted);
  HearActions(Entry(kId, "FAILED"));
  EXPECT_EQ(Ending(), "FAILED");
  FollowAndPublish("cancelOrder", WaitFor::kAccepted);
  HearErrors(Error("E", "actionId", kId));
  EXPECT_EQ(Ending(), "REJECTED");
}

// ── nothing to cancel ──

TEST_F(ResponseTracker, HadNoOrderToCancelWhenAnErrorAloneSaysSo) {
  for (const char* type : {"noOrderToCancel", "NO_ORDER_TO_CANCEL", "no-order-to-cancel"}) {
    FollowAndPublish("cancelOrder");
    HearErrors(Error(type, "action_id", kId));
    EXPECT_EQ(Ending(), "NO_ORDER") << type;
  }
  FollowAndPublish("cancelOrder");
  HearErrors(Error("orderError", "actionId", kId));
  EXPECT_EQ(Ending(), "REJECTED") << "for another reason";
  FollowAndPublish("startPause");
  HearActions(Entry(kId, "FAILED"), Error("noOrderToCancel", "actionId", kId));
  EXPECT_EQ(Ending(), "FAILED") << "it was not to cancel anything";
}

TEST_F(ResponseTracker, HasAnOrderToCancelWhenTheStateShowsOne) {
  const auto say = [&](std::string_view order_id, std::string_view nodes, std::string_view error) {
    HearState(fmt::format(R"("orderId":"{}","nodeStates":[{}],"edgeStates":[],"errors":[{}],)"
                          R"("instantActionStates":[{}])",
                          order_id, nodes, error, Entry(kId, "FAILED")));
    return Ending();
  };
  const std::string ours = Error("NO_ORDER_TO_CANCEL", "actionId", kId);
  FollowAndPublish("cancelOrder");
  EXPECT_EQ(say("o-1", R"({"nodeId":"n"})", ours), "FAILED") << "a contradiction";
  parameters_ = {{"orderId", R"("o-2")"}};
  FollowAndPublish("cancelOrder");
  EXPECT_EQ(say("o-1", R"({"nodeId":"n"})", ours), "NO_ORDER") << "but not this one";
  FollowAndPublish("cancelOrder");
  EXPECT_EQ(say("o-2", R"({"nodeId":"n"})", ours), "FAILED");
}

TEST_F(ResponseTracker, DoesNotTakeAnErrorOfBeforeForItsOwnNoOrder) {
  constexpr std::string_view kUnnamed = R"({"errorType":"noOrderToCancel","errorLevel":"WARNING"})";
  const auto say = [&](std::string_view nodes, std::string_view more) {
    HearState(fmt::format(R"("nodeStates":[{}],"errors":[{}]{})", nodes, kUnnamed, more));
  };
  const std::string failed = fmt::format(R"(,"actionStates":[{}])", Entry(kId, "FAILED"));
  Follow("cancelOrder");
  say("", "");
  Publish();
  say(R"({"nodeId":"n"})", failed);
  EXPECT_EQ(Ending(), "FAILED");
  Follow("cancelOrder");
  say("", "");
  Publish();
  say("", failed);
  EXPECT_EQ(Ending(), "NO_ORDER") << "and the state shows none";
}

}  // namespace
}  // namespace fleetpub::vda5050
