// Ctrl-C and `kill` while nobody is waited for: the process ends at once.
#pragma once

#include <sys/types.h>

#include <csignal>
#include <string_view>

namespace fleetpub::cli {

/// While it lives, SIGINT and SIGTERM end the process with 130 or 143 after one sentence on
/// standard error. Ending at any moment is safe: the ledger is made for `kill -9`, and a
/// half-written MQTT packet is no message. Inside another one, or a StopSignal, it goes before that.
class InterruptGuard {
 public:
  InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  ~InterruptGuard();

  /// From now on messages may have left.
  static void Begin();

 private:
  struct sigaction old_interrupt_ {};
  struct sigaction old_terminate_ {};
};

/// Gets SIGTERM when this process is ended at once: a process, or with a minus its group; 0: nobody.
void EndWithUs(pid_t process);

/// Inside a signal handler: writes the sentence to standard error and ends the process.
[[noreturn]] void EndAtOnce(int signal, std::string_view sentence);

}  // namespace fleetpub::cli
