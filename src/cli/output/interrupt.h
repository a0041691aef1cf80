// Ctrl-C and `kill` while commands are on their way: the process ends at once and says what was
// sent.
#pragma once

#include <csignal>
#include <cstddef>

namespace fleetpub::cli {

/// While it lives, SIGINT and SIGTERM end the process with 130 or 143 after one sentence on
/// standard error. Ending at any moment is safe: the ledger is made for `kill -9`, and a
/// half-written MQTT packet is no message. One at a time.
class InterruptGuard {
 public:
  InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  ~InterruptGuard();

  /// From now on messages leave, so many in all: that none was counted no longer means that none
  /// was sent.
  static void Begin(std::size_t total);
  /// One more message was handed to the network.
  static void CountSent();

 private:
  struct sigaction old_interrupt_ {};
  struct sigaction old_terminate_ {};
};

}  // namespace fleetpub::cli
