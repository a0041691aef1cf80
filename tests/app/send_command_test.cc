#include "app/send_command.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "support/fake_environment.h"
#include "support/fake_observer.h"
#include "support/fake_tracker.h"
#include "support/report_matchers.h"

namespace fleetpub::app {
namespace {

using message::CommandStatus;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using testing::Is;
using ::testing::IsEmpty;
using testing::Says;
using ::testing::SizeIs;
using vda5050::RobotAddress;

class Action final : public RobotMessage {
 public:
  explicit Action(std::string type, std::string blocking_type = "") {
    action_.type = std::move(type);
    action_.id = "3f2c8a2e-7b51-4c4e-9d0a-5a4f0f6d1c22";
    action_.blocking_type = std::move(blocking_type);
  }
  [[nodiscard]] Result<message::Command> Build(
      const RobotAddress& robot, const vda5050::Dialect& dialect,
      std::optional<std::uint32_t> header_id) const override {
    return vda5050::BuildInstantActions(robot, dialect, {&action_, 1}, header_id);
  }
  [[nodiscard]] vda5050::PreflightFindings Check(const RobotAddress& robot,
                                                 const vda5050::Dialect& dialect,
                                                 const vda5050::KnownRobot& known) const override {
    return vda5050::CheckRobot(robot, dialect, {&action_, 1}, known, 100);
  }
  [[nodiscard]] Result<std::unique_ptr<message::ResponseTracker>> Track(
      const RobotAddress& /*robot*/, const vda5050::Dialect& /*dialect*/,
      vda5050::WaitFor /*wait_for*/) const override {
    return std::make_unique<testing::FakeTracker>("state");
  }
  [[nodiscard]] bool IsOnlyStartPause() const override { return action_.type == "startPause"; }
  [[nodiscard]] bool NeedsFactsheet() const override {
    return vda5050::NeedsFactsheet({&action_, 1});
  }
  [[nodiscard]] bool IsAlikeForAll() const override { return true; }

 private:
  vda5050::InstantAction action_;
};

class SendingCommands : public ::testing::Test {
 protected:
  SendingCommands() {
    waiting_.discover.quiet = std::chrono::milliseconds(50);
    world_.on_connect = [this](testing::FakeTransport& broker) { broker.retained = retained_; };
  }

  void IsThere(const std::string& serial, const std::string& state = "ONLINE") {
    Leaves("vda5050/v3", "3.0.0", serial, state);
  }

  void Leaves(std::string_view place, std::string_view version, const std::string& serial,
              const std::string& state) {
    retained_[fmt::format("{}/KIT/{}/connection", place, serial)] =
        fmt::format(R"({{"headerId":1,"timestamp":"2026-01-02T03:04:05.678Z","version":"{}",)"
                    R"("manufacturer":"KIT","serialNumber":"{}","connectionState":"{}"}})",
                    version, serial, state);
  }

  Status Send(std::vector<std::string> words, std::vector<std::string> except = {},
              const std::vector<std::string>& where = {}) {
    TargetRequest asked;
    asked.words = std::move(words);
    asked.except = std::move(except);
    asked.expect = expect_;
    for (const std::string& text : where) {
      asked.where.push_back(vda5050::ParseCondition(text).value());
    }
    auto targets = ResolveTargets(std::move(asked), world_.config, observer_);
    if (!targets) return Fail(targets.error());
    const CommandRequest request{
        .targets = *std::move(targets),
        .resolver =
            DialectResolver::Make({.version = version_, .topic_template = template_}, world_.config)
                .value(),
        .needs_consent = needs_consent_,
        .header_id = {},
        .make_message = [this] { return std::make_unique<Action>(type_, blocking_type_); },
        .waiting = waiting_};
    return SendCommand(request, settings_, world_.Get(), observer_);
  }

  [[nodiscard]] std::vector<std::string> Published() const {
    std::vector<std::string> topics;
    for (const std::string& entry : world_.journal.entries()) {
      if (entry.starts_with("publish ")) topics.push_back(entry.substr(8));
    }
    return topics;
  }

