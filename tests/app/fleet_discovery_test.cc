#include "app/fleet_discovery.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "support/fake_environment.h"
#include "support/fake_observer.h"

namespace fleetpub::app {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class DiscoveringFleets : public ::testing::Test {
 protected:
  DiscoveringFleets() {
    request_.discover.quiet = std::chrono::milliseconds(50);
    world_.on_connect = [](testing::FakeTransport& broker) {
      broker.retained["vda5050/v3/KIT/0001/connection"] =
          R"({"headerId":1,"timestamp":"2026-01-02T03:04:05.678Z","version":"3.0.0",)"
          R"("manufacturer":"KIT","serialNumber":"0001","connectionState":"ONLINE"})";
    };
  }

  Result<Fleet> Discover() {
    return DiscoverFleet(std::exchange(request_, {}), world_.Get(), {}, log_);
  }

  testing::FakeEnvironment world_;
  testing::FakeLog log_;
  FleetRequest request_;
};

TEST_F(DiscoveringFleets, FindsWhoIsThereAndWarnsOfTheSilent) {
  request_.targets.state_wait = std::chrono::milliseconds(1);
  const auto fleet = Discover();
  ASSERT_TRUE(fleet);
  EXPECT_EQ(fleet->robots().size(), 1U);
  EXPECT_THAT(log_.warnings, ElementsAre(HasSubstr("1 of 1 robot")));
}

TEST_F(DiscoveringFleets, AsksForConfiguredOnesByNameWhereWildcardsBringNothing) {
  const auto on_connect = world_.on_connect;
  world_.on_connect = [&](testing::FakeTransport& broker) {
    on_connect(broker);
    broker.exact_retained.swap(broker.retained);
  };
  EXPECT_FALSE(Discover());
  world_.config.robots[{"KIT", "0001"}];
  const auto fleet = Discover();
  ASSERT_TRUE(fleet);
  EXPECT_TRUE(fleet->robots().front()->second.IsOnline());
  EXPECT_THAT(log_.warnings, ElementsAre(HasSubstr("wildcards")));
}

// Of many that are named, discovery ends the subscriptions.
TEST_F(DiscoveringFleets, HearsTheAnswersOfAllThatAreNamedAndAsked) {
  for (const int count : {100, 200, 300}) {
    world_.on_connect = [&](testing::FakeTransport& broker) {
      for (int i = 0; i < count; ++i) {
        broker.retained[fmt::format("vda5050/v3/KIT/{}/connection", i)] =
            R"({"version":"3.0.0","connectionState":"ONLINE"})";
      }
      broker.answers = [](const mqtt::Message& request) -> std::vector<mqtt::Message> {
        const std::string place = request.topic.substr(0, request.topic.rfind('/'));
        return {{.topic = place + "/state", .payload = R"({"version":"3.0.0"})"}};
      };
    };
    request_.ask = true;
    request_.targets.state_wait = std::chrono::milliseconds(500);
    for (int i = 0; i < count; ++i) request_.targets.words.push_back(fmt::format("KIT/{}", i));
    const auto fleet = Discover();
    ASSERT_TRUE(fleet);
    const auto robots = fleet->robots();
    EXPECT_EQ(std::count_if(robots.begin(), robots.end(),
                            [](const ListedRobot* robot) { return robot->second.HasSpoken(); }),
              count);
  }
}

TEST_F(DiscoveringFleets, FailsWhenNoSuchRobotIsKnown) {
  request_.targets.words = {"ACME/*"};
  const auto fleet = Discover();
  ASSERT_FALSE(fleet);
  EXPECT_EQ(fleet.error().kind, ErrorKind::kPreflight);
  EXPECT_THAT(fleet.error().message, HasSubstr("ACME/*"));
}

TEST_F(DiscoveringFleets, ShowsWhomTheOptionsMean) {
  world_.on_connect = [](testing::FakeTransport& broker) {
    const auto leave = [&](const std::string& serial, const std::string& state) {
      broker.retained["vda5050/v3/KIT/" + serial + "/connection"] =
          R"({"version":"3.0.0","connectionState":")" + state + "\"}";
    };
    leave("1", "ONLINE");
    leave("2", "OFFLINE");
    leave("3", "CONNECTION_BROKEN");
    leave("4", "ONLINE");
  };
  const auto discover = [&](const auto& change) {
    FleetRequest request;
    request.discover.quiet = std::chrono::milliseconds(50);
    change(request);
    std::string names;
    const auto fleet = DiscoverFleet(std::move(request), world_.Get(), {}, log_);
    if (!fleet) return fleet.error().message;
    for (const ListedRobot* robot : fleet->robots()) names += robot->first.serial_number;
    return names;
  };
  EXPECT_EQ(discover([](FleetRequest&) {}), "1234");
  EXPECT_EQ(discover([](FleetRequest& r) { r.targets.online = true; }), "14");
  EXPECT_EQ(discover([](FleetRequest& r) { r.problems = true; }), "3");
  EXPECT_EQ(discover([](FleetRequest& r) { r.targets.except = {"KIT/2"}; }), "134");
  EXPECT_EQ(discover([](FleetRequest& r) { r.targets.words = {"KIT/3", "KIT/4"}; }), "34");
  EXPECT_EQ(discover([](FleetRequest& r) {
              r.targets.where.push_back(*vda5050::ParseCondition("connectionState=OFFLINE"));
            }),
            "2");
}

TEST_F(DiscoveringFleets, ConnectsForNoMisspeltWord) {
  request_.targets.words = {"@hall"};
  EXPECT_FALSE(Discover());
  EXPECT_EQ(world_.connections, 0);
}

/// Has enough after some looks.
class Display final : public FleetDisplay {
 public:
  explicit Display(std::vector<std::string>& seen) : seen_(seen) {}

  void Changed(const ListedRobot& robot) override { seen_.push_back(robot.first.ToString()); }
  void Lost(const Error& error) override { seen_.push_back(error.message); }
  void ConnectedAgain() override { seen_.emplace_back("again"); }
  Result<bool> Refresh(const Fleet& fleet) override {
    seen_.push_back(std::to_string(fleet.robots().size()));
    return false;
  }

 private:
  std::vector<std::string>& seen_;
};

TEST_F(DiscoveringFleets, WatchesUntilThePersonHasSeenEnough) {
  std::vector<std::string> seen;
  std::string at;
  const auto make_display = [&](const mqtt::BrokerUrl& broker, const Fleet& /*fleet*/,
                                const AskHook& /*ask*/) {
    at = broker.host;
    return std::make_unique<Display>(seen);
  };
  EXPECT_TRUE(
      WatchFleet(std::move(request_), mqtt::Deadline::max(), world_.Get(), make_display, log_));
  EXPECT_THAT(seen, ElementsAre("KIT/0001", "1"));
  EXPECT_EQ(at, "broker");
}

TEST_F(DiscoveringFleets, TakesNoScreenWithoutAConnection) {
  world_.connect_error = Error{ErrorKind::kBroker, "broker: refused"};
  bool is_made = false;
  const auto make_display = [&](const mqtt::BrokerUrl& /*broker*/, const Fleet& /*fleet*/,
                                const AskHook& /*ask*/) {
    is_made = true;
    return nullptr;
  };
  EXPECT_FALSE(
      WatchFleet(std::move(request_), mqtt::Deadline::max(), world_.Get(), make_display, log_));
  EXPECT_FALSE(is_made);
}

}  // namespace
}  // namespace fleetpub::app
