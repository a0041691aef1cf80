// The options of waiting for the robot's word, and of checking beforehand.
#pragma once

#include <chrono>
#include <optional>

#include "app/command_factory.h"
#include "base/result.h"

namespace fleetpub::cli {

class OptionSet;

struct WaitingOptions {
  bool wait = false;
  std::optional<vda5050::WaitFor> wait_for;  ///< nothing: as `wait` says
  /// In total; nothing: 35 s to be seen, 10 min to be done.
  std::optional<std::chrono::milliseconds> timeout;
  int resend = 0;
  bool check = false;  ///< the default, said outright
  bool no_check = false;
  bool tidy = false;
  std::chrono::milliseconds discover{300};
};

/// `--wait`, `--wait-for` and `--timeout` alone.
void DeclareWaitOptions(OptionSet& set, WaitingOptions& options);
/// `--check`, `--no-check` and `--discover` alone.
void DeclareCheckOptions(OptionSet& set, WaitingOptions& options);
void DeclareWaitingOptions(OptionSet& set, WaitingOptions& options);

/// Errors: ErrorKind::kUsage.
[[nodiscard]] Result<app::Waiting> ParseWaitingOptions(const WaitingOptions& options);

}  // namespace fleetpub::cli
