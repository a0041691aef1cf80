#include "delivery/send_all.h"

#include <gmock/gmock.h>

#include <chrono>

#include "delivery/publish_pipeline.h"
#include "support/fake_ledger.h"
#include "support/fake_tracker.h"
#include "support/fake_transport.h"
#include "support/report_matchers.h"

namespace fleetpub::delivery {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using testing::Is;
using ::testing::IsEmpty;
using ::testing::Not;
using testing::Says;
using ::testing::SizeIs;

message::Command CommandFor(const std::string& target) {
  message::Command command;
  command.target = target;
  command.protocol = "vda5050";
  command.version = "3.0.0";
  command.topic = "t/" + target;
  command.actions = {{"startPause", "id of " + target}};
  command.payload = {.before_id = "<", .before_time = "|", .rest = ">"};
  return command;
}

std::vector<message::Command> CommandsFor(int count) {
  std::vector<message::Command> commands;
  commands.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) commands.push_back(CommandFor(std::to_string(i)));
  return commands;
}

class Sending : public ::testing::Test {
 protected:
  Sending() {
    options_.now = [] { return base::WallTime(1767323045678ms); };
  }

  // Returns what changes no status.
  Status Send(const std::vector<message::Command>& commands,
              mqtt::Qos qos = mqtt::Qos::kAtMostOnce) {
    options_.qos = qos;
    const ReportSink report = [&](const message::Report& done) { reports_.push_back(done); };
    CommandSession session(
        connection_, ledger_, options_, WaitOptions{.resend = 0},
        {.report = report,
         .sent = [&] { ++left_; },
         .reconnect = {
             .open = [](mqtt::Deadline) { return Fail(ErrorKind::kBroker, "broker: gone"); },
             .lost = {},
             .again = {}}});
    CommandList list(commands, report);
    EXPECT_TRUE(SendAll(list, session, {.batch = options_.batch, .rate = rate_}));
    return session.trouble();
  }

  [[nodiscard]] std::vector<std::string> Statuses() const {
    std::vector<std::string> statuses;
    for (const ledger::Record& row : ledger_.rows()) statuses.push_back(row.status);
    return statuses;
  }

  testing::Journal journal_;
  testing::FakeLedger ledger_{journal_};
  std::unique_ptr<mqtt::Transport> connection_ = std::make_unique<testing::FakeTransport>(journal_);
  testing::FakeTransport& transport_ = dynamic_cast<testing::FakeTransport&>(*connection_);
  SendOptions options_;
  RateLimiter rate_;
  std::vector<message::Report> reports_;
  int left_ = 0;
};

using SendAtQos0 = Sending;
using SendAtQos1 = Sending;
using SendInBatches = Sending;

TEST_F(SendAtQos0, ReservesUnderTheLockAndPublishesAfterwards) {
  EXPECT_TRUE(Send({CommandFor("a"), CommandFor("b")}));
  EXPECT_THAT(journal_.entries(), ElementsAre("lock t/a t/b", "reserve 2", "publish t/a",
                                              "publish t/b", "unlock", "record SENT SENT"));
}

TEST_F(SendAtQos0, ReportsWhatWasSent) {
  EXPECT_TRUE(Send({CommandFor("a")}));
  ASSERT_THAT(reports_, SizeIs(1));
  const message::Report& report = reports_.front();
  EXPECT_EQ(report.target, "a");
  EXPECT_EQ(report.topic, "t/a");
  EXPECT_EQ(report.version, "3.0.0");
  EXPECT_EQ(report.header_id, 0U);
  EXPECT_EQ(report.status, message::CommandStatus::kSent);
  EXPECT_EQ(report.error, std::nullopt);
  EXPECT_EQ(report.payload, "<0|2026-01-02T03:04:05.678Z>");
  EXPECT_THAT(report.actions, ElementsAre(message::ActionRef{"startPause", "id of a"}));
  EXPECT_GT(report.elapsed.count(), 0);
}

TEST_F(SendAtQos0, PublishesExactlyWhatItRecordedAndNeverRetained) {
  EXPECT_TRUE(Send({CommandFor("a"), CommandFor("a"), CommandFor("b")}));
  ASSERT_THAT(transport_.published(), SizeIs(3));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(transport_.published()[i].payload, ledger_.rows()[i].payload);
    EXPECT_EQ(transport_.published()[i].topic, ledger_.rows()[i].topic);
    EXPECT_EQ(transport_.published()[i].qos, mqtt::Qos::kAtMostOnce);
    EXPECT_FALSE(transport_.published()[i].retained);
  }
}

