#pragma once

#include <cstdint>

namespace fleetpub::testing {

/// A TCP port of 127.0.0.1 that nobody listens on, and that no other test is given as long as this process runs: what
/// kills its broker finds no other one in its place. A program that is no test may take it: whoever uses it tries
/// again with the next one then. Any thread.
[[nodiscard]] std::uint16_t FreePort();

}  // namespace fleetpub::testing
