#include "soar/message_type.h"

#include <gtest/gtest.h>

namespace fleetpub::soar {
namespace {

TEST(MessageType, HasAName) {
  for (const auto& [name, type] : kMessageTypes) {
    EXPECT_EQ(ParseMessageType(GetName(type)), type);
  }
  EXPECT_EQ(GetName(MessageType::kPlanningConfiguration), "planning_configuration");
  EXPECT_FALSE(ParseMessageType("Mission_Plan"));
  EXPECT_FALSE(ParseMessageType(""));
  EXPECT_EQ(MessageTypeNames(),
            "acknowledgement, mission_plan, observation, planning_configuration, platform_status");
}

TEST(Level, HasAnOrderAndAName) {
  EXPECT_LT(Level::kC2Received, Level::kOperatorApprovedAndSent);
  EXPECT_LT(Level::kOperatorApprovedAndSent, Level::kExecuted);
  for (const auto& [name, level] : kLevels) EXPECT_EQ(ParseLevel(GetName(level)), level);
  EXPECT_FALSE(ParseLevel("EXECUTED"));
}

}  // namespace
}  // namespace fleetpub::soar