TEST_F(SendAtQos0, CountsEachTopicOnItsOwn) {
  EXPECT_TRUE(Send({CommandFor("a"), CommandFor("b"), CommandFor("a")}));
  std::vector<std::uint32_t> ids;
  for (const message::Report& report : reports_) ids.push_back(report.header_id.value());
  EXPECT_THAT(ids, ElementsAre(0U, 0U, 1U));
}

TEST_F(SendAtQos0, SendsTheHeaderIdAskedFor) {
  message::Command command = CommandFor("a");
  command.header_id = 41;
  EXPECT_TRUE(Send({command, CommandFor("a")}));
  EXPECT_THAT(transport_.published()[0].payload, HasSubstr("<41|"));
  EXPECT_THAT(transport_.published()[1].payload, HasSubstr("<42|"));
}

TEST_F(SendAtQos0, GivesNoIdToAMessageThatIsNotCounted) {
  message::Command command = CommandFor("a");
  command.payload = {.before_id = "", .before_time = "{", .rest = "}", .counted = false};
  EXPECT_TRUE(Send({command}));
  EXPECT_EQ(reports_.front().header_id, std::nullopt);
  EXPECT_EQ(transport_.published().front().payload, "{2026-01-02T03:04:05.678Z}");
  EXPECT_EQ(reports_.front().payload, transport_.published().front().payload);
}

TEST_F(SendAtQos0, RecordsBrokerAndTargetWithTheMessage) {
  EXPECT_TRUE(Send({CommandFor("a")}));
  const ledger::Record& row = ledger_.rows().front();
  EXPECT_EQ(row.target, "a");
  EXPECT_EQ(row.broker, "mqtt://broker:1883");
  EXPECT_EQ(row.status, "SENT");
  EXPECT_THAT(row.actions, ElementsAre(message::ActionRef{"startPause", "id of a"}));
}

TEST_F(SendAtQos0, TellsOfEachMessageThatLeft) {
  EXPECT_TRUE(Send(CommandsFor(3)));
  EXPECT_EQ(left_, 3);
}

TEST_F(SendAtQos0, SendsNothingOfNothing) {
  EXPECT_TRUE(Send({}));
  EXPECT_THAT(journal_.entries(), IsEmpty());
}

TEST_F(SendAtQos0, SendsNothingWhenTheLockIsNotToBeHad) {
  ledger_.lock_error = Error{ErrorKind::kLedger, "t/0 is held by somebody else"};
  EXPECT_TRUE(Send(CommandsFor(2)));
  EXPECT_THAT(transport_.published(), IsEmpty());
  EXPECT_THAT(reports_, SizeIs(2));
  EXPECT_THAT(reports_, Each(AllOf(Is(message::CommandStatus::kError),
                                   Field(&message::Report::error, ErrorKind::kLedger),
                                   Says("not sent: t/0 is held by somebody else"),
                                   Field(&message::Report::header_id, std::nullopt))));
  EXPECT_EQ(left_, 0);
}

TEST_F(SendAtQos0, WaitsForTheLockNoLongerThanItMay) {
  options_.lock_timeout = 250ms;
  const auto before = std::chrono::steady_clock::now();
  EXPECT_TRUE(Send(CommandsFor(1)));
  EXPECT_GE(ledger_.last_deadline(), before + 250ms);
  EXPECT_LE(ledger_.last_deadline(), std::chrono::steady_clock::now() + 250ms);
}

TEST_F(SendAtQos0, SendsNothingWhenTheLedgerRefuses) {
  ledger_.reserve_error = Error{ErrorKind::kLedger, "disk full"};
  EXPECT_TRUE(Send(CommandsFor(2)));
  EXPECT_THAT(journal_.entries(), ElementsAre("lock t/0 t/1", "unlock"));
  EXPECT_THAT(reports_, SizeIs(2));
  EXPECT_THAT(reports_, Each(AllOf(Is(message::CommandStatus::kError),
                                   Field(&message::Report::error, ErrorKind::kLedger),
                                   Says("not sent: disk full"))));
}

