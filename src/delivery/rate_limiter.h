// How many messages may leave, when somebody has said how many per second.
#pragma once

#include <chrono>
#include <cstddef>

namespace fleetpub::delivery {

/// So many per second on average, and never more at once than 50 ms of that, or one: what was not
/// used is not saved up.
class RateLimiter {
 public:
  using Clock = std::chrono::steady_clock;

  /// As many as there are.
  RateLimiter() = default;
  explicit RateLimiter(double per_second);

  [[nodiscard]] bool IsLimited() const { return interval_.count() > 0; }
  /// How many may leave now.
  [[nodiscard]] std::size_t Available(Clock::time_point now) const;
  /// So many have left; more than the allowance is made up for later.
  void Consume(std::size_t count, Clock::time_point now);
  /// When the next one may leave.
  [[nodiscard]] Clock::time_point Next() const { return next_; }

 private:
  Clock::duration interval_{0};  // from one to the next
  Clock::duration burst_{0};
  Clock::time_point next_{};
};

}  // namespace fleetpub::delivery
