// TLS and WebSockets against a real mosquitto.
#include <algorithm>
#include <memory>
#include <thread>

#include "mqtt/certificates.h"
#include "mqtt/connecting.h"
#include "support/broken_broker.h"
#include "support/free_port.h"
#include "support/front.h"
#include "support/mosquitto.h"
#include "support/process.h"
#include "support/publish_packet.h"

namespace fleetpub::mqtt {
namespace {

using fleetpub::testing::BrokenBroker;
using fleetpub::testing::Mosquitto;
using fleetpub::testing::PublishPacket;
using fleetpub::testing::ReadSome;
using fleetpub::testing::WebSocketAnswer;
using fleetpub::testing::WebSocketFrame;
using fleetpub::testing::WriteTo;
using ::testing::HasSubstr;
using ::testing::Not;

ConnectOptions Trusting(const std::string& url) {
  ConnectOptions options = To(url);
  options.tls.ca_file = Certificates::Get() / "ca.crt";
  return options;
}

// Publishes and receives at every QoS, small and large, with packets arriving close together.
void ExpectTraffic(const ConnectOptions& options, std::size_t large_size = 1 << 20) {
  const auto both = Connected(options);
  MustSubscribe(*both, "t/#", Qos::kExactlyOnce);
  for (const Qos qos : {Qos::kAtMostOnce, Qos::kAtLeastOnce, Qos::kExactlyOnce}) {
    for (int i = 0; i < 200; ++i) {
      ASSERT_TRUE(both->Publish({"t/" + std::to_string(i), std::string(50, 'x'), qos}, Soon()));
    }
    std::size_t acknowledged = 0;
    while (both->in_flight() > 0)
      acknowledged += both->AwaitAcknowledgements(Soon(), 0).value().size();
    EXPECT_EQ(acknowledged, qos == Qos::kAtMostOnce ? 0U : 200U);
    for (int i = 0; i < 200; ++i) ASSERT_EQ(MustReceive(*both).topic, "t/" + std::to_string(i));
  }
  const std::string large(large_size, 'y');
  ASSERT_TRUE(both->Publish({"t/large", large, Qos::kAtLeastOnce}, Soon()));
  EXPECT_EQ(MustReceive(*both).payload, large);
  while (both->in_flight() > 0) ASSERT_FALSE(both->AwaitAcknowledgements(Soon(), 0)->empty());
  both->Disconnect();
}

TEST(Tls, CarriesTraffic) {
  const Mosquitto broker(Certificates::Get().Subscription());
  ExpectTraffic(Trusting(broker.Url("mqtts", "localhost")));
  ExpectTraffic(V5(Trusting(broker.Url("mqtts", "localhost"))));
}

// Paho goes on reading while it writes a message in parts, which it does only on TLS.
TEST(Tls, KeepsAnAcknowledgementThatComesDuringPublishing) {
  const Mosquitto broker(Certificates::Get().Subscription());
  const auto master = Connected(Trusting(broker.Url("mqtts", "localhost")));
  const auto sent = master->Publish({"t", std::string(16 << 20, 'x'), Qos::kAtLeastOnce}, Soon());
  ASSERT_TRUE(sent) << sent.error().message;
  const auto acknowledged = master->AwaitAcknowledgements(In(std::chrono::seconds(5)), 0);
  ASSERT_TRUE(acknowledged);
  ASSERT_EQ(acknowledged->size(), 1U);
  EXPECT_EQ(acknowledged->front().token, *sent);
}

TEST(Tls, ChecksAnAddressInNumbersToo) {
  const Mosquitto broker(Certificates::Get().Subscription());
  EXPECT_TRUE(ConnectPaho(Trusting(broker.Url("mqtts", "127.0.0.1"))));
}

TEST(Tls, ConnectsFiftyTimes) {
  const Mosquitto broker(Certificates::Get().Subscription());
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(ConnectPaho(Trusting(broker.Url("mqtts", "localhost"))));
}

TEST(Tls, TrustsNoUnknownAuthority) {
  const Mosquitto broker(Certificates::Get().Subscription());
  ConnectOptions options = To(broker.Url("mqtts", "localhost"));
  EXPECT_THAT(Refusal(options).message,
              HasSubstr("not trusted here: name that authority's certificate"));
  options.tls.ca_file = Certificates::Get() / "stranger.crt";
  EXPECT_THAT(Refusal(options).message, HasSubstr("not trusted here"));
  options.tls.verify = false;
  EXPECT_TRUE(ConnectPaho(options));
}

TEST(Tls, NamesTheHostsOfAnotherCertificate) {
  const Mosquitto broker(Certificates::Get().Subscription("other.crt"));
  ConnectOptions options = Trusting(broker.Url("mqtts", "localhost"));
  EXPECT_THAT(Refusal(options).message,
              HasSubstr("its certificate is for other.example, not for localhost"));
  options.tls.verify = false;
  EXPECT_TRUE(ConnectPaho(options));
}

TEST(Tls, SendsNoPasswordToAnotherHost) {
  const Mosquitto broker(Certificates::Get().Subscription("other.crt"));
  EXPECT_FALSE(ConnectPaho(Trusting(broker.Url("mqtts", "localhost"))));
  EXPECT_THAT(broker.Log(), Not(HasSubstr("New client connected")));
}

TEST(Tls, SaysThatTheCertificateHasExpired) {
  const Mosquitto broker(Certificates::Get().Subscription("expired.crt"));
  EXPECT_THAT(Refusal(Trusting(broker.Url("mqtts", "localhost"))).message,
              HasSubstr("has expired"));
}

TEST(Tls, ShowsACertificateOfItsOwn) {
  const auto& files = Certificates::Get();
  const Mosquitto broker(files.Subscription("server.crt", {"require_certificate true"}));
  ConnectOptions options = Trusting(broker.Url("mqtts", "localhost"));
  bool may_heal = true;
  const auto without = ConnectPaho(options, &may_heal);
  ASSERT_FALSE(without);
  EXPECT_EQ(without.error().kind, ErrorKind::kBroker);
  EXPECT_FALSE(may_heal);
  options.tls.cert_file = files / "client.crt";
  options.tls.key_file = files / "client.key";
  EXPECT_THAT(Refusal(options).message, HasSubstr("--key-password-file"));
  options.tls.key_password = "wrong";
  EXPECT_EQ(Refusal(options).kind, ErrorKind::kUsage);
  options.tls.key_password = "secret";
  EXPECT_TRUE(ConnectPaho(options));
}

TEST(Tls, SaysWhichFileIsWrong) {
  const Mosquitto broker(Certificates::Get().Subscription());
  ConnectOptions options = Trusting(broker.Url("mqtts", "localhost"));
  options.tls.ca_file = "/nowhere/ca.crt";
  EXPECT_THAT(Refusal(options).message, HasSubstr("/nowhere/ca.crt (--cafile)"));
  options.tls.ca_file = Certificates::Get() / "ca.key";
  EXPECT_THAT(Refusal(options).message, HasSubstr("holds no certificate in PEM form"));
  options = Trusting(broker.Url("mqtts", "localhost"));
  options.tls.ciphers = "NO-SUCH-CIPHER";
  EXPECT_THAT(Refusal(options).message, HasSubstr("--ciphers"));
}

TEST(Tls, SpeaksNothingOlderThan12) {
  const auto& files = Certificates::Get();
  const std::string port = std::to_string(fleetpub::testing::FreePort());
  fleetpub::testing::Process server(
      {.arguments = {"openssl", "s_server", "-tls1_1", "-cipher", "ALL:@SECLEVEL=0", "-accept",
                     port, "-cert", files / "server.crt", "-key", files / "server.key"},
       .input = std::nullopt});
  ASSERT_TRUE(server.AwaitOutput("ACCEPT")) << server.Errors();
  EXPECT_THAT(Refusal(Trusting("mqtts://localhost:" + port)).message, HasSubstr("TLS"));
}

// What one record of TLS brings is with OpenSSL, where poll() sees nothing of it.
TEST(Tls, FindsTheMessageBehindAPingresp) {
  FLEETPUB_NEEDS_FAST_CONNECT();
  const auto& files = Certificates::Get();
  const std::string port = std::to_string(fleetpub::testing::FreePort());
  fleetpub::testing::Process server(
      {.arguments = {"openssl", "s_server", "-quiet", "-accept", port, "-cert",
                     files / "server.crt", "-key", files / "server.key"},
       .input = std::nullopt});
  server.Write(BrokenBroker::Connack(0));
  std::unique_ptr<Transport> robot;
  const auto patience = Soon();  // s_server says nothing of its listening when it is quiet
  while (robot == nullptr && std::chrono::steady_clock::now() < patience) {
    if (auto connected = ConnectPaho(Trusting("mqtts://localhost:" + port))) {
      robot = *std::move(connected);
    }
  }
  ASSERT_NE(robot, nullptr) << server.Errors();
  server.Write(std::string("\xD0\0", 2) + PublishPacket("t", "first") +
               PublishPacket("t", "second"));
  EXPECT_EQ(MustReceive(*robot).payload, "first");
  EXPECT_EQ(MustReceive(*robot).payload, "second");
}

/// Answers the handshake and CONNECT, then says these, with a pause between them.
BrokenBroker::Behaviour SpeaksFrames(std::vector<std::string> frames) {
  return [frames = std::move(frames)](int socket) {
    WriteTo(socket, WebSocketAnswer(ReadSome(socket)));
    static_cast<void>(ReadSome(socket));
    WriteTo(socket, WebSocketFrame(BrokenBroker::Connack(0)));
    for (const std::string& frame : frames) {
      WriteTo(socket, frame);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    while (!ReadSome(socket).empty()) {
    }
  };
}

TEST(WebSocket, FindsEveryMessageOfAFrame) {
  const BrokenBroker broker(SpeaksFrames({WebSocketFrame(
      PublishPacket("t", "first") + PublishPacket("t", "second") + PublishPacket("t", "third"))}));
  const auto robot = Connected(To(broker.Url("ws")));
  for (const std::string payload : {"first", "second", "third"}) {
    EXPECT_EQ(MustReceive(*robot).payload, payload);
  }
}

// Paho alone loses the first piece, and takes the ping for a part of the message.
TEST(WebSocket, PutsAMessageTogetherFromFramesOfEverySize) {
  const std::string large(200'000, 'y');
  std::string all = PublishPacket("t", "first") + "\x30\xC3\x9A\x0C";
  all += std::string("\0\1t", 3) + large;
  const std::size_t cuts[] = {0, 1, 2, 9, 11, 12, 13, 5000, 80'000, all.size()};
  std::vector<std::string> frames;
  for (std::size_t i = 0; i + 1 < std::size(cuts); ++i) {
    const int first = (i == 0 ? 0x02 : 0x00) | (i + 2 == std::size(cuts) ? 0x80 : 0);
    frames.push_back(
        WebSocketFrame(std::string_view(all).substr(cuts[i], cuts[i + 1] - cuts[i]), first));
    frames.push_back(WebSocketFrame("still there?", 0x89));  // ping
    frames.push_back(WebSocketFrame("", 0x8A));              // pong
  }
  const BrokenBroker broker(SpeaksFrames(frames));
  const auto robot = Connected(To(broker.Url("ws")));
  EXPECT_EQ(MustReceive(*robot).payload, "first");
  EXPECT_EQ(MustReceive(*robot).payload, large);
}

TEST(WebSocket, IsLostWithASentenceWhenItsFramesAreNone) {
  const std::pair<std::string, std::string> faults[] = {
      {WebSocketFrame("x", 0x81), "binary"},           // text
      {WebSocketFrame("x", 0xC2), "reserved"},         //
      {WebSocketFrame("x", 0x80), "continued"},        // of nothing
      {WebSocketFrame("x", 0x83), "binary"},           // no such frame
      {WebSocketFrame("x", 0x8B), "no such"},          // nor this one
      {WebSocketFrame("x", 0x09), "short and whole"},  // a ping in pieces
      {WebSocketFrame(std::string(126, 'x'), 0x89), "short and whole"},
      {WebSocketFrame("\x30", 0x02) + WebSocketFrame("\x30", 0x82), "continued"},
      {std::string("\x82\x81mask\x30", 7), "masks"},
      {WebSocketFrame(std::string("\x30\x02\0\0", 4)), "PUBLISH"},
      {std::string("\x82\x7F\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF\x30\xFF\xFF\xFF\x7F", 15),
       "268435455"},
  };
  for (const auto& [frames, words] : faults) {
    const BrokenBroker broker(SpeaksFrames({frames}));
    const auto robot = Connected(To(broker.Url("ws")));
    const auto message = robot->Receive(Soon());
    ASSERT_FALSE(message) << words;
    EXPECT_THAT(message.error().message,
                AllOf(HasSubstr("was lost"), HasSubstr("the broker sent"), HasSubstr(words)));
  }
  std::string endless;
  for (int i = 0; i < 2'000; ++i) endless += WebSocketFrame("", 0x8A);
  const BrokenBroker broker(SpeaksFrames({endless}));
  EXPECT_FALSE(Connected(To(broker.Url("ws")))->Receive(Soon()));
}

TEST(WebSocket, TakesAnAnswerToItsHandshakeInPieces) {
  const BrokenBroker broker([](int socket) {
    for (const char byte : WebSocketAnswer(ReadSome(socket))) {
      WriteTo(socket, {&byte, 1});
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    static_cast<void>(ReadSome(socket));
    WriteTo(socket, WebSocketFrame(BrokenBroker::Connack(0)));
    while (!ReadSome(socket).empty()) {
    }
  });
  EXPECT_TRUE(ConnectPaho(To(broker.Url("ws"))));
  const BrokenBroker verbose([](int socket) {
    std::string answer = WebSocketAnswer(ReadSome(socket));
    answer.insert(answer.size() - 2, "X-Long: " + std::string(2'000, 'x') + "\r\n");
    WriteTo(socket, answer);
    while (!ReadSome(socket).empty()) {
    }
  });
  EXPECT_THAT(Refusal(To(verbose.Url("ws"))).message, HasSubstr("handshake"));
}

// mosquitto 2.0.11 sends 4 KB in 100 ms over WebSockets, on its own initiative.
constexpr std::size_t kLargeForWebSockets = 9000;

TEST(WebSocket, CarriesTraffic) {
  const Mosquitto broker({"protocol websockets", "allow_anonymous true"});
  ExpectTraffic(To(broker.Url("ws")), kLargeForWebSockets);
  ExpectTraffic(V5(To(broker.Url("ws") + "/mqtt:a")), kLargeForWebSockets);
}

TEST(WebSocket, CarriesTrafficOverTls) {
  const Mosquitto broker(Certificates::Get().Subscription("server.crt", {"protocol websockets"}));
  ExpectTraffic(Trusting(broker.Url("wss", "localhost")), kLargeForWebSockets);
  EXPECT_FALSE(ConnectPaho(To(broker.Url("wss", "localhost"))));
}

TEST(WebSocket, SendsNoPasswordToAServerThatRefuses) {
  FLEETPUB_NEEDS_FAST_CONNECT();
  std::string heard;
  {
    const BrokenBroker server([&heard](int socket) {
      heard += fleetpub::testing::ReadSome(socket);
      fleetpub::testing::WriteTo(socket, "HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n");
      for (std::string more; !(more = fleetpub::testing::ReadSome(socket)).empty();) heard += more;
    });
    ConnectOptions options = To(server.Url("ws"));
    options.username = "operator";
    options.password = "hunter2";
    EXPECT_THAT(Refusal(options).message, HasSubstr("refuses the WebSocket (HTTP status 404)"));
  }
  EXPECT_THAT(heard, HasSubstr("Upgrade: websocket"));
  EXPECT_THAT(heard, Not(HasSubstr("hunter2")));
}

}  // namespace
}  // namespace fleetpub::mqtt
