// How long to wait before asking again for a lock that another process holds.
#pragma once

#include <algorithm>
#include <chrono>

namespace fleetpub::ledger {

/// Before the nth repetition, counted from 0: 50 µs, half as much again each time, 5 ms at most. A
/// holder usually lets go within a millisecond.
[[nodiscard]] inline std::chrono::microseconds BackoffFor(int attempt) {
  double wait = 50;
  for (int i = 0; i < std::min(attempt, 12); ++i) wait *= 1.5;
  return std::chrono::microseconds(static_cast<int>(std::min(wait, 5'000.0)));
}

}  // namespace fleetpub::ledger
