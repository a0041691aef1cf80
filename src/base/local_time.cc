#include "base/local_time.h"

#include <array>
#include <chrono>
#include <ctime>
#include <utility>

#include "base/scanner.h"
#include "base/text.h"

namespace fleetpub::base {
namespace {

using std::chrono::local_days;

std::tm LocalParts(WallTime time) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
  std::tm parts{};
  localtime_r(&seconds, &parts);
  return parts;
}

// `14:30`, `7:05`, `14:30:59`, since midnight.
bool ScanClock(Scanner& scanner, std::chrono::seconds& clock) {
  int hour = 0;
  int minute = 0;
  int second = 0;
  if (!scanner.Digits(2, hour) && !scanner.Digits(1, hour)) return false;
  if (!scanner.OneOf(":") || !scanner.Digits(2, minute)) return false;
  if (scanner.OneOf(":") && !scanner.Digits(2, second)) return false;
  clock = std::chrono::seconds((hour * 60 + minute) * 60 + second);
  return hour < 24 && minute < 60 && second < 60;
}

WallTime FromLocal(local_days day, std::chrono::seconds clock) {
  const std::chrono::year_month_day date(day);
  std::tm parts{};
  parts.tm_year = static_cast<int>(date.year()) - 1900;
  parts.tm_mon = static_cast<int>(static_cast<unsigned>(date.month())) - 1;
  parts.tm_mday = static_cast<int>(static_cast<unsigned>(date.day()));
  parts.tm_hour = static_cast<int>(clock / std::chrono::hours(1));
  parts.tm_min = static_cast<int>(clock / std::chrono::minutes(1) % 60);
  parts.tm_sec = static_cast<int>(clock.count() % 60);
  parts.tm_isdst = -1;  // whichever holds there
  return std::chrono::system_clock::from_time_t(std::mktime(&parts));
}

// A day as it was written, and after how many days there is another of its kind; 0: never.
struct SpokenDay {
  local_days day;
  int period = 0;
};

// As ParseDateTime() keeps them.
bool ScanDate(Scanner& scanner, SpokenDay& spoken) {
  int year = 0;
  int month = 0;
  int day = 0;
  if (!scanner.Digits(4, year) || !scanner.OneOf("-") || !scanner.Digits(2, month) ||
      !scanner.OneOf("-") || !scanner.Digits(2, day)) {
    return false;
  }
  const std::chrono::year_month_day date{std::chrono::year(year),
                                         std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  spoken = {local_days(date), 0};
  return date.ok() && year >= 1900 && year < 2190;
}

bool ScanDayName(Scanner& scanner, local_days today, SpokenDay& spoken) {
  constexpr std::array<std::pair<std::string_view, int>, 3> kNear = {
      {{"yesterday", -1}, {"today", 0}, {"tomorrow", 1}}};
  for (const auto& [name, distance] : kNear) {
    if (!scanner.Word(name)) continue;
    spoken = {today + std::chrono::days(distance), 0};
    return true;
  }
  constexpr std::array<std::string_view, 7> kWeek = {"sunday",   "monday", "tuesday", "wednesday",
                                                     "thursday", "friday", "saturday"};
  for (unsigned i = 0; i < kWeek.size(); ++i) {
    if (!scanner.Word(kWeek.at(i)) && !scanner.Word(kWeek.at(i).substr(0, 3))) continue;
    spoken = {today + (std::chrono::weekday(i) - std::chrono::weekday(today)), 7};
    return true;
  }
  return false;
}

}  // namespace

std::optional<WallTime> ParseLocalTime(std::string_view text, WallTime now, Direction direction) {
  const std::string lower = ToLower(text);
  if (lower == "now") return now;
  const std::tm parts = LocalParts(now);
  const local_days today =
      local_days(std::chrono::year(parts.tm_year + 1900) / (parts.tm_mon + 1) / parts.tm_mday);
  SpokenDay spoken{today, 1};
  std::chrono::seconds clock(0);
  Scanner date(lower);
  Scanner scanner(lower);
  if (ScanDate(date, spoken) || ScanDayName(date, today, spoken)) {
    scanner = date;
    if (!scanner.AtEnd() && (!scanner.OneOf(" t") || !ScanClock(scanner, clock))) return {};
  } else if (!ScanClock(scanner, clock)) {
    return {};
  }
  if (!scanner.AtEnd()) return {};
  const int step = spoken.period * static_cast<int>(direction);
  for (WallTime time = FromLocal(spoken.day, clock);; time = FromLocal(spoken.day, clock)) {
    const bool is_right = direction == Direction::kBack ? time <= now : time > now;
    if (step == 0 || is_right) return time;
    spoken.day += std::chrono::days(step);
  }
}

std::string WithLocalTimes(std::string_view text) {
  constexpr std::size_t kLength = std::string_view("2026-01-02T03:04:05.678Z").size();
  std::string local;
  while (!text.empty()) {
    const auto time = ParseDateTime(text.substr(0, kLength));
    const bool is_utc = time && text.size() >= kLength && text[kLength - 1] == 'Z';
    local += is_utc ? FormatLocal(*time) : std::string(1, text.front());
    text.remove_prefix(is_utc ? kLength : 1);
  }
  return local;
}

}  // namespace fleetpub::base