TEST_F(SendAtQos0, SendsNothingUnderAHeaderIdThatTheLedgerRefuses) {
  ledger_.reserve_error = Error{ErrorKind::kUsage, "header id 3 is not above the last one, 9"};
  EXPECT_TRUE(Send(CommandsFor(1)));
  EXPECT_THAT(journal_.entries(), ElementsAre("lock t/0", "unlock"));
  EXPECT_THAT(reports_, ElementsAre(AllOf(Is(message::CommandStatus::kError),
                                          Field(&message::Report::error, ErrorKind::kUsage),
                                          Says("not sent: header id 3 is not above"))));
}

TEST_F(SendAtQos0, UsesNoHeaderIdWhenTheConnectionWentWhileItWaited) {
  transport_.ready_error = Error{ErrorKind::kBroker, "broker: gone"};
  EXPECT_TRUE(Send(CommandsFor(2)));
  EXPECT_THAT(journal_.entries(), ElementsAre("lock t/0 t/1", "unlock", "record"));
  EXPECT_THAT(reports_, Each(AllOf(Is(message::CommandStatus::kError),
                                   Field(&message::Report::error, ErrorKind::kBroker),
                                   Says("not sent: broker: gone"))));
  EXPECT_THAT(reports_, SizeIs(2));
}

TEST_F(SendAtQos0, UsesNoHeaderIdForWhatTheBrokerDoesNotTake) {
  auto commands = CommandsFor(1);
  commands[0].payload.rest = std::string(100, '>');
  transport_.largest = 100;
  EXPECT_TRUE(Send(commands));
  EXPECT_THAT(journal_.entries(), IsEmpty());
  EXPECT_THAT(reports_, ElementsAre(Says("not sent: too large")));
}

TEST_F(SendAtQos0, SendsNothingMoreOnceTheLedgerHasEndedTheLock) {
  ledger_.held_so_often = 2;
  ASSERT_TRUE(Send(CommandsFor(4)));
  EXPECT_THAT(transport_.published(), SizeIs(2));
  EXPECT_THAT(
      reports_,
      ElementsAre(Is(message::CommandStatus::kSent), Is(message::CommandStatus::kSent),
                  AllOf(Is(message::CommandStatus::kError), Says("not sent: the ledger ended")),
                  Is(message::CommandStatus::kError)));
  EXPECT_EQ(reports_.back().error, ErrorKind::kLedger);
  EXPECT_THAT(Statuses(), ElementsAre("SENT", "SENT", "ERROR", "ERROR"));
}

TEST_F(SendAtQos0, StopsAtALostConnection) {
  transport_.publish_fails_at = 1;
  EXPECT_TRUE(Send(CommandsFor(3)));
  EXPECT_THAT(reports_, ElementsAre(Is(message::CommandStatus::kSent),
                                    Says("perhaps sent: broker: connection lost"),
                                    Says("not sent: broker: connection lost")));
  EXPECT_EQ(reports_[1].error, ErrorKind::kBroker);
  EXPECT_EQ(reports_[2].error, ErrorKind::kBroker);
  EXPECT_THAT(Statuses(), ElementsAre("SENT", "ERROR", "ERROR"));
  EXPECT_THAT(ledger_.rows()[2].detail, HasSubstr("not sent"));
  EXPECT_EQ(left_, 1);
}

TEST_F(SendAtQos0, OnlyReturnsTroubleWithRecordingTheOutcome) {
  ledger_.record_error = Error{ErrorKind::kLedger, "disk full"};
  const Status ended = Send(CommandsFor(2));
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().message, "disk full");
  EXPECT_THAT(reports_,
              ElementsAre(Is(message::CommandStatus::kSent), Is(message::CommandStatus::kSent)));
  EXPECT_THAT(reports_, Each(Field(&message::Report::error, std::nullopt)));
}

TEST_F(SendAtQos1, HoldsTheLockUntilTheAcknowledgement) {
  EXPECT_TRUE(Send({CommandFor("a"), CommandFor("b")}, mqtt::Qos::kAtLeastOnce));
  EXPECT_THAT(journal_.entries(),
              ElementsAre("lock t/a t/b", "reserve 2", "publish t/a", "publish t/b", "await",
                          "unlock", "record PUBLISHED PUBLISHED"));
  EXPECT_THAT(reports_, Each(Is(message::CommandStatus::kPublished)));
  EXPECT_THAT(transport_.published(), Each(Field(&mqtt::Message::qos, mqtt::Qos::kAtLeastOnce)));
}

