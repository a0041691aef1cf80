#include "base/time.h"

#include <gmock/gmock.h>

#include <ctime>

#include "support/environment.h"

namespace fleetpub::base {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

using namespace std::chrono_literals;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr WallTime kEpoch{};

// As FormatTimestamp writes what was read, or "none".
std::string Read(std::string_view text) {
  const auto time = ParseDateTime(text);
  return time ? FormatTimestamp(*time) : "none";
}

TEST(FormatTimestamp, AlwaysHasThreeFractionDigits) {
  const std::pair<WallTime, std::string_view> cases[] = {
      {kEpoch, "1970-01-01T00:00:00.000Z"},
      {kEpoch + 1ms, "1970-01-01T00:00:00.001Z"},
      {kEpoch + 999'999'999ns, "1970-01-01T00:00:00.999Z"},
      {kEpoch + 1767323045678ms, "2026-01-02T03:04:05.678Z"},
      {kEpoch + 1767323045670ms, "2026-01-02T03:04:05.670Z"},
      {kEpoch + 951782400s, "2000-02-29T00:00:00.000Z"},
  };
  for (const auto& [time, text] : cases) EXPECT_EQ(FormatTimestamp(time), text);
}

TEST(FormatTimestamp, RoundsDownBefore1970Too) {
  EXPECT_EQ(FormatTimestamp(kEpoch - 1ms), "1969-12-31T23:59:59.999Z");
  EXPECT_EQ(FormatTimestamp(kEpoch - 1ns), "1969-12-31T23:59:59.999Z");
  EXPECT_EQ(FormatTimestamp(kEpoch - 24h), "1969-12-31T00:00:00.000Z");
}

TEST(FormatTimestamp, ReachesBothEndsOfTheClock) {
  EXPECT_EQ(FormatTimestamp(WallTime::max()), "2262-04-11T23:47:16.854Z");
  EXPECT_EQ(FormatTimestamp(WallTime::min()), "1677-09-21T00:12:43.145Z");
}

TEST(ParseDateTime, TakesWhatRfc3339Allows) {
  constexpr std::pair<std::string_view, std::string_view> kCases[] = {
      {"2026-01-02T03:04:05Z", "2026-01-02T03:04:05.000Z"},
      {"2026-01-02t03:04:05z", "2026-01-02T03:04:05.000Z"},
      {"2024-02-29T00:00:00Z", "2024-02-29T00:00:00.000Z"},
      {"2000-02-29T00:00:00Z", "2000-02-29T00:00:00.000Z"},
      {"2026-01-02T03:04:05+00:00", "2026-01-02T03:04:05.000Z"},
      {"2026-01-02T03:04:05-00:00", "2026-01-02T03:04:05.000Z"},
      {"2026-01-02T03:04:05+08:00", "2026-01-01T19:04:05.000Z"},
      {"2026-01-02T03:04:05.5-03:30", "2026-01-02T06:34:05.500Z"},
      {"2026-12-31T23:59:59+23:59", "2026-12-31T00:00:59.000Z"},
  };
  for (const auto& [text, time] : kCases) EXPECT_EQ(Read(text), time) << text;
}

TEST(ParseDateTime, TakesAnyNumberOfFractionDigits) {
  const std::string digits = "123456789123456789";
  for (std::size_t count = 1; count <= digits.size(); ++count) {
    const auto time = ParseDateTime("1970-01-01T00:00:00." + digits.substr(0, count) + "Z");
    ASSERT_TRUE(time) << count;
    std::string micros = digits.substr(0, std::min<std::size_t>(count, 6));
    micros.resize(6, '0');
    EXPECT_EQ(*time - kEpoch, std::chrono::microseconds(std::stol(micros))) << count;
  }
}

TEST(ParseDateTime, TakesALeapSecondWhereOneCanBe) {
  EXPECT_EQ(Read("2016-12-31T23:59:60Z"), "2017-01-01T00:00:00.000Z");
  EXPECT_EQ(Read("2016-12-31T15:59:60.5-08:00"), "2017-01-01T00:00:00.500Z");
  EXPECT_EQ(Read("2017-01-01T00:59:60+01:00"), "2017-01-01T00:00:00.000Z");
  EXPECT_EQ(Read("2016-12-31T23:58:60Z"), "none");
  EXPECT_EQ(Read("2016-06-30T23:59:60Z"), "2016-07-01T00:00:00.000Z");
  EXPECT_EQ(Read("2016-06-29T23:59:60Z"), "none");
  EXPECT_EQ(Read("2016-12-31T23:59:60+01:00"), "none");
  EXPECT_EQ(Read("2016-12-31T23:59:61Z"), "none");
}

TEST(ParseDateTime, RefusesWhatIsNone) {
  for (const std::string_view text : {"",
                                      "2026",
                                      "2026-01-02",
                                      "2026-01-02T03:04:05",
                                      "2026-01-02 03:04:05Z",
                                      "26-01-02T03:04:05Z",
                                      "2026-1-2T03:04:05Z",
                                      "2026-01-02T3:04:05Z",
                                      "2026-01-02T03:04Z",
                                      "20260102T030405Z",
                                      "2026-00-01T00:00:00Z",
                                      "2026-13-01T00:00:00Z",
                                      "2026-01-00T00:00:00Z",
                                      "2026-01-32T00:00:00Z",
                                      "2026-04-31T00:00:00Z",
                                      "2023-02-29T00:00:00Z",
                                      "1900-02-29T00:00:00Z",
                                      "2026-01-02T24:00:00Z",
                                      "2026-01-02T03:60:00Z",
                                      "2026-01-02T03:04:05.Z",
                                      "2026-01-02T03:04:05,5Z",
                                      "2026-01-02T03:04:05.5",
                                      "2026-01-02T03:04:05+0100",
                                      "2026-01-02T03:04:05+01",
                                      "2026-01-02T03:04:05+24:00",
                                      "2026-01-02T03:04:05+01:60",
                                      "2026-01-02T03:04:05Z ",
                                      " 2026-01-02T03:04:05Z",
                                      "2026-01-02T03:04:05ZZ",
                                      "-026-01-02T03:04:05Z",
                                      "+2026-01-02T03:04:05Z",
                                      "2026-01-02T03:04:0\xD9\xA5Z",
                                      "now"}) {
    EXPECT_EQ(Read(text), "none") << text;
  }
}

TEST(ParseDateTime, HoldsTimesBeyondTheClockAtItsEnds) {
  EXPECT_EQ(Read("9999-12-31T23:59:59Z"), "2190-01-01T00:00:00.000Z");
  EXPECT_EQ(Read("0000-01-01T00:00:00Z"), "1900-01-01T00:00:00.000Z");
  EXPECT_GT(*ParseDateTime("9999-12-31T23:59:59Z") - *ParseDateTime("0000-01-01T00:00:00Z"),
            std::chrono::years(289));
}

TEST(ParseDateTime, ReadsWhatFormatTimestampWrites) {
  for (const WallTime time : {kEpoch, kEpoch - 1ms, kEpoch + 1767323045678ms}) {
    EXPECT_EQ(ParseDateTime(FormatTimestamp(time)), time);
  }
}

TEST(FormatLocal, IsInTheMachinesTimeZone) {
  {
    // POSIX counts westwards: two hours east of Greenwich.
    const testing::EnvironmentVariable zone("TZ", "UTC-2");
    tzset();
    EXPECT_EQ(FormatLocal(kEpoch + 1767323045678ms), "2026-01-02 05:04:05");
  }
  tzset();
}

TEST(ParseDuration, TakesWhatPeopleWrite) {
  const std::pair<std::string_view, milliseconds> cases[] = {
      {"250ms", 250ms}, {"30s", 30s},          {"5m", 5min},     {"5min", 5min},
      {"2h", 2h},       {"90d", 2160h},        {"1.5s", 1500ms}, {"0.5d", 12h},
      {"0", 0ms},       {"10", 10s},           {"1e3ms", 1s},    {"0.4ms", 0ms},
      {"0.5ms", 1ms},   {"3652d", 3652 * 24h},
  };
  for (const auto& [text, duration] : cases) EXPECT_EQ(ParseDuration(text), duration) << text;
}

TEST(ParseDuration, CountsABareNumberInTheUnitGiven) {
  EXPECT_EQ(ParseDuration("300", 1ms), 300ms);
  EXPECT_EQ(ParseDuration("2", 24h), 48h);
  EXPECT_EQ(ParseDuration("2s", 24h), 2s) << "a suffix wins";
}

TEST(ParseDuration, RefusesTheRest) {
  for (const std::string_view text :
       {"",    "s",   "ms",   "-1s",   "1 s",   " 1s",  "1s ", "1y",   "1S",   "1sec",
        "nan", "inf", "infs", "1e400", "3653d", "0x10", "+5s", "5m3s", "1,5s", "--5"}) {
    const auto duration = ParseDuration(text);
    ASSERT_FALSE(duration) << text;
    EXPECT_EQ(duration.error().kind, ErrorKind::kUsage);
  }
  EXPECT_THAT(ParseDuration("\x1b[2J").error().message,
              AllOf(HasSubstr(R"('\x1b[2J')"), HasSubstr("250ms")));
}

TEST(FormatElapsed, SuitsTheSize) {
  const std::pair<nanoseconds, std::string_view> cases[] = {
      {0ns, "0.0 ms"},
      {42'300us, "42 ms"},
      {1'234us, "1.2 ms"},
      {9'940us, "9.9 ms"},
      {9'960us, "10 ms"},
      {999'400us, "999 ms"},
      {999'600us, "1.0 s"},
      {3'400ms, "3.4 s"},
      {9'940ms, "9.9 s"},
      {9'960ms, "10 s"},
      {35s, "35 s"},
      {59'400ms, "59 s"},
      {59'499ms, "59 s"},
      {59'501ms, "1 min 00 s"},
      {59'999ms, "1 min 00 s"},
      {60s, "1 min 00 s"},
      {125s, "2 min 05 s"},
      {119'600ms, "2 min 00 s"},
      {2h + 3s, "120 min 03 s"},
  };
  for (const auto& [elapsed, text] : cases) EXPECT_EQ(FormatElapsed(elapsed), text);
}

}  // namespace
}  // namespace fleetpub::base
