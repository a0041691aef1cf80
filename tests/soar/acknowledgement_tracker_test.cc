#include "soar/acknowledgement_tracker.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

namespace fleetpub::soar {
namespace {

using message::CommandStatus;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::StartsWith;

constexpr const char* kTopic = "soar/noc/autosub/ah1/from_platform/acknowledgement";

std::string Said(std::string_view id, std::string_view status, std::string_view source = "c2") {
  return fmt::format(R"({{"header":{{"source":"{}"}},"payload":{{"message_type":"acknowledgement",)"
                     R"("acknowledged_message_ID":"{}","status":"{}"}}}})",
                     source, id, status);
}

class AcknowledgementTracker : public ::testing::Test {
 protected:
  void Follow(Level wait_for, std::size_t count = 1) {
    tracker_ = TrackAcknowledgements({.message_id = "id-1",
                                      .topics = {kTopic},
                                      .prefix = {},
                                      .wait_for = wait_for,
                                      .count = count,
                                      .target = "ah1"});
    tracker_->Published(0);
  }
  void Hear(const std::string& payload, std::string_view topic = kTopic, bool retained = false) {
    tracker_->Receive({topic, payload, retained});
    for (std::string& line : tracker_->TakeNews()) levels_.push_back(std::move(line));
  }
  [[nodiscard]] const message::Progress& Now() const { return tracker_->progress(); }

  std::unique_ptr<message::ResponseTracker> tracker_;
  std::vector<std::string> levels_;
};

TEST_F(AcknowledgementTracker, GoesThroughTheLevels) {
  Follow(Level::kExecuted);
  EXPECT_THAT(tracker_->Topics(), ElementsAre(kTopic));
  EXPECT_FALSE(Now().seen);
  Hear(Said("id-1", "c2_received"));
  EXPECT_TRUE(Now().seen);
  EXPECT_FALSE(Now().ended);
  Hear(Said("id-1", "operator_approved_and_sent"));
  EXPECT_EQ(Now().message, "operator_approved_and_sent");
  Hear(Said("id-1", "executed"));
  EXPECT_TRUE(Now().ended);
  EXPECT_EQ(Now().status, CommandStatus::kFinished);
  EXPECT_THAT(levels_, ElementsAre(StartsWith("soar.noc.autosub.ah1: c2_received"),
                                   StartsWith("soar.noc.autosub.ah1: operator_approved_and_sent"),
                                   StartsWith("soar.noc.autosub.ah1: executed")));
}

TEST_F(AcknowledgementTracker, EndsAtTheLevelThatIsWaitedFor) {
  Follow(Level::kC2Received);
  Hear(Said("id-1", "c2_received"));
  EXPECT_TRUE(Now().ended);
  EXPECT_EQ(Now().status, CommandStatus::kAccepted);
  EXPECT_EQ(Now().message, "c2_received");
}

TEST_F(AcknowledgementTracker, TakesAHigherLevelForAllBelow) {
  Follow(Level::kOperatorApprovedAndSent);
  Hear(Said("id-1", "executed"));
  EXPECT_EQ(Now().status, CommandStatus::kFinished);
  EXPECT_TRUE(Now().ended);
}

TEST_F(AcknowledgementTracker, NeitherGoesBackNorTellsALevelTwice) {
  Follow(Level::kExecuted);
  Hear(Said("id-1", "operator_approved_and_sent"));
  Hear(Said("id-1", "c2_received"));
  Hear(Said("id-1", "operator_approved_and_sent"));
  EXPECT_EQ(Now().message, "operator_approved_and_sent");
  EXPECT_EQ(levels_.size(), 1U);
}

TEST_F(AcknowledgementTracker, IsNotConfusedByWhatIsNotMeant) {
  Follow(Level::kC2Received);
  Hear(Said("id-2", "executed"));
  Hear(Said("id-11", "executed"));
  Hear(Said("id-1", "done"));
  Hear(Said("id-1", ""));
  Hear("id-1");
  Hear(R"({"payload":"id-1"})");
  Hear(R"({"payload":{"message_type":"observation","x":"id-1"}})");
  Hear(R"({"payload":{"message_type":"acknowledgement","acknowledged_message_ID":["id-1"],
           "status":"executed"}})");
  Hear("\xFF id-1");
  Hear(std::string(100'000, '[') + "id-1");
  Hear(Said("id-1", "executed"), kTopic, true);
  EXPECT_FALSE(Now().seen) << "the last one was retained";
  EXPECT_THAT(levels_, IsEmpty());
  EXPECT_THAT(Now().message, ::testing::StartsWith("nobody acknowledged it"));
  Hear(R"({"payload":{"message_type":"acknowledgement","acknowledged_message_ID":"id-1",
           "status":"c2_received"}})");
  EXPECT_TRUE(Now().ended) << "without a header it still counts";
}

TEST_F(AcknowledgementTracker, ReadsAnIdWhoseCharactersAreEscaped) {
  Follow(Level::kExecuted);
  Hear(Said(R"(id\u002d1)", "executed"));
  EXPECT_TRUE(Now().ended);
}

TEST_F(AcknowledgementTracker, HearsNothingBeforeItIsPublished) {
  tracker_ = TrackAcknowledgements({.message_id = "id-1", .topics = {}, .prefix = {}});
  Hear(Said("id-1", "executed"));
  EXPECT_FALSE(Now().seen);
}

TEST_F(AcknowledgementTracker, CountsEachPlatformOnce) {
  Follow(Level::kExecuted, 2);
  Hear(Said("id-1", "executed"));
  Hear(Said("id-1", "executed", "another name"));
  EXPECT_FALSE(Now().ended);
  EXPECT_EQ(Now().message,
            "1 of 2 c2_received, 1 of 2 operator_approved_and_sent, 1 of 2 executed");
  Hear(Said("id-1", "c2_received"), "soar/noc/autosub/ah2/from_platform/acknowledgement");
  EXPECT_FALSE(Now().ended);
  Hear(Said("id-1", "executed"), "soar/noc/autosub/ah2/from_platform/acknowledgement");
  EXPECT_EQ(Now().status, CommandStatus::kFinished);
  EXPECT_TRUE(Now().ended);
}

TEST_F(AcknowledgementTracker, TellsSourcesApartWhereTheTopicNamesNoPlatform) {
  Follow(Level::kC2Received, 2);
  Hear(Said("id-1", "c2_received", "one"), "soar/fleetpub");
  Hear(Said("id-1", "c2_received", "one"), "soar/fleetpub");
  EXPECT_FALSE(Now().ended);
  Hear(Said("id-1", "executed", "two"), "soar/fleetpub");
  EXPECT_EQ(Now().status, CommandStatus::kAccepted) << "only one has executed it";
  EXPECT_TRUE(Now().ended);
}

TEST_F(AcknowledgementTracker, ReadsLenientlyAndTellsWhatItCannotRead) {
  Follow(Level::kExecuted);
  Hear(R"({"note":"of somebody else",)");
  EXPECT_FALSE(Now().unreadable);
  std::string cut = Said("id-1", "executed");
  cut.pop_back();
  Hear(cut);
  Hear(cut);
  EXPECT_TRUE(Now().unreadable);
  EXPECT_FALSE(Now().ended);
  EXPECT_THAT(Now().message, ::testing::HasSubstr("2 messages"));
  Hear(Said("id-1", "executed",
            "k\xFC"
            "ste") +
       '\0');
  EXPECT_EQ(Now().status, CommandStatus::kFinished);
}

}  // namespace
}  // namespace fleetpub::soar
