#include "cli/parser/value_kind.h"

#include <gmock/gmock.h>

#include <optional>

namespace fleetpub::cli {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::HasSubstr;

bool Store(const ValueKind& kind, const std::string& text) { return kind.store({text}); }

TEST(ValueKind, ADurationIsReadInItsUnit) {
  milliseconds time{7};
  EXPECT_TRUE(Store(Duration(time), "2"));
  EXPECT_EQ(time, milliseconds(2000));
  EXPECT_TRUE(Store(Duration(time, milliseconds(1)), "300"));
  EXPECT_EQ(time, milliseconds(300));
  EXPECT_FALSE(Store(Duration(time), "soon"));
  EXPECT_FALSE(Store(Duration(time), ""));
  EXPECT_EQ(time, milliseconds(300)) << "what is refused changes nothing";
}

TEST(ValueKind, WhatMayBeLeftOpenIsLeftOpenByAnEmptyText) {
  std::optional<milliseconds> time;
  EXPECT_TRUE(Store(Duration(time), ""));
  EXPECT_FALSE(time);
  std::optional<double> rate;
  EXPECT_TRUE(Store(Rate(rate), ""));
  EXPECT_FALSE(rate);
}

TEST(ValueKind, AnIntervalIsAboveZero) {
  milliseconds time{7};
  EXPECT_FALSE(Store(Interval(time), "0s"));
  EXPECT_TRUE(Store(Interval(time), "1ms"));
}

TEST(ValueKind, AWholeNumberLiesBetweenItsBounds) {
  int number = 9;
  const ValueKind kind = WholeNumber(number, 1, 65);
  for (const char* text : {"0", "66", "1.5", "5x", "-1", " 5", ""}) {
    EXPECT_FALSE(Store(kind, text)) << text;
  }
  EXPECT_EQ(number, 9);
  EXPECT_TRUE(Store(kind, "65"));
  EXPECT_EQ(number, 65);
  EXPECT_EQ(kind.Takes(), "a whole number from 1 to 65");
}

TEST(ValueKind, AWholeNumberFillsItsType) {
  std::optional<std::uint32_t> id;
  EXPECT_TRUE(Store(WholeNumber(id), "4294967295"));
  EXPECT_EQ(id, 4294967295U);
  EXPECT_FALSE(Store(WholeNumber(id), "4294967296"));
}

TEST(ValueKind, ARateAndAPercentageHaveTheirRange) {
  std::optional<double> rate;
  EXPECT_TRUE(Store(Rate(rate), "0.5"));
  EXPECT_EQ(rate, 0.5);
  for (const char* text : {"0", "-1", "nan", "inf", "2000000"}) {
    EXPECT_FALSE(Store(Rate(rate), text)) << text;
  }
  double share = 0;
  EXPECT_TRUE(Store(Percentage(share), "25%"));
  EXPECT_EQ(share, 0.25);
  EXPECT_FALSE(Store(Percentage(share), "101"));
  EXPECT_FALSE(Store(Percentage(share), "%"));
}

TEST(ValueKind, APointInTimeIsATimeOrCountsFromNow) {
  std::optional<base::WallTime> time;
  EXPECT_TRUE(Store(PointInTime(time, base::Direction::kBack), "2026-01-02T03:04:05Z"));
  EXPECT_EQ(base::FormatTimestamp(*time), "2026-01-02T03:04:05.000Z");
  const auto now = base::WallTime::clock::now();
  EXPECT_TRUE(Store(PointInTime(time, base::Direction::kBack), "1h"));
  EXPECT_LT(*time, now);
  EXPECT_TRUE(Store(PointInTime(time, base::Direction::kAhead), "1h"));
  EXPECT_GT(*time, now);
  EXPECT_TRUE(Store(PointInTime(time, base::Direction::kBack), "yesterday"));
  EXPECT_LT(*time, now);
  EXPECT_TRUE(Store(PointInTime(time, base::Direction::kAhead), "23:59:59"));
  EXPECT_GT(*time, now);
  EXPECT_FALSE(Store(PointInTime(time, base::Direction::kBack), "soon"));
}

TEST(ValueKind, AChoiceIsShownByItsFirstWord) {
  constexpr auto kTable = std::to_array<base::Choice<int>>({{"red", 1}, {"rouge", 1}, {"blue", 2}});
  int colour = 0;
  const ValueKind kind = OneOf(colour, kTable);
  EXPECT_TRUE(Store(kind, "ROUGE"));
  EXPECT_EQ(colour, 1);
  EXPECT_FALSE(Store(kind, "green"));
  EXPECT_FALSE(Store(kind, ""));
  EXPECT_THAT(kind.choices(), ElementsAre("red", "blue"));
  EXPECT_EQ(kind.Takes(), "red or blue");
}

TEST(ValueKind, ANameIsNotEmptyAmongOthersEither) {
  std::string name;
  EXPECT_TRUE(Store(Name(name), "n1"));
  EXPECT_FALSE(Store(Name(name), ""));
  EXPECT_EQ(name, "n1");
  std::vector<std::string> names;
  EXPECT_FALSE(Name(names).store({"n1", "", "n2"}));
  EXPECT_TRUE(Name(names).store({"n1", "n2"}));
}

TEST(ValueKind, ADurationSaysHowLongItMayBe) {
  std::chrono::milliseconds time{0};
  std::optional<base::WallTime> since;
  for (const ValueKind& kind :
       {Duration(time), Interval(time), PointInTime(since, base::Direction::kBack)}) {
    EXPECT_FALSE(Store(kind, "5000d"));
    EXPECT_THAT(kind.Takes(), HasSubstr("at most ten years"));
  }
}

TEST(ValueKind, AWordIsStoredAsItsListSpellsIt) {
  constexpr auto kWords = std::to_array<std::string_view>({"NONE", "SOFT"});
  std::string word;
  EXPECT_TRUE(Store(OneOf(word, kWords), "soft"));
  EXPECT_EQ(word, "SOFT");
  EXPECT_FALSE(Store(OneOf(word, kWords), "LOUD"));
  EXPECT_TRUE(Store(OneOf(word, kWords), ""));
  EXPECT_EQ(word, "");
}

TEST(ValueKind, AVersionMayBeShortAndPerhapsAutomatic) {
  std::string version;
  EXPECT_TRUE(Store(VdaVersion(version), "2.1"));
  EXPECT_TRUE(Store(VdaVersion(version), "auto"));
  EXPECT_EQ(version, "auto");
  EXPECT_FALSE(Store(VdaVersion(version, Automatic::kNo), "auto"));
  EXPECT_FALSE(Store(VdaVersion(version), "4"));
  EXPECT_THAT(VdaVersion(version).Takes(), HasSubstr("3.0.0"));
}

}  // namespace
}  // namespace fleetpub::cli
