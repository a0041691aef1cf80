#include "base/time.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <ctime>

#include "base/scanner.h"
#include "base/text.h"

namespace fleetpub::base {
namespace {

using std::chrono::duration_cast;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::sys_days;

bool ScanOffset(Scanner& scanner, std::chrono::minutes& offset) {
  if (scanner.OneOf("Zz")) return true;
  const int sign = scanner.Front() == '-' ? -1 : 1;
  int hours = 0;
  int minutes = 0;
  if (!scanner.OneOf("+-") || !scanner.Digits(2, hours) || !scanner.OneOf(":") ||
      !scanner.Digits(2, minutes) || hours > 23 || minutes > 59) {
    return false;
  }
  offset = sign * std::chrono::minutes(hours * 60 + minutes);
  return true;
}

// A leap second ends a month in UTC (RFC 3339 §5.7).
bool BeginsMonth(std::chrono::sys_time<std::chrono::minutes> time) {
  const auto days = std::chrono::floor<std::chrono::days>(time);
  return time == days && std::chrono::year_month_day(days).day() == std::chrono::day(1);
}

// Nanoseconds in 64 bits reach over 584 years, but what lies between two times over 292.
WallTime ToWallTime(std::chrono::sys_time<microseconds> time) {
  constexpr std::chrono::sys_time<microseconds> kFirst = sys_days(std::chrono::year(1900) / 1 / 1);
  constexpr std::chrono::sys_time<microseconds> kLast = sys_days(std::chrono::year(2190) / 1 / 1);
  return WallTime(std::clamp(time, kFirst, kLast));
}

}  // namespace

std::string FormatTimestamp(WallTime time) {
  const auto ms = std::chrono::floor<milliseconds>(time);
  // Of a bulk job thousands fall into one millisecond.
  thread_local std::optional<decltype(ms)> last;
  thread_local std::string text;
  if (last == ms) return text;
  const auto days = std::chrono::floor<std::chrono::days>(ms);
  const std::chrono::year_month_day date{days};
  const std::chrono::hh_mm_ss clock{ms - days};
  text = fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                     clock.hours().count(), clock.minutes().count(), clock.seconds().count(),
                     clock.subseconds().count());
  last.emplace(ms);
  return text;
}

std::string FormatLocal(WallTime time) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
  std::tm parts{};
  localtime_r(&seconds, &parts);
  std::array<char, 32> text{};
  const std::size_t length = std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M:%S", &parts);
  return {text.data(), length};
}

std::optional<WallTime> ParseDateTime(std::string_view text) {
  Scanner scanner(text);
  int year = 0;
  int month = 0;
  int day = 0;
  int hour = 0;
  int minute = 0;
  int second = 0;
  if (!scanner.Digits(4, year) || !scanner.OneOf("-") || !scanner.Digits(2, month) ||
      !scanner.OneOf("-") || !scanner.Digits(2, day) || !scanner.OneOf("Tt") ||
      !scanner.Digits(2, hour) || !scanner.OneOf(":") || !scanner.Digits(2, minute) ||
      !scanner.OneOf(":") || !scanner.Digits(2, second)) {
    return std::nullopt;
  }
  microseconds fraction(0);
  if (scanner.OneOf(".") && !scanner.Fraction(fraction)) return std::nullopt;
  std::chrono::minutes offset(0);
  if (!ScanOffset(scanner, offset) || !scanner.AtEnd()) return std::nullopt;

  const std::chrono::year_month_day date{std::chrono::year(year),
                                         std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok() || hour > 23 || minute > 59 || second > 60) return std::nullopt;
  const auto utc_minute =
      sys_days(date) + std::chrono::hours(hour) + std::chrono::minutes(minute) - offset;
  if (second == 60 && !BeginsMonth(utc_minute + std::chrono::minutes(1))) return std::nullopt;
  return ToWallTime(utc_minute + std::chrono::seconds(second) + fraction);
}

Result<milliseconds> ParseDuration(std::string_view text, milliseconds unit) {
  const auto bad = [&] {
    return Fail(
        ErrorKind::kUsage,
        fmt::format("'{}' is not a duration of at most ten years: use 250ms, 30s, 5m, 2h or 90d",
                    Printable(text)));
  };
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !(value >= 0)) return bad();
  const std::string_view suffix = text.substr(static_cast<std::size_t>(end - text.data()));
  double scale = 0;
  if (suffix.empty()) scale = static_cast<double>(unit.count());
  if (suffix == "ms") scale = 1;
  if (suffix == "s") scale = 1e3;
  if (suffix == "m" || suffix == "min") scale = 60e3;
  if (suffix == "h") scale = 3600e3;
  if (suffix == "d") scale = 86400e3;
  constexpr double kTenYears = 10 * 365.25 * 86400e3;
  if (scale == 0 || value * scale > kTenYears) return bad();
  return milliseconds(std::llround(value * scale));
}

std::string FormatElapsed(nanoseconds elapsed) {
  const double ms = static_cast<double>(elapsed.count()) / 1e6;
  if (ms < 9.95) return fmt::format("{:.1f} ms", ms);
  if (ms < 999.5) return fmt::format("{:.0f} ms", ms);
  if (ms < 9'950) return fmt::format("{:.1f} s", ms / 1e3);
  if (ms < 59'500) return fmt::format("{:.0f} s", ms / 1e3);
  const auto seconds = std::lround(ms / 1e3);
  return fmt::format("{} min {:02} s", seconds / 60, seconds % 60);
}

}  // namespace fleetpub::base
