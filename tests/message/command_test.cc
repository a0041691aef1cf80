#include "message/command.h"

#include <gmock/gmock.h>

#include <chrono>
#include <limits>

namespace fleetpub::message {
namespace {

using namespace std::chrono_literals;

constexpr base::WallTime kNow{1767323045678ms};

TEST(PayloadTemplate, PutsIdAndTimestampIntoItsHoles) {
  const PayloadTemplate payload{R"({"headerId":)", R"(,"timestamp":")", R"("})"};
  EXPECT_EQ(payload.Render(7, kNow), R"({"headerId":7,"timestamp":"2026-01-02T03:04:05.678Z"})");
}

TEST(PayloadTemplate, WritesEveryIdAsItsDecimalDigits) {
  const PayloadTemplate payload{"<", ">", ""};
  EXPECT_EQ(payload.Render(0, kNow).substr(0, 3), "<0>");
  EXPECT_EQ(payload.Render(std::numeric_limits<std::uint32_t>::max(), kNow).substr(0, 12),
            "<4294967295>");
}

TEST(PayloadTemplate, HasNoIdWhenItIsNotCounted) {
  const PayloadTemplate payload{.before_time = "{", .rest = "}", .counted = false};
  EXPECT_EQ(payload.Render(7, kNow), "{2026-01-02T03:04:05.678Z}");
}

TEST(PayloadTemplate, KnowsItsLargestSize) {
  const PayloadTemplate payload{.before_id = "{", .before_time = ",,", .rest = "}}}"};
  EXPECT_EQ(payload.LargestSize(), payload.Render(4'294'967'295, base::WallTime()).size());
}

}  // namespace
}  // namespace fleetpub::message
