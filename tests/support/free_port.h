#pragma once

#include <cstdint>

namespace fleetpub::testing {

/// A TCP port of 127.0.0.1 that nobody listens on. Another program may take it at any time: whoever
/// uses it tries again with the next one then.
[[nodiscard]] std::uint16_t FreePort();

}  // namespace fleetpub::testing
