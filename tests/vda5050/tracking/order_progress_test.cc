#include "vda5050/tracking/order_progress.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "base/json.h"
#include "base/text.h"
#include "vda5050/messages/user_message.h"

namespace fleetpub::vda5050 {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// An order `o` over these nodes, with an action `pick` at the last one, or none.
std::string Order(const std::vector<std::string>& nodes, bool has_action = false,
                  std::uint32_t update_id = 0) {
  std::string list;
  std::string edges;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const bool is_last = i + 1 == nodes.size();
    list += fmt::format(R"({}{{"nodeId":"{}","sequenceId":{},"released":true,"actions":[{}]}})",
                        i == 0 ? "" : ",", nodes[i], 2 * i,
                        is_last && has_action ? R"({"actionType":"pick","actionId":"p-1"})" : "");
    if (!is_last) edges += fmt::format(R"({}{{"edgeId":"e{}"}})", i == 0 ? "" : ",", i);
  }
  return fmt::format(R"({{"orderId":"o","orderUpdateId":{},"nodes":[{}],"edges":[{}]}})", update_id,
                     list, edges);
}

class OrderTracking : public ::testing::Test {
 protected:
  void Follow(const std::string& order, WaitFor wait_for = WaitFor::kFinished) {
    tracker_ = *TrackUserMessage({"KIT", "0001"}, {}, "order", *base::ParseJson(order), wait_for);
    header_id_ = 0;
  }
  void Send(const std::string& order, WaitFor wait_for = WaitFor::kFinished) {
    Follow(order, wait_for);
    tracker_->Published(7);
  }
  void Hear(std::string_view members) {
    tracker_->Receive({"vda5050/v3/KIT/0001/state",
                       fmt::format(R"({{"headerId":{},"timestamp":"2026-01-02T03:04:05Z",{}}})",
                                   ++header_id_, members)});
  }
  // At this node, with so many nodes and edges to go.
  void At(std::string_view node, int sequence_id, std::string_view left = "",
          std::string_view more = "", std::string_view order = "o", int update_id = 0) {
    Hear(fmt::format(
        R"("orderId":"{}","orderUpdateId":{},"nodeStates":[{}],"edgeStates":[],"lastNodeId":"{}",)"
        R"("lastNodeSequenceId":{}{})",
        order, update_id, left, node, sequence_id, more));
  }
  static std::string Pick(std::string_view status) {
    return fmt::format(R"(,"actionStates":[{{"actionId":"p-1","actionStatus":"{}"}}])", status);
  }
  [[nodiscard]] std::string Ending() const {
    const auto& now = tracker_->progress();
    return now.ended ? std::string(GetName(now.status)) : "";
  }
  [[nodiscard]] std::string Told() const { return tracker_->progress().message; }

  static constexpr std::string_view kOneLeft = R"({"nodeId":"x","sequenceId":2})";
  std::unique_ptr<message::ResponseTracker> tracker_;
  int header_id_ = 0;
};

TEST_F(OrderTracking, EndsAtTheLastNodeOnceItWasUnderWay) {
  Send(Order({"a", "b"}));
  At("a", 0, kOneLeft);
  EXPECT_EQ(Ending(), "");
  At("b", 2);
  EXPECT_EQ(Ending(), "FINISHED");
}

TEST_F(OrderTracking, IsNotDoneWhereANodeOccursAgain) {
  for (const auto& nodes : {std::vector<std::string>{"a", "b", "a"}, {"a", "a"}}) {
    Send(Order(nodes));
    At("a", 0);
    At("a", 0);
    EXPECT_NE(Ending(), "FINISHED");
  }
  Send(Order({"a", "a"}));
  At("a", 0, kOneLeft);
  At("a", 2);
  EXPECT_EQ(Ending(), "FINISHED");
}

