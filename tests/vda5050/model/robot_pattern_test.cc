#include "vda5050/model/robot_pattern.h"

#include <gmock/gmock.h>

namespace fleetpub::vda5050 {
namespace {

using ::testing::Eq;
using ::testing::Optional;

bool Matches(std::string_view pattern, std::string_view robot) {
  return ParseRobotPattern(pattern).value().Matches(ParseRobotAddress(robot).value());
}

TEST(RobotPattern, MeansTheRobotsThatItDescribes) {
  const std::pair<const char*, const char*> cases[] = {
      {"KIT/0001", "KIT/0001"}, {"KIT/*", "KIT/0001"},     {"*/0001", "KIT/0001"},
      {"*/*", "KIT/0001"},      {"KIT/000?", "KIT/0001"},  {"K*T/*1", "KIT/0001"},
      {"K*/0*0*1", "KIT/0001"}, {"*/**", "KIT/1"},         {"?/1", "\xC3\xA4/1"},
      {"*?/1", "K\xC3\xA4/1"},  {"*IT*/*00*", "KIT/0001"},
  };
  for (const auto& [pattern, robot] : cases) EXPECT_TRUE(Matches(pattern, robot)) << pattern;
}

TEST(RobotPattern, MeansNoOther) {
  const std::pair<const char*, const char*> cases[] = {
      {"KIT/0001", "KIT/0002"}, {"KIT/0001", "kit/0001"}, {"KIT/000?", "KIT/000"},
      {"KIT/?", "KIT/0001"},    {"K*/*2", "KIT/0001"},    {"*I/*", "KIT/0001"},
      {"?\?/1", "\xC3\xA4/1"},
  };
  for (const auto& [pattern, robot] : cases) EXPECT_FALSE(Matches(pattern, robot)) << pattern;
}

TEST(RobotPattern, MeansARobotThatIsCalledLikeAPattern) {
  const RobotAddress star{"*", "?x"};
  const RobotPattern alone = RobotPattern::Of(star);
  EXPECT_TRUE(alone.Matches(star));
  EXPECT_FALSE(alone.Matches({"KIT", "0x"}));
  EXPECT_EQ(alone.Filter().manufacturer, "*");
  EXPECT_TRUE(ParseRobotPattern("%2A*/?%78")->Matches({"*KIT", "?x"}));
  EXPECT_FALSE(ParseRobotPattern("%2A*/*")->Matches({"KIT", "1"}));
}

TEST(RobotPattern, LetsTheBrokerSortOutWhatIsFixed) {
  const RobotFilter one = ParseRobotPattern("KIT/*")->Filter();
  EXPECT_THAT(one.manufacturer, Optional(Eq("KIT")));
  EXPECT_EQ(one.serial_number, std::nullopt);
  EXPECT_EQ(ParseRobotPattern("K?T/1")->Filter().manufacturer, std::nullopt);
}

TEST(RobotPattern, RefusesWhatNamesNoRobots) {
  for (const char* text : {"", "*", "KIT", "KIT/", "/1", "a/b/c", "KIT/+", "#/1", "KIT/\n"}) {
    const auto pattern = ParseRobotPattern(text);
    ASSERT_FALSE(pattern) << text;
    EXPECT_EQ(pattern.error().kind, ErrorKind::kUsage);
  }
}

}  // namespace
}  // namespace fleetpub::vda5050