  testing::FakeEnvironment world_;
  testing::FakeObserver observer_;
  std::map<std::string, std::string> retained_;
  std::string version_;
  std::string template_;
  std::string type_ = "startPause";
  std::string blocking_type_;
  std::optional<std::size_t> expect_;
  NeedsConsent needs_consent_ = NeedsConsent::kYes;
  SendSettings settings_;
  Waiting waiting_;
};

using SendingToNamedRobots = SendingCommands;
using SendingToFoundRobots = SendingCommands;

TEST_F(SendingToNamedRobots, SendsToEachInTheOrderOfTheWords) {
  IsThere("0001");
  IsThere("0002");
  EXPECT_TRUE(Send({"KIT/0002", "KIT/0001"}));
  EXPECT_THAT(Published(), ElementsAre("vda5050/v3/KIT/0002/instantActions",
                                       "vda5050/v3/KIT/0001/instantActions"));
  EXPECT_THAT(observer_.reports, Each(Is(CommandStatus::kSent)));
  EXPECT_THAT(observer_.chosen, ElementsAre("KIT/0002", "KIT/0001"));
  EXPECT_THAT(observer_.asked_for, IsEmpty()) << "each was named outright";
  EXPECT_EQ(observer_.total, 2U);
  EXPECT_EQ(observer_.sent, 2U);
  EXPECT_EQ(world_.connections, 1);
}

TEST_F(SendingToNamedRobots, WaitsForTheirEnds) {
  IsThere("0001");
  waiting_.wait_for = vda5050::WaitFor::kFinished;
  EXPECT_TRUE(Send({"KIT/0001"}));
  EXPECT_THAT(observer_.reports, ElementsAre(Is(CommandStatus::kFinished)));
}

TEST_F(SendingToNamedRobots, RefusesWhomTheCheckDoesNotFind) {
  type_ = "stopPause";
  IsThere("0001");
  EXPECT_TRUE(Send({"KIT/0001", "KIT/0003"}));
  EXPECT_THAT(Published(), ElementsAre("vda5050/v3/KIT/0001/instantActions"));
  ASSERT_THAT(observer_.reports, SizeIs(2));
  EXPECT_THAT(observer_.reports,
              Contains(AllOf(Is(CommandStatus::kRefused),
                             Field(&message::Report::target, "KIT/0003"), Says("did you mean"))));
}

TEST_F(SendingToNamedRobots, KeepsRobotsApartThatATemplateDoesNot) {
  template_ = "amr/{major}/{serial}/{topic}";
  const Status both = Send({"KIT/0001", "ACME/0001"});
  ASSERT_FALSE(both);
  EXPECT_THAT(both.error().message, AllOf(HasSubstr("KIT/0001"), HasSubstr("ACME/0001")));
  EXPECT_TRUE(Send({"KIT/0001", "ACME/0002"}));
  EXPECT_THAT(Published(), ElementsAre("amr/v3/0001/instantActions", "amr/v3/0002/instantActions"));
}

TEST_F(SendingToNamedRobots, WaitsForNothingWhereOnlyTheTopicOfCommandsIsKnown) {
  template_ = "fts/{manufacturer}/{serial}/instantAction";
  EXPECT_TRUE(Send({"KIT/0001"}));
  EXPECT_THAT(Published(), ElementsAre("fts/KIT/0001/instantAction"));
  waiting_.wait_for = vda5050::WaitFor::kFinished;
  const Status sent = Send({"KIT/0001"});
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().kind, ErrorKind::kUsage);
}

TEST_F(SendingToNamedRobots, ConnectsForNothingThatIsInvalid) {
  blocking_type_ = "SOMETIMES";
  const Status sent = Send({"KIT/0001"});
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().kind, ErrorKind::kInvalid);
  EXPECT_THAT(observer_.nothing_sent, ElementsAre(Is(CommandStatus::kInvalid)));
  EXPECT_EQ(world_.connections, 0);
}

TEST_F(SendingToNamedRobots, SendsNothingWithoutAConnection) {
  world_.connect_error = Error{ErrorKind::kBroker, "broker: refused"};
  const Status sent = Send({"KIT/0001"});
  ASSERT_FALSE(sent);
  EXPECT_THAT(sent.error().message, HasSubstr("nothing was sent: broker: refused"));
  EXPECT_THAT(observer_.nothing_sent, ElementsAre(Is(CommandStatus::kError)));
}

