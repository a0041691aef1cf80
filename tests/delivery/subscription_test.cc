#include "delivery/subscription.h"

#include <gmock/gmock.h>

#include <deque>

#include "support/fake_transport.h"

namespace fleetpub::delivery {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using ::testing::ElementsAre;

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
  Result<std::unique_ptr<Subscription>> Open(std::deque<std::deque<std::string>> connections) {
    connections_ = std::move(connections);
    const auto connect =
        [this](mqtt::Deadline /*deadline*/) -> Result<std::unique_ptr<mqtt::Transport>> {
      auto payloads = connections_.front();
      connections_.pop_front();
      if (payloads.empty()) return Fail(ErrorKind::kBroker, "no broker");
      return std::make_unique<Breaking>(journal_, payloads);
    };
    return Subscription::Open({"t"}, connect,
                              {[this](const Error& error) { told_.push_back(error.message); },
                               [this] { told_.emplace_back("again"); }},
                              steady_clock::now() + std::chrono::seconds(20));
  }

  std::vector<std::string> Take(Subscription& listener, std::size_t count) {
    std::vector<std::string> payloads;
    const auto limit = steady_clock::now() + std::chrono::seconds(10);
    while (payloads.size() < count && steady_clock::now() < limit) {
      if (auto message = listener.Next(limit)) payloads.push_back(message->payload);
    }
    return payloads;
  }

  testing::Journal journal_;
  std::deque<std::deque<std::string>> connections_;
  std::vector<std::string> told_;
};

TEST_F(Listening, GoesOnOverAnotherConnection) {
  const auto listener = Open({{"1", "2"}, {}, {"3"}});
  ASSERT_TRUE(listener);
  EXPECT_THAT(Take(**listener, 3), ElementsAre("1", "2", "3"));
  EXPECT_THAT(told_, ElementsAre("lost", "again"));
}

TEST_F(Listening, TellsTheLossAtOnceAndKeepsToTheDeadline) {
  const auto listener = Open({{"1"}, {"2"}});
  ASSERT_TRUE(listener);
  Take(**listener, 1);
  EXPECT_FALSE((*listener)->Next(steady_clock::now() + std::chrono::seconds(10)));
  EXPECT_FALSE((*listener)->connected());
  EXPECT_THAT(told_, ElementsAre("lost"));
  EXPECT_FALSE((*listener)->Next(steady_clock::now() + milliseconds(1)));
  EXPECT_FALSE((*listener)->connected());
}

TEST_F(Listening, DoesNotBeginWithoutABroker) {
  const auto listener = Open({{}});
  ASSERT_FALSE(listener);
  EXPECT_EQ(listener.error().message, "no broker");
}

}  // namespace
}  // namespace fleetpub::delivery
