#include "mqtt/broker_url.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>

namespace fleetpub::mqtt {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

struct Good {
  std::string_view text;
  BrokerUrl url;
};

TEST(BrokerUrl, ReadsEveryForm) {
  const Good cases[] = {
      {"mqtt://localhost", {Scheme::kMqtt, "localhost", 1883, "", ""}},
      {"mqtts://b.example", {Scheme::kMqtts, "b.example", 8883, "", ""}},
      {"ws://b.example", {Scheme::kWs, "b.example", 80, "", ""}},
      {"wss://b.example", {Scheme::kWss, "b.example", 443, "", ""}},
      {"MQTT://B.example:1", {Scheme::kMqtt, "B.example", 1, "", ""}},
      {"mqtt://b:65535", {Scheme::kMqtt, "b", 65535, "", ""}},
      {"mqtt://b:01883/", {Scheme::kMqtt, "b", 1883, "", ""}},
      {"mqtt://10.0.0.1:1884", {Scheme::kMqtt, "10.0.0.1", 1884, "", ""}},
      {"mqtt://[::1]", {Scheme::kMqtt, "::1", 1883, "", ""}},
      {"mqtts://[2001:db8::7]:8884", {Scheme::kMqtts, "2001:db8::7", 8884, "", ""}},
      {"mqtt://[fe80::1%25eth0]:1883", {Scheme::kMqtt, "fe80::1%eth0", 1883, "", ""}},
      {"mqtt://operator@b", {Scheme::kMqtt, "b", 1883, "", "operator"}},
      {"mqtt://o%40site%3A1@b", {Scheme::kMqtt, "b", 1883, "", "o@site:1"}},
      {"mqtt://j%C3%BCrgen@b", {Scheme::kMqtt, "b", 1883, "", "j\xC3\xBCrgen"}},
      {"mqtt://100%25@b", {Scheme::kMqtt, "b", 1883, "", "100%"}},
      {"mqtt://%62roker", {Scheme::kMqtt, "broker", 1883, "", ""}},
      {"ws://b:8080/mqtt", {Scheme::kWs, "b", 8080, "/mqtt", ""}},
      {"wss://b/a%20b/c:d", {Scheme::kWss, "b", 443, "/a%20b/c:d", ""}},
  };
  for (const Good& good : cases) {
    const auto url = ParseBrokerUrl(good.text);
    ASSERT_TRUE(url) << good.text << ": " << url.error().message;
    EXPECT_EQ(*url, good.url) << good.text << " was read as " << url->ToString();
  }
}

struct Bad {
  std::string text;
  std::string_view says;
};

const std::vector<Bad> kBad = {
    {"", "is empty"},
    {std::string(5000, 'a'), "longer than"},
    {"mqtt://" + std::string(300, 'a'), "not a host name"},
    {"localhost", "write mqtt://localhost"},
    {"localhost:1883", "write mqtt://localhost:1883"},
    {"//localhost", "has no scheme"},
    {"tcp://b", "write mqtt://"},
    {"ssl://b", "write mqtts://"},
    {"https://b", "write wss://"},
    {"amqp://b", "scheme of the broker URL is not known"},
    {"://b", "scheme of the broker URL is not known"},
    {"mqtt://", "names no host"},
    {"mqtt://:1883", "names no host"},
    {"mqtt://a b", "contains a space"},
    {"mqtt://a\nb", "control character"},
    {std::string("mqtt://a\0b", 10), "control character"},
    {"mqtt://a\x7F", "control character"},
    {"mqtt://a\xFF", "not UTF-8"},
    {"mqtt://b\xC3\xBC", "not a host name"},
    {"mqtt://a%zz", "not a host name"},
    {"mqtt://a%00b", "not a host name"},
    {"mqtt://a%2", "not a host name"},
    {"mqtt://a,b", "not a host name"},
    {"mqtt://b:0", "1 to 65535"},
    {"mqtt://b:65536", "1 to 65535"},
    {"mqtt://b:+1", "1 to 65535"},
    {"mqtt://b:-1", "1 to 65535"},
    {"mqtt://b:", "1 to 65535"},
    {"mqtt://b:0x10", "1 to 65535"},
    {"mqtt://b:99999999999999999999", "1 to 65535"},
    {"mqtt://::1", "in brackets"},
    {"mqtt://::1:1883", "in brackets"},
    {"mqtt://[::1", "no proper brackets"},
    {"mqtt://[::1]1883", "no proper brackets"},
    {"mqtt://[]", "not an IPv6 address"},
    {"mqtt://[1.2.3.4]", "not an IPv6 address"},
    {"mqtt://[fe80::1%25]", "not an IPv6 address"},
    {"mqtt://[fe80::1%eth0]", "not an IPv6 address"},
    {"mqtt://b/path", "does not belong in an mqtt://"},
    {"mqtts://b/path", "does not belong in an mqtt://"},
    {"mqtt://b?x=1", "no query"},
    {"ws://b/p?x=1", "no query"},
    {"ws://b/p#f", "no fragment"},
    {"ws://b/%zz", "the path"},
    {"ws://b/<p>", "the path"},
    {"mqtt://@b", "without a user name"},
    {"mqtt://a@b@c", "%40"},
    {"mqtt://a/b@c", "%2F"},
    {"mqtt://a%zz@b", "bad percent escape"},
    {"mqtt://a%00@b", "bad percent escape"},
    {"mqtt://a%FF@b", "bad percent escape"},
    {"mqtt://a:@b", "carries no password"},
    {"mqtt://a:p@b", "carries no password"},
};

TEST(BrokerUrl, SaysWhatIsWrong) {
  for (const Bad& bad : kBad) {
    const auto url = ParseBrokerUrl(bad.text);
    ASSERT_FALSE(url) << bad.text << " was read as " << url->ToString();
    EXPECT_EQ(url.error().kind, ErrorKind::kUsage) << bad.text;
    EXPECT_THAT(url.error().message, HasSubstr(std::string(bad.says))) << bad.text;
    EXPECT_LT(url.error().message.size(), 500U) << bad.text;
  }
}

TEST(BrokerUrl, NeverRepeatsAPassword) {
  for (const std::string text :
       {"mqtt://user:hunter2@host", "mqtt://user:hunter2@", "mqtt://user:hun/hunter2@host",
        "mqtt://user:hunter2#@host", "mqtt://user:?hunter2@host:x", "mqtt://user:a@hunter2@host",
        "user:hunter2@host", "amqp://user:hunter2@host", "mqtt://:hunter2@host",
        "mqtt://u:hunter2@[::1", "hunter2://u:p@host", "mqtt:/user:hunter2@host",
        "mqtt://user:hunter2 @host", "ws://user:/hunter2@host/<"}) {
    const auto url = ParseBrokerUrl(text);
    ASSERT_FALSE(url) << text;
    EXPECT_THAT(url.error().message, Not(HasSubstr("hunter2"))) << text;
    EXPECT_THAT(url.error().detail, Not(HasSubstr("hunter2"))) << text;
  }
}

TEST(BrokerUrl, ShowsItselfWithoutTheUserName) {
  EXPECT_EQ(ParseBrokerUrl("mqtt://operator@b")->ToString(), "mqtt://b:1883");
  EXPECT_EQ(ParseBrokerUrl("wss://b/mqtt")->ToString(), "wss://b:443/mqtt");
  EXPECT_EQ(ParseBrokerUrl("mqtt://[::1]")->ToString(), "mqtt://[::1]:1883");
}

TEST(BrokerUrl, ReadsWhatItShows) {
  for (const std::string_view text :
       {"mqtt://b:1883", "mqtts://[fe80::1%25eth0]:1", "ws://b:80/a:b/%20"}) {
    EXPECT_EQ(ParseBrokerUrl(text)->ToString(), text);
  }
}

}  // namespace
}  // namespace fleetpub::mqtt