TEST_F(SendingToNamedRobots, SaysOfEachWhatALostConnectionMeans) {
  world_.on_connect = [](testing::FakeTransport& broker) { broker.publish_fails_at = 1; };
  version_ = "3.0.0";
  waiting_.check = false;
  EXPECT_TRUE(Send({"KIT/0001", "KIT/0002", "KIT/0003"}));
  EXPECT_THAT(observer_.reports,
              ElementsAre(Is(CommandStatus::kSent), Says("perhaps sent: "), Says("not sent: ")));
  EXPECT_EQ(world_.connections, 1) << "nobody is waited for";
  EXPECT_THAT(observer_.warnings, IsEmpty());
}

TEST_F(SendingToNamedRobots, SpeaksToEachInItsOwnVersionAtItsOwnTopics) {
  Leaves("uagv/v2", "2.1.0", "0001", "ONLINE");
  Leaves("own/v1", "1.1.0", "0002", "ONLINE");
  for (const bool check : {true, false}) {
    waiting_.check = check;
    EXPECT_TRUE(Send({"KIT/0001", "KIT/0002"}));
  }
  const std::vector<std::string> once = {"uagv/v2/KIT/0001/instantActions",
                                         "own/v1/KIT/0002/instantActions"};
  EXPECT_THAT(Published(), ElementsAre(once[0], once[1], once[0], once[1]));
  EXPECT_THAT(observer_.reports, Each(Field(&message::Report::version_assumed, false)));
}

TEST_F(SendingToNamedRobots, AsksNothingWhereTheVersionIsStatedAndNoCheckIsWanted) {
  Leaves("uagv/v2", "2.1.0", "0001", "ONLINE");
  version_ = "3.0.0";
  waiting_.check = false;
  EXPECT_TRUE(Send({"KIT/0001"}));
  EXPECT_THAT(Published(), ElementsAre("vda5050/v3/KIT/0001/instantActions"));
  EXPECT_THAT(observer_.reports, ElementsAre(Is(CommandStatus::kSent)));
  waiting_.check = true;
  EXPECT_TRUE(Send({"KIT/0001"}));
  EXPECT_THAT(observer_.reports, Contains(Is(CommandStatus::kRefused))) << "it speaks 2.1.0";
}

TEST_F(SendingToNamedRobots, StopsEvenARobotThatNobodyKnows) {
  for (const bool check : {true, false}) {
    waiting_.check = check;
    EXPECT_TRUE(Send({"KIT/0007"}));
  }
  EXPECT_THAT(observer_.reports, Each(Is(CommandStatus::kSent)));
  EXPECT_THAT(observer_.reports, Each(Field(&message::Report::version_assumed, true)));
  EXPECT_THAT(observer_.warnings, Each(HasSubstr("KIT/0007 is unknown to mqtt://broker")));
  EXPECT_THAT(observer_.warnings, SizeIs(2));
}

TEST_F(SendingToNamedRobots, StopsARobotEvenWhereTheLoginMayNotLook) {
  world_.on_connect = [](testing::FakeTransport& broker) {
    broker.forbidden = "+/+/KIT/0001/connection";
  };
  EXPECT_TRUE(Send({"KIT/0001"}));
  EXPECT_THAT(observer_.reports, ElementsAre(Is(CommandStatus::kSent)));
  EXPECT_THAT(observer_.warnings, Contains(HasSubstr("refuses")));
  type_ = "stopPause";
  EXPECT_FALSE(Send({"KIT/0001"}));
  EXPECT_THAT(Published(), SizeIs(1));
}

TEST_F(SendingToNamedRobots, SendsNothingElseToARobotThatNobodyKnows) {
  type_ = "cancelOrder";
  world_.config.profile = "north";
  IsThere("0008", "OFFLINE");
  for (const bool check : {true, false}) {
    waiting_.check = check;
    EXPECT_TRUE(Send({"KIT/0007"}));
  }
  EXPECT_THAT(observer_.reports, SizeIs(2));
  EXPECT_THAT(observer_.reports, Each(AllOf(Is(CommandStatus::kRefused), Says("mqtt://broker"),
                                            Says("north"), ::testing::Not(Says("did you mean")))))
      << "who is away is no proposal";
  EXPECT_THAT(Published(), IsEmpty());
}

TEST_F(SendingToNamedRobots, ShowsTheMessageThatWouldBeSentInADryRun) {
  Leaves("uagv/v2", "2.1.0", "0001", "ONLINE");
  settings_.dry_run = true;
  world_.names_broker = true;
  EXPECT_TRUE(Send({"KIT/0001"}));
  ASSERT_THAT(observer_.reports, ElementsAre(Is(CommandStatus::kDryRun)));
  EXPECT_EQ(observer_.reports.front().version, "2.1.0");
  EXPECT_EQ(world_.connections, 1);
  EXPECT_THAT(Published(), IsEmpty());
}

