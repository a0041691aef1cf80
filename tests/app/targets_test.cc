#include "app/targets.h"

#include <gmock/gmock.h>

#include "support/fake_observer.h"

namespace fleetpub::app {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using vda5050::RobotAddress;

class ResolvingTargets : public ::testing::Test {
 protected:
  ResolvingTargets() {
    config_.aliases["tug"] = RobotAddress{"KIT", "0007"};
    config_.groups["hall"] = {};
    config_.group_robots["hall"] = {RobotAddress{"KIT", "0001"}, RobotAddress{"KIT", "0002"}};
  }

  Result<Targets> Resolve(std::vector<std::string> words, std::vector<std::string> except = {}) {
    TargetRequest request;
    request.words = std::move(words);
    request.except = std::move(except);
    return ResolveTargets(std::move(request), config_, log_);
  }

  config::Config config_;
  testing::FakeLog log_;
};

TEST_F(ResolvingTargets, TakesAddressesAliasesAndGroupsInTheirOrder) {
  const auto targets = Resolve({"tug", "@hall", "ACME/x"});
  ASSERT_TRUE(targets);
  EXPECT_THAT(targets->include.robots,
              ElementsAre(RobotAddress{"KIT", "0007"}, RobotAddress{"KIT", "0001"},
                          RobotAddress{"KIT", "0002"}, RobotAddress{"ACME", "x"}));
  EXPECT_TRUE(targets->IsSet());
  EXPECT_FALSE(targets->AreFound());
}

TEST_F(ResolvingTargets, LeavesPatternsToTheBroker) {
  const auto targets = Resolve({"KIT/*"});
  ASSERT_TRUE(targets);
  EXPECT_THAT(targets->include.patterns, SizeIs(1));
  EXPECT_EQ(targets->include.set, "KIT/*");
  EXPECT_TRUE(targets->AreFound());
}

TEST_F(ResolvingTargets, CountsARobotOnce) {
  const auto targets = Resolve({"KIT/0007", "tug"});
  ASSERT_TRUE(targets);
  EXPECT_THAT(targets->include.robots, SizeIs(1));
  EXPECT_THAT(log_.warnings, ElementsAre(HasSubstr("KIT/0007")));
}

TEST_F(ResolvingTargets, TakesOutWhatIsExcepted) {
  const auto targets = Resolve({"@hall"}, {"KIT/0002"});
  ASSERT_TRUE(targets);
  EXPECT_THAT(targets->include.robots, ElementsAre(RobotAddress{"KIT", "0001"}));
  EXPECT_THAT(log_.warnings, IsEmpty());
  EXPECT_FALSE(Resolve({"tug"}, {"KIT/*"})) << "nobody is left";
}

TEST_F(ResolvingTargets, WarnsOfAnExceptionThatIsNoTarget) {
  ASSERT_TRUE(Resolve({"@hall"}, {"tug"}));
  EXPECT_THAT(log_.warnings, ElementsAre(HasSubstr("KIT/0007")));
}

TEST_F(ResolvingTargets, SuggestsWhatWasPerhapsMeant) {
  const auto group = Resolve({"@hal"});
  ASSERT_FALSE(group);
  EXPECT_EQ(group.error().kind, ErrorKind::kUsage);
  EXPECT_THAT(group.error().message, HasSubstr("@hall"));
  const auto alias = Resolve({"tugg"});
  ASSERT_FALSE(alias);
  EXPECT_THAT(alias.error().message, HasSubstr("did you mean tug?"));
}

TEST_F(ResolvingTargets, RefusesNoTargetAtAll) { EXPECT_FALSE(Resolve({})); }

TEST_F(ResolvingTargets, TakesAllOnlyAlone) {
  TargetRequest request;
  request.all = true;
  const auto targets = ResolveTargets(std::move(request), config_, log_);
  ASSERT_TRUE(targets);
  EXPECT_TRUE(targets->include.patterns.front().Matches({"any", "body"}));
  TargetRequest both;
  both.all = true;
  both.words = {"KIT/0001"};
  EXPECT_FALSE(ResolveTargets(std::move(both), config_, log_));
}

TEST_F(ResolvingTargets, NamesOneRobotNotAGroup) {
  EXPECT_EQ(ResolveRobot("tug", config_), (RobotAddress{"KIT", "0007"}));
  EXPECT_FALSE(ResolveRobot("@hall", config_));
  EXPECT_FALSE(ResolveRobots({"KIT/*"}, config_, log_));
}

TEST(RobotList, MarksNamesWithUnusualCharactersFirst) {
  const std::vector<RobotAddress> robots = {RobotAddress{"KIT", "0001"},
                                            RobotAddress{"KIT", "\xD0\x90"}};
  EXPECT_THAT(FormatRobotList(robots), AllOf(HasSubstr("U+0410"), HasSubstr(", KIT/0001")));
}

TEST(RobotList, NamesTwentyAtMost) {
  const std::vector<RobotAddress> robots(23, RobotAddress{"KIT", "0001"});
  EXPECT_THAT(FormatRobotList(robots), HasSubstr("3 more"));
}

TEST(Consent, IsAskedUnlessTheActionStopsOrAsks) {
  EXPECT_EQ(DecideConsent("startPause"), NeedsConsent::kNo);
  EXPECT_EQ(DecideConsent("stateRequest"), NeedsConsent::kNo);
  EXPECT_EQ(DecideConsent("stopPause"), NeedsConsent::kYes);
}

}  // namespace
}  // namespace fleetpub::app
