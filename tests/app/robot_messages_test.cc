#include "app/robot_messages.h"

#include <gtest/gtest.h>

namespace fleetpub::app {
namespace {

std::unique_ptr<RobotMessage> Message(std::string_view topic, std::string_view json) {
  auto message = base::ParseJson(json);
  return MakeUserMessage(topic, std::make_shared<const base::JsonDocument>(*std::move(message)),
                         vda5050::HeaderMismatch::kReplace);
}
std::unique_ptr<RobotMessage> Actions(const std::string& key, const std::string& types) {
  return Message("instantActions", R"({")" + key + R"(":[)" + types + "]}");
}

constexpr const char* kPause = R"({"actionType":"startPause","actionId":"a"})";
constexpr const char* kCancel = R"({"actionType":"cancelOrder","actionId":"b"})";
constexpr const char* kBeep = R"({"actionType":"beep","actionId":"c"})";

// As for the command `pause`, whatever the version calls the array.
TEST(UserMessage, ThatOnlyStopsAsksForNoFactsheet) {
  for (const char* key : {"actions", "instantActions"}) {
    EXPECT_TRUE(Actions(key, kPause)->IsOnlyStartPause()) << key;
    EXPECT_FALSE(Actions(key, kPause)->NeedsFactsheet()) << key;
  }
}

TEST(UserMessage, AsksForAFactsheetUnlessEveryRobotKnowsItsActions) {
  const auto both = [](const char* a, const char* b) { return std::string(a) + "," + b; };
  EXPECT_FALSE(Actions("actions", both(kPause, kCancel))->NeedsFactsheet());
  EXPECT_FALSE(Actions("actions", both(kPause, kCancel))->IsOnlyStartPause());
  EXPECT_TRUE(Actions("actions", both(kPause, kBeep))->NeedsFactsheet());
  EXPECT_TRUE(Actions("instantActions", kBeep)->NeedsFactsheet());
  EXPECT_TRUE(Actions("actions", "")->NeedsFactsheet());
  EXPECT_TRUE(Message("order", R"({"orderId":"o"})")->NeedsFactsheet());
  EXPECT_FALSE(Message("order", R"({"orderId":"o"})")->IsOnlyStartPause());
}

}  // namespace
}  // namespace fleetpub::app
