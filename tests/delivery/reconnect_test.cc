#include "delivery/reconnect.h"

#include <gmock/gmock.h>

#include "support/fake_transport.h"

namespace fleetpub::delivery {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;
using ::testing::IsNull;
using ::testing::NotNull;

constexpr auto kForever = mqtt::Deadline::max();

TEST(ReconnectSchedule, TriesEverMoreSeldomWhatBreaksAgainAtOnce) {
  const auto start = steady_clock::now();
  ReconnectSchedule schedule;
  std::vector<milliseconds> pauses;
  for (int i = 0; i < 6; ++i) {
    schedule.Connected(start);
    schedule.Lost(start);
    pauses.push_back(std::chrono::duration_cast<milliseconds>(schedule.next() - start));
  }
  EXPECT_TRUE(std::is_sorted(pauses.begin(), pauses.end()));
  EXPECT_LT(pauses.front(), pauses.back());
  EXPECT_LE(pauses.back(), seconds(5));
  schedule.Connected(start);
  schedule.Lost(start + seconds(60));
  EXPECT_EQ(schedule.next() - (start + seconds(60)), pauses.front()) << "it had lasted";
}

TEST(ReconnectSchedule, KeepsItsPaceWhileTheBrokerIsAway) {
  const auto start = steady_clock::now();
  ReconnectSchedule schedule;
  schedule.Lost(start);
  const auto pause = schedule.next() - start;
  for (int i = 1; i < 10; ++i) {
    schedule.Failed(start + seconds(i));
    EXPECT_EQ(schedule.next(), start + seconds(i) + pause);
  }
}

class Reconnecting : public ::testing::Test {
 protected:
  std::unique_ptr<mqtt::Transport> Try(mqtt::Deadline end = kForever, const Status& ready = {}) {
    return reconnector_.TryAgain(kForever, end, [&](mqtt::Transport&) { return ready; });
  }

  testing::Journal journal_;
  int attempts_ = 0;
  int losses_ = 0;
  int returns_ = 0;
  Reconnector reconnector_{{
      .open = [this](mqtt::Deadline) -> Result<std::unique_ptr<mqtt::Transport>> {
        if (++attempts_ == 1) return Fail(ErrorKind::kBroker, "refused");
        return std::make_unique<testing::FakeTransport>(journal_);
      },
      .lost = [this](const Error&) { ++losses_; },
      .again = [this] { ++returns_; },
  }};
};

TEST_F(Reconnecting, TellsALossOnceAndItsEnd) {
  reconnector_.Lose({ErrorKind::kBroker, "broken pipe"});
  EXPECT_FALSE(reconnector_.is_told());
  EXPECT_THAT(Try(), IsNull());
  EXPECT_TRUE(reconnector_.is_told());
  EXPECT_EQ(reconnector_.lost()->message, "broken pipe");
  EXPECT_THAT(Try(), NotNull());
  EXPECT_FALSE(reconnector_.lost());
  EXPECT_EQ(losses_, 1);
  EXPECT_EQ(returns_, 1);
}

TEST_F(Reconnecting, HasNoConnectionThatIsNotReady) {
  attempts_ = 1;
  reconnector_.Lose({ErrorKind::kBroker, "broken pipe"});
  EXPECT_THAT(Try(kForever, Fail(ErrorKind::kBroker, "not subscribed")), IsNull());
  EXPECT_TRUE(reconnector_.lost());
  EXPECT_EQ(returns_, 0);
}

TEST_F(Reconnecting, TriesNothingBeforeItsTimeOrAfterTheEnd) {
  reconnector_.Lose({ErrorKind::kBroker, "broken pipe"});
  EXPECT_THAT(reconnector_.TryAgain(steady_clock::now(), kForever, {}), IsNull());
  EXPECT_THAT(Try(steady_clock::now()), IsNull());
  EXPECT_EQ(attempts_, 0);
  EXPECT_EQ(losses_, 0);
}

}  // namespace
}  // namespace fleetpub::delivery
