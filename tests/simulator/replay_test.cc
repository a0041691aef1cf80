// What a replay says of a broker that does not take all of it.
#include "simulator/replay.h"

#include <gmock/gmock.h>

#include "support/fake_transport.h"
#include "support/temporary_folder.h"

namespace fleetpub::simulator {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kNotAuthorized = 0x87;

// An ONLINE, which is retained, and a state, both at QoS 1.
class Replaying : public ::testing::Test {
 protected:
  Replaying() {
    options_.file = folder_.Write(
        "shift.jsonl",
        R"({"t":0,"topic":"uagv/v2/KIT/1/connection","qos":1,"payload":"{\"headerId\":1}"})"
        "\n"
        R"({"t":0,"topic":"uagv/v2/KIT/1/state","qos":1,"payload":"{\"headerId\":1}"})"
        "\n");
    options_.stopped = [] { return false; };
  }

  // Why it failed, at a broker that says this to each message.
  std::string Play(const std::function<std::optional<mqtt::Acknowledgement>(int token)>& answer) {
    auto transport = std::make_unique<testing::FakeTransport>(journal_);
    transport->acknowledge = answer;
    const auto plan = PlanReplay(options_);
    EXPECT_TRUE(plan) << plan.error().message;
    const auto replayed = Replay(options_, *plan, std::move(transport), {});
    if (replayed) return "";
    EXPECT_EQ(replayed.error().kind, ErrorKind::kBroker);
    return replayed.error().message;
  }

  testing::TemporaryFolder folder_;
  testing::Journal journal_;
  ReplayOptions options_;
};

TEST_F(Replaying, IsDoneWhenAllIsTaken) {
  EXPECT_EQ(Play([](int token) { return mqtt::Acknowledgement{.token = token}; }), "");
}

TEST_F(Replaying, CountsWhatTheBrokerRefuses) {
  const auto refuse = [](int token) {
    return mqtt::Acknowledgement{token, kNotAuthorized, "not authorized (0x87)"};
  };
  EXPECT_THAT(Play(refuse),
              AllOf(HasSubstr("refused 2 of 2 messages"),
                    HasSubstr("uagv/v2/KIT/1/connection: not authorized (0x87)"),
                    HasSubstr("did not take back what it had retained before at 1 topic")));
  options_.keep = true;
  EXPECT_THAT(Play(refuse),
              AllOf(HasSubstr("refused 2 of 2 messages"), Not(HasSubstr("retained before"))));
}

TEST_F(Replaying, CountsWhatTheBrokerDoesNotAcknowledge) {
  const auto answer_the_first = [](int token) {
    return token == 1 ? std::optional(mqtt::Acknowledgement{.token = token}) : std::nullopt;
  };
  EXPECT_THAT(Play(answer_the_first), AllOf(HasSubstr("did not acknowledge 1 of 2 messages"),
                                            HasSubstr("retained before at 1 topic")));
}

TEST_F(Replaying, SaysWhatCannotBePutBack) {
  const auto refuse_the_third = [](int token) {
    return mqtt::Acknowledgement{.token = token, .reason_code = token == 3 ? kNotAuthorized : 0};
  };
  EXPECT_THAT(Play(refuse_the_third),
              AllOf(HasSubstr("did not take back what it had retained before at 1 topic"),
                    Not(HasSubstr("messages"))));
}

}  // namespace
}  // namespace fleetpub::simulator
