// What brokers other than mosquitto do otherwise: RabbitMQ's MQTT plugin, aedes and ejabberd. It
// stands in docs/brokers.md. What all of them do is in core_list_test.cc.
#include <gmock/gmock.h>

#include <memory>

#include "support/aedes.h"
#include "support/ejabberd.h"
#include "support/operator.h"
#include "support/rabbitmq.h"
#include "support/relay.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::SizeIs;

enum class Kind { kRabbitMq, kAedes };

class OtherBroker : public ::testing::TestWithParam<Kind> {
 protected:
  OtherBroker() {
    if (GetParam() == Kind::kAedes) aedes_ = std::make_unique<Aedes>();
    port_ = aedes_ ? aedes_->port() : RabbitMq::Shared().mqtt_port();
    operator_.UseBroker("mqtt://127.0.0.1:" + std::to_string(port_));
  }

  [[nodiscard]] bool IsRabbitMq() const { return GetParam() == Kind::kRabbitMq; }
  [[nodiscard]] Finished Fleetpub(std::vector<std::string> arguments) const {
    return operator_.Fleetpub(std::move(arguments));
  }
  /// `fleetpub simulate ARGUMENTS…`, online when this returns.
  [[nodiscard]] std::unique_ptr<Process> Robot(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "simulate");
    auto robot = std::make_unique<Process>(operator_.Prepare(std::move(arguments)));
    EXPECT_TRUE(robot->AwaitErrors("online")) << robot->Errors();
    return robot;
  }
  void ExpectEnd(const std::vector<std::string>& arguments, int exit_code,
                 const std::string& words) const {
    const Finished run = Fleetpub(arguments);
    EXPECT_EQ(run.exit_code, exit_code) << arguments[0] << run.output << run.errors;
    EXPECT_THAT(run.output + run.errors, HasSubstr(words));
  }

  std::unique_ptr<Aedes> aedes_;
  std::uint16_t port_ = 0;
  Operator operator_;
};

constexpr auto kNoSuffix = [](const auto& /*kind*/) { return std::string("Core"); };
INSTANTIATE_TEST_SUITE_P(RabbitMq, OtherBroker, ::testing::Values(Kind::kRabbitMq), kNoSuffix);
INSTANTIATE_TEST_SUITE_P(Aedes, OtherBroker, ::testing::Values(Kind::kAedes), kNoSuffix);

TEST_P(OtherBroker, CarriesWhatIsPublished) {
  const Subscriber subscriber(port_, "vda5050/v3/PUB/+/instantActions", 2);
  ExpectEnd(WithoutLook({"pause", "PUB/0001"}), 0, "SENT");
  ExpectEnd(WithoutLook({"pause", "PUB/0001", "-q", "1"}), 0, "PUBLISHED");
  ExpectEnd(WithoutLook({"resume", "PUB/0002", "-q", "2"}), 0, "PUBLISHED");
  const auto messages = subscriber.Await(3);
  ASSERT_THAT(messages, SizeIs(3));
  EXPECT_EQ(messages[0].topic, "vda5050/v3/PUB/0001/instantActions");
  EXPECT_EQ(Json(messages[1].payload)["headerId"].GetInt(), 1);
  EXPECT_EQ(messages[2].qos, IsRabbitMq() ? 1 : 2);
  for (const auto& message : messages) EXPECT_FALSE(message.retained);
}

TEST_P(OtherBroker, CarriesTheRobotsWord) {
  for (const char* version : {"1.1.0", "2.1.0", "3.0.0"}) {
    const std::string name = std::string("WORD/") + version[0];
    const auto robot = Robot({name, "--vda", version, "--reject", "startCharging"});
    ExpectEnd({"pause", name, "--wait", "--vda", version}, 0, "FINISHED");
    ExpectEnd({"resume", name, "--wait", "--vda", "auto", "-q", "1"}, 0, "FINISHED");
    ExpectEnd({"charge", name, "--wait", "--vda", version}, 5, "startCharging");
  }
  const auto silent = Robot({"WORD/0009", "--silent"});
  ExpectEnd({"pause", "WORD/0009", "--wait", "-W", "300ms"}, 6, "TIMEOUT");
  ExpectEnd({"resume", "WORD/0010", "--wait"}, 7, "unknown");
}

