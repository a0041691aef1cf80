#include "dispatch/pace.h"

#include <gtest/gtest.h>

namespace fleetpub::dispatch {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

const Pace::Clock::time_point kStart = Pace::Clock::time_point(seconds(1'000));

// How many leave within a time, looked at every millisecond.
std::size_t SentWithin(Pace pace, milliseconds time) {
  std::size_t sent = 0;
  for (milliseconds at{0}; at < time; at += milliseconds(1)) {
    const std::size_t some = pace.Allowance(kStart + at);
    pace.Took(some, kStart + at);
    sent += some;
  }
  return sent;
}

TEST(Pace, AllowsEverythingWithoutARate) {
  Pace pace;
  EXPECT_GT(pace.Allowance(kStart), 1'000'000U);
  pace.Took(1'000'000, kStart);
  EXPECT_GT(pace.Allowance(kStart), 1'000'000U);
  EXPECT_LE(pace.Next(), kStart);
}

TEST(Pace, KeepsToTheRate) {
  EXPECT_EQ(SentWithin(Pace(10), milliseconds(1'000)), 10U);
  EXPECT_EQ(SentWithin(Pace(0.5), milliseconds(4'000)), 2U);
  const std::size_t many = SentWithin(Pace(5'000), milliseconds(1'000));
  EXPECT_GE(many, 4'990U);
  EXPECT_LE(many, 5'260U);
}

TEST(Pace, SavesNothingUp) {
  Pace pace(100);
  EXPECT_EQ(pace.Allowance(kStart), 5U);
  pace.Took(5, kStart);
  EXPECT_EQ(pace.Allowance(kStart), 0U);
  EXPECT_EQ(pace.Next(), kStart + milliseconds(10));
  EXPECT_EQ(pace.Allowance(kStart + seconds(60)), 5U);
}

TEST(Pace, MakesUpForWhatWasTooMuch) {
  Pace pace(10);
  pace.Took(11, kStart);
  EXPECT_EQ(pace.Next(), kStart + milliseconds(1'000) + milliseconds(100));
}

}  // namespace
}  // namespace fleetpub::dispatch
