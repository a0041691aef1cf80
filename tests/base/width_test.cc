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

TEST(Wrapped, BreaksBetweenWords) {
  EXPECT_EQ(Wrapped(80, 4, "a short line"), "a short line");
  EXPECT_EQ(Wrapped(10, 2, "one two three four"), "one two\n  three\n  four");
  EXPECT_EQ(Wrapped(9, 4, "搬送 車車 a"), "搬送 車車\n    a") << "as wide as the letters";
}

TEST(Wrapped, KeepsWhatStandsApartAndCutsWhatIsTooWide) {
  EXPECT_EQ(Wrapped(12, 4, "  KIT/1  FAILED  x"), "  KIT/1\n    FAILED\n    x");
  EXPECT_EQ(Wrapped(20, 4, "KIT/1  FAILED  x"), "KIT/1  FAILED  x");
  EXPECT_EQ(Wrapped(6, 2, "abcdefghij k"), "abcdef\n  ghij\n  k");
  EXPECT_EQ(Wrapped(4, 0, "x 搬送車 a"), "x\n搬送\n車 a");
  EXPECT_EQ(Wrapped(1, 0, "搬"), "搬");
  EXPECT_EQ(Wrapped(4, 2, ""), "");
}

TEST(Wrapped, KeepsACommandInOnePiece) {
  EXPECT_EQ(Wrapped(20, 2, "none. try: fleetpub x"), "none.\n  try: fleetpub x");
  EXPECT_EQ(Wrapped(21, 2, "none. try: fleetpub x"), "none. try: fleetpub x");
  EXPECT_EQ(Wrapped(9, 2, "none. try: fleetpub fleet"), "none.\n  try: fleetpub fleet")
      << "a terminal breaks it without a new line";
}

TEST(Wrapped, CountsNoColours) {
  EXPECT_EQ(Wrapped(7, 2, "\x1b[31mred\x1b[0m \x1b[1;32mtea\x1b[0m"),
            "\x1b[31mred\x1b[0m \x1b[1;32mtea\x1b[0m");
}

}  // namespace
}  // namespace fleetpub::base