TEST_F(SendingToNamedRobots, AsksNobodyInADryRunWithoutABroker) {
  settings_.dry_run = true;
  EXPECT_TRUE(Send({"KIT/0001"}));
  settings_.offline = true;
  world_.names_broker = true;
  EXPECT_TRUE(Send({"KIT/0001"}));
  EXPECT_THAT(observer_.reports, SizeIs(2));
  EXPECT_THAT(observer_.reports, Each(Is(CommandStatus::kDryRun)));
  EXPECT_THAT(observer_.reports.front().payload, HasSubstr("startPause"));
  EXPECT_EQ(world_.connections, 0);
}

TEST_F(SendingToFoundRobots, SendsToWhomThePatternFinds) {
  IsThere("0001");
  IsThere("0002");
  EXPECT_TRUE(Send({"KIT/*"}));
  EXPECT_THAT(observer_.asked_for,
              ElementsAre(RobotAddress{"KIT", "0001"}, RobotAddress{"KIT", "0002"}));
  EXPECT_EQ(observer_.offline, 0U);
  EXPECT_THAT(observer_.reports, SizeIs(2));
  EXPECT_THAT(observer_.reports, Each(Is(CommandStatus::kSent)));
  EXPECT_EQ(world_.connections, 1);
}

TEST_F(SendingToFoundRobots, SaysHowManyAreOfflineWhenItAsks) {
  for (const std::string serial : {"0001", "0002"}) IsThere(serial);
  for (const std::string serial : {"0003", "0004", "0005"}) IsThere(serial, "OFFLINE");
  EXPECT_TRUE(Send({"KIT/*"}));
  EXPECT_THAT(observer_.asked_for, SizeIs(5));
  EXPECT_EQ(observer_.offline, 3U);
}

TEST_F(SendingToFoundRobots, SaysWhenTheBrokerKeepsNothing) {
  world_.on_connect = [](testing::FakeTransport& broker) { broker.keeps_nothing = true; };
  const Status found = Send({"KIT/*"});
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().message, HasSubstr("retained"));
  type_ = "cancelOrder";
  EXPECT_TRUE(Send({"KIT/0001"}));
  EXPECT_THAT(observer_.reports, ElementsAre(Says("retained")));
}

// As RabbitMQ.
TEST_F(SendingToFoundRobots, AsksForConfiguredOnesByNameWhereWildcardsBringNothing) {
  IsThere("0001");
  IsThere("0002");
  IsThere("0003");
  world_.on_connect = [this](testing::FakeTransport& broker) { broker.exact_retained = retained_; };
  for (const char* serial : {"0001", "0003"}) world_.config.robots[{"KIT", serial}];
  settings_.agreed = true;
  ASSERT_TRUE(Send({"KIT/*"}));
  EXPECT_THAT(Published(), ElementsAre("vda5050/v3/KIT/0001/instantActions",
                                       "vda5050/v3/KIT/0003/instantActions"));
  EXPECT_THAT(observer_.warnings, ElementsAre(HasSubstr("wildcards")));
}

TEST_F(SendingToFoundRobots, SendsNothingUnlessJustSoManyAreMeant) {
  for (const char* serial : {"0001", "0002", "0003"}) IsThere(serial);
  needs_consent_ = NeedsConsent::kNo;
  for (const std::size_t expected : {2U, 4U}) {
    expect_ = expected;
    const auto sent = Send({"KIT/*"});
    ASSERT_FALSE(sent);
    EXPECT_EQ(sent.error().kind, ErrorKind::kPreflight);
  }
  EXPECT_THAT(Published(), IsEmpty());
  expect_ = 2;
  EXPECT_TRUE(Send({"KIT/*"}, {"KIT/0003"}));
  EXPECT_THAT(Published(), SizeIs(2));
}

TEST_F(SendingToFoundRobots, SendsNothingWithoutConsent) {
  IsThere("0001");
  IsThere("0002");
  observer_.consent = Fail(ErrorKind::kUsage, "not confirmed");
  const Status sent = Send({"KIT/*"});
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().message, "not confirmed");
  EXPECT_THAT(Published(), IsEmpty());
  EXPECT_EQ(observer_.total, 0U);
}