TEST_F(SendAtQos1, WaitsAtQos2Too) {
  EXPECT_TRUE(Send(CommandsFor(1), mqtt::Qos::kExactlyOnce));
  EXPECT_THAT(journal_.entries(), Contains("await"));
  EXPECT_THAT(reports_, ElementsAre(Is(message::CommandStatus::kPublished)));
}

TEST_F(SendAtQos1, NamesTheMessagesThatTheBrokerDidNotAcknowledge) {
  options_.acknowledge_timeout = 1500ms;
  transport_.acknowledge = [](int token) {
    return token == 2 ? std::nullopt : std::optional(mqtt::Acknowledgement{.token = token});
  };
  EXPECT_TRUE(Send(CommandsFor(3), mqtt::Qos::kAtLeastOnce));
  EXPECT_THAT(reports_, ElementsAre(Is(message::CommandStatus::kPublished),
                                    Is(message::CommandStatus::kError),
                                    Is(message::CommandStatus::kPublished)));
  EXPECT_EQ(reports_[1].error, ErrorKind::kBroker);
  EXPECT_THAT(reports_[1].message, AllOf(HasSubstr("not acknowledged"),
                                         HasSubstr("mqtt://broker:1883"), HasSubstr("1.5 s")));
  EXPECT_THAT(Statuses(), ElementsAre("PUBLISHED", "ERROR", "PUBLISHED"));
}

TEST_F(SendAtQos1, NamesTheMessageThatTheBrokerRefused) {
  transport_.acknowledge = [](int token) {
    const bool refused = token == 1;
    return mqtt::Acknowledgement{.token = token,
                                 .reason_code = refused ? 0x87 : 0x10,
                                 .reason = refused ? "not authorized (0x87)" : ""};
  };
  EXPECT_TRUE(Send(CommandsFor(2), mqtt::Qos::kAtLeastOnce));
  EXPECT_EQ(reports_[0].status, message::CommandStatus::kError);
  EXPECT_EQ(reports_[0].error, ErrorKind::kBroker);
  EXPECT_THAT(reports_[0].message,
              AllOf(HasSubstr("mqtt://broker:1883"), HasSubstr("not authorized (0x87)")));
  EXPECT_EQ(reports_[1].status, message::CommandStatus::kPublished)
      << "nobody subscribed (0x10) is a success";
}

TEST_F(SendAtQos1, SaysThatSentMessagesMayHaveArrivedWhenTheConnectionIsLost) {
  transport_.await_error = Error{ErrorKind::kBroker, "broker: connection lost"};
  EXPECT_TRUE(Send(CommandsFor(2), mqtt::Qos::kAtLeastOnce));
  EXPECT_THAT(reports_, Each(AllOf(Is(message::CommandStatus::kError),
                                   Field(&message::Report::error, ErrorKind::kBroker),
                                   Says("sent, but not acknowledged: broker: connection lost"))));
  EXPECT_EQ(left_, 2);
}

TEST_F(SendAtQos1, StillTakesAcknowledgementsOfWhatWentBeforeALostConnection) {
  transport_.publish_fails_at = 1;
  EXPECT_TRUE(Send(CommandsFor(3), mqtt::Qos::kAtLeastOnce));
  EXPECT_THAT(reports_, ElementsAre(Is(message::CommandStatus::kPublished), Says("perhaps sent: "),
                                    Says("not sent: ")));
}

TEST_F(SendAtQos1, PassesOverAcknowledgementsOfOthers) {
  options_.acknowledge_timeout = std::chrono::milliseconds(50);
  transport_.acknowledge = [](int token) { return mqtt::Acknowledgement{.token = token + 100}; };
  EXPECT_TRUE(Send(CommandsFor(1), mqtt::Qos::kAtLeastOnce));
  EXPECT_THAT(reports_, ElementsAre(Is(message::CommandStatus::kError)));
}

TEST_F(SendInBatches, TakesTheLockAnewForEach) {
  options_.batch = 2;
  EXPECT_TRUE(Send(CommandsFor(5)));
  EXPECT_THAT(journal_.entries(),
              ElementsAre("lock t/0 t/1", "reserve 2", "publish t/0", "publish t/1", "unlock",
                          "record SENT SENT", "lock t/2 t/3", "reserve 2", "publish t/2",
                          "publish t/3", "unlock", "record SENT SENT", "lock t/4", "reserve 1",
                          "publish t/4", "unlock", "record SENT"));
}

