#include "app/fleet_discovery.h"

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
    request_.discover.quiet = std::chrono::milliseconds(1);
    world_.on_connect = [](testing::FakeTransport& broker) {
      broker.retained["vda5050/v3/KIT/0001/connection"] =
          R"({"headerId":1,"timestamp":"2026-01-02T03:04:05.678Z","version":"3.0.0",)"
          R"("manufacturer":"KIT","serialNumber":"0001","connectionState":"ONLINE"})";
    };
  }

  testing::FakeEnvironment world_;
  testing::FakeLog log_;
  FleetRequest request_;
};

TEST_F(DiscoveringFleets, FindsWhoIsThereAndWarnsOfTheSilent) {
  request_.state_wait = std::chrono::milliseconds(1);
  const auto fleet = DiscoverFleet(request_, world_.Get(), log_);
  ASSERT_TRUE(fleet);
  EXPECT_EQ(fleet->size(), 1U);
  EXPECT_THAT(log_.warnings, ElementsAre(HasSubstr("1 of 1 robots")));
}

TEST_F(DiscoveringFleets, AsksForConfiguredOnesByNameWhereWildcardsBringNothing) {
  const auto on_connect = world_.on_connect;
  world_.on_connect = [&](testing::FakeTransport& broker) {
    on_connect(broker);
    broker.exact_retained.swap(broker.retained);
  };
  EXPECT_FALSE(DiscoverFleet(request_, world_.Get(), log_));
  world_.config.robots[{"KIT", "0001"}];
  const auto fleet = DiscoverFleet(request_, world_.Get(), log_);
  ASSERT_TRUE(fleet);
  EXPECT_TRUE(fleet->robots().front()->IsOnline());
  EXPECT_THAT(log_.warnings, ElementsAre(HasSubstr("wildcards")));
}

TEST_F(DiscoveringFleets, FailsWhenNoSuchRobotIsKnown) {
  request_.words = {"ACME/*"};
  const auto fleet = DiscoverFleet(request_, world_.Get(), log_);
  ASSERT_FALSE(fleet);
  EXPECT_EQ(fleet.error().kind, ErrorKind::kPreflight);
  EXPECT_THAT(fleet.error().message, HasSubstr("ACME/*"));
}

TEST_F(DiscoveringFleets, ConnectsForNoMisspeltWord) {
  request_.words = {"@hall"};
  EXPECT_FALSE(DiscoverFleet(request_, world_.Get(), log_));
  EXPECT_EQ(world_.connections, 0);
}

/// Has enough after some looks.
class Display final : public FleetDisplay {
 public:
  explicit Display(std::vector<std::string>& seen) : seen_(seen) {}

  void Changed(const vda5050::RobotView& robot) override {
    seen_.push_back(robot.robot.ToString());
  }
  void Lost(const Error& error) override { seen_.push_back(error.message); }
  void ConnectedAgain() override { seen_.emplace_back("again"); }
  Result<bool> Refresh(const vda5050::FleetView& view) override {
    seen_.push_back(std::to_string(view.size()));
    return false;
  }

 private:
  std::vector<std::string>& seen_;
};

TEST_F(DiscoveringFleets, WatchesUntilThePersonHasSeenEnough) {
  std::vector<std::string> seen;
  std::string at;
  const auto make_display = [&](const mqtt::BrokerUrl& broker) {
    at = broker.host;
    return std::make_unique<Display>(seen);
  };
  EXPECT_TRUE(WatchFleet(request_, mqtt::Deadline::max(), world_.Get(), make_display, log_));
  EXPECT_THAT(seen, ElementsAre("KIT/0001", "1"));
  EXPECT_EQ(at, "broker");
}

TEST_F(DiscoveringFleets, TakesNoScreenWithoutAConnection) {
  world_.connect_error = Error{ErrorKind::kBroker, "broker: refused"};
  bool is_made = false;
  const auto make_display = [&](const mqtt::BrokerUrl& /*broker*/) {
    is_made = true;
    return nullptr;
  };
  EXPECT_FALSE(WatchFleet(request_, mqtt::Deadline::max(), world_.Get(), make_display, log_));
  EXPECT_FALSE(is_made);
}

}  // namespace
}  // namespace fleetpub::app