// Over a line on which the factsheet comes well behind the connection message, or before it.
TEST_P(OtherBroker, SendsNothingThatTheFactsheetForbids) {
  const auto robot = Robot({"FACTS/0001", "--vda", "2.1.0"});
  ExpectEnd({"action", "dance", "FACTS/0001"}, 7, "factsheet");
  const Relay slow(port_, std::chrono::milliseconds(5), 16);
  operator_.UseBroker(slow.Url());
  ExpectEnd({"action", "dance", "FACTS/0001"}, 7, "factsheet");
}

TEST_P(OtherBroker, ShowsEveryRobotOfTheFleet) {
  const auto often = Robot({"SHOW/0001", "--state-interval", "100ms"});
  const auto seldom = Robot({"SHOW/0002", "--state-interval", "700ms"});
  const Finished run = Fleetpub({"fleet", "SHOW/*", "--state-wait", "1500ms", "-o", "json"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(Lines(run.output), SizeIs(2)) << run.output;
  EXPECT_THAT(run.output, ::testing::Not(HasSubstr(R"("connectionState":null)")));
  EXPECT_EQ(run.errors.find("wildcards") != std::string::npos, IsRabbitMq());
}

// Robots that say nothing for 30 s.
TEST_P(OtherBroker, FindsByPatternsWhomItHasCommanded) {
  const auto robots = Robot({"SEEN/0001", "SEEN/0002"});
  if (IsRabbitMq()) ExpectEnd({"pause", "SEEN/*"}, 7, "RabbitMQ");
  ExpectEnd({"pause", "SEEN/0001", "SEEN/0002", "--wait"}, 0, "FINISHED");
  ExpectEnd({"resume", "SEEN/*", "--yes", "--wait"}, 0, "2 finished");
  ExpectEnd({"await", "SEEN/*", "connection", "connectionState=ONLINE", "-W", "60s"}, 0,
            "SEEN/0002");
  ExpectEnd({"action", "dance", "SEEN/*", "--yes"}, 7, "factsheet");
}

TEST_P(OtherBroker, MissesNoConnectionMessageThatIsThere) {
  const auto robot = Robot({"LIVE/0001", "--state-interval", "100ms"});
  ExpectEnd({"validate", "--live", "LIVE/*", "--strict", "--for", "1s", "-o", "json"}, 0,
            R"("withoutConnection":0,"topics":{"connection":{"messages":1,)");
}

// RabbitMQ sends a copy of a message for each subscription that matches (MQTT §3.3.5).
TEST_P(OtherBroker, FindsNoFaultInASoundRobot) {
  const auto robot = Robot({"SOUND/0001", "--state-interval", "200ms"});
  ExpectEnd({"conform", "SOUND/0001", "--level", "actions", "--only", "H,C,F01,I02", "--for", "1s"},
            0, "0 failed");
}

TEST_P(OtherBroker, LetsDoctorFindWhatIsRetained) {
  const auto robot = Robot({"DOC/0001", "--state-interval", "200ms"});
  ExpectEnd({"doctor", "DOC/*", "--for", "500ms"}, 0, "0 problems, 0 warnings");
}

TEST_P(OtherBroker, RefusesAWrongLogin) {
  const Aedes closed("ann", "s3cret");
  if (!IsRabbitMq()) operator_.UseBroker(closed.Url());
  for (const char* user : {"nobody", "guest", "ann"}) {
    Command command = operator_.Prepare({"pause", "LOGIN/0001", "-u", user});
    command.environment.emplace_back("FLEETPUB_PASSWORD", "wr0ng");
    const Finished run = testing::Run(command);
    EXPECT_EQ(run.exit_code, 4);
    EXPECT_THAT(run.errors,
                AllOf(HasSubstr("nothing was sent"), HasSubstr("bad user name or password"),
                      ::testing::Not(HasSubstr("wr0ng"))));
  }
}

TEST_P(OtherBroker, SpeaksNoMqtt5) {
  const Finished run = Fleetpub({"pause", "OLD/0001", "-V", "5"});
  EXPECT_EQ(run.exit_code, 4);
  EXPECT_THAT(run.errors, AllOf(HasSubstr("nothing was sent"), HasSubstr("-V")));
}

// It keeps `/` as `.` and turns every `.` into `/` on the way out.
TEST_P(OtherBroker, MayMistakeADotInASerialNumber) {
  const Subscriber subscriber(port_, "vda5050/v3/DOT/#", 0);
  ExpectEnd(WithoutLook({"pause", "DOT/00.1", "-q", "1"}), 0, "PUBLISHED");
  const auto messages = subscriber.Await(1);
  ASSERT_THAT(messages, SizeIs(1));
  EXPECT_EQ(messages[0].topic, IsRabbitMq() ? "vda5050/v3/DOT/00/1/instantActions"
                                            : "vda5050/v3/DOT/00.1/instantActions");
}

// aedes hangs up on who publishes what is not allowed.
TEST(Aedes, DeniesWhatIsForbidden) {
  const Aedes broker;
  Operator someone;
  someone.UseBroker(broker.Url());
  const Finished published =
      someone.Send({"pause", "KIT/0001", "--interface", "forbidden", "-q", "1"});
  EXPECT_EQ(published.exit_code, 4) << published.output;
  EXPECT_THAT(published.output, HasSubstr("Is something not allowed?"));
  const Finished subscribed =
      someone.Send({"pause", "KIT/0001", "--interface", "forbidden", "--wait"});
  EXPECT_EQ(subscribed.exit_code, 4) << subscribed.output;
  EXPECT_THAT(subscribed.errors,
              AllOf(HasSubstr("nothing was sent"), HasSubstr("may not read it")));
}

class EjabberdBroker : public ::testing::Test {
 protected:
  EjabberdBroker() { operator_.UseBroker(broker_.Url("mqtt")); }
  [[nodiscard]] Finished Send(std::vector<std::string> arguments) const {
    Command command = operator_.Prepare(WithoutLook(std::move(arguments)));
    command.environment.emplace_back("FLEETPUB_PASSWORD", "any");
    return testing::Run(std::move(command));
  }

  Ejabberd broker_{R"(    access_publish: {"closed/#": [deny: all]}
    access_subscribe: {"closed/#": [deny: all]}
)"};
  Operator operator_;
};

TEST_F(EjabberdBroker, WantsALoginOfEverybody) {
  for (const char* version : {"3.1.1", "5"}) {
    const Finished run = operator_.Send({"pause", "KIT/0001", "-u", "", "-V", version});
    EXPECT_EQ(run.exit_code, 4) << run.output;
    EXPECT_THAT(run.errors, AllOf(HasSubstr("nothing was sent"), HasSubstr("not authorized")));
  }
}

TEST_F(EjabberdBroker, SaysOverMqtt5ThatAMessageIsNotAllowed) {
  const std::vector<std::string> pause = {"pause", "KIT/0001", "--interface", "closed"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), pause.begin(), pause.end());
    return Send(std::move(more));
  };
  EXPECT_EQ(with({"-q", "0", "-V", "5"}).exit_code, 0);
  EXPECT_EQ(with({"-q", "1", "-V", "3.1.1"}).exit_code, 0) << "acknowledged, and dropped";
  const Finished refused = with({"-q", "1", "-V", "5"});
  EXPECT_EQ(refused.exit_code, 4);
  EXPECT_THAT(refused.output, HasSubstr("0x90"));
  for (const char* version : {"3.1.1", "5"}) {
    const Finished subscribed = with({"--wait", "-V", version});
    EXPECT_EQ(subscribed.exit_code, 4) << subscribed.output;
    EXPECT_THAT(subscribed.errors, AllOf(HasSubstr("nothing was sent"), HasSubstr("refuses")));
  }
}

TEST_F(EjabberdBroker, HangsUpOnAMessageThatIsTooLarge) {
  const auto file =
      operator_.home().Write("large", std::string(Ejabberd::kMaximumPayload + 1'000, 'x'));
  for (const char* version : {"3.1.1", "5"}) {
    const Finished run = Send(
        {"action", "note", "KIT/0001", "-P", "text=@" + file.string(), "-q", "1", "-V", version});
    EXPECT_EQ(run.exit_code, 4) << run.output;
    EXPECT_THAT(run.output, HasSubstr("ERROR"));
  }
}

}  // namespace
}  // namespace fleetpub::testing
