#include "delivery/pending_commands.h"

#include <gmock/gmock.h>

namespace fleetpub::delivery {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

using std::chrono::milliseconds;

// Ends with the word that it is told.
class Told : public message::ResponseTracker {
 public:
  explicit Told(std::string topic) : topic_(std::move(topic)) {}
  std::vector<std::string> Topics() const override { return {topic_}; }
  void Published(std::uint32_t /*header_id*/) override {}
  void Receive(const message::Incoming& message) override {
    progress_.unreadable = message.payload == "unreadable";
    progress_.seen = !progress_.unreadable;
    if (message.payload != "done") return;
    progress_ = {
        .seen = true, .ended = true, .status = message::CommandStatus::kFinished, .message = "so"};
  }
  const message::Progress& progress() const override { return progress_; }

 private:
  std::string topic_;
  message::Progress progress_;
};

class Following : public ::testing::Test {
 protected:
  void Publish(PendingCommands& pending, PendingCommands::Key key, const std::string& topic) {
    pending.Track(key, std::make_shared<Told>(topic));
    pending.Published(key, {.reference = std::to_string(key)});
  }
  PendingCommands::EndHook RecordEnd() {
    return [this](PendingCommands::Key key, const message::Report& report) {
      EXPECT_EQ(report.reference, std::to_string(key));
      ended_.push_back(std::to_string(key) + " " + std::string(GetName(report.status)));
    };
  }
  /// Of `options`, by a clock that stands still until `now_` is set.
  PendingCommands Pending(const WaitOptions& options) {
    return {options, RecordEnd(), {}, [this] { return now_; }};
  }
  PendingCommands::Clock::time_point now_{std::chrono::hours(1)};
  std::vector<std::string> ended_;
};

TEST_F(Following, TellsEachEndOnceAndForgetsIt) {
  PendingCommands pending = Pending({});
  Publish(pending, 1, "a");
  Publish(pending, 2, "a");
  Publish(pending, 3, "b/+");
  EXPECT_THAT(pending.Topics(), UnorderedElementsAre("a", "b/+"));
  pending.Deliver({.topic = "a", .payload = "done"});
  pending.Deliver({.topic = "a", .payload = "done"});
  pending.Deliver({.topic = "b/x", .payload = "done"});
  EXPECT_THAT(ended_, ElementsAre("1 FINISHED", "2 FINISHED", "3 FINISHED"));
  EXPECT_THAT(pending.Topics(), IsEmpty());
  EXPECT_EQ(pending.waiting(), 0U);
  EXPECT_EQ(pending.NextLimit(), PendingCommands::Clock::time_point::max());
}

// Is at its end as soon as it has left.
class NotAwaited final : public Told {
 public:
  NotAwaited() : Told("a") {}
  std::vector<std::string> Topics() const override { return {}; }
  void Published(std::uint32_t /*header_id*/) override { Receive({"a", "done"}); }
};

TEST_F(Following, EndsAtOnceOfWhomNoAnswerIsExpected) {
  PendingCommands pending = Pending({});
  pending.Track(7, std::make_shared<NotAwaited>());
  pending.Published(7, {.reference = "7"});
  EXPECT_THAT(ended_, ElementsAre("7 FINISHED"));
  EXPECT_EQ(pending.waiting(), 0U);
}

TEST_F(Following, EndsInTheOrderOfTheLimits) {
  PendingCommands pending = Pending({.seen = milliseconds(20), .done = milliseconds(60)});
  Publish(pending, 1, "a");
  pending.Deliver({.topic = "a", .payload = "seen"});
  Publish(pending, 2, "b");
  const auto first = pending.NextLimit();
  now_ = first;
  EXPECT_THAT(pending.Expire(), IsEmpty());
  EXPECT_THAT(ended_, ElementsAre("2 TIMEOUT"));
  EXPECT_GT(pending.NextLimit(), first);
  now_ = pending.NextLimit();
  EXPECT_THAT(pending.Expire(), IsEmpty());
  EXPECT_THAT(ended_, ElementsAre("2 TIMEOUT", "1 TIMEOUT"));
}

TEST_F(Following, AsksForWhatWasNotSeenToBeSentAgain) {
  PendingCommands pending = Pending({.seen = milliseconds(5), .resend = 1});
  Publish(pending, 7, "a");
  now_ = pending.NextLimit();
  EXPECT_THAT(pending.Expire(), ElementsAre(7U));
  EXPECT_THAT(pending.Expire(), IsEmpty());
  now_ = pending.NextLimit();
  EXPECT_THAT(pending.Expire(), IsEmpty());
  EXPECT_THAT(ended_, ElementsAre("7 TIMEOUT"));
}

// The topic's lock and the broker may have taken long.
TEST_F(Following, CountsTheTimeFromAskingForTheTopic) {
  std::chrono::nanoseconds elapsed{0};
  PendingCommands pending(
      {},
      [&](PendingCommands::Key /*key*/, const message::Report& report) {
        elapsed = report.elapsed;
      },
      {}, [this] { return now_; });
  pending.Track(1, std::make_shared<Told>("a"));
  pending.Published(1, {.elapsed = std::chrono::seconds(3)});
  now_ += std::chrono::seconds(1);
  pending.Deliver({.topic = "a", .payload = "done"});
  EXPECT_EQ(elapsed, std::chrono::seconds(4));
}

TEST_F(Following, WaitsNoLongerInTotalHoweverLateItIsSentAgain) {
  PendingCommands pending = Pending({.total = milliseconds(40), .resend = 1});
  const auto start = now_;
  Publish(pending, 1, "a");
  now_ = start + milliseconds(30);
  EXPECT_THAT(pending.Expire(), ElementsAre(1));
  pending.Published(1, {.reference = "1"});
  EXPECT_EQ(pending.NextLimit(), start + milliseconds(40));
}

// The machine, or the program, stood still.
TEST_F(Following, SendsNothingAgainWhenTheWholeTimeIsUp) {
  PendingCommands pending = Pending({.total = milliseconds(40), .resend = 1});
  Publish(pending, 1, "a");
  now_ += milliseconds(40);
  EXPECT_THAT(pending.Expire(), IsEmpty());
  EXPECT_THAT(ended_, ElementsAre("1 TIMEOUT"));
}

TEST_F(Following, SendsNothingAgainForAnAnswerThatCannotBeRead) {
  PendingCommands pending = Pending({.total = milliseconds(40), .resend = 3});
  Publish(pending, 7, "a");
  pending.Deliver({.topic = "a", .payload = "unreadable"});
  now_ = pending.NextLimit();
  EXPECT_THAT(pending.Expire(), IsEmpty());
  EXPECT_THAT(ended_, IsEmpty()) << "the whole time is for the answer";
  now_ = pending.NextLimit();
  EXPECT_THAT(pending.Expire(), IsEmpty());
  EXPECT_THAT(ended_, ElementsAre("7 TIMEOUT"));
}

TEST_F(Following, ForgetsWhatDidNotLeave) {
  PendingCommands pending = Pending({});
  pending.Track(1, std::make_shared<Told>("a"));
  Publish(pending, 2, "a");
  pending.Forget(1);
  pending.Forget(1);
  EXPECT_EQ(pending.waiting(), 1U);
  pending.EndAll(message::CommandStatus::kError, {ErrorKind::kBroker, "gone"});
  EXPECT_THAT(ended_, ElementsAre("2 ERROR"));
}

}  // namespace
}  // namespace fleetpub::delivery
