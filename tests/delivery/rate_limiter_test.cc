#include "delivery/rate_limiter.h"

#include <gtest/gtest.h>

namespace fleetpub::delivery {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

const RateLimiter::Clock::time_point kStart = RateLimiter::Clock::time_point(seconds(1'000));

// How many leave within a time, looked at every millisecond.
std::size_t SentWithin(RateLimiter limiter, milliseconds time) {
  std::size_t sent = 0;
  for (milliseconds at{0}; at < time; at += milliseconds(1)) {
    const std::size_t some = limiter.Available(kStart + at);
    limiter.Consume(some, kStart + at);
    sent += some;
  }
  return sent;
}

TEST(RateLimiter, AllowsEverythingWithoutARate) {
  RateLimiter limiter;
  EXPECT_GT(limiter.Available(kStart), 1'000'000U);
  limiter.Consume(1'000'000, kStart);
  EXPECT_GT(limiter.Available(kStart), 1'000'000U);
  EXPECT_LE(limiter.Next(), kStart);
}

TEST(RateLimiter, KeepsToTheRate) {
  EXPECT_EQ(SentWithin(RateLimiter(10), milliseconds(1'000)), 10U);
  EXPECT_EQ(SentWithin(RateLimiter(0.5), milliseconds(4'000)), 2U);
  const std::size_t many = SentWithin(RateLimiter(5'000), milliseconds(1'000));
  EXPECT_GE(many, 4'990U);
  EXPECT_LE(many, 5'260U);
}

TEST(RateLimiter, SavesNothingUp) {
  RateLimiter limiter(100);
  EXPECT_EQ(limiter.Available(kStart), 5U);
  limiter.Consume(5, kStart);
  EXPECT_EQ(limiter.Available(kStart), 0U);
  EXPECT_EQ(limiter.Next(), kStart + milliseconds(10));
  EXPECT_EQ(limiter.Available(kStart + seconds(60)), 5U);
}

TEST(RateLimiter, MakesUpForWhatWasTooMuch) {
  RateLimiter limiter(10);
  limiter.Consume(11, kStart);
  EXPECT_EQ(limiter.Next(), kStart + milliseconds(1'000) + milliseconds(100));
}

}  // namespace
}  // namespace fleetpub::delivery
