// Publishing and receiving through a real broker.
#include "mqtt/paho/paho_transport.h"

#include <signal.h>

#include <algorithm>

#include "mqtt/connecting.h"
#include "support/broken_broker.h"
#include "support/mosquitto.h"
#include "support/publish_packet.h"

namespace fleetpub::mqtt {
namespace {

using fleetpub::testing::BrokenBroker;
using fleetpub::testing::Mosquitto;
using fleetpub::testing::PublishPacket;
using std::chrono::milliseconds;
using std::chrono::steady_clock;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

constexpr Qos kEveryQos[] = {Qos::kAtMostOnce, Qos::kAtLeastOnce, Qos::kExactlyOnce};

// Both protocol versions.
class PahoTransport : public ::testing::TestWithParam<ProtocolVersion> {
 protected:
  [[nodiscard]] ConnectOptions Options(const Mosquitto& broker) const {
    ConnectOptions options = To(broker.Url());
    options.version = GetParam();
    return options;
  }
};

INSTANTIATE_TEST_SUITE_P(Versions, PahoTransport,
                         ::testing::Values(ProtocolVersion::k311, ProtocolVersion::k5),
                         [](const auto& version) {
                           return version.param == ProtocolVersion::k5 ? "Mqtt5" : "Mqtt311";
                         });

TEST_P(PahoTransport, DeliversAtEveryQos) {
  const Mosquitto broker;
  const auto robot = Connected(Options(broker));
  const auto master = Connected(Options(broker));
  MustSubscribe(*robot, "uagv/#", Qos::kExactlyOnce);
  for (const Qos qos : kEveryQos) {
    const std::string payload("a\0b", 3);
    const auto token = master->Publish({"uagv/v2/KIT/0001/state", payload, qos}, Soon());
    ASSERT_TRUE(token) << token.error().message;
    EXPECT_EQ(*token == 0, qos == Qos::kAtMostOnce);
    const auto acknowledged = master->AwaitAcknowledgements(Soon(), 0);
    ASSERT_TRUE(acknowledged);
    ASSERT_THAT(*acknowledged, SizeIs(qos == Qos::kAtMostOnce ? 0 : 1));
    if (qos != Qos::kAtMostOnce) {
      EXPECT_EQ(acknowledged->front().token, *token);
      EXPECT_FALSE(acknowledged->front().Refused());
    }
    EXPECT_EQ(master->in_flight(), 0);
    const Message message = MustReceive(*robot);
    EXPECT_EQ(message.topic, "uagv/v2/KIT/0001/state");
    EXPECT_EQ(message.payload, payload);
    EXPECT_EQ(message.qos, qos);
    EXPECT_FALSE(message.retained);
  }
}

TEST_P(PahoTransport, TellsRetainedMessagesFromNewOnes) {
  const Mosquitto broker;
  ASSERT_EQ(
      fleetpub::testing::Run({.arguments = {"mosquitto_pub", "-p", std::to_string(broker.port()),
                                            "-t", "t", "-m", "old", "-r"}})
          .exit_code,
      0);
  const auto robot = Connected(Options(broker));
  MustSubscribe(*robot, "t");
  EXPECT_TRUE(MustReceive(*robot).retained);
}

TEST_P(PahoTransport, PublishesARobotsOwnTopicsRetained) {
  const Mosquitto broker;
  const auto robot = ConnectPahoAsRobot(Options(broker));
  ASSERT_TRUE(robot);
  ASSERT_TRUE((*robot)->PublishRetained({"connection", "ONLINE", Qos::kAtLeastOnce}, Soon()));
  ASSERT_TRUE((*robot)->Publish({"state", "driving", Qos::kAtLeastOnce}, Soon()));
  ASSERT_TRUE((*robot)->AwaitAcknowledgements(Soon(), 0));
  const auto master = Connected(Options(broker));
  MustSubscribe(*master, "#");
  const Message message = MustReceive(*master);
  EXPECT_TRUE(message.retained);
  EXPECT_EQ(message.payload, "ONLINE");
  EXPECT_FALSE(*master->Receive(In(milliseconds(50)))) << "nothing else was kept";
}

TEST_P(PahoTransport, LeavesAWillUnlessItSaysGoodbye) {
  const Mosquitto broker;
  const auto master = Connected(Options(broker));
  MustSubscribe(*master, "#", Qos::kAtLeastOnce);
  ConnectOptions options = Options(broker);
  options.will = {"connection", "BROKEN", Qos::kAtLeastOnce, true};
  Connected(options)->Disconnect();
  EXPECT_FALSE(*master->Receive(In(milliseconds(50))));
  Connected(options).reset();
  const Message will = MustReceive(*master);
  EXPECT_EQ(will.topic, "connection");
  EXPECT_EQ(will.payload, "BROKEN");
  EXPECT_EQ(will.qos, Qos::kAtLeastOnce);
  const auto later = Connected(Options(broker));
  MustSubscribe(*later, "#");
  EXPECT_TRUE(MustReceive(*later).retained);
}

TEST(Will, IsRefusedWithoutATopic) {
  ConnectOptions options = To("mqtt://127.0.0.1:1");
  options.will = {"", "BROKEN"};
  EXPECT_EQ(Refusal(options).kind, ErrorKind::kUsage);
}

TEST_P(PahoTransport, PublishesTenThousandMessagesAtEveryQos) {
  const Mosquitto broker({"allow_anonymous true", "max_queued_messages 0"});
  for (const Qos qos : kEveryQos) {
    const auto robot = Connected(Options(broker));
    const auto master = Connected(Options(broker));
    MustSubscribe(*robot, "#", Qos::kAtMostOnce);
    std::size_t acknowledged = 0;
    for (int i = 0; i < 10'000; ++i) {
      const auto sent =
          master->Publish({"t/" + std::to_string(i), std::string(360, 'x'), qos}, Soon());
      ASSERT_TRUE(sent) << sent.error().message;
    }
    while (master->in_flight() > 0 || acknowledged == 0) {
      const auto some = master->AwaitAcknowledgements(Soon(), 0);
      ASSERT_TRUE(some) << some.error().message;
      acknowledged += some->size();
      if (qos == Qos::kAtMostOnce) break;
    }
    EXPECT_EQ(acknowledged, qos == Qos::kAtMostOnce ? 0U : 10'000U);
    for (int i = 0; i < 10'000; ++i) ASSERT_EQ(MustReceive(*robot).topic, "t/" + std::to_string(i));
  }
}

TEST_P(PahoTransport, CarriesAMegabyteBothWays) {
  const Mosquitto broker;
  const auto robot = Connected(Options(broker));
  const auto master = Connected(Options(broker));
  MustSubscribe(*robot, "big", Qos::kAtLeastOnce);
  std::string payload(1 << 20, ' ');
  for (std::size_t i = 0; i < payload.size(); ++i) payload[i] = static_cast<char>(i * 31);
  for (const Qos qos : kEveryQos) {
    ASSERT_TRUE(master->Publish({"big", payload, qos}, Soon()));
    ASSERT_TRUE(master->AwaitAcknowledgements(Soon(), 0));
    EXPECT_EQ(MustReceive(*robot).payload, payload);
  }
}

TEST_P(PahoTransport, SubscribesToManyFilters) {
  const Mosquitto broker;
  const auto robot = Connected(Options(broker));
  std::vector<std::string> filters;
  filters.reserve(250);
  for (int i = 0; i < 250; ++i) filters.push_back("t/" + std::to_string(i));
  ASSERT_TRUE(robot->Subscribe(filters, Qos::kAtLeastOnce, Soon()));
  const auto master = Connected(Options(broker));
  ASSERT_TRUE(master->Publish({"t/249", "x"}, Soon()));
  EXPECT_EQ(MustReceive(*robot).topic, "t/249");
}

TEST_P(PahoTransport, EndsSubscriptionsAndKeepsWhatCameBefore) {
  const Mosquitto broker;
  const auto both = Connected(Options(broker));
  std::vector<std::string> filters = {"last"};
  for (int i = 0; i < 250; ++i) filters.push_back("t/" + std::to_string(i));
  ASSERT_TRUE(both->Subscribe(filters, Qos::kAtMostOnce, Soon()));
  ASSERT_TRUE(both->Publish({"t/249", "before"}, Soon()));
  ASSERT_TRUE(both->Unsubscribe(std::span(filters).subspan(1), Soon()));
  for (const char* topic : {"t/0", "t/249", "last"}) {
    ASSERT_TRUE(both->Publish({topic, "after"}, Soon()));
  }
  EXPECT_EQ(MustReceive(*both).payload, "before");
  EXPECT_EQ(MustReceive(*both).topic, "last");
}

TEST_P(PahoTransport, ReceivesNothingUntilTheDeadline) {
  const Mosquitto broker;
  const auto robot = Connected(Options(broker));
  const auto start = steady_clock::now();
  const auto message = robot->Receive(In(milliseconds(50)));
  ASSERT_TRUE(message);
  EXPECT_FALSE(*message);
  EXPECT_GE(steady_clock::now() - start, milliseconds(50));
}

TEST_P(PahoTransport, KeepsMessagesThatComeWhileItWaitsForAcknowledgements) {
  const Mosquitto broker;
  const auto both = Connected(Options(broker));
  MustSubscribe(*both, "t/+");
  for (int i = 0; i < 50; ++i) {
    ASSERT_TRUE(both->Publish({"t/" + std::to_string(i), "x", Qos::kExactlyOnce}, Soon()));
  }
  EXPECT_THAT(*both->AwaitAcknowledgements(Soon(), 0), SizeIs(50));
  for (int i = 0; i < 50; ++i) EXPECT_EQ(MustReceive(*both).topic, "t/" + std::to_string(i));
}

TEST_P(PahoTransport, NoticesThatTheBrokerDiedWhileReceiving) {
  Mosquitto broker;
  const auto robot = Connected(Options(broker));
  MustSubscribe(*robot, "t");
  broker.Kill();
  const auto message = robot->Receive(Soon());
  ASSERT_FALSE(message);
  EXPECT_EQ(message.error().kind, ErrorKind::kBroker);
  EXPECT_THAT(message.error().message, StartsWith("the connection to mqtt://127.0.0.1"));
  EXPECT_FALSE(robot->Receive(Soon())) << "it stays lost";
  const std::string filter[] = {"u"};
  EXPECT_FALSE(robot->Subscribe(filter, Qos::kAtMostOnce, Soon()));
}

TEST_P(PahoTransport, NoticesThatTheBrokerDiedBeforePublishing) {
  FLEETPUB_NEEDS_FAST_CONNECT();
  for (const Qos qos : kEveryQos) {
    Mosquitto broker;
    const auto master = Connected(Options(broker));
    broker.Kill();
    const auto sent = master->Publish({"t", "x", qos}, Soon());
    EXPECT_FALSE(sent) << "QoS " << static_cast<int>(qos);
  }
}

TEST_P(PahoTransport, NoticesThatTheBrokerDiedBeforeTheAcknowledgement) {
  Mosquitto broker;
  const auto master = Connected(Options(broker));
  broker.process().Signal(SIGSTOP);
  ASSERT_TRUE(master->Publish({"t", "x", Qos::kAtLeastOnce}, Soon()));
  EXPECT_THAT(*master->AwaitAcknowledgements(In(milliseconds(20)), 0), IsEmpty());
  EXPECT_EQ(master->in_flight(), 1);
  broker.Kill();
  EXPECT_FALSE(master->AwaitAcknowledgements(Soon(), 0));
}

TEST_P(PahoTransport, TellsAfterQos0WhetherTheConnectionStillStands) {
  Mosquitto broker;
  const auto master = Connected(Options(broker));
  ASSERT_TRUE(master->Publish({"t", "x"}, Soon()));
  EXPECT_TRUE(master->AwaitAcknowledgements(In(milliseconds(0)), 0));
  broker.Kill();
  EXPECT_FALSE(master->AwaitAcknowledgements(Soon(), 0));
}

TEST_P(PahoTransport, GivesUpOnABrokerThatTakesNoMore) {
  FLEETPUB_NEEDS_FAST_CONNECT();
  // At QoS 1 the library itself calls a lost message a success.
  for (const Qos qos : {Qos::kAtMostOnce, Qos::kAtLeastOnce}) {
    Mosquitto broker;
    const auto master = Connected(Options(broker));
    broker.process().Signal(SIGSTOP);
    const auto sent =
        master->Publish({"t", std::string(64 << 20, 'x'), qos}, In(milliseconds(200)));
    ASSERT_FALSE(sent) << "QoS " << static_cast<int>(qos);
    EXPECT_EQ(sent.error().kind, ErrorKind::kBroker);
  }
}

TEST_P(PahoTransport, GivesUpOnASubscriptionThatIsNotAnswered) {
  FLEETPUB_NEEDS_FAST_CONNECT();
  Mosquitto broker;
  const auto robot = Connected(Options(broker));
  broker.process().Signal(SIGSTOP);
  const std::string filter[] = {"t"};
  const auto start = steady_clock::now();
  const auto status = robot->Subscribe(filter, Qos::kAtMostOnce, In(milliseconds(100)));
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().message, HasSubstr("in time"));
  EXPECT_LT(steady_clock::now() - start, milliseconds(4000));
}

TEST_P(PahoTransport, WaitsForRoomInTheWindow) {
  Mosquitto broker;
  ConnectOptions options = Options(broker);
  options.window = 3;
  const auto master = Connected(options);
  broker.process().Signal(SIGSTOP);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(master->Publish({"t", "x", Qos::kAtLeastOnce}, Soon()));
  }
  EXPECT_FALSE(master->Publish({"t", "x", Qos::kAtLeastOnce}, In(milliseconds(20))));
  EXPECT_EQ(master->in_flight(), 3);
  broker.process().Signal(SIGCONT);
  EXPECT_TRUE(master->Publish({"t", "x", Qos::kAtLeastOnce}, Soon()));
  ASSERT_TRUE(master->AwaitAcknowledgements(Soon(), 0));
}

// Paho would sleep 100 ms over each message at QoS 0 that meets a full window.
TEST_P(PahoTransport, SendsQosZeroQuicklyBetweenWhatIsAcknowledged) {
  const Mosquitto broker;
  ConnectOptions options = Options(broker);
  options.window = 3;
  const auto master = Connected(options);
  const auto begin = steady_clock::now();
  for (int i = 0; i < 150; ++i) {
    ASSERT_TRUE(master->Publish({"t", "x", Qos::kAtLeastOnce}, Soon()));
    ASSERT_TRUE(master->Publish({"t", "x", Qos::kAtMostOnce}, Soon()));
  }
  EXPECT_LT(steady_clock::now() - begin, fleetpub::testing::kSlowness * milliseconds(7'500));
}

TEST_P(PahoTransport, TakesLeaveOnlyWhenAsked) {
  FLEETPUB_NEEDS_FAST_CONNECT();
  Mosquitto broker;
  ConnectOptions options = Options(broker);
  options.client_id = "polite";
  Connected(options)->Disconnect();
  EXPECT_TRUE(broker.AwaitLog("Received DISCONNECT from polite"));
  options.client_id = "rude";
  Connected(options).reset();
  EXPECT_TRUE(broker.AwaitLog("Client rude closed its connection"));
  EXPECT_THAT(broker.Log(), ::testing::Not(HasSubstr("Received DISCONNECT from rude")));
}

TEST_P(PahoTransport, LosesNothingThatWasSentBeforeLeaving) {
  FLEETPUB_NEEDS_FAST_CONNECT();
  const Mosquitto broker;
  const auto robot = Connected(Options(broker));
  MustSubscribe(*robot, "last");
  for (int round = 0; round < 20; ++round) {
    const auto master = Connected(Options(broker));
    MustSubscribe(*master, "#");
    // What comes back unread must not make the connection end in a reset.
    for (int i = 0; i < 20; ++i)
      ASSERT_TRUE(master->Publish({"noise", std::string(5000, 'x')}, Soon()));
    ASSERT_TRUE(master->Publish({"last", std::to_string(round)}, Soon()));
    master->Disconnect();
    EXPECT_EQ(MustReceive(*robot).payload, std::to_string(round));
  }
}

TEST_P(PahoTransport, RefusesWhatIsNoTopic) {
  const Mosquitto broker;
  const auto master = Connected(Options(broker));
  for (const std::string& topic :
       {std::string(), std::string("a/+"), std::string("#"), std::string("a\0b", 3),
        std::string("\xFF"), std::string(70'000, 'a')}) {
    const auto sent = master->Publish({topic, "x"}, Soon());
    ASSERT_FALSE(sent);
    EXPECT_EQ(sent.error().kind, ErrorKind::kUsage);
  }
  const std::string empty[] = {""};
  EXPECT_EQ(master->Subscribe(empty, Qos::kAtMostOnce, Soon()).error().kind, ErrorKind::kUsage);
}

TEST_P(PahoTransport, GivesItselfAName) {
  Mosquitto broker;
  const auto master = Connected(Options(broker));
  EXPECT_THAT(broker.Log(), ::testing::ContainsRegex("as fleetpub[0-9a-f]{15} "));
}

TEST(PahoTransport5, TellsWhyAMessageWasRefused) {
  const Mosquitto broker({"allow_anonymous true", "acl_file {}/acl"},
                         {{"acl", "topic read #\ntopic write allowed\n"}});
  const auto master = Connected(V5(To(broker.Url())));
  for (const Qos qos : {Qos::kAtLeastOnce, Qos::kExactlyOnce}) {
    const int denied = master->Publish({"denied", "x", qos}, Soon()).value();
    const int allowed = master->Publish({"allowed", "x", qos}, Soon()).value();
    auto acknowledged = master->AwaitAcknowledgements(Soon(), 0);
    ASSERT_TRUE(acknowledged) << acknowledged.error().message;
    ASSERT_THAT(*acknowledged, SizeIs(2)) << "QoS " << static_cast<int>(qos);
    std::sort(acknowledged->begin(), acknowledged->end(),
              [](const auto& a, const auto& b) { return a.token < b.token; });
    EXPECT_EQ((*acknowledged)[0].token, denied);
    EXPECT_EQ((*acknowledged)[0].reason, "not authorized (0x87)");
    EXPECT_TRUE((*acknowledged)[0].Refused());
    EXPECT_EQ((*acknowledged)[1].token, allowed);
    EXPECT_FALSE((*acknowledged)[1].Refused());
  }
}

TEST(PahoTransport5, KnowsTheBrokersLimits) {
  const Mosquitto broker({"allow_anonymous true", "max_qos 1", "retain_available false",
                          "max_packet_size 1000", "max_inflight_messages 5"});
  const auto master = Connected(V5(To(broker.Url())));
  EXPECT_EQ(master->server().maximum_qos, Qos::kAtLeastOnce);
  EXPECT_EQ(master->server().retain_available, false);
  EXPECT_EQ(master->server().maximum_packet_size, 1000U);
  EXPECT_FALSE(master->Publish({"t", "x", Qos::kExactlyOnce}, Soon()));
  const auto large = master->Publish({"t", std::string(2000, 'x')}, Soon());
  ASSERT_FALSE(large);
  EXPECT_THAT(large.error().message, HasSubstr("2000 bytes"));
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(master->Publish({"t", "x", Qos::kAtLeastOnce}, Soon()));
    EXPECT_LE(master->in_flight(), 5);
  }
  EXPECT_TRUE(master->AwaitAcknowledgements(Soon(), 0));
}

TEST(PahoTransport5, StaysWithinTheBrokersReceiveMaximum) {
  Mosquitto broker({"allow_anonymous true", "max_inflight_messages 5"});
  const auto master = Connected(V5(To(broker.Url())));
  broker.process().Signal(SIGSTOP);
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(master->Publish({"t", "x", Qos::kAtLeastOnce}, Soon()));
  }
  EXPECT_FALSE(master->Publish({"t", "x", Qos::kAtLeastOnce}, In(milliseconds(20))));
  broker.process().Signal(SIGCONT);
  EXPECT_TRUE(master->Publish({"t", "x", Qos::kAtLeastOnce}, Soon())) << "the connection is lost";
}

TEST(PahoTransport5, ObeysTheBrokersKeepAlive) {
  Mosquitto broker({"allow_anonymous true", "max_keepalive 10"});
  const auto master = Connected(V5(To(broker.Url())));
  EXPECT_THAT(broker.Log(), HasSubstr("k10)"));
}

TEST(PahoTransport5, NamesTheRefusedSubscription) {
  const BrokenBroker broker(BrokenBroker::Answers(
      {BrokenBroker::Connack5(0), std::string("\x90\x05\x00\x01\x00\x00\x87", 7)}));
  const auto robot = Connected(V5(To(broker.Url())));
  const std::string filters[] = {"fine", "secret/#"};
  const auto status = robot->Subscribe(filters, Qos::kAtMostOnce, Soon());
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().message,
              HasSubstr("refuses the subscription to secret/#: not authorized (0x87)"));
}

TEST(PahoTransport311, PingsWhileItWaitsAndNoticesADeadPeer) {
  FLEETPUB_NEEDS_FAST_CONNECT();
  Mosquitto broker;
  ConnectOptions options = To(broker.Url());
  options.keep_alive = std::chrono::seconds(1);
  const auto robot = Connected(options);
  const auto message = robot->Receive(In(milliseconds(1300)));
  ASSERT_TRUE(message) << message.error().message;
  EXPECT_THAT(broker.Log(), HasSubstr("Received PINGREQ"));
  broker.process().Signal(SIGSTOP);
  const auto lost = robot->Receive(Soon());
  ASSERT_FALSE(lost);
  EXPECT_THAT(lost.error().message, HasSubstr("did not answer the keep-alive pings"));
}

// Of what is read ahead no message is lost, split or kept back, wherever its packet is cut, whether or not more comes.
void ReadMessageByMessage(bool closes) {
  constexpr std::size_t kMessages = 400;
  std::string answer("\x90\x03\x00\x01\x00", 5);
  std::vector<std::string> payloads;
  for (std::size_t i = 0; i < kMessages; ++i) {
    const std::size_t size = 3 + i * 37 % 90 + (i % 50 == 7 ? 20'000 : 0);
    payloads.emplace_back(size, static_cast<char>('a' + i % 26));
    answer += PublishPacket("t", payloads.back());
  }
  const std::vector<std::string> answers = {BrokenBroker::Connack(0), std::move(answer)};
  const BrokenBroker broker(closes ? BrokenBroker::AnswersAndCloses(answers)
                                   : BrokenBroker::Answers(answers));
  const auto robot = Connected(To(broker.Url()));
  const std::vector<std::string> filters = {"t"};
  ASSERT_TRUE(robot->Subscribe(filters, Qos::kAtMostOnce, Soon()));
  for (const std::string& payload : payloads) {
    const auto message = robot->Receive(Soon());
    ASSERT_TRUE(message && *message);
    EXPECT_EQ((*message)->payload, payload);
  }
  const auto end = robot->Receive(In(milliseconds(100)));
  EXPECT_EQ(end.has_value(), !closes);
  EXPECT_THAT(end ? "" : end.error().message,
              closes ? HasSubstr("was lost: the broker closed it") : HasSubstr(""));
}

TEST(PahoTransport311, ReadsWhatComesInOnePieceMessageByMessage) {
  ReadMessageByMessage(false);
  ReadMessageByMessage(true);
}

TEST(PahoTransport311, NamesTheRefusedSubscription) {
  const BrokenBroker broker(BrokenBroker::Answers(
      {BrokenBroker::Connack(0), std::string("\x90\x04\x00\x01\x00\x80", 6)}));
  const auto robot = Connected(To(broker.Url()));
  const std::string filters[] = {"fine", "secret/#"};
  const auto status = robot->Subscribe(filters, Qos::kAtMostOnce, Soon());
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().message, HasSubstr("refuses the subscription to secret/#"));
}

}  // namespace
}  // namespace fleetpub::mqtt
