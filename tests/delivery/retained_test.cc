#include "delivery/retained.h"

#include <gmock/gmock.h>

#include <deque>
#include <set>

#include "support/fake_transport.h"

namespace fleetpub::delivery {
namespace {

using ::testing::ElementsAre;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAre;

// Has a retained message of each of so many robots, and drops what is beyond its queue: those that
// it handed out last time come last.
class ForgetfulBroker : public testing::FakeTransport {
 public:
  ForgetfulBroker(testing::Journal& journal, int robots, std::size_t queue)
      : FakeTransport(journal), queue_(queue) {
    for (int i = 0; i < robots; ++i) robots_.push_back(std::to_string(i));
  }

  int asked = 0;
  std::vector<std::string> filters;

  Status Subscribe(std::span<const std::string> wanted, mqtt::Qos /*qos*/,
                   mqtt::Deadline /*deadline*/) override {
    ++asked;
    filters.insert(filters.end(), wanted.begin(), wanted.end());
    for (std::size_t i = 0; i < std::min(queue_, robots_.size()); ++i) {
      incoming_.push_back({.topic = robots_.front(), .retained = true});
      robots_.push_back(robots_.front());
      robots_.pop_front();
    }
    return {};
  }

 private:
  std::size_t queue_;
  std::deque<std::string> robots_;
};

std::set<std::string> Collected(ForgetfulBroker& broker) {
  std::set<std::string> known;
  const std::vector<std::string> filters = {"+/connection"};
  const auto ok = ReadAllRetained(
      broker, filters, {}, [&](const mqtt::Message& message) { known.insert(message.topic); },
      [&] { return known.size(); });
  EXPECT_TRUE(ok);
  return known;
}

TEST(ReadAllRetained, AsksOnceWhereNothingCanHaveBeenDropped) {
  testing::Journal journal;
  ForgetfulBroker broker(journal, 900, 2'000);
  EXPECT_THAT(Collected(broker), SizeIs(900));
  EXPECT_EQ(broker.asked, 1);
}

TEST(ReadAllRetained, AsksAgainAsLongAsSomebodyNewTurnsUp) {
  testing::Journal journal;
  ForgetfulBroker broker(journal, 3'500, 1'200);
  EXPECT_THAT(Collected(broker), SizeIs(3'500));
  EXPECT_EQ(broker.asked, 4);
}

// What one filter brings is there before another one may fill the broker's queue.
TEST(ReadRetained, AsksForWhatComesBehindOnce) {
  testing::Journal journal;
  ForgetfulBroker broker(journal, 1'500, 1'200);
  std::vector<std::size_t> taken;  // by the time of each asking
  RetainedOptions options;
  options.behind = {"+/state"};
  std::set<std::string> known;
  const std::vector<std::string> filters = {"+/connection"};
  ASSERT_TRUE(ReadAllRetained(
      broker, filters, options,
      [&](const mqtt::Message& message) {
        known.insert(message.topic);
        taken.resize(static_cast<std::size_t>(broker.asked));
        ++taken.back();
      },
      [&] { return known.size(); }));
  EXPECT_THAT(known, SizeIs(1'500));
  EXPECT_EQ(taken.front(), 1'200U);
  EXPECT_THAT(broker.filters, ElementsAre("+/connection", "+/state", "+/connection"));
}

class ReadingRetained : public ::testing::Test {
 protected:
  ReadingRetained() {
    for (int i = 0; i < 502; ++i) filters_.push_back("robot/" + std::to_string(i));
  }
  void Read(std::size_t filters, const RetainedOptions& options) {
    EXPECT_TRUE(ReadRetained(broker_, std::span(filters_).first(filters), options,
                             [](const mqtt::Message&) { return false; }));
  }

  testing::Journal journal_;
  testing::FakeTransport broker_{journal_};
  std::vector<std::string> filters_;
};

TEST_F(ReadingRetained, EndsManySubscriptionsAndLeavesAFew) {
  Read(500, {});
  EXPECT_THAT(broker_.subscribed(), SizeIs(500));
  Read(501, {});
  EXPECT_THAT(broker_.subscribed(), SizeIs(0));
  Read(2, {.keep = 0});
  EXPECT_THAT(broker_.subscribed(), SizeIs(0));
}

TEST_F(ReadingRetained, EndsNothingThatWasSubscribedBefore) {
  ASSERT_TRUE(broker_.Subscribe(std::span(filters_).first(1), mqtt::kListeningQos, {}));
  Subscribed subscribed = {filters_[0]};
  Read(502, {.subscribed = &subscribed});
  EXPECT_THAT(broker_.subscribed(), ElementsAre(filters_[0]));
  EXPECT_THAT(subscribed, ElementsAre(filters_[0]));
}

TEST_F(ReadingRetained, TellsWhatStaysSubscribed) {
  Subscribed subscribed;
  Read(2, {.behind = {"robot/behind"}, .subscribed = &subscribed});
  EXPECT_THAT(subscribed, UnorderedElementsAre("robot/0", "robot/1", "robot/behind"));
  broker_.forbidden = filters_[501];
  EXPECT_FALSE(ReadRetained(broker_, filters_, {.subscribed = &subscribed}, {}));
  EXPECT_THAT(subscribed, SizeIs(3)) << "of what failed nothing is known";
}

}  // namespace
}  // namespace fleetpub::delivery
