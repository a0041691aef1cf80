#include "app/dialect_resolver.h"

#include <gmock/gmock.h>

namespace fleetpub::app {
namespace {

using ::testing::SizeIs;
using vda5050::Version;

const vda5050::RobotAddress kTug{"KIT", "0007"};

config::Config WithTug(const std::string& key, const std::string& value) {
  config::Config config;
  config::ConfigValue text;
  text.texts = {value};
  config.robots[kTug].settings[key] = text;
  return config;
}

TEST(DialectResolver, AssumesTheNewestVersionUntilTheRobotSaysItsOwn) {
  const config::Config config;
  const auto resolver = DialectResolver::Make({}, config);
  ASSERT_TRUE(resolver);
  const auto named = resolver->Resolve(kTug);
  ASSERT_TRUE(named);
  EXPECT_EQ(named->dialect->version, Version::k300);
  EXPECT_TRUE(named->dialect->assumed);
  EXPECT_TRUE(named->automatic);
}

TEST(DialectResolver, SpeaksAsTheRobotsTableSays) {
  const config::Config config = WithTug("vda", "2.0.0");
  const auto resolver = DialectResolver::Make({}, config);
  ASSERT_TRUE(resolver);
  EXPECT_EQ(resolver->Resolve(kTug)->dialect->version, Version::k200);
  EXPECT_FALSE(resolver->Resolve(kTug)->automatic);
  EXPECT_EQ(resolver->Resolve({"KIT", "0001"})->dialect->version, Version::k300);
}

TEST(DialectResolver, PrefersWhatWasSaidToTheTable) {
  const config::Config config = WithTug("vda", "2.0.0");
  const auto resolver = DialectResolver::Make({.version = "2.1.0"}, config);
  ASSERT_TRUE(resolver);
  EXPECT_EQ(resolver->Resolve(kTug)->dialect->version, Version::k210);
}

TEST(DialectResolver, TakesTheMessagesVersionWhereNobodyStatesOne) {
  const config::Config config = WithTug("vda", "2.0.0");
  auto resolver = DialectResolver::Make({}, config);
  ASSERT_TRUE(resolver);
  resolver->Assume(Version::k110);
  EXPECT_EQ(resolver->Resolve({"KIT", "0001"})->dialect->version, Version::k110);
  EXPECT_FALSE(resolver->common().assumed);
  EXPECT_EQ(resolver->Resolve(kTug)->dialect->version, Version::k200);
}

TEST(DialectResolver, KnowsEachShapeOfTopicsOnce) {
  const config::Config config = WithTug("interface", "own");
  const auto resolver = DialectResolver::Make({}, config);
  ASSERT_TRUE(resolver);
  const auto schemes = resolver->Schemes();
  ASSERT_TRUE(schemes);
  EXPECT_THAT(*schemes, SizeIs(2));
}

TEST(DialectResolver, RefusesWhatIsNoVersion) {
  const config::Config config;
  EXPECT_FALSE(DialectResolver::Make({.version = "4"}, config));
  EXPECT_FALSE(DialectResolver::Make({.actions_key = "action"}, config));
  EXPECT_FALSE(DialectResolver::Make({.header_serial = "\xFF"}, config));
}

}  // namespace
}  // namespace fleetpub::app