TEST_F(SendInBatches, AreOf500) {
  EXPECT_TRUE(Send(CommandsFor(1001)));
  EXPECT_THAT(journal_.entries(), AllOf(Contains("reserve 500").Times(2), Contains("reserve 1")));
  EXPECT_THAT(reports_, SizeIs(1001));
}

TEST_F(SendInBatches, ReportsInTheOrderOfTheCommands) {
  options_.batch = 2;
  EXPECT_TRUE(Send(CommandsFor(5), mqtt::Qos::kAtLeastOnce));
  std::string targets;
  for (const message::Report& report : reports_) targets += report.target;
  EXPECT_EQ(targets, "01234");
}

TEST_F(SendInBatches, NeverPublishesWhatIsNotReserved) {
  options_.batch = 3;
  EXPECT_TRUE(Send(CommandsFor(10), mqtt::Qos::kAtLeastOnce));
  int reserved = 0;
  for (const std::string& entry : journal_.entries()) {
    if (entry.starts_with("reserve ")) reserved += std::stoi(entry.substr(8));
    if (entry.starts_with("publish ")) --reserved;
    EXPECT_GE(reserved, 0) << entry;
  }
  EXPECT_EQ(reserved, 0);
}

TEST_F(SendInBatches, ReservesNothingMoreOnceTheConnectionIsLost) {
  options_.batch = 2;
  transport_.publish_fails_at = 1;
  EXPECT_TRUE(Send(CommandsFor(5)));
  EXPECT_THAT(ledger_.rows(), SizeIs(2));
  EXPECT_THAT(reports_, ElementsAre(Is(message::CommandStatus::kSent), Says("perhaps sent: "),
                                    Says("not sent: "), Says("not sent: "), Says("not sent: ")));
  EXPECT_EQ(reports_[4].header_id, std::nullopt);
}

TEST_F(SendInBatches, ReservesNothingMoreOnceTheBrokerIsSilent) {
  options_.batch = 1;
  options_.acknowledge_timeout = std::chrono::milliseconds(50);
  transport_.acknowledge = [](int) { return std::nullopt; };
  constexpr std::size_t kSent = PublishPipeline::kMostUnderWay + 1;
  EXPECT_TRUE(Send(CommandsFor(kSent + 2), mqtt::Qos::kAtLeastOnce));
  EXPECT_EQ(left_, static_cast<int>(kSent));
  ASSERT_THAT(reports_, SizeIs(kSent + 2));
  EXPECT_THAT(std::span(reports_).first(kSent), Each(Says("sent, but not acknowledged: ")));
  EXPECT_THAT(std::span(reports_).last(2), Each(Says("not sent: ")));
}

TEST_F(SendInBatches, GoesOnAfterAMessageThatTheBrokerRefused) {
  options_.batch = 1;
  transport_.acknowledge = [](int token) {
    return mqtt::Acknowledgement{.token = token, .reason_code = token == 1 ? 0x87 : 0};
  };
  EXPECT_TRUE(Send(CommandsFor(2), mqtt::Qos::kAtLeastOnce));
  EXPECT_THAT(reports_, ElementsAre(Is(message::CommandStatus::kError),
                                    Is(message::CommandStatus::kPublished)));
}

TEST_F(SendInBatches, KeepsWhatWasSentWhenTheLedgerRefusesLater) {
  options_.batch = 2;
  ledger_.reserve_error = Error{ErrorKind::kLedger, "disk full"};
  ledger_.reserve_errors_begin_at = 1;
  EXPECT_TRUE(Send(CommandsFor(4)));
  EXPECT_THAT(reports_,
              ElementsAre(Is(message::CommandStatus::kSent), Is(message::CommandStatus::kSent),
                          Says("not sent: disk full"), Says("not sent: disk full")));
  EXPECT_THAT(transport_.published(), SizeIs(2));
}

TEST_F(SendInBatches, GoesOnWhenAnOutcomeCannotBeRecorded) {
  options_.batch = 1;
  ledger_.record_error = Error{ErrorKind::kLedger, "disk full"};
  EXPECT_FALSE(Send(CommandsFor(3)));
  EXPECT_THAT(reports_, SizeIs(3));
  EXPECT_THAT(reports_, Each(Is(message::CommandStatus::kSent)));
}

