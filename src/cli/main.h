#pragma once

#include "cli/commands/version.h"

namespace fleetpub::cli {

/// The whole program: parses, runs, prints, and returns the exit code of the manual's table. Never
/// throws.
int Main(int argc, char** argv, const BuildInfo& build);

}  // namespace fleetpub::cli
