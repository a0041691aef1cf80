// Ctrl-C and `kill` for commands that bring their work to an end first.
#pragma once

#include <csignal>
#include <optional>

#include "cli/output/exit_code.h"

namespace fleetpub::cli {

/// While it lives, the first SIGINT or SIGTERM is only noted; a second one ends the process at once
/// with 130 or 143, after a sentence on standard error. One at a time.
class StopSignal {
 public:
  StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;
  ~StopSignal();

  /// kInterrupted or kTerminated once there was one.
  [[nodiscard]] static std::optional<ExitCode> Received();
  /// Readable from the first one on.
  [[nodiscard]] int descriptor() const { return reader_; }

 private:
  int reader_ = -1;
  struct sigaction old_interrupt_ {};
  struct sigaction old_terminate_ {};
};

}  // namespace fleetpub::cli
