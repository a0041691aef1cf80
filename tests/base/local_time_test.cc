#include "base/local_time.h"

#include <gtest/gtest.h>

#include <ctime>
#include <optional>

#include "support/environment.h"

namespace fleetpub::base {
namespace {

class LocalTime : public ::testing::Test {
 protected:
  ~LocalTime() override {
    zone_.reset();
    tzset();
  }
  LocalTime() { tzset(); }
  [[nodiscard]] std::string Back(std::string_view text) const {
    return Written(ParseLocalTime(text, now_, Direction::kBack));
  }
  [[nodiscard]] std::string Ahead(std::string_view text) const {
    return Written(ParseLocalTime(text, now_, Direction::kAhead));
  }

 private:
  static std::string Written(const std::optional<WallTime>& time) {
    return time ? FormatTimestamp(*time).substr(0, 19) : "none";
  }
  std::optional<testing::EnvironmentVariable> zone_{std::in_place, "TZ",
                                                    "CET-1CEST,M3.5.0,M10.5.0/3"};
  // A Wednesday, 14:00 by the clock on the wall.
  WallTime now_ = ParseDateTime("2026-07-15T12:00:00Z").value();
};

TEST_F(LocalTime, IsReadAsPeopleSayIt) {
  const std::pair<std::string_view, std::string_view> cases[] = {
      {"now", "2026-07-15T12:00:00"},
      {"today", "2026-07-14T22:00:00"},
      {"Yesterday", "2026-07-13T22:00:00"},
      {"yesterday 22:00", "2026-07-14T20:00:00"},
      {"13:59", "2026-07-15T11:59:00"},
      {"7:05", "2026-07-15T05:05:00"},
      {"22:00:30", "2026-07-14T20:00:30"},
      {"wednesday", "2026-07-14T22:00:00"},
      {"wed 15:00", "2026-07-08T13:00:00"},
      {"MON 06:00", "2026-07-13T04:00:00"},
      {"thu", "2026-07-08T22:00:00"},
      {"2026-01-02", "2026-01-01T23:00:00"},
      {"2026-01-02 03:04", "2026-01-02T02:04:00"},
      {"2026-01-02T03:04:05", "2026-01-02T02:04:05"},
  };
  for (const auto& [text, time] : cases) EXPECT_EQ(Back(text), time) << text;
}

TEST_F(LocalTime, LiesAheadWhereThatIsMeant) {
  EXPECT_EQ(Ahead("13:59"), "2026-07-16T11:59:00");
  EXPECT_EQ(Ahead("22:00"), "2026-07-15T20:00:00");
  EXPECT_EQ(Ahead("tomorrow 06:00"), "2026-07-16T04:00:00");
  EXPECT_EQ(Ahead("wednesday"), "2026-07-21T22:00:00");
  EXPECT_EQ(Ahead("wed 15:00"), "2026-07-15T13:00:00");
}

TEST_F(LocalTime, RefusesTheRest) {
  for (const std::string_view text :
       {"", "soon", "24:00", "12:60", "12", "12:3", "2026-02-30", "2026-13-01", "2026-01-02 ",
        "mon06:00", "monda", "yesterday  22:00", "14:00Z", "2026-01-02T03:04:05.5"}) {
    EXPECT_EQ(Back(text), "none") << text;
  }
}

TEST_F(LocalTime, StandsForTimesInAText) {
  EXPECT_EQ(WithLocalTimes("OFFLINE since 2026-07-15T12:00:00.000Z; ü 2026-07-15"),
            "OFFLINE since 2026-07-15 14:00:00; ü 2026-07-15");
}

}  // namespace
}  // namespace fleetpub::base
