// Connects virtual platforms to a broker and keeps them there.
#pragma once

#include "base/result.h"
#include "simulator/platform.h"
#include "simulator/runner.h"

namespace fleetpub::simulator {

/// Runs them until the time is over or `stopped` says so. A connection that is lost is made again.
/// Errors: the first connection cannot be made.
[[nodiscard]] Status RunPlatforms(PlatformFleet& fleet, const RunOptions& options);

}  // namespace fleetpub::simulator
