#include "base/width.h"

#include <gmock/gmock.h>

#include <cstddef>

namespace fleetpub::base {
namespace {

TEST(Width, IsWhatATerminalShows) {
  const std::pair<const char*, std::size_t> cases[] = {
      {"", 0},
      {"KIT/0001", 8},
      {"Förderer", 8},
      {"Fo\u0308rderer", 8},  // o, then a combining diaeresis
      {"搬送車/一号", 11},
      {"ｶﾀｶﾅ", 4},  // half-width
      {"🤖", 2},
      {"로봇", 4},
      {"→±²…", 4},
      {"e\u0301\u0323", 1}};
  for (const auto& [text, width] : cases) EXPECT_EQ(MeasureWidth(text), width) << text;
}

TEST(Width, CountsWhatIsNoTextByItsBytes) { EXPECT_EQ(MeasureWidth("\xFF\xC3"), 2U); }

TEST(Width, CountsWhatTheLibraryDoesNotKnowYet) { EXPECT_EQ(MeasureWidth("\U0002FFFD"), 1U); }

TEST(CutTo, CutsNoCharacterInTwo) {
  EXPECT_EQ(CutTo(3, "搬送車"), "搬");
  EXPECT_EQ(CutTo(4, "搬送車"), "搬送");
  EXPECT_EQ(CutTo(1, "e\u0301a"), "e\u0301");
  EXPECT_EQ(CutTo(0, "a"), "");
  EXPECT_EQ(CutTo(9, "a"), "a");
}

TEST(Shortened, SaysThatSomethingIsMissing) {
  EXPECT_EQ(Shortened(8, "KIT/0001"), "KIT/0001");
  EXPECT_EQ(Shortened(7, "KIT/0001"), "KIT/00…");
  EXPECT_EQ(Shortened(4, "搬送車"), "搬…");
  EXPECT_EQ(Shortened(1, "ab"), "…");
  EXPECT_EQ(Shortened(0, "ab"), "");
}

TEST(Padded, FillsUpToTheWidth) {
  EXPECT_EQ(Padded(4, "搬"), "搬  ");
  EXPECT_EQ(Padded(2, "abc"), "abc");
}

TEST(Wrapped, BreaksAtBlanksAndCutsOnlyWhatDoesNotFit) {
  using Lines = std::vector<std::string>;
  EXPECT_EQ(Wrapped(10, "motor 2 is hot"), (Lines{"motor 2 is", "hot"}));
  EXPECT_EQ(Wrapped(80, "motor 2"), Lines{"motor 2"});
  EXPECT_EQ(Wrapped(4, "abcdefghij k"), (Lines{"abcd", "efgh", "ij k"}));
  EXPECT_EQ(Wrapped(4, "x abcdefg"), (Lines{"x", "abcd", "efg"}));
  EXPECT_EQ(Wrapped(4, "搬送車 a"), (Lines{"搬送", "車 a"}));
  EXPECT_EQ(Wrapped(1, "搬"), Lines{"搬"});
  EXPECT_EQ(Wrapped(5, ""), Lines{""});
}

}  // namespace
}  // namespace fleetpub::base
