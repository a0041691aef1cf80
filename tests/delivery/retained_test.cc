#include "delivery/retained.h"

#include <gmock/gmock.h>

#include <deque>
#include <set>

#include "support/fake_transport.h"

namespace fleetpub::delivery {
namespace {

using ::testing::SizeIs;

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
  EXPECT_THAT(broker.filters, ::testing::ElementsAre("+/connection", "+/state", "+/connection"));
}

TEST(ReadRetained, EndsManySubscriptionsAndLeavesAFew) {
  testing::Journal journal;
  testing::FakeTransport broker(journal);
  std::vector<std::string> filters;
  for (int i = 0; i < 501; ++i) filters.push_back("robot/" + std::to_string(i));
  const auto nothing = [](const mqtt::Message&) { return false; };
  ASSERT_TRUE(ReadRetained(broker, std::span(filters).first(500), {}, nothing));
  EXPECT_THAT(broker.subscribed(), SizeIs(500));
  ASSERT_TRUE(ReadRetained(broker, filters, {}, nothing));
  EXPECT_THAT(broker.subscribed(), SizeIs(0));
}

}  // namespace
}  // namespace fleetpub::delivery
