#include "simulator/runner.h"

#include <gmock/gmock.h>

#include <deque>

namespace fleetpub::simulator {
namespace {

using ::testing::ElementsAre;

/// Connects as it is told, and works until it is told that it breaks.
class FakeInhabitant final : public Inhabitant {
 public:
  std::deque<bool> connects;  ///< whether each attempt succeeds
  int turns_until_lost = 1;
  std::vector<std::string> did;

  Status Connect() override {
    const bool can = connects.front();
    connects.pop_front();
    did.emplace_back(can ? "connect" : "fail");
    return can ? Status() : Fail(ErrorKind::kBroker, "refused");
  }
  Status Turn() override {
    if (!connects.empty() && turns_until_lost-- == 0) return Fail(ErrorKind::kBroker, "lost");
    is_gone = connects.empty();
    return {};
  }
  void Drop() override { did.emplace_back("drop"); }
  Status Disconnect() override {
    did.emplace_back("disconnect");
    return {};
  }
  [[nodiscard]] bool IsGone() const override { return is_gone; }
  [[nodiscard]] bool MayHeal() const override { return may_heal; }

  bool is_gone = false;
  bool may_heal = false;
};

class KeepingRobotsAtABroker : public ::testing::Test {
 protected:
  Status Keep() { return KeepAtBroker(robot_, options_); }

  FakeInhabitant robot_;
  std::vector<std::string> told_;
  bool stopped_ = false;
  RunOptions options_{
      .connect = {},
      .duration = {},
      .stopped = [this] { return stopped_; },
      .on_ready = [this] { told_.emplace_back("ready"); },
      .places = {},
      .on_lost = [this](const Error& error) { told_.push_back(error.message); },
  };
};

TEST_F(KeepingRobotsAtABroker, ConnectsAgainAndTellsOnce) {
  robot_.connects = {true, false, true};
  EXPECT_TRUE(Keep());
  EXPECT_THAT(robot_.did, ElementsAre("connect", "drop", "fail", "drop", "connect", "disconnect"));
  EXPECT_THAT(told_, ElementsAre("ready", "lost"));
}

TEST_F(KeepingRobotsAtABroker, FailsWhenTheFirstConnectionDoes) {
  robot_.connects = {false};
  const Status kept = Keep();
  ASSERT_FALSE(kept);
  EXPECT_EQ(kept.error().message, "refused");
  EXPECT_THAT(told_, ElementsAre());
}

TEST_F(KeepingRobotsAtABroker, WaitsForOneThatIsNotThereYet) {
  robot_.connects = {false, true, true};
  robot_.may_heal = true;
  EXPECT_TRUE(Keep());
  EXPECT_THAT(robot_.did, ElementsAre("fail", "drop", "connect", "drop", "connect", "disconnect"));
  EXPECT_THAT(told_, ElementsAre("refused", "ready", "lost"));
}

TEST_F(KeepingRobotsAtABroker, WaitsForItNoLongerThanTheConnectTimeout) {
  robot_.connects = {false, false, false};
  robot_.may_heal = true;
  options_.connect.connect_timeout = std::chrono::milliseconds(300);
  EXPECT_FALSE(Keep());
  EXPECT_THAT(robot_.did, ElementsAre("fail", "drop", "fail"));
}

TEST_F(KeepingRobotsAtABroker, StopsWhileItWaitsToConnectAgain) {
  robot_.connects = {true, true};
  options_.on_lost = [this](const Error&) { stopped_ = true; };
  EXPECT_TRUE(Keep());
  EXPECT_THAT(robot_.did, ElementsAre("connect", "drop"));
}

}  // namespace
}  // namespace fleetpub::simulator
