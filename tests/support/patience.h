// How long tests wait for what should come at once.
#pragma once

#include <chrono>

namespace fleetpub::testing {

/// Under a sanitizer, and while lines are counted, everything takes some times as long
/// (tests/CMakeLists.txt).
#ifdef FLEETPUB_SLOW
inline constexpr int kSlowness = 4;
#else
inline constexpr int kSlowness = 1;
#endif

}  // namespace fleetpub::testing
