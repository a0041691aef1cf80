#include "mqtt/http_proxy.h"

#include <poll.h>
#include <sys/socket.h>

#include <future>
#include <thread>

#include "mqtt/connecting.h"
#include "support/broken_broker.h"
#include "support/mosquitto.h"

namespace fleetpub::mqtt {
namespace {

using fleetpub::testing::BrokenBroker;
using fleetpub::testing::Mosquitto;
using fleetpub::testing::ReadSome;
using fleetpub::testing::WriteTo;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// Answers CONNECT and passes everything on to this port.
BrokenBroker::Behaviour Tunnel(std::uint16_t port, std::promise<std::string>& request) {
  return [port, &request](int client) {
    request.set_value(ReadSome(client));
    const auto broker = TcpConnect(Lookup("127.0.0.1", port, Soon()).value(), Soon());
    WriteTo(client, "HTTP/1.1 200 Connection established\r\nVia: test\r\n\r\n");
    std::thread back([&] {
      while (WaitFor(broker->get(), POLLIN, Soon()) != 0) {
        const std::string some = ReadSome(broker->get());
        if (some.empty()) return;
        WriteTo(client, some);
      }
    });
    for (std::string some; !(some = ReadSome(client)).empty();) WriteTo(broker->get(), some);
    shutdown(broker->get(), SHUT_RDWR);
    back.join();
  };
}

TEST(HttpProxy, ReadsItsUrl) {
  const auto proxy = ParseHttpProxy("http://user:p%40ss%3A@[::1]:8080/");
  ASSERT_TRUE(proxy) << proxy.error().message;
  EXPECT_EQ(proxy->host, "::1");
  EXPECT_EQ(proxy->port, 8080);
  EXPECT_EQ(proxy->credentials, "user:p@ss:");
  EXPECT_EQ(ParseHttpProxy("HTTP://proxy")->port, 3128);
}

TEST(HttpProxy, RefusesABadUrlWithoutRepeatingIt) {
  for (const std::string text :
       {"", "proxy:8080", "https://proxy", "http://", "http://hunter2@:1", "http://a:hunter2%zz@p",
        "http://:hunter2@p", "http://u:hunter2@p:0", "http://u:hunter2@p/x"}) {
    const auto proxy = ParseHttpProxy(text);
    ASSERT_FALSE(proxy) << text;
    EXPECT_EQ(proxy.error().kind, ErrorKind::kUsage);
    EXPECT_THAT(proxy.error().message, Not(HasSubstr("hunter2")));
  }
}

TEST(HttpProxy, LeadsToTheBroker) {
  FLEETPUB_NEEDS_FAST_CONNECT();
  const Mosquitto broker;
  std::promise<std::string> request;
  const BrokenBroker proxy(Tunnel(broker.port(), request));
  ConnectOptions options = To("mqtt://broker.invalid:1883");
  options.proxy = "http://user:pass@127.0.0.1:" + std::to_string(proxy.port());
  const auto transport = Connected(options);
  ASSERT_TRUE(transport->Publish({"t", "x", Qos::kAtLeastOnce}, Soon()));
  EXPECT_TRUE(transport->AwaitAcknowledgements(Soon(), 0));
  EXPECT_THAT(request.get_future().get(),
              AllOf(HasSubstr("CONNECT broker.invalid:1883 HTTP/1.1\r\n"),
                    HasSubstr("Proxy-Authorization: Basic dXNlcjpwYXNz\r\n")));
}

TEST(HttpProxy, SaysWhatTheProxySaysAndWhetherItPasses) {
  FLEETPUB_NEEDS_FAST_CONNECT();
  struct Case {
    std::string answer, words;
    bool passes = false;
  };
  const Case cases[] = {
      {"HTTP/1.1 407 Proxy Authentication Required\r\n\r\n", "FLEETPUB_PROXY"},
      {"HTTP/1.1 403 Forbidden\r\n\r\n", "HTTP status 403"},
      {"HTTP/1.0 400 Bad Request\r\n\r\n", "HTTP status 400"},
      {"HTTP/1.1 503 Service Unavailable\r\n\r\n", "HTTP status 503", true},
      {"HTTP/1.1 429 Too Many Requests\r\n\r\n", "HTTP status 429", true},
      {"SSH-2.0-OpenSSH\r\n\r\n", "no HTTP proxy"},
      {std::string(20'000, 'x'), "no end", true},
  };
  for (const auto& [answer, words, passes] : cases) {
    const BrokenBroker proxy(BrokenBroker::Answers({answer}));
    ConnectOptions options = To("mqtt://broker.invalid:1883");
    options.proxy = "http://u:hunter2@127.0.0.1:" + std::to_string(proxy.port());
    bool may_heal = !passes;
    const auto transport = ConnectPaho(options, &may_heal);
    ASSERT_FALSE(transport);
    EXPECT_EQ(may_heal, passes) << answer;
    EXPECT_THAT(transport.error().message, AllOf(HasSubstr(words), Not(HasSubstr("hunter2"))));
  }
}

// A reverse proxy whose broker is down, or a path that it does not know.
TEST(HttpProxy, MayPassBeforeWebSocketsToo) {
  for (const std::string status : {"502", "504", "404", "401"}) {
    const BrokenBroker server(BrokenBroker::AnswersAndCloses(
        {"HTTP/1.1 " + status + " No\r\nContent-Length: 0\r\n\r\n"}));
    bool may_heal = status.front() != '5';
    const auto transport = ConnectPaho(To(server.Url("ws")), &may_heal);
    ASSERT_FALSE(transport);
    EXPECT_THAT(transport.error().message, HasSubstr("HTTP status " + status));
    EXPECT_EQ(may_heal, status.front() == '5') << status;
  }
}

TEST(HttpProxy, IsNotWaitedForForever) {
  FLEETPUB_NEEDS_FAST_CONNECT();
  const BrokenBroker proxy(BrokenBroker::Silent());
  ConnectOptions options = To("mqtt://broker.invalid:1883");
  options.proxy = "http://127.0.0.1:" + std::to_string(proxy.port());
  options.connect_timeout = std::chrono::milliseconds(100);
  EXPECT_THAT(Refusal(options).message, HasSubstr("no answer"));
}

}  // namespace
}  // namespace fleetpub::mqtt
