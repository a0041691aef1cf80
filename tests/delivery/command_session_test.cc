#include "delivery/command_session.h"

#include <gmock/gmock.h>

#include "support/fake_ledger.h"
#include "support/fake_tracker.h"
#include "support/fake_transport.h"

namespace fleetpub::delivery {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

class Streaming : public ::testing::Test {
 protected:
  Streaming() { Connect(); }

  void Connect() {
    auto fake = std::make_unique<testing::FakeTransport>(journal_);
    fake_ = fake.get();
    transport_ = std::move(fake);
  }

  std::unique_ptr<CommandSession> Open(SendOptions options = {}) {
    return std::make_unique<CommandSession>(
        transport_, ledger_, options, WaitOptions{},
        SessionHooks{
            .report =
                [this](const message::Report& report) {
                  reports_.push_back(report.reference + " " + std::string(GetName(report.status)) +
                                     " " + report.message);
                },
            .sent = {},
            .reconnect = {
                .open = [this](mqtt::Deadline) -> Result<std::unique_ptr<mqtt::Transport>> {
                  ++connections_;
                  auto fake = std::make_unique<testing::FakeTransport>(journal_);
                  fake_ = fake.get();
                  return fake;
                },
                .lost = [this](const Error& error) { lost_ = error.message; },
                .again = {}}});
  }

  static std::vector<message::Command> Commands(int count, int first = 0) {
    std::vector<message::Command> commands(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
      message::Command& command = commands[static_cast<std::size_t>(i)];
      command.reference = "#" + std::to_string(first + i);
      command.topic = "t/" + std::to_string((first + i) % 2);
      command.payload = {"{", ",", "}"};
    }
    return commands;
  }