TEST_F(OrderTracking, TakesRobotsThatKeepNoSequenceIds) {
  Send(Order({"a", "b"}));
  At("a", 0, "{}");
  At("b", 0);
  EXPECT_EQ(Ending(), "FINISHED");
  Send(Order({"a", "b", "c"}));
  At("a", 8, "{}");
  At("c", 0);
  EXPECT_NE(Ending(), "FINISHED") << "it does keep them";
}

TEST_F(OrderTracking, IsNotDoneBeforeEachActionWasSeenToItsEnd) {
  Send(Order({"a"}, true));
  At("a", 0);
  EXPECT_EQ(Ending(), "");
  EXPECT_THAT(Told(), HasSubstr("pick is not listed"));
  At("a", 0, "", Pick("RUNNING"));
  At("a", 0);
  EXPECT_EQ(Ending(), "") << "no longer listed is no end";
  At("a", 0, "", Pick("FINISHED"));
  EXPECT_EQ(Ending(), "FINISHED");
}

TEST_F(OrderTracking, TellsOfActionsAndErrorsWhileItWaits) {
  Send(Order({"a", "b"}, true));
  At("a", 0, kOneLeft, Pick("RETRIABLE"));
  EXPECT_THAT(Told(), HasSubstr("RETRIABLE"));
  At("a", 0, kOneLeft, Pick("FAILED") + R"(,"errors":[{"errorType":"gripper","errorLevel":"FATAL",
        "errorReferences":[{"referenceKey":"actionId","referenceValue":"p-1"}]}])");
  EXPECT_EQ(Ending(), "") << "the order goes on";
  EXPECT_THAT(Told(), AllOf(HasSubstr("pick failed"), HasSubstr("gripper")));
  At("b", 2, "", Pick("FAILED"));
  EXPECT_EQ(Ending(), "FAILED");
  EXPECT_THAT(Told(), AllOf(HasSubstr("pick failed"), HasSubstr("gripper")));
}

TEST_F(OrderTracking, TellsAtOnceWhatGoesWrongAndOnce) {
  const auto news = [&] { return base::Join(tracker_->TakeNews(), "\n"); };
  constexpr std::string_view kError = R"(,"errors":[{"errorType":"gripper","errorLevel":"FATAL",
        "errorReferences":[{"referenceKey":"nodeId","referenceValue":"b"}]}])";
  Send(Order({"a", "b"}, true));
  At("a", 0, kOneLeft, Pick("RUNNING"));
  EXPECT_EQ(news(), "KIT/0001  a (1 of 2)  pick RUNNING");
  At("a", 0, kOneLeft, Pick("RUNNING"));
  EXPECT_EQ(news(), "") << "it is where it was";
  At("a", 0, kOneLeft, Pick("RETRIABLE"));
  EXPECT_THAT(news(), AllOf(HasSubstr("KIT/0001: action pick (p-1)"), HasSubstr("retry")));
  At("a", 0, kOneLeft, Pick("RETRIABLE") + std::string(kError));
  EXPECT_THAT(news(), AllOf(HasSubstr("KIT/0001: gripper"), Not(HasSubstr("pick"))));
  At("a", 0, kOneLeft, Pick("FAILED") + std::string(kError));
  EXPECT_THAT(news(), AllOf(HasSubstr("failed"), Not(HasSubstr("gripper"))));
  At("a", 0, kOneLeft, Pick("FAILED"));
  EXPECT_EQ(news(), "");
  Send(Order({"a"}, true));
  At("a", 0, "", Pick("FAILED"));
  EXPECT_EQ(Ending(), "FAILED");
  EXPECT_EQ(news(), "KIT/0001  a (1 of 1)") << "the result says the rest";
}

