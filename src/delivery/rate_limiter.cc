#include "delivery/rate_limiter.h"

#include <algorithm>
#include <limits>

namespace fleetpub::delivery {
namespace {

constexpr std::chrono::milliseconds kBurst{50};

}  // namespace

RateLimiter::RateLimiter(double per_second)
    : interval_(std::max(Clock::duration(1), std::chrono::duration_cast<Clock::duration>(
                                                 std::chrono::duration<double>(1 / per_second)))),
      burst_(std::max<Clock::duration>(kBurst, interval_)) {}

// The next one is due at next_, the others an interval apart; of those that are overdue, a burst.
std::size_t RateLimiter::Available(Clock::time_point now) const {
  if (!IsLimited()) return std::numeric_limits<std::size_t>::max();
  if (now < next_) return 0;
  const auto due = std::min(now - next_, burst_ - interval_);
  return 1 + static_cast<std::size_t>(due / interval_);
}

void RateLimiter::Consume(std::size_t count, Clock::time_point now) {
  if (!IsLimited() || count == 0) return;
  next_ = std::max(next_, now - (burst_ - interval_));
  next_ += interval_ * static_cast<Clock::rep>(count);
}

}  // namespace fleetpub::delivery
