#include "delivery/first_connection.h"

#include <gmock/gmock.h>

#include <deque>

#include "support/fake_transport.h"

namespace fleetpub::delivery {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using ::testing::ElementsAre;

/// Attempts that fail for these reasons, in their order; then one that succeeds.
class ConnectingPatiently : public ::testing::Test {
 protected:
  struct Failure {
    std::string why;
    bool may_heal = true;
  };
  Result<std::unique_ptr<mqtt::Transport>> Try(milliseconds patience) {
    return Connect({.open = [this](mqtt::Deadline,
                                   bool& may_heal) -> Result<std::unique_ptr<mqtt::Transport>> {
                      ++attempts_;
                      if (failures_.empty())
                        return std::make_unique<testing::FakeTransport>(journal_);
                      const Failure failure = failures_.front();
                      failures_.pop_front();
                      may_heal = failure.may_heal;
                      return Fail(ErrorKind::kBroker, failure.why);
                    },
                    .waits = [this](const Error& error) { told_.push_back(error.message); }},
                   steady_clock::now() + patience);
  }

  std::deque<Failure> failures_;
  std::vector<std::string> told_;
  int attempts_ = 0;
  testing::Journal journal_;
};

TEST_F(ConnectingPatiently, TriesAgainAndTellsOnce) {
  failures_ = {{"nobody"}, {"still nobody"}};
  EXPECT_TRUE(Try(milliseconds(5'000)));
  EXPECT_EQ(attempts_, 3);
  EXPECT_THAT(told_, ElementsAre("nobody"));
}

TEST_F(ConnectingPatiently, EndsAtOnceWhenNothingWillHeal) {
  failures_ = {{"bad password", false}};
  const auto transport = Try(milliseconds(5'000));
  ASSERT_FALSE(transport);
  EXPECT_EQ(transport.error().message, "bad password");
  EXPECT_EQ(attempts_, 1);
  EXPECT_THAT(told_, ElementsAre());
}

TEST_F(ConnectingPatiently, TriesOnceWithoutPatience) {
  failures_ = {{"nobody"}};
  EXPECT_FALSE(Try(milliseconds(0)));
  EXPECT_EQ(attempts_, 1);
}

TEST_F(ConnectingPatiently, EndsWhenTimeIsUp) {
  failures_ = {{"one"}, {"two"}, {"three"}};
  const auto transport = Try(milliseconds(800));
  ASSERT_FALSE(transport);
  EXPECT_EQ(transport.error().message, "two");
}

}  // namespace
}  // namespace fleetpub::delivery
