// Connections that do not come about, and what a person is told.
#include "mqtt/paho/paho_connect.h"

#include <fmt/format.h>

#include <cstdlib>

#include "mqtt/connecting.h"
#include "support/broken_broker.h"
#include "support/free_port.h"
#include "support/mosquitto.h"

namespace fleetpub::mqtt {
namespace {

using fleetpub::testing::BrokenBroker;
using fleetpub::testing::FreePort;
using fleetpub::testing::Mosquitto;
using fleetpub::testing::PasswordFile;
using std::chrono::milliseconds;
using std::chrono::steady_clock;
using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

std::string ClosedPort() { return fmt::format("mqtt://127.0.0.1:{}", FreePort()); }

TEST(ConnectPaho, SaysThatNobodyListens) {
  FLEETPUB_NEEDS_FAST_CONNECT();
  const std::string url = ClosedPort();
  const Error error = Refusal(To(url));
  EXPECT_EQ(error.kind, ErrorKind::kBroker);
  EXPECT_THAT(error.message,
              AllOf(HasSubstr(url), HasSubstr("connection refused"), HasSubstr("--broker")));
}

TEST(ConnectPaho, SaysThatANameIsNotKnown) {
  const Error error = Refusal(To("mqtt://nobody.invalid"));
  EXPECT_EQ(error.kind, ErrorKind::kBroker);
  EXPECT_THAT(error.message, StartsWith("cannot reach mqtt://nobody.invalid:1883: the name"));
}

TEST(ConnectPaho, TriesTheBrokersInTheirOrder) {
  const Mosquitto broker;
  ConnectOptions options = To(ClosedPort());
  options.brokers.push_back(To(broker.Url()).brokers.front());
  EXPECT_EQ(Connected(options)->server().broker.port, broker.port());
}

TEST(ConnectPaho, TellsWhatEveryBrokerSaid) {
  FLEETPUB_NEEDS_FAST_CONNECT();
  const std::string first = ClosedPort();
  const BrokenBroker second(BrokenBroker::Answers({BrokenBroker::Connack(3)}));
  ConnectOptions options = To(first);
  options.brokers.push_back(To(second.Url()).brokers.front());
  EXPECT_THAT(Refusal(options).message,
              AllOf(StartsWith("cannot reach " + first),
                    HasSubstr("; " + second.Url() + " refused"), Not(HasSubstr("\n"))));
}

TEST(ConnectPaho, PutsEveryReturnCodeInWords) {
  const std::pair<int, std::string> cases[] = {
      {1, "does not speak this version"}, {2, "client id"},      {3, "unavailable"},
      {4, "bad user name or password"},   {5, "not authorized"}, {77, "return code 77"},
  };
  for (const auto& [code, words] : cases) {
    const BrokenBroker broker(BrokenBroker::Answers({BrokenBroker::Connack(code)}));
    const Error error = Refusal(To(broker.Url()));
    EXPECT_EQ(error.kind, ErrorKind::kBroker);
    EXPECT_THAT(error.message, StartsWith(broker.Url() + " refused the connection: "));
    EXPECT_THAT(error.message, HasSubstr(words));
    EXPECT_EQ(error.detail, fmt::format("CONNACK return code {}", code));
  }
}

TEST(ConnectPaho, PutsEveryReasonCodeInWords) {
  const std::pair<int, std::string> cases[] = {
      {0x84, "does not speak this version"},
      {0x85, "client id"},
      {0x86, "bad user name or password"},
      {0x87, "not authorized"},
      {0x88, "unavailable"},
      {0x8A, "banned"},
      {0x97, "quota exceeded (0x97)"},
      {0xF0, "unknown reason (0xF0)"},
  };
  for (const auto& [code, words] : cases) {
    const BrokenBroker broker(BrokenBroker::Answers({BrokenBroker::Connack5(code)}));
    const Error error = Refusal(V5(To(broker.Url())));
    EXPECT_THAT(error.message, StartsWith(broker.Url() + " refused the connection: "));
    EXPECT_THAT(error.message, HasSubstr(words));
  }
}

ConnectOptions WithMethod(const std::string& url) {
  ConnectOptions options = V5(To(url));
  options.authentication = Authentication{.method = "TOKEN", .data = "sesame"};
  options.login = "method TOKEN";
  return options;
}

TEST(ConnectPaho, TellsWhatIsWrongWithAMethodOfAuthentication) {
  const std::pair<int, std::string> cases[] = {
      {0x86, "--auth-data-file"}, {0x87, "not authorized"}, {0x8C, "bad authentication method"}};
  for (const auto& [code, words] : cases) {
    const BrokenBroker broker(BrokenBroker::Answers({BrokenBroker::Connack5(code)}));
    EXPECT_THAT(Refusal(WithMethod(broker.Url())).message,
                AllOf(HasSubstr("refused the connection"), HasSubstr(words),
                      HasSubstr("(tried: method TOKEN)"), Not(HasSubstr("sesame"))));
  }
  const BrokenBroker broker(BrokenBroker::Answers({BrokenBroker::Connack5(0x8C)}));
  EXPECT_THAT(Refusal(V5(To(broker.Url()))).message, HasSubstr("--auth-method"));
}

TEST(ConnectPaho, EndsAnAuthenticationThatGoesOn) {
  const std::string further("\xf0\2\x18\0", 4);
  const BrokenBroker broker(BrokenBroker::Answers({further}));
  bool may_heal = true;
  const auto asked = ConnectPaho(WithMethod(broker.Url()), &may_heal);
  ASSERT_FALSE(asked);
  EXPECT_EQ(asked.error().kind, ErrorKind::kBroker);
  EXPECT_THAT(asked.error().message, AllOf(HasSubstr("further step"), HasSubstr("--auth-method")));
  EXPECT_FALSE(may_heal);
  EXPECT_THAT(Refusal(V5(To(broker.Url()))).message, HasSubstr("an AUTH packet"))
      << "nobody began one";
}

TEST(ConnectPaho, TakesNoMethodThatMqttCannotCarry) {
  const BrokenBroker broker(BrokenBroker::Silent());
  const auto refusal = [&](Authentication authentication, bool v5 = true) {
    ConnectOptions options = v5 ? V5(To(broker.Url())) : To(broker.Url());
    options.authentication = std::move(authentication);
    const Error error = Refusal(options);
    EXPECT_EQ(error.kind, ErrorKind::kUsage);
    return error.message;
  };
  EXPECT_THAT(refusal({.method = "TOKEN", .data = {}}, false), HasSubstr("--mqtt-version 5"));
  EXPECT_THAT(refusal({.method = "", .data = "x"}), HasSubstr("--auth-method"));
  EXPECT_THAT(refusal({.method = "\xff", .data = {}}), HasSubstr("UTF-8"));
  EXPECT_THAT(refusal({.method = "a", .data = std::string(65'536, 'x')}), HasSubstr("65,535"));
}

TEST(ConnectPaho, TellsWhatTheBrokerAddsToAReason) {
  // CONNACK 0x9D with a reason string and a server reference.
  const std::string properties = std::string("\x1f\0\5spa\nt", 8) + std::string("\x1c\0\3b:1", 6);
  const std::string rest =
      std::string("\0\x9d", 2) + static_cast<char>(properties.size()) + properties;
  const BrokenBroker broker(
      BrokenBroker::Answers({std::string("\x20") + static_cast<char>(rest.size()) + rest}));
  EXPECT_THAT(Refusal(V5(To(broker.Url()))).message,
              AllOf(HasSubstr("it has moved"), HasSubstr(R"('spa\nt')"), HasSubstr("server b:1")));
}

// The server name that a ClientHello holds is readable.
std::string Hello(const std::string& host, const std::string& server_name) {
  std::mutex mutex;
  std::string hello;
  const BrokenBroker broker([&](int socket) {
    const std::string got = testing::ReadSome(socket);
    const std::lock_guard lock(mutex);
    hello += got;
  });
  ConnectOptions options = To(fmt::format("mqtts://{}:{}", host, broker.port()));
  options.tls.server_name = server_name;
  EXPECT_THAT(Refusal(options).message, HasSubstr("TLS handshake"));
  const std::lock_guard lock(mutex);
  return hello;
}

TEST(ConnectPaho, NamesTheServerInTlsButNoAddress) {
  EXPECT_THAT(Hello("localhost", ""), HasSubstr("localhost"));
  EXPECT_THAT(Hello("127.0.0.1", ""), Not(HasSubstr("127.0.0.1")));
  EXPECT_THAT(Hello("127.0.0.1", "b.example"), HasSubstr("b.example"));
  EXPECT_THAT(Hello("localhost", "::1"), AllOf(Not(HasSubstr("localhost")), Not(HasSubstr("::1"))));
}

TEST(ConnectPaho, GivesUpAtItsTimeout) {
  FLEETPUB_NEEDS_FAST_CONNECT();
  const BrokenBroker broker(BrokenBroker::Silent());
  for (const std::string scheme : {"mqtt", "mqtts", "ws", "wss"}) {
    ConnectOptions options = To(broker.Url(scheme));
    options.connect_timeout = milliseconds(150);
    const auto start = steady_clock::now();
    EXPECT_THAT(Refusal(options).message, HasSubstr("answer within 150 ms")) << scheme;
    EXPECT_GE(steady_clock::now() - start, milliseconds(150)) << scheme;
    EXPECT_LT(steady_clock::now() - start, milliseconds(5000)) << scheme;
  }
}

TEST(ConnectPaho, SaysThatThePeerHungUp) {
  for (const auto& behaviour :
       {BrokenBroker::ClosesAtOnce(), BrokenBroker::AnswersAndCloses({""})}) {
    const BrokenBroker broker(behaviour);
    for (const std::string scheme : {"mqtt", "ws"}) {
      EXPECT_THAT(Refusal(To(broker.Url(scheme))).message, HasSubstr("closed the connection"));
    }
    for (const std::string scheme : {"mqtts", "wss"}) {
      EXPECT_THAT(Refusal(To(broker.Url(scheme))).message, HasSubstr("TLS handshake"));
    }
  }
}

TEST(ConnectPaho, SaysThatSomethingElseAnswers) {
  FLEETPUB_NEEDS_FAST_CONNECT();
  const std::pair<std::string, std::string> cases[] = {
      {"SSH-2.0-OpenSSH_9.2\r\n", "not an MQTT broker"},
      {"HTTP/1.1 400 Bad Request\r\n\r\n", "ws://"},
      {std::string("\x15\x03\x03\x00\x02\x02\x32", 7), "mqtts://"},
      {std::string("\0\0\0\0", 4), "not an MQTT broker"},
  };
  for (const auto& [greeting, words] : cases) {
    const BrokenBroker broker(BrokenBroker::Greets(greeting));
    const auto start = steady_clock::now();
    EXPECT_THAT(Refusal(To(broker.Url())).message, HasSubstr(words));
    EXPECT_LT(steady_clock::now() - start, milliseconds(5000)) << "waited for a packet's rest";
  }
}

TEST(ConnectPaho, SaysThatThereIsNoTls) {
  const BrokenBroker broker(
      BrokenBroker::Greets("220 mail.example ESMTP and more of this sort\r\n"));
  EXPECT_THAT(Refusal(To(broker.Url("mqtts"))).message, HasSubstr("does not speak TLS"));
}

TEST(ConnectPaho, StopsAtGarbageInsteadOfAConnack) {
  FLEETPUB_NEEDS_FAST_CONNECT();
  for (const std::string& garbage : {std::string("\x20\xFF\xFF\xFF\xFF\xFF", 6),
                                     std::string("\x20\x00", 2), std::string("\x20\x01\x00", 3)}) {
    const BrokenBroker broker(BrokenBroker::AnswersAndCloses({garbage}));
    for (const auto version : {ProtocolVersion::k311, ProtocolVersion::k5}) {
      ConnectOptions options = To(broker.Url());
      options.version = version;
      options.connect_timeout = milliseconds(1000);
      EXPECT_EQ(Refusal(options).kind, ErrorKind::kBroker);
    }
  }
}

TEST(ConnectPaho, LogsInWithAPasswordThatNoErrorRepeats) {
  const Mosquitto broker({"allow_anonymous false", "password_file {}/passwords"},
                         {{"passwords", PasswordFile("operator", "right:@/ \xC3\xBC")}});
  ConnectOptions options = To(broker.Url());
  EXPECT_THAT(Refusal(options).message, HasSubstr("not authorized"));
  options.username = "operator";
  options.password = "wrong-hunter2";
  for (const auto version : {ProtocolVersion::k311, ProtocolVersion::k5}) {
    options.version = version;
    const Error error = Refusal(options);
    EXPECT_THAT(error.message, HasSubstr("not authorized"));
    EXPECT_THAT(error.message + error.detail, Not(HasSubstr("hunter2")));
  }
  options.password = "right:@/ \xC3\xBC";
  EXPECT_TRUE(ConnectPaho(options));
}

TEST(ConnectPaho, TakesTheUserNameFromTheUrl) {
  const Mosquitto broker({"allow_anonymous false", "password_file {}/passwords"},
                         {{"passwords", PasswordFile("o@x", "p")}});
  ConnectOptions options = To(broker.Url("mqtt", "o%40x@localhost"));
  options.password = "p";
  EXPECT_TRUE(ConnectPaho(options));
}

TEST(ConnectPaho, TracesEveryStepWithoutSecrets) {
  const Mosquitto broker({"allow_anonymous false", "password_file {}/passwords"},
                         {{"passwords", PasswordFile("operator7", "hunter2")}});
  ConnectOptions options = To(broker.Url());
  options.username = "operator7";
  options.password = "hunter2";
  options.client_id = "tracer";
  std::string trace;
  options.trace = [&trace](std::string_view line) { trace += std::string(line) + "\n"; };
  const auto transport = Connected(options);
  ASSERT_TRUE(transport->Publish({"t", std::string("a\x1B[2J", 5)}, Soon()));
  EXPECT_THAT(trace, AllOf(HasSubstr("tracer -> CONNECT"), HasSubstr("<- CONNACK"),
                           HasSubstr("-> PUBLISH")));
  EXPECT_THAT(
      trace, AllOf(Not(HasSubstr("hunter2")), Not(HasSubstr("operator7")), Not(HasSubstr("\x1B"))));
}

TEST(ConnectPaho, IgnoresTheProxyOfTheEnvironment) {
  // The first connection of a process takes it out of the environment; another process is not
  // touched.
  setenv("http_proxy", "http://127.0.0.1:1", 1);
  const Mosquitto broker;
  EXPECT_TRUE(ConnectPaho(To(broker.Url())));
}

TEST(ConnectPaho, RefusesOptionsThatCannotWork) {
  const auto Wrong = [](auto change) {
    ConnectOptions options = To("mqtt://localhost:1");
    change(options);
    const Error error = Refusal(options);
    EXPECT_EQ(error.kind, ErrorKind::kUsage) << error.message;
  };
  Wrong([](ConnectOptions& o) { o.brokers.clear(); });
  Wrong([](ConnectOptions& o) { o.client_id = "\xFF"; });
  Wrong([](ConnectOptions& o) { o.username = std::string(1, '\0'); });
  Wrong([](ConnectOptions& o) { o.password = "without a user name"; });
  Wrong([](ConnectOptions& o) { o.proxy = "socks5://x"; });
  Wrong([](ConnectOptions& o) { o.tls.key_file = "key without a certificate"; });
  Wrong([](ConnectOptions& o) { o.tls.ciphers = "ALL:@SECLEVEL=0"; });
  Wrong([](ConnectOptions& o) { o.tls.alpn = {""}; });
}

TEST(ConnectPaho, ConnectsAHundredTimes) {
  const Mosquitto broker;
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(ConnectPaho(To(broker.Url("mqtt", "localhost"))));
}

}  // namespace
}  // namespace fleetpub::mqtt
