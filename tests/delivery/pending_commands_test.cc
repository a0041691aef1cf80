#include "delivery/pending_commands.h"

#include <gmock/gmock.h>

#include <thread>

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
  void Publish(PendingCommands& follower, PendingCommands::Key key, const std::string& topic) {
    follower.Track(key, std::make_shared<Told>(topic));
    follower.Published(key, {.reference = std::to_string(key)});
  }
  PendingCommands::EndHook Note() {
    return [this](PendingCommands::Key key, const message::Report& report) {
      EXPECT_EQ(report.reference, std::to_string(key));
      ended_.push_back(std::to_string(key) + " " + std::string(NameOf(report.status)));
    };
  }
  std::vector<std::string> ended_;
};

TEST_F(Following, TellsEachEndOnceAndForgetsIt) {
  PendingCommands follower({}, Note());
  Publish(follower, 1, "a");
  Publish(follower, 2, "a");
  Publish(follower, 3, "b/+");
  EXPECT_THAT(follower.Topics(), UnorderedElementsAre("a", "b/+"));
  follower.Deliver({.topic = "a", .payload = "done"});
  follower.Deliver({.topic = "a", .payload = "done"});
  follower.Deliver({.topic = "b/x", .payload = "done"});
  EXPECT_THAT(ended_, ElementsAre("1 FINISHED", "2 FINISHED", "3 FINISHED"));
  EXPECT_THAT(follower.Topics(), IsEmpty());
  EXPECT_EQ(follower.waiting(), 0U);
  EXPECT_EQ(follower.NextLimit(), PendingCommands::Clock::time_point::max());
}

// Is at its end as soon as it has left.
class NotAwaited final : public Told {
 public:
  NotAwaited() : Told("a") {}
  std::vector<std::string> Topics() const override { return {}; }
  void Published(std::uint32_t /*header_id*/) override { Receive({"a", "done"}); }
};

TEST_F(Following, EndsAtOnceOfWhomNoAnswerIsExpected) {
  PendingCommands follower({}, Note());
  follower.Track(7, std::make_shared<NotAwaited>());
  follower.Published(7, {.reference = "7"});
  EXPECT_THAT(ended_, ElementsAre("7 FINISHED"));
  EXPECT_EQ(follower.waiting(), 0U);
}

TEST_F(Following, EndsInTheOrderOfTheLimits) {
  PendingCommands follower({.seen = milliseconds(20), .done = milliseconds(60)}, Note());
  Publish(follower, 1, "a");
  follower.Deliver({.topic = "a", .payload = "seen"});
  Publish(follower, 2, "b");
  const auto first = follower.NextLimit();
  std::this_thread::sleep_until(first);
  EXPECT_THAT(follower.Expire(), IsEmpty());
  EXPECT_THAT(ended_, ElementsAre("2 TIMEOUT"));
  EXPECT_GT(follower.NextLimit(), first);
  std::this_thread::sleep_until(follower.NextLimit());
  EXPECT_THAT(follower.Expire(), IsEmpty());
  EXPECT_THAT(ended_, ElementsAre("2 TIMEOUT", "1 TIMEOUT"));
}

TEST_F(Following, AsksForWhatWasNotSeenToBeSentAgain) {
  PendingCommands follower({.seen = milliseconds(5), .resend = 1}, Note());
  Publish(follower, 7, "a");
  std::this_thread::sleep_until(follower.NextLimit());
  EXPECT_THAT(follower.Expire(), ElementsAre(7U));
  EXPECT_THAT(follower.Expire(), IsEmpty());
  std::this_thread::sleep_until(follower.NextLimit());
  EXPECT_THAT(follower.Expire(), IsEmpty());
  EXPECT_THAT(ended_, ElementsAre("7 TIMEOUT"));
}

TEST_F(Following, SendsNothingAgainForAnAnswerThatCannotBeRead) {
  PendingCommands follower({.total = milliseconds(40), .resend = 3}, Note());
  Publish(follower, 7, "a");
  follower.Deliver({.topic = "a", .payload = "unreadable"});
  std::this_thread::sleep_until(follower.NextLimit());
  EXPECT_THAT(follower.Expire(), IsEmpty());
  EXPECT_THAT(ended_, IsEmpty()) << "the whole time is for the answer";
  std::this_thread::sleep_until(follower.NextLimit());
  EXPECT_THAT(follower.Expire(), IsEmpty());
  EXPECT_THAT(ended_, ElementsAre("7 TIMEOUT"));
}

TEST_F(Following, ForgetsWhatDidNotLeave) {
  PendingCommands follower({}, Note());
  follower.Track(1, std::make_shared<Told>("a"));
  Publish(follower, 2, "a");
  follower.Forget(1);
  follower.Forget(1);
  EXPECT_EQ(follower.waiting(), 1U);
  follower.EndAll({ErrorKind::kBroker, "gone"});
  EXPECT_THAT(ended_, ElementsAre("2 ERROR"));
}

}  // namespace
}  // namespace fleetpub::delivery
