// Wall-clock times as the protocols write them, and durations as people do.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"

namespace fleetpub::base {

using WallTime = std::chrono::system_clock::time_point;

/// `2026-01-02T03:04:05.678Z`: UTC, exactly three fraction digits, in every version (VDA 5050 3.0
/// §7.1.1; robots in the field choke on fewer, or on an offset).
[[nodiscard]] std::string FormatTimestamp(WallTime time);

/// `2026-01-02 03:04:05` in the machine's own time zone, for people.
[[nodiscard]] std::string FormatLocal(WallTime time);

/// RFC 3339 §5.6 date-time with a real calendar: no 29 February 2023, no hour 24; a leap second
/// where one can be. Microseconds are kept, further digits dropped; a time outside 1900..2189
/// becomes the end of that range, so that any two can be subtracted. Nothing when it is none.
[[nodiscard]] std::optional<WallTime> ParseDateTime(std::string_view text);

/// `250ms`, `30s`, `5m`, `2h`, `90d`; a bare number counts in `unit`. At most ten years.
/// Errors: ErrorKind::kUsage.
[[nodiscard]] Result<std::chrono::milliseconds> ParseDuration(
    std::string_view text, std::chrono::milliseconds unit = std::chrono::seconds(1));

/// `42 ms`, `3.4 s`, `2 min 05 s`.
[[nodiscard]] std::string FormatElapsed(std::chrono::nanoseconds elapsed);

}  // namespace fleetpub::base