TEST_F(SendingToNamedRobots, MakesNoLedgerForThoseOfASetBeforeSomebodyAgrees) {
  IsThere("0001");
  IsThere("0002");
  world_.config.groups["hall"] = {};
  world_.config.group_robots["hall"] = {vda5050::RobotAddress{"KIT", "0001"},
                                        vda5050::RobotAddress{"KIT", "0002"}};
  observer_.consent = Fail(ErrorKind::kUsage, "not confirmed");
  ASSERT_FALSE(Send({"@hall"}));
  EXPECT_EQ(world_.ledgers, 0);
  observer_.consent = {};
  ASSERT_TRUE(Send({"@hall"}));
  EXPECT_EQ(world_.ledgers, 1);
  ASSERT_TRUE(Send({"KIT/0001"}));
  EXPECT_EQ(world_.ledgers, 2);
}

TEST_F(SendingToFoundRobots, AsksForNoConsentWhereNoneIsNeeded) {
  IsThere("0001");
  IsThere("0002");
  needs_consent_ = NeedsConsent::kNo;
  EXPECT_TRUE(Send({"KIT/*"}));
  EXPECT_THAT(observer_.asked_for, IsEmpty());
  EXPECT_THAT(Published(), SizeIs(2));
}

TEST_F(SendingToFoundRobots, SparesTheExcluded) {
  IsThere("0001");
  IsThere("0002");
  EXPECT_TRUE(Send({"KIT/*"}, {"KIT/0002"}));
  EXPECT_THAT(Published(), ElementsAre("vda5050/v3/KIT/0001/instantActions"));
}

TEST_F(SendingToFoundRobots, SendsNothingWhenAnExclusionSparesNobody) {
  IsThere("0001");
  const Status sent = Send({"KIT/*"}, {"KIT/0009"});
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().kind, ErrorKind::kPreflight);
  EXPECT_THAT(Published(), IsEmpty());
}

TEST_F(SendingToFoundRobots, OnlyWarnsOfSuchAnExclusionFromWhatIsNeverWrong) {
  IsThere("0001");
  needs_consent_ = NeedsConsent::kNo;
  EXPECT_TRUE(Send({"KIT/*"}, {"KIT/0009"}));
  EXPECT_THAT(observer_.warnings, Contains(HasSubstr("KIT/0009")));
  EXPECT_THAT(Published(), SizeIs(1));
}

TEST_F(SendingToFoundRobots, ChoosesThoseThatSatisfyTheCondition) {
  IsThere("0001");
  IsThere("0002", "OFFLINE");
  EXPECT_TRUE(Send({"KIT/*"}, {}, {"connectionState=ONLINE"}));
  EXPECT_THAT(observer_.chosen, ElementsAre("KIT/0001"));
}

TEST_F(SendingToFoundRobots, SaysWhoIsThereWhenNobodyMatches) {
  IsThere("0001");
  const Status sent = Send({"ACME/*"});
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().kind, ErrorKind::kPreflight);
  EXPECT_THAT(sent.error().message, HasSubstr("KIT/0001"));
}

TEST_F(SendingToFoundRobots, LooksEvenInADryRun) {
  IsThere("0001");
  settings_.dry_run = true;
  EXPECT_TRUE(Send({"KIT/*"}));
  EXPECT_THAT(observer_.reports, ElementsAre(Is(CommandStatus::kDryRun)));
  EXPECT_THAT(Published(), IsEmpty());
}

TEST_F(SendingCommands, SendsPreparedOnesOrNone) {
  vda5050::Dialect dialect;
  auto good = Action("startPause").Build({"KIT", "0001"}, dialect, {});
  auto bad = Action("startPause", "SOMETIMES").Build({"KIT", "0002"}, dialect, {});
  ASSERT_TRUE(good && bad);
  EXPECT_TRUE(SendMessages({*good}, settings_, {}, world_.Get(), observer_));
  EXPECT_THAT(Published(), SizeIs(1));
  EXPECT_FALSE(SendMessages({*good, *bad}, settings_, {}, world_.Get(), observer_));
  EXPECT_THAT(Published(), SizeIs(1));
  EXPECT_THAT(observer_.nothing_sent, SizeIs(2));
}

}  // namespace
}  // namespace fleetpub::app
