#include "base/text.h"

#include <gmock/gmock.h>

#include <array>

namespace fleetpub::base {
namespace {

using ::testing::ElementsAre;
using ::testing::Optional;
using namespace std::string_view_literals;

TEST(ToLower, LeavesEverythingButAsciiLettersAlone) {
  EXPECT_EQ(ToLower("StartPAUSE-09_Ä"), "startpause-09_Ä");
}

TEST(EqualsIgnoringCase, ComparesTheWholeText) {
  EXPECT_TRUE(EqualsIgnoringCase("startPause", "STARTPAUSE"));
  EXPECT_TRUE(EqualsIgnoringCase("", ""));
  EXPECT_FALSE(EqualsIgnoringCase("start", "startPause"));
  EXPECT_FALSE(EqualsIgnoringCase("startPause", "start"));
  EXPECT_FALSE(EqualsIgnoringCase("[", "{")) << "they differ by the same bit as letters do";
}

TEST(ToKebabCase, SplitsBeforeCapitals) {
  EXPECT_EQ(ToKebabCase("mapDownloadLink"), "map-download-link");
  EXPECT_EQ(ToKebabCase("x"), "x");
  EXPECT_EQ(ToKebabCase("Upper"), "upper");
  EXPECT_EQ(ToKebabCase(""), "");
}

TEST(Join, PutsTheSeparatorBetween) {
  EXPECT_EQ(Join(std::vector<std::string>{"a", "b", "c"}, ", "), "a, b, c");
  EXPECT_EQ(Join(std::vector<std::string>{"a"}, ", "), "a");
  EXPECT_EQ(Join({}, ", "), "");
}

TEST(Split, KeepsEmptyParts) {
  EXPECT_THAT(Split("a/b", '/'), ElementsAre("a", "b"));
  EXPECT_THAT(Split("/a//", '/'), ElementsAre("", "a", "", ""));
  EXPECT_THAT(Split("", '/'), ElementsAre(""));
}

TEST(EditDistance, CountsChangesAdditionsOmissionsAndSwaps) {
  struct Case {
    std::string_view a;
    std::string_view b;
    int distance;
  };
  for (const auto& [a, b, distance] : {Case{"", "", 0},
                                       {"pause", "pause", 0},
                                       {"pause", "PAUSE", 0},
                                       {"", "abc", 3},
                                       {"pause", "pasue", 1},
                                       {"pause", "puase", 1},
                                       {"pause", "paus", 1},
                                       {"pause", "pausee", 1},
                                       {"pause", "pausa", 1},
                                       {"pause", "resume", 4},
                                       {"ab", "ba", 1},
                                       {"kitten", "sitting", 3},
                                       {"mapId", "mpaID", 1}}) {
    EXPECT_EQ(EditDistance(a, b), distance) << a << " " << b;
    EXPECT_EQ(EditDistance(b, a), distance) << b << " " << a;
  }
}

constexpr auto kCommands =
    std::to_array<std::string_view>({"pause", "resume", "cancel", "ping", "x"});

TEST(Nearest, FindsWhatATypoMeans) {
  EXPECT_THAT(Nearest("puase", kCommands), Optional("pause"sv));
  EXPECT_THAT(Nearest("RESUM", kCommands), Optional("resume"sv));
  EXPECT_THAT(Nearest("png", kCommands), Optional("ping"sv));
  EXPECT_THAT(Nearest("cancle", kCommands), Optional("cancel"sv));
  EXPECT_THAT(Nearest("X", kCommands), Optional("x"sv));
}

TEST(Nearest, FindsNothingForAnotherWord) {
  for (const std::string_view word : {"", "z", "fly", "abcdefghij", "status"}) {
    EXPECT_EQ(Nearest(word, kCommands), std::nullopt) << word;
  }
  EXPECT_EQ(Nearest("pause", {}), std::nullopt);
  EXPECT_EQ(Nearest(std::string(100'000, 'p'), kCommands), std::nullopt) << "and is quick about it";
}

TEST(Nearest, PrefersTheNearer) {
  constexpr auto kNames = std::to_array<std::string_view>({"enableMap", "enableMop", "enableM"});
  EXPECT_THAT(Nearest("enableMop", kNames), Optional("enableMop"sv));
}

TEST(Nearest, IsNeverTheOpposite) {
  constexpr auto kNames = std::to_array<std::string_view>(
      {"pause", "paused", "startPause", "enableMap", "watch", "--wait", "--no-history"});
  for (const std::string_view word : {"unpause", "unpaus", "unpaused", "stopPause", "stoppPause",
                                      "disableMap", "unwatch", "--no-wait", "--history"}) {
    EXPECT_EQ(Nearest(word, kNames), std::nullopt) << word;
  }
  EXPECT_THAT(Nearest("startPuase", kNames), Optional("startPause"sv));
  EXPECT_THAT(Nearest("enablMap", kNames), Optional("enableMap"sv));
  constexpr auto kBoth = std::to_array<std::string_view>({"charge", "uncharge"});
  EXPECT_EQ(Nearest("ncharge", kBoth), std::nullopt) << "either may be meant";
  EXPECT_THAT(Nearest("uncharg", kBoth), Optional("uncharge"sv));
}

TEST(AreOpposites, KnowsHowWordsSayNo) {
  for (const auto& [a, b] : {std::pair("pause", "unpause"),
                             {"startCharging", "stopCharging"},
                             {"enableZoneSet", "disableZoneSet"},
                             {"retry", "skipRetry"},
                             {"--check", "--no-check"},
                             {"Load", "unload"}}) {
    EXPECT_TRUE(AreOpposites(a, b)) << a << b;
    EXPECT_TRUE(AreOpposites(b, a)) << b << a;
    EXPECT_FALSE(AreOpposites(a, a)) << a;
  }
  EXPECT_FALSE(AreOpposites("node", "de"));
  EXPECT_FALSE(AreOpposites("unit", "it"));
  EXPECT_FALSE(AreOpposites("", ""));
}

TEST(IsUtf8, TakesEveryLength) {
  for (const std::string_view text :
       {""sv, "a"sv, "\0"sv, "\x7F"sv, "\xC2\x80"sv, "\xDF\xBF"sv, "\xE0\xA0\x80"sv,
        "\xED\x9F\xBF"sv, "\xEE\x80\x80"sv, "\xEF\xBF\xBF"sv, "\xF0\x90\x80\x80"sv,
        "\xF4\x8F\xBF\xBF"sv, "Straße 🤖"sv}) {
    EXPECT_TRUE(IsUtf8(text)) << Printable(text);
  }
}

TEST(IsUtf8, RefusesWhatRfc3629Forbids) {
  for (const std::string_view text :
       {"\x80", "\xBF", "\xC0\x80", "\xC1\xBF", "\xC2", "\xC2\x7F", "\xC2\xC0", "\xE0\x9F\xBF",
        "\xE0\xA0", "\xED\xA0\x80", "\xED\xBF\xBF", "\xF0\x8F\xBF\xBF", "\xF0\x90\x80",
        "\xF4\x90\x80\x80", "\xF5\x80\x80\x80", "\xFE", "\xFF", "abc\xE2\x82", "a\x80z"}) {
    EXPECT_FALSE(IsUtf8(text)) << Printable(text);
  }
}

TEST(Printable, LeavesOrdinaryTextAlone) {
  EXPECT_EQ(Printable("KIT/0001 Straße 🤖 \\"), "KIT/0001 Straße 🤖 \\");
}

TEST(Printable, ShowsWhatWouldMoveTheCursor) {
  constexpr std::pair<std::string_view, std::string_view> kCases[] = {
      {"\x1b[2J", "\\x1b[2J"},
      {"a\nb\tc\rd", "a\\nb\\tc\\x0dd"},
      {std::string_view("\0", 1), "\\x00"},
      {"\x7F", "\\x7f"},
      {"\xC2\x9B"
       "31m",
       "\\x9b31m"},  // CSI as a C1 control character
      {"\xC2\x80\xC2\x9F", "\\x80\\x9f"},
      {"\xC2\xA0", "\xC2\xA0"},  // the first one behind them
      {"\x9B"
       "31m",
       "\\x9b31m"},  // and as a bare byte
      {"a\xFF\xC3", "a\\xff\\xc3"},
      {"\xED\xA0\x80", "\\xed\\xa0\\x80"},
      {"KIT/\u202E1000", "KIT/\\u202e1000"},
      {"a\u200Bb\u2066\uFEFF", "a\\u200bb\\u2066\\ufeff"},
  };
  for (const auto& [text, shown] : kCases) EXPECT_EQ(Printable(text), shown);
}

TEST(Printable, ShowsWhatNobodyWouldSee) {
  constexpr std::pair<std::string_view, std::string_view> kCases[] = {
      {"KIT\u00AD/1", "KIT\\u00ad/1"},                     // soft hyphen
      {"\u3164\u115F\uFFA0", "\\u3164\\u115f\\uffa0"},     // Hangul fillers: letters, by category
      {"1\uFE0F\u180B", "1\\ufe0f\\u180b"},                // variation selectors
      {"\u034F\u17B4", "\\u034f\\u17b4"},                  // joiner, Khmer inherent vowel
      {"\U000E0041\U000E01EF", "\\U000e0041\\U000e01ef"},  // tag A, the last variation selector
      {"\U000E0002\u2065", "\\U000e0002\\u2065"},          // reserved for more of them
      {"\u2800", "\\u2800"},                               // braille without dots
      {"\uE000\U0010FFFD", "\\ue000\\U0010fffd"},          // private use
      {"\u2028\u2029\u206A\uFFF9", "\\u2028\\u2029\\u206a\\ufff9"}};
  for (const auto& [text, shown] : kCases) EXPECT_EQ(Printable(text), shown);
  for (const std::string text : {"Ёлка 機械 é e\u0301 ภาษา", "\u00A0\u3000", "⠁", "🛰"}) {
    EXPECT_EQ(Printable(text), text);
  }
}

TEST(Printable, LeavesNothingThatATerminalObeys) {
  std::string every_byte;
  for (int byte = 0; byte < 256; ++byte) every_byte += static_cast<char>(byte);
  const std::string shown = Printable(every_byte);
  EXPECT_TRUE(IsUtf8(shown));
  for (const char c : shown) EXPECT_GE(static_cast<unsigned char>(c), 0x20U);
}

}  // namespace
}  // namespace fleetpub::base