TEST_F(OrderTracking, TakesNoOrderOfBeforeForTheOneThatWasSent) {
  Send(Order({"a", "b"}));
  At("b", 2);
  At("b", 2);
  EXPECT_EQ(Ending(), "") << "done, but when?";
  EXPECT_THAT(Told(), HasSubstr("before"));
  Follow(Order({"a", "b"}));
  At("b", 2);
  tracker_->Published(7);
  At("b", 2);
  EXPECT_EQ(Ending(), "");
  Follow(Order({"a", "b"}));
  At("a", 0, "", "", "another");
  tracker_->Published(7);
  At("b", 2);
  EXPECT_EQ(Ending(), "FINISHED") << "it came, and is done";
  Send(Order({"a"}));
  At("a", 0);
  EXPECT_EQ(Ending(), "FINISHED") << "there is nothing to do";
}

TEST_F(OrderTracking, OfSomebodyElsesExtensionProvesNothing) {
  Send(Order({"a", "b"}));
  At("a", 0, kOneLeft, "", "o", 1);
  At("c", 4, "", "", "o", 1);
  EXPECT_EQ(Ending(), "");
  EXPECT_THAT(Told(), HasSubstr("orderUpdateId 1"));
  Send(Order({"a", "b"}));
  At("a", 0, kOneLeft);
  At("b", 2, R"({"sequenceId":4})", "", "o", 1);
  EXPECT_EQ(Ending(), "FINISHED") << "its own last node, on the way further";
  Send(Order({"a", "b"}));
  At("a", 0, kOneLeft);
  At("c", 4, "", "", "o", 1);
  EXPECT_EQ(Ending(), "") << "nobody saw it at its last node";
}

TEST_F(OrderTracking, IsNoLowerUpdateThatTheRobotDoesNotTake) {
  Send(Order({"a", "b"}, false, 2), WaitFor::kAccepted);
  At("a", 0, kOneLeft, "", "o", 5);
  EXPECT_EQ(Ending(), "");
  At("a", 0, kOneLeft, R"(,"errors":[{"errorType":"orderUpdateError"}])", "o", 5);
  EXPECT_EQ(Ending(), "");
  EXPECT_THAT(Told(), AllOf(HasSubstr("possibly related"), HasSubstr("orderUpdateError")));
}

TEST_F(OrderTracking, IsRefusedByAnErrorThatNamesOneOfItsNodes) {
  constexpr std::string_view kError = R"(,"errors":[{"errorType":"noRoute","errorReferences":[
      {"referenceKey":"nodeId","referenceValue":"b"}]}])";
  Send(Order({"a", "b"}), WaitFor::kAccepted);
  At("a", 0, "", kError, "another");
  EXPECT_EQ(Ending(), "REJECTED");
  EXPECT_THAT(Told(), HasSubstr("before")) << "no state from before is known";
  Follow(Order({"a", "b"}), WaitFor::kAccepted);
  At("a", 0, "", kError, "another");
  tracker_->Published(7);
  At("a", 0, "", kError, "another");
  EXPECT_EQ(Ending(), "") << "it stood there before";
  At("a", 0, kOneLeft, kError);
  EXPECT_EQ(Ending(), "ACCEPTED");
}

TEST_F(OrderTracking, SaysThatTheRobotHadItBefore) {
  Follow(Order({"a", "b"}), WaitFor::kAccepted);
  At("a", 0, kOneLeft);
  tracker_->Published(7);
  At("a", 0, kOneLeft);
  EXPECT_EQ(Ending(), "ACCEPTED");
  EXPECT_THAT(Told(), HasSubstr("before"));
  Send(Order({"a", "b"}), WaitFor::kAccepted);
  At("b", 2);
  EXPECT_THAT(Told(), HasSubstr("may have had it before")) << "it is done in no time";
  Send(Order({"a", "b"}), WaitFor::kAccepted);
  At("a", 0, kOneLeft);
  EXPECT_THAT(Told(), Not(HasSubstr("before")));
  Send(Order({"a", "b"}), WaitFor::kAccepted);
  At("a", 0, kOneLeft, R"(,"errors":[{"errorType":"SAME_ORDER_UPDATE_ID","errorReferences":[
        {"referenceKey":"orderId","referenceValue":"o"}]}])");
  EXPECT_EQ(Ending(), "REJECTED");
  EXPECT_THAT(Told(), AllOf(HasSubstr("before"), HasSubstr("SAME_ORDER_UPDATE_ID")));
}

