// The options of waiting for the robot's word, and of checking beforehand.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "base/result.h"
#include "dispatch/collect.h"
#include "dispatch/follow.h"
#include "vda5050/confirmation.h"

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
  dispatch::WaitOptions wait;
  bool check = false;
  bool no_check = false;  ///< said outright
  dispatch::CollectOptions discover;
};

/// Errors: ErrorKind::kUsage.
[[nodiscard]] Result<Waiting> WaitingOf(const WaitingOptions& options);

}  // namespace fleetpub::cli