  testing::Journal journal_;
  testing::FakeLedger ledger_{journal_};
  testing::FakeTransport* fake_ = nullptr;
  std::unique_ptr<mqtt::Transport> transport_;
  std::vector<std::string> reports_;
  std::string lost_;
  int connections_ = 0;
};

TEST_F(Streaming, SendsWhatIsThereThroughOneBracketInOrder) {
  const auto stream = Open();
  EXPECT_TRUE(stream->Send(Commands(3)));
  EXPECT_THAT(reports_, ElementsAre("#0 SENT ", "#1 SENT ", "#2 SENT "));
  EXPECT_THAT(journal_.entries(),
              ElementsAre("lock t/0 t/1", "reserve 3", "publish t/0", "publish t/1", "publish t/0",
                          "unlock", "record SENT SENT SENT"));
}

TEST_F(Streaming, SaysOfEachCommandWhatALostConnectionMeans) {
  const auto stream = Open();
  fake_->publish_fails_at = 1;
  EXPECT_FALSE(stream->Send(Commands(3)));
  EXPECT_THAT(reports_, ElementsAre("#0 SENT ", StartsWith("#1 ERROR perhaps sent: "),
                                    StartsWith("#2 ERROR not sent: ")));
  EXPECT_TRUE(stream->lost());
  EXPECT_EQ(lost_, "") << "told when it connects again";
}

TEST_F(Streaming, ConnectsAgainAndSendsNothingTwice) {
  const auto stream = Open();
  fake_->publish_fails_at = 0;
  EXPECT_FALSE(stream->Send(Commands(1)));
  reports_.clear();
  stream->Listen(std::chrono::steady_clock::now() + std::chrono::seconds(5));
  EXPECT_FALSE(stream->lost());
  EXPECT_THAT(lost_, HasSubstr("connection lost"));
  EXPECT_EQ(connections_, 1);
  EXPECT_THAT(fake_->published(), IsEmpty());
  EXPECT_TRUE(stream->Send(Commands(1, 1)));
  EXPECT_THAT(reports_, ElementsAre("#1 SENT "));
}

std::shared_ptr<message::ResponseTracker> Tracker(int robot, bool ends) {
  using testing::FakeTracker;
  return std::make_shared<FakeTracker>(
      "state/" + std::to_string(robot),
      ends ? FakeTracker::Ends::kOncePublished : FakeTracker::Ends::kNever);
}

TEST_F(Streaming, GoesOnWaitingWhenAnAcknowledgementIsLost) {
  const auto stream = Open({.qos = mqtt::Qos::kAtLeastOnce});
  std::vector<message::Command> commands = Commands(1);
  commands.front().tracker = Tracker(0, false);
  fake_->await_error = Error{ErrorKind::kBroker, "broker: connection lost"};
  EXPECT_FALSE(stream->Send(commands));
  EXPECT_THAT(reports_, IsEmpty()) << "the robot may have it, and say so";
  EXPECT_EQ(stream->waiting(), 1U);
  stream->Listen(std::chrono::steady_clock::now() + std::chrono::seconds(5));
  EXPECT_TRUE(fake_->subscribed().contains("state/0"));
  EXPECT_THAT(fake_->published(), IsEmpty()) << "nothing is sent twice";
  stream->EndAll(message::CommandStatus::kError, {ErrorKind::kBroker, "enough"});
  EXPECT_THAT(reports_, ElementsAre(HasSubstr("did not acknowledge")));
}

TEST_F(Streaming, EndsSubscriptionsThatNobodyAwaits) {
  const auto stream = Open();
  const auto send = [&](int robot, bool ends) {
    std::vector<message::Command> commands = Commands(1);
    commands.front().tracker = Tracker(robot, ends);
    ASSERT_TRUE(stream->Send(commands));
  };
  send(-1, false);
  for (int robot = 0; robot < 12'000; ++robot) {
    send(robot, true);
    ASSERT_TRUE(fake_->subscribed().contains("state/" + std::to_string(robot)));
    ASSERT_LE(fake_->subscribed().size(), 5'003U);
  }
  EXPECT_TRUE(fake_->subscribed().contains("state/-1")) << "who is awaited is listened to";
  send(0, true);
  EXPECT_TRUE(fake_->subscribed().contains("state/0")) << "commanded again";
}

TEST_F(Streaming, LetsOneForbiddenTopicStopNobodyElse) {
  const auto stream = Open();
  fake_->forbidden = "state/1";
  std::vector<message::Command> commands = Commands(3);
  for (int robot = 0; robot < 3; ++robot) {
    commands[static_cast<std::size_t>(robot)].tracker = Tracker(robot, true);
  }
  EXPECT_FALSE(stream->Send(commands));
  EXPECT_THAT(reports_, ElementsAre("#0 FINISHED ", "#1 ERROR not sent: broker refuses state/1",
                                    "#2 FINISHED "));
  EXPECT_EQ(fake_->published().size(), 2U);
}

TEST_F(Streaming, LetsOneUnfitHeaderIdStopNobodyElse) {
  const auto stream = Open();
  ledger_.reserve_error = Error{ErrorKind::kUsage, "header id 3 is not above 7"};
  ledger_.reserve_errors_begin_at = 0;
  EXPECT_FALSE(stream->Send(Commands(2)));
  EXPECT_THAT(reports_, ElementsAre(AllOf(StartsWith("#0 ERROR not sent"), HasSubstr("above 7")),
                                    StartsWith("#1 ERROR not sent")));
  // Each was tried alone.
  EXPECT_THAT(journal_.entries(),
              ElementsAre("lock t/0 t/1", "unlock", "lock t/0", "unlock", "lock t/1", "unlock"));
}

TEST_F(Streaming, LetsOneMessageThatIsTooLargeStopNobodyElse) {
  const auto stream = Open();
  auto commands = Commands(3);
  commands[1].payload.rest = std::string(100, '}');
  fake_->largest = 100;
  EXPECT_FALSE(stream->Send(commands));
  EXPECT_THAT(reports_, ElementsAre("#0 SENT ", "#1 ERROR not sent: too large", "#2 SENT "));
  EXPECT_FALSE(stream->lost());
}

TEST_F(Streaming, GoesOnAfterTroubleWithTheLedger) {
  const auto stream = Open();
  ledger_.lock_error = Error{ErrorKind::kLedger, "held"};
  EXPECT_FALSE(stream->Send(Commands(2)));
  ledger_.lock_error.reset();
  EXPECT_TRUE(stream->Send(Commands(1, 2)));
  EXPECT_THAT(reports_,
              ElementsAre("#0 ERROR not sent: held", "#1 ERROR not sent: held", "#2 SENT "));
}

}  // namespace
}  // namespace fleetpub::delivery
