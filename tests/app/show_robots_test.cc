#include "app/show_robots.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "support/fake_environment.h"
#include "support/fake_observer.h"

namespace fleetpub::app {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

std::string Header(std::string_view serial_number) {
  return fmt::format(R"("headerId":1,"timestamp":"2026-01-02T03:04:05.678Z","version":"2.1.0",)"
                     R"("manufacturer":"KIT","serialNumber":"{}")",
                     serial_number);
}

class ShowingRobots : public ::testing::Test {
 protected:
  ShowingRobots() {
    world_.on_connect = [this](testing::FakeTransport& broker) { broker.retained = retained_; };
    Leave("1", "connection", R"("connectionState":"ONLINE")");
  }

  void Leave(std::string_view serial_number, std::string_view topic, std::string_view members) {
    retained_[fmt::format("uagv/v2/KIT/{}/{}", serial_number, topic)] =
        fmt::format("{{{},{}}}", Header(serial_number), members);
  }
  void LeaveActions(std::string_view type) {
    Leave("1", "factsheet",
          fmt::format(R"("protocolFeatures":{{"agvActions":[{{"actionType":"{}",)"
                      R"("actionScopes":["INSTANT"]}}]}})",
                      type));
  }

  Result<ShownRobots> Show(const std::vector<std::string>& words, bool ask = true) {
    auto environment = world_.Get();
    if (ledger_error_) {
      environment.ledger = [this](ledger::OpenMode) -> Result<std::unique_ptr<ledger::Ledger>> {
        return Fail(*ledger_error_);
      };
    }
    auto targets = ResolveTargets(
        {.words = words, .except = {}, .where = {}, .state_wait = std::chrono::milliseconds(5)},
        world_.config, log_);
    return ShowRobots({.targets = *std::move(targets),
                       .resolver = *DialectResolver::Make({}, world_.config),
                       .ask = ask,
                       .discover = {.quiet = std::chrono::milliseconds(50)}},
                      environment, log_);
  }

  testing::FakeEnvironment world_;
  testing::FakeLog log_;
  std::map<std::string, std::string> retained_;
  std::optional<Error> ledger_error_;
};

constexpr const char* kAsked = "publish uagv/v2/KIT/1/instantActions";

TEST_F(ShowingRobots, AsksWhoIsThereForItsState) {
  const auto shown = Show({"KIT/1"});
  ASSERT_TRUE(shown);
  ASSERT_THAT(shown->sheets, SizeIs(1));
  EXPECT_EQ(shown->sheets[0].version, vda5050::Version::k210);
  EXPECT_FALSE(shown->sheets[0].state);
  EXPECT_THAT(world_.journal.entries(), Contains(kAsked));
  EXPECT_THAT(world_.journal.entries(), Contains(HasSubstr("reserve 1"))) << "recorded before";
  EXPECT_THAT(log_.warnings, IsEmpty());
}

TEST_F(ShowingRobots, AsksNobodyWhoIsNotToBeAsked) {
  ASSERT_TRUE(Show({"KIT/1"}, false));
  LeaveActions("beep");
  ASSERT_TRUE(Show({"KIT/1"}));
  Leave("1", "connection", R"("connectionState":"OFFLINE")");
  LeaveActions("stateRequest");
  ASSERT_TRUE(Show({"KIT/1"}));
  EXPECT_THAT(world_.journal.entries(), Not(Contains(HasSubstr("publish"))));
  Leave("1", "connection", R"("connectionState":"ONLINE")");
  ASSERT_TRUE(Show({"KIT/1"}));
  EXPECT_THAT(world_.journal.entries(), Contains(kAsked));
}

TEST_F(ShowingRobots, ShowsThemWithoutALedgerButAsksThemNothing) {
  ledger_error_ = {ErrorKind::kLedger, "the ledger is read-only"};
  const auto shown = Show({"KIT/1"});
  ASSERT_TRUE(shown);
  EXPECT_EQ(shown->sheets.at(0).commands_fault, "the ledger is read-only");
  EXPECT_THAT(world_.journal.entries(), Not(Contains(kAsked)));
  EXPECT_THAT(log_.warnings, Contains(HasSubstr("read-only")));
}

TEST_F(ShowingRobots, TakesTheLiveStateAndKeepsTheMessagesAsTheyWere) {
  Leave("1", "state", R"("operatingMode":"MANUAL")");
  const auto on_connect = world_.on_connect;
  world_.on_connect = [&](testing::FakeTransport& broker) {
    on_connect(broker);
    broker.arrives_behind = 2;
    broker.arriving = {{.topic = "uagv/v2/KIT/1/state",
                        .payload = "{" + Header("1") + R"(,"paused":true,"own":7})"}};
  };
  const auto shown = Show({"KIT/1"});
  ASSERT_TRUE(shown);
  const RobotSheet& sheet = shown->sheets.at(0);
  ASSERT_TRUE(sheet.state);
  EXPECT_FALSE(sheet.state_is_retained);
  EXPECT_EQ(sheet.state->paused, true);
  EXPECT_THAT(sheet.state_json, HasSubstr(R"("own":7)"));
  EXPECT_THAT(sheet.connection_json, HasSubstr("ONLINE"));
}

TEST_F(ShowingRobots, ShowsTheRetainedStateOfARobotThatIsAwayAsThePast) {
  Leave("2", "connection", R"("connectionState":"OFFLINE")");
  Leave("2", "state", R"("operatingMode":"MANUAL")");
  LeaveActions("beep");
  Leave("2", "factsheet", R"("typeSpecification":{"seriesName":"S9"})");
  const auto shown = Show({"KIT/2"});
  ASSERT_TRUE(shown);
  const RobotSheet& sheet = shown->sheets.at(0);
  EXPECT_TRUE(sheet.state_is_retained);
  ASSERT_TRUE(sheet.factsheet);
  EXPECT_EQ(sheet.factsheet->specification.series, "S9");
}

TEST_F(ShowingRobots, NamesThoseThatTheBrokerDoesNotKnow) {
  const auto shown = Show({"KIT/1", "KIT/7"});
  ASSERT_TRUE(shown);
  EXPECT_THAT(shown->sheets, SizeIs(1));
  ASSERT_THAT(shown->unknown, SizeIs(1));
  EXPECT_EQ(shown->unknown[0].kind, ErrorKind::kPreflight);
  EXPECT_THAT(shown->unknown[0].message, HasSubstr("KIT/7"));
  const auto none = Show({"ACME/*"});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().kind, ErrorKind::kPreflight);
}

}  // namespace
}  // namespace fleetpub::app
