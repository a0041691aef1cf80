// Times as people say them, in the machine's own time zone.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/time.h"

namespace fleetpub::base {

enum class Direction { kBack = -1, kAhead = 1 };

/// A time as people say it, in the machine's own time zone: `14:30`, `2026-01-02`,
/// `2026-01-02 14:30`, `today`, `yesterday 22:00`, `tomorrow`, `monday`, `fri 06:00`, `now`; a day is
/// its midnight. A clock time or a weekday is the last one before `now`, or with kAhead the next one
/// after it. Nothing when it is none.
[[nodiscard]] std::optional<WallTime> ParseLocalTime(std::string_view text, WallTime now,
                                                     Direction direction);

/// The text with each UTC time of FormatTimestamp() in it as FormatLocal() has it.
[[nodiscard]] std::string WithLocalTimes(std::string_view text);

}  // namespace fleetpub::base
