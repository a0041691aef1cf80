#include "delivery/subscription.h"

#include <gmock/gmock.h>

#include <deque>

#include "support/fake_transport.h"

namespace fleetpub::delivery {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// Hands out these messages, then breaks.
class Breaking : public testing::FakeTransport {
 public:
  Breaking(testing::Journal& journal, std::deque<std::string> payloads)
      : FakeTransport(journal), payloads_(std::move(payloads)) {}

  Result<std::optional<mqtt::Message>> Receive(mqtt::Deadline /*deadline*/) override {
    if (payloads_.empty()) return Fail(ErrorKind::kBroker, "lost");
    mqtt::Message message{.topic = "t", .payload = payloads_.front()};
    payloads_.pop_front();
    return std::optional(std::move(message));
  }

 private:
  std::deque<std::string> payloads_;
};

class Listening : public ::testing::Test {
 protected:
  // Each connection of this list in turn; an empty one cannot be made.
  Result<Subscription> Open(std::deque<std::deque<std::string>> connections,
                            mqtt::Deadline end = steady_clock::now() + std::chrono::seconds(20)) {
    connections_ = std::move(connections);
    const auto open =
        [this](mqtt::Deadline /*deadline*/) -> Result<std::unique_ptr<mqtt::Transport>> {
      auto payloads = connections_.front();
      connections_.pop_front();
      if (payloads.empty()) return Fail(ErrorKind::kBroker, "no broker");
      return std::make_unique<Breaking>(journal_, payloads);
    };
    auto first = open(end);
    if (!first) return Fail(first.error());
    return Subscription::Open(
        *std::move(first), {"t"},
        {.open = open,
         .lost = [this](const Error& error) { told_.push_back(error.message); },
         .again = [this] { told_.emplace_back("again"); }},
        end);
  }

  std::vector<std::string> Take(Subscription& listener, std::size_t count) {
    std::vector<std::string> payloads;
    EXPECT_TRUE(listener.Read([&](const mqtt::Message& message) {
      payloads.push_back(message.payload);
      return payloads.size() == count;
    }));
    return payloads;
  }

  testing::Journal journal_;
  std::deque<std::deque<std::string>> connections_;
  std::vector<std::string> told_;
};

TEST_F(Listening, GoesOnOverAnotherConnection) {
  auto listener = Open({{"1", "2"}, {}, {"3"}});
  ASSERT_TRUE(listener);
  EXPECT_THAT(Take(*listener, 3), ElementsAre("1", "2", "3"));
  EXPECT_THAT(told_, ElementsAre("lost", "again"));
}

TEST_F(Listening, TellsOfALossWhenItConnectsAgainAndKeepsToTheDeadline) {
  auto listener = Open({{"1"}, {"2"}});
  ASSERT_TRUE(listener);
  Take(*listener, 1);
  EXPECT_FALSE(listener->Next(steady_clock::now() + std::chrono::seconds(10)));
  EXPECT_EQ(listener->transport(), nullptr);
  EXPECT_FALSE(listener->Next(steady_clock::now() + milliseconds(1)));
  EXPECT_EQ(listener->transport(), nullptr);
  EXPECT_THAT(told_, IsEmpty());
  EXPECT_TRUE(listener->Next(steady_clock::now() + std::chrono::seconds(10)));
  EXPECT_THAT(told_, ElementsAre("lost", "again"));
}

TEST_F(Listening, LooksOnceHoweverShortTheTime) {
  auto listener = Open({{"1", "2"}}, steady_clock::now());
  ASSERT_TRUE(listener);
  EXPECT_THAT(Take(*listener, 2), ElementsAre("1"));
}

TEST_F(Listening, EndsWhenItIsNotToGoOn) {
  auto listener = Open({{"1"}, {"2"}});
  ASSERT_TRUE(listener);
  int looks = 0;
  EXPECT_TRUE(listener->Read([](const mqtt::Message&) { return false; },
                             [&]() -> Result<bool> { return ++looks < 3; }));
  EXPECT_EQ(looks, 3);
  const auto read =
      listener->Read([](const mqtt::Message&) { return false; },
                     []() -> Result<bool> { return Fail(ErrorKind::kLedger, "closed"); });
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().message, "closed");
}

TEST_F(Listening, DoesNotBeginWithoutTheSubscription) {
  auto transport = std::make_unique<testing::FakeTransport>(journal_);
  transport->forbidden = "t";
  const auto listener = Subscription::Open(std::move(transport), {"t"}, {}, steady_clock::now());
  ASSERT_FALSE(listener);
  EXPECT_EQ(listener.error().message, "broker refuses t");
}

}  // namespace
}  // namespace fleetpub::delivery
