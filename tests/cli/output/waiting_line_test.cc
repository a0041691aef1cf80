#include "cli/output/waiting_line.h"

#include <gtest/gtest.h>

#include <chrono>

namespace fleetpub::cli {
namespace {

using namespace std::chrono_literals;

constexpr std::string_view kWhat = "waiting for KIT/0004: sent, not yet seen";
constexpr std::string_view kHint = "Ctrl-C stops waiting, not the robot";

TEST(FormatWaiting, CountsTheSeconds) {
  EXPECT_EQ(FormatWaiting(kWhat, kHint, 12'400ms, 34'900ms, 200),
            "waiting for KIT/0004: sent, not yet seen  12 s of 35 s  "
            "(Ctrl-C stops waiting, not the robot)");
  EXPECT_EQ(FormatWaiting("connecting", "", 500ms, 10min, 80), "connecting  1 s of 10 min");
  EXPECT_EQ(FormatWaiting("connecting", "", 75s, 605s, 80),
            "connecting  1 min 15 s of 10 min 05 s");
}

TEST(FormatWaiting, LeavesOutWhatDoesNotFitOrHasNoEnd) {
  EXPECT_EQ(FormatWaiting(kWhat, kHint, 2s, 35s, 80),
            "waiting for KIT/0004: sent, not yet seen  2 s of 35 s");
  EXPECT_EQ(FormatWaiting("listening", "", 2s, std::chrono::nanoseconds::max(), 80),
            "listening  2 s");
}

}  // namespace
}  // namespace fleetpub::cli
