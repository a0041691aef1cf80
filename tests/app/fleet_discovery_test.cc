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

}  // namespace
}  // namespace fleetpub::app