TEST_F(SendInBatches, StampsEachWithItsOwnTime) {
  options_.batch = 1;
  options_.now = [now = base::WallTime(1767323045678ms)]() mutable { return now += 1s; };
  EXPECT_TRUE(Send(CommandsFor(2)));
  EXPECT_THAT(transport_.published()[0].payload, HasSubstr("03:04:06.678Z"));
  EXPECT_THAT(transport_.published()[1].payload, HasSubstr("03:04:07.678Z"));
}

TEST_F(Sending, WaitsForTheEndOfEach) {
  options_.batch = 2;
  auto commands = CommandsFor(3);
  for (auto& command : commands) {
    command.tracker = std::make_shared<testing::FakeTracker>("state/" + command.target);
  }
  EXPECT_TRUE(Send(commands));
  EXPECT_THAT(reports_, SizeIs(3));
  EXPECT_THAT(reports_, Each(Is(message::CommandStatus::kFinished)));
  EXPECT_THAT(transport_.subscribed(), ElementsAre("state/0", "state/1", "state/2"));
}

TEST_F(Sending, SendsNoFasterThanTheRate) {
  rate_ = RateLimiter(200);
  const auto before = std::chrono::steady_clock::now();
  EXPECT_TRUE(Send(CommandsFor(40)));
  EXPECT_GE(std::chrono::steady_clock::now() - before, std::chrono::milliseconds(100));
  EXPECT_THAT(reports_, SizeIs(40));
}

TEST_F(Sending, StopsWaitingAndSaysWhoIsOpenWhenStopped) {
  const ReportSink report = [&](const message::Report& done) { reports_.push_back(done); };
  CommandSession session(connection_, ledger_, options_, WaitOptions{.resend = 0},
                         {.report = report, .sent = {}, .reconnect = {}});
  auto commands = CommandsFor(2);
  for (message::Command& command : commands) {
    command.tracker = std::make_shared<testing::FakeTracker>("state/" + command.target,
                                                             testing::FakeTracker::Ends::kNever);
  }
  CommandList list(commands, report);
  Waiting seen;
  EXPECT_TRUE(SendAll(list, session,
                      {.batch = 1,
                       .rate = RateLimiter(0.001),
                       .waits = [&](const CommandSession& open) { seen = open.DescribeWaiting(); },
                       .is_stopped = [&] { return seen.commands == 1; }}));
  EXPECT_EQ(seen.target, "0");
  EXPECT_FALSE(seen.seen);
  using enum message::CommandStatus;
  ASSERT_THAT(reports_, SizeIs(2));
  EXPECT_EQ(reports_[0].status, kError) << "it did not leave";
  EXPECT_EQ(reports_[1].status, kInterrupted);
  EXPECT_EQ(ledger_.rows().size(), 1U);
}

TEST_F(Sending, FailsWhenNothingCouldBeSubscribedTo) {
  const ReportSink report = [&](const message::Report& done) { reports_.push_back(done); };
  CommandSession session(connection_, ledger_, options_, WaitOptions{.resend = 0},
                         {.report = report, .sent = {}, .reconnect = {}});
  auto commands = CommandsFor(2);
  commands[1].tracker = std::make_shared<testing::FakeTracker>("state/1");
  transport_.forbidden = "state/1";
  CommandList list(commands, report);
  const Status sent = SendAll(list, session, {.batch = 2});
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().kind, ErrorKind::kBroker);
  EXPECT_THAT(journal_.entries(), IsEmpty());
  EXPECT_THAT(reports_, IsEmpty());
}

TEST(ReportOn, CarriesWhatTheCommandTells) {
  message::Command command = CommandFor("a");
  command.version_assumed = true;
  const message::Report report = message::ReportOn(command);
  EXPECT_EQ(report.target, "a");
  EXPECT_EQ(report.protocol, "vda5050");
  EXPECT_TRUE(report.version_assumed);
  EXPECT_EQ(report.status, message::CommandStatus::kError) << "until somebody knows better";
  EXPECT_THAT(report.payload, Not(HasSubstr("<")));
}

}  // namespace
}  // namespace fleetpub::delivery
