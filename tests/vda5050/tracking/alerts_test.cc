#include "vda5050/tracking/alerts.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <tuple>

#include "vda5050/tracking/tracker_support.h"

namespace fleetpub::vda5050 {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST_F(ResponseTracker, TellsSevereErrorsOnceWhileItWaits) {
  FollowAndPublish("startCharging");
  const std::string error =
      R"({"errorType":"chargerBlocked","errorLevel":"FATAL","errorReferences":[)" +
      fmt::format(R"({{"referenceKey":"actionId","referenceValue":"{}"}}]}})", kId);
  HearActions(Entry(kId, "RUNNING"), error);
  EXPECT_THAT(News(), AllOf(HasSubstr("KIT/0001: chargerBlocked"), HasSubstr("FATAL")));
  HearActions(Entry(kId, "RUNNING"), error);
  HearActions(Entry(kId, "RUNNING"), Error("lowBattery", "actionId", kId));
  EXPECT_EQ(News(), "") << "told once; a warning is told at the end";
  HearActions(Entry(kId, "FAILED"), error + "," + R"({"errorType":"x","errorLevel":"CRITICAL"})");
  EXPECT_EQ(News(), "") << "the result says it";
}

TEST_F(ResponseTracker, TellsThatTheListIsFull) {
  using message::Kept;
  constexpr std::string_view kFull = R"({"errorType":"INSTANT_ACTION_STATES_FULL"})";
  FollowAndPublish("startPause");
  HearActions(Entry(kId, "RUNNING"));
  EXPECT_EQ(Now().kept, Kept::kNothing);
  HearActions(Entry(kId, "FINISHED"));
  EXPECT_EQ(Now().kept, Kept::kEntry);
  EXPECT_EQ(News(), "");
  FollowAndPublish("startPause");
  HearActions(Entry(kId, "RUNNING"), kFull);
  EXPECT_THAT(News(), HasSubstr("full"));
  HearActions(Entry(kId, "FINISHED"), kFull);
  EXPECT_EQ(Now().kept, Kept::kTooMuch);
  EXPECT_EQ(News(), "");
  FollowAndPublish("clearInstantActions");
  HearActions(Entry(kId, "FINISHED"), kFull);
  EXPECT_EQ(Now().kept, Kept::kNothing) << "it has cleared what there was";
}

TEST_F(ResponseTracker, TellsANewLedgerOfHigherHeaderIds) {
  const auto named = [](std::string_view topic, std::string_view id) {
    return fmt::format(R"({{"errorType":"validationError","errorReferences":[)"
                       R"({{"referenceKey":"topic","referenceValue":"{}"}},)"
                       R"({{"referenceKey":"headerId","referenceValue":"{}"}}]}})",
                       topic, id);
  };
  for (const bool is_before : {true, false}) {
    Follow("startPause");
    if (is_before) HearErrors(named("instantActions", "4711"));
    Publish(0);
    if (!is_before) HearErrors(named("instantActions", "4711"));
    EXPECT_THAT(News(), AllOf(HasSubstr("4711"), HasSubstr("--header-id 4712")));
    HearErrors(named("instantActions", "4711"));
    EXPECT_EQ(News(), "") << "once";
  }
  for (const auto& [topic, id, own] : {std::tuple("order", "4711", 0U),
                                       {"instantActions", "0", 0U},
                                       {"instantActions", "4711", 3U},
                                       {"instantActions", "later", 0U}}) {
    Follow("startPause");
    HearErrors(named(topic, id));
    Publish(own);
    HearErrors(named(topic, id));
    EXPECT_EQ(News(), "") << topic << id << own;
  }
}

}  // namespace
}  // namespace fleetpub::vda5050
