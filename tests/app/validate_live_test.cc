#include "app/validate_live.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "support/fake_environment.h"
#include "support/fake_observer.h"

namespace fleetpub::app {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Remembers what was found: `v ` and the violations, `w ` and the warnings.
class Reader final : public LiveObserver {
 public:
  std::vector<std::string> found;
  bool goes_on = true;
  std::function<void()> glance;

  void Begin() override {}
  void Checked(const mqtt::Message& message, const vda5050::ValidationResult& result) override {
    for (const auto& violation : result.findings.errors) {
      found.push_back(fmt::format("v {} {}", message.topic, violation.path));
    }
    for (const auto& warning : result.findings.warnings) {
      found.push_back(fmt::format("w {} {}", message.topic, warning.path));
    }
  }
  Result<bool> GoesOn() override {
    if (glance) glance();
    return goes_on;
  }
};

class ValidatingLive : public ::testing::Test {
 protected:
  ValidatingLive() {
    request_.end = steady_clock::now() + milliseconds(20);
    world_.on_connect = [this](testing::FakeTransport& broker) {
      broker.retained = retained_;
      broker.arriving = arriving_;
    };
  }

  static std::string Connection(std::string_view state) {
    return fmt::format(R"({{"headerId":17,"timestamp":"2026-01-02T03:04:05.678Z",)"
                       R"("version":"3.0.0","manufacturer":"KIT","serialNumber":"0001",)"
                       R"("connectionState":"{}"}})",
                       state);
  }
  static std::string Topic(std::string_view name) {
    return fmt::format("vda5050/v3/KIT/0001/{}", name);
  }

  Result<LiveSummary> Validate() {
    return ValidateLive(std::exchange(request_, {}), world_.Get(), reader_, log_);
  }

  std::map<std::string, std::string> retained_;
  std::deque<mqtt::Message> arriving_;
  testing::FakeEnvironment world_;
  testing::FakeLog log_;
  Reader reader_;
  LiveRequest request_;
};

TEST_F(ValidatingLive, CountsByTopicAndTellsViolations) {
  retained_[Topic("connection")] = Connection("AWAY");
  arriving_ = {{.topic = Topic("factsheet"), .payload = "{"},
               {.topic = Topic("connection"), .payload = Connection("ONLINE")}};
  request_.end = mqtt::Deadline::max();
  request_.count = 3;
  const auto summary = Validate();
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->all.messages, 3U);
  EXPECT_EQ(summary->all.invalid, 2U);
  EXPECT_EQ(summary->by_topic.at("connection").invalid, 1U);
  EXPECT_THAT(reader_.found, ElementsAre("v vda5050/v3/KIT/0001/connection /connectionState",
                                         "v vda5050/v3/KIT/0001/factsheet "));
}

TEST_F(ValidatingLive, KeepsToTheRobotsThatAreMeant) {
  for (const char* serial : {"0001", "0002", "0003"}) {
    const std::string topic = fmt::format("vda5050/v3/KIT/{}/", serial);
    const bool is_online = std::string_view(serial) != "0002";
    retained_[topic + "connection"] = fmt::format(R"({{"version":"3.0.0","connectionState":"{}"}})",
                                                  is_online ? "ONLINE" : "OFFLINE");
    arriving_.push_back({.topic = topic + "order", .payload = "{"});
  }
  const auto orders = [&](const auto& choose) {
    request_.conformance.topic = "order";
    request_.end = steady_clock::now() + milliseconds(20);
    choose(request_.robots.targets);
    reader_.found.clear();
    const auto summary = Validate();
    if (!summary) return summary.error().message;
    std::string serials;
    for (const std::string& found : reader_.found) serials += found.substr(20, 1);
    return serials;
  };
  EXPECT_EQ(orders([](TargetRequest&) {}), "123");
  EXPECT_EQ(orders([](TargetRequest& r) { r.words = {"KIT/0001", "KIT/0002"}; }), "12");
  EXPECT_EQ(orders([](TargetRequest& r) { r.except = {"KIT/0001"}; }), "23");
  EXPECT_EQ(orders([](TargetRequest& r) { r.online = true; }), "13");
}

TEST_F(ValidatingLive, EndsAfterSoManyMessages) {
  request_.end = mqtt::Deadline::max();
  request_.count = 2;
  arriving_.assign(5, {.topic = Topic("connection"), .payload = Connection("ONLINE")});
  EXPECT_EQ(Validate()->all.messages, 2U);
}

TEST_F(ValidatingLive, EndsWhenTheReaderHasEnough) {
  request_.end = mqtt::Deadline::max();
  reader_.goes_on = false;
  EXPECT_EQ(Validate()->all.messages, 0U);
}

TEST_F(ValidatingLive, ReportsTheMissingConnectionOfARobotThatSendsStatesOnce) {
  arriving_.assign(3, {.topic = Topic("state"), .payload = "{}"});
  const auto summary = Validate();
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->without_connection, 1U);
  EXPECT_THAT(reader_.found, Contains("w vda5050/v3/KIT/0001/connection ").Times(1));
  EXPECT_EQ(summary->all.messages, 3U) << "what is missing is no message";
}

TEST_F(ValidatingLive, MakesItAViolationForTheStrict) {
  request_.conformance.strict = true;
  arriving_ = {{.topic = Topic("state"), .payload = "{}"}};
  EXPECT_TRUE(Validate());
  EXPECT_THAT(reader_.found, Contains("v vda5050/v3/KIT/0001/connection "));
}

TEST_F(ValidatingLive, AsksOutrightForWhatWildcardsDoNotFind) {
  world_.on_connect = [this](testing::FakeTransport& broker) {
    broker.exact_retained[Topic("connection")] = Connection("ONLINE");
    broker.arriving = arriving_;
  };
  arriving_ = {{.topic = Topic("state"), .payload = "{}"}};
  const auto summary = Validate();
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->without_connection, 0U);
  EXPECT_EQ(summary->by_topic.at("connection").messages, 1U);
}

// By a template without wildcards they are asked for by the topics that are listened to.
TEST_F(ValidatingLive, GoesOnListeningToThoseItHasAskedFor) {
  request_.conformance.scheme.topic_template = "site/{manufacturer}/{serial}/{topic}";
  request_.robots.targets.words = {"KIT/0001"};
  arriving_ = {{.topic = "site/KIT/0001/state", .payload = "{}"}};
  testing::FakeTransport* broker = nullptr;
  world_.on_connect = [&](testing::FakeTransport& opened) {
    broker = &opened;
    broker->arriving = arriving_;
  };
  std::set<std::string> subscribed;
  reader_.glance = [&] { subscribed = broker->subscribed(); };
  EXPECT_EQ(Validate()->without_connection, 1U);
  EXPECT_THAT(subscribed, Contains("site/KIT/0001/connection"));
}

TEST_F(ValidatingLive, AsksNothingOfRetainedStatesOrOneTopicAlone) {
  retained_[Topic("state")] = "{}";
  EXPECT_EQ(Validate()->without_connection, 0U);
  retained_.clear();
  arriving_ = {{.topic = Topic("state"), .payload = "{}"}};
  request_.end = steady_clock::now() + milliseconds(20);
  request_.conformance.topic = "state";
  EXPECT_EQ(Validate()->without_connection, 0U);
}

TEST_F(ValidatingLive, RefusesATopicThatIsNoneBeforeItConnects) {
  request_.conformance.topic = "status";
  EXPECT_FALSE(Validate());
  EXPECT_EQ(world_.connections, 0);
  EXPECT_THAT(log_.warnings, IsEmpty());
}

}  // namespace
}  // namespace fleetpub::app