TEST_F(OrderTracking, TellsWhereARobotStandsThatForgetsItsOrder) {
  Send(Order({"a", "b"}));
  At("a", 0, kOneLeft);
  At("b", 2, "", "", "");
  EXPECT_EQ(Ending(), "FINISHED");
  EXPECT_THAT(Told(), HasSubstr("b (2)"));
  Send(Order({"a", "b"}));
  At("a", 0, kOneLeft);
  At("a", 0, "", "", "");
  EXPECT_EQ(Ending(), "VANISHED");
  EXPECT_THAT(Told(), HasSubstr("a (0)"));
}

TEST_F(OrderTracking, PassesOverAnOlderState) {
  Send(Order({"a", "b"}));
  header_id_ = 30;
  At("a", 0, kOneLeft);
  header_id_ = 20;
  At("z", 0, "", "", "another");
  EXPECT_EQ(Ending(), "");
  header_id_ = 40;
  At("b", 2);
  EXPECT_EQ(Ending(), "FINISHED");
}

class ResponseTracking : public OrderTracking {
 protected:
  void Answer(std::string_view grant) {
    tracker_ =
        *TrackUserMessage({"KIT", "0001"}, {}, "responses",
                          *base::ParseJson(fmt::format(
                              R"({{"responses":[{{"requestId":"q","grantType":"{}"}}]}})", grant)),
                          WaitFor::kFinished);
    header_id_ = 0;
  }
  void Request(std::string_view status) {
    Hear(fmt::format(R"("zoneRequests":[{{"requestId":"q","requestStatus":"{}"}}])", status));
  }
  void Gone() { Hear(R"("zoneRequests":[])"); }
};

TEST_F(ResponseTracking, ObeysARevocationByRemovingTheRequest) {
  Answer("REVOKED");
  tracker_->Published(7);
  Gone();
  EXPECT_EQ(Ending(), "") << "was it ever there?";
  Request("GRANTED");
  EXPECT_EQ(Ending(), "");
  EXPECT_THAT(Told(), HasSubstr("GRANTED"));
  Gone();
  EXPECT_EQ(Ending(), "FINISHED");
  Answer("REVOKED");
  Request("GRANTED");
  tracker_->Published(7);
  Gone();
  EXPECT_EQ(Ending(), "FINISHED");
}

TEST_F(ResponseTracking, TellsOfARequestThatIsGoneUngranted) {
  Answer("GRANTED");
  tracker_->Published(7);
  Request("EXPIRED");
  EXPECT_THAT(Told(), AllOf(HasSubstr("EXPIRED"), Not(HasSubstr("does not show"))));
  header_id_ = -1;
  Gone();
  EXPECT_EQ(Ending(), "") << "an older state";
  header_id_ = 9;
  Gone();
  EXPECT_EQ(Ending(), "VANISHED");
}

TEST_F(ResponseTracking, PassesOverAnOlderStateOfAZoneSet) {
  tracker_ =
      *TrackUserMessage({"KIT", "0001"}, {}, "zoneSet",
                        *base::ParseJson(R"({"zoneSet":{"zoneSetId":"z"}})"), WaitFor::kFinished);
  header_id_ = 10;
  Hear(R"("zoneSets":[])");
  tracker_->Published(7);
  header_id_ = 8;
  Hear(R"("zoneSets":[{"zoneSetId":"z","zoneSetStatus":"ENABLED"}])");
  EXPECT_EQ(Ending(), "");
  header_id_ = 11;
  Hear(R"("zoneSets":[{"zoneSetId":"z","zoneSetStatus":"ENABLED"}])");
  EXPECT_EQ(Ending(), "FINISHED");
}

}  // namespace
}  // namespace fleetpub::vda5050
