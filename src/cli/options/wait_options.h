// The options of waiting for the robot's word, and of checking beforehand.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "base/result.h"
#include "delivery/pending_commands.h"
#include "delivery/retained.h"
#include "vda5050/tracking/action_tracker.h"

namespace fleetpub::cli {

class OptionSet;

struct WaitingOptions {
  bool wait = false;
  std::string wait_for;  ///< accepted, finished; empty: as `wait` says
  std::string timeout;   ///< in total; empty: 35 s to be seen, 10 min to be done
  int resend = 0;
  bool check = false;
  bool no_check = false;
  std::string discover = "300";
};

/// `--wait`, `--wait-for` and `--timeout` alone.
void DeclareWaitOptions(OptionSet& set, WaitingOptions& options);
void DeclareWaitingOptions(OptionSet& set, WaitingOptions& options);

/// What these options ask for.
struct Waiting {
  std::optional<vda5050::WaitFor> wait_for;  ///< nothing: do not wait
  delivery::WaitOptions wait;
  bool check = false;
  bool no_check = false;  ///< said outright
  delivery::RetainedOptions discover;
};

/// Errors: ErrorKind::kUsage.
[[nodiscard]] Result<Waiting> WaitingOf(const WaitingOptions& options);

}  // namespace fleetpub::cli
