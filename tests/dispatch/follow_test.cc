#include "dispatch/follow.h"

#include <gmock/gmock.h>

namespace fleetpub::dispatch {
namespace {

using ::testing::ElementsAre;
using ::testing::UnorderedElementsAre;

// Ends with the first message that it hears.
class Listening : public Confirmation {
 public:
  explicit Listening(std::vector<std::string> topics) : topics_(std::move(topics)) {}
  [[nodiscard]] std::vector<std::string> Topics() const override { return topics_; }
  void Published(std::uint32_t /*header_id*/) override {}
  void Receive(const Incoming& message) override {
    progress_ = {true, true, Verdict::kFinished, std::string(message.topic)};
  }
  [[nodiscard]] const Progress& progress() const override { return progress_; }

 private:
  std::vector<std::string> topics_;
  Progress progress_;
};

class FollowTopics : public ::testing::Test {
 protected:
  void Publish(std::size_t index, Confirmation* confirmation) {
    follower_.Watch(index, confirmation);
    follower_.Published(index, {.target = std::to_string(index)});
  }

  std::vector<std::string> ended_;
  Follower follower_{
      {}, [this](const Report& report) { ended_.push_back(report.target + " " + report.message); }};
};

TEST_F(FollowTopics, HandsAMessageToWhoWaitsOnItsTopic) {
  Listening one({"a/b"});
  Listening other({"a/c"});
  Publish(1, &one);
  Publish(2, &other);
  EXPECT_THAT(follower_.Topics(), UnorderedElementsAre("a/b", "a/c"));
  follower_.Deliver({.topic = "a/c", .payload = ""});
  follower_.Deliver({.topic = "a/d", .payload = ""});
  EXPECT_THAT(ended_, ElementsAre("2 a/c"));
  EXPECT_EQ(follower_.waiting(), 1U);
}

TEST_F(FollowTopics, HandsAMessageToWhoWaitsOnAFilter) {
  Listening exact({"a/b"});
  Listening any({"a/+", "c"});
  Publish(1, &exact);
  Publish(2, &any);
  EXPECT_THAT(follower_.Topics(), UnorderedElementsAre("a/b", "a/+", "c"));
  follower_.Deliver({.topic = "a", .payload = ""});
  EXPECT_EQ(follower_.waiting(), 2U);
  follower_.Deliver({.topic = "a/b", .payload = ""});
  EXPECT_THAT(ended_, ElementsAre("1 a/b", "2 a/b"));
}

}  // namespace
}  // namespace fleetpub::dispatch
