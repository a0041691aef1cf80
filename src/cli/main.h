#pragma once

namespace fleetpub::cli {

/// The whole program: parses, runs, prints, and returns the exit code of the manual's table. Never
/// throws.
int Main(int argc, char** argv);

}  // namespace fleetpub::cli
