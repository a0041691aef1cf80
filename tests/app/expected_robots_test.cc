#include "app/expected_robots.h"

#include <gmock/gmock.h>

#include "support/fake_environment.h"
#include "support/fake_observer.h"

namespace fleetpub::app {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using vda5050::RobotAddress;

class ExpectedRobots : public ::testing::Test {
 protected:
  ExpectedRobots() { broker_.host = "north"; }

  void Commanded(const std::string& target, const std::string& host) {
    mqtt::BrokerUrl broker;
    broker.host = host;
    ledger::Draft draft;
    draft.topic = target;
    draft.target = target;
    draft.protocol = "vda5050";
    draft.broker = broker.ToString();
    drafts_.push_back(draft);
  }

  std::vector<ExpectedRobot> Find() {
    Environment environment = world_.Get();
    environment.ledger = [this](ledger::OpenMode) -> Result<std::unique_ptr<ledger::Ledger>> {
      auto ledger = std::make_unique<testing::FakeLedger>(world_.journal);
      for (const ledger::Draft& draft : drafts_) {
        const auto lock = ledger->Lock(std::span(&draft.topic, 1), ledger::Deadline::max());
        EXPECT_TRUE(ledger->Reserve(std::span(&draft, 1)));
      }
      return ledger;
    };
    return FindExpectedRobots(environment, {.broker = broker_},
                              [](const RobotAddress& robot) -> std::optional<vda5050::TopicScheme> {
                                if (robot.manufacturer != "KIT") return std::nullopt;
                                return vda5050::TopicScheme();
                              });
  }

  testing::FakeEnvironment world_;
  mqtt::BrokerUrl broker_;
  std::vector<ledger::Draft> drafts_;
};

TEST_F(ExpectedRobots, AreConfiguredOrWereCommandedHere) {
  world_.config.robots[{"KIT", "0002"}];
  world_.config.group_robots["hall"] = {{"KIT", "0003"}, {"ACME", "0001"}};
  Commanded("KIT/0001", "north");
  Commanded("KIT/0003", "north");
  Commanded("KIT/0009", "south");
  const auto found = Find();
  ASSERT_THAT(found, SizeIs(3));
  EXPECT_EQ(found[0].robot, (RobotAddress{"KIT", "0001"}));
  EXPECT_TRUE(found[0].was_commanded);
  EXPECT_FALSE(found[1].was_commanded);
  EXPECT_TRUE(found[2].was_commanded);
}

TEST_F(ExpectedRobots, AreMissedOnlyWhenTheyWereCommanded) {
  world_.config.robots[{"KIT", "0002"}];
  Commanded("KIT/0001", "north");
  Commanded("KIT/0003", "north");
  testing::FakeLog log;
  const auto unheard =
      FindUnheard(Find(), [](const RobotAddress& robot) { return robot.serial_number == "0003"; });
  WarnOfUnheard(unheard, log);
  EXPECT_THAT(log.warnings, ElementsAre(HasSubstr("KIT/0001")));
}

TEST_F(ExpectedRobots, AreAskedByNameWhereTheyAreFewOrSomeAreLeftOut) {
  for (int i = 0; i < 4; ++i) world_.config.robots[{"KIT", std::to_string(i)}];
  EXPECT_TRUE(AreAskedByName(Find(), false));
  for (int i = 4; i < 40; ++i) world_.config.robots[{"KIT", std::to_string(i)}];
  EXPECT_FALSE(AreAskedByName(Find(), false));
  EXPECT_TRUE(AreAskedByName(Find(), true));
  EXPECT_FALSE(AreAskedByName({}, true));
}

TEST_F(ExpectedRobots, AreNoneWhereNobodyNamesAny) { EXPECT_THAT(Find(), IsEmpty()); }

}  // namespace
}  // namespace fleetpub::app
