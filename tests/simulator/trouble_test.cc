#include "simulator/trouble.h"

#include <gmock/gmock.h>

namespace fleetpub::simulator {
namespace {

using ::testing::HasSubstr;
using vda5050::Version;

TEST(ParseRobotError, ReadsTypeLevelAndText) {
  const auto bare = ParseRobotError("motorFault:fatal", Version::k110);
  ASSERT_TRUE(bare);
  EXPECT_EQ(bare->type, "motorFault");
  EXPECT_EQ(bare->level, "FATAL");
  EXPECT_EQ(bare->description, "");
  EXPECT_EQ(bare->until, Until::kEnd);
  const auto told = ParseRobotError("gripper:URGENT:jammed: left jaw", Version::k300);
  ASSERT_TRUE(told);
  EXPECT_EQ(told->level, "URGENT");
  EXPECT_EQ(told->description, "jammed: left jaw");
}

TEST(ParseRobotError, RefusesWhatTheVersionDoesNotHave) {
  for (const char* level : {"URGENT", "CRITICAL"}) {
    const std::string text = std::string("slip:") + level;
    EXPECT_TRUE(ParseRobotError(text, Version::k300)) << text;
    const auto refused = ParseRobotError(text, Version::k210);
    ASSERT_FALSE(refused) << text;
    EXPECT_EQ(refused.error().kind, ErrorKind::kUsage);
    EXPECT_THAT(refused.error().message, HasSubstr("WARNING, FATAL"));
  }
  for (const char* text : {"", "slip", "slip:", ":FATAL", "slip:SEVERE", "slip\xFF:FATAL"}) {
    EXPECT_FALSE(ParseRobotError(text, Version::k300)) << text;
  }
}

TEST(ParsePosition, ReadsNumbersAndAMap) {
  const auto bare = ParsePosition("4,-0.25,3");
  ASSERT_TRUE(bare);
  EXPECT_EQ(bare->x, 4);
  EXPECT_EQ(bare->y, -0.25);
  EXPECT_EQ(bare->theta, 3);
  EXPECT_EQ(bare->map_id, "map-1");
  EXPECT_EQ(ParsePosition("0,0,0,yard")->map_id, "yard");
}

TEST(ParsePosition, RefusesWhatIsNone) {
  for (const char* text :
       {"", "1,2", "1,2,3,4,5", "1,2,x", "1,2,4", "1,nan,0", "1, 2,0", "1,2,0,"}) {
    const auto position = ParsePosition(text);
    ASSERT_FALSE(position) << text;
    EXPECT_EQ(position.error().kind, ErrorKind::kUsage);
  }
}

TEST(HasEmergencyStop, KnowsNoneThatAcknowledgesItselfFrom30) {
  EXPECT_TRUE(HasEmergencyStop("AUTOACK", Version::k210));
  EXPECT_FALSE(HasEmergencyStop("AUTOACK", Version::k300));
  EXPECT_TRUE(HasEmergencyStop("REMOTE", Version::k300));
}

}  // namespace
}  // namespace fleetpub::simulator
