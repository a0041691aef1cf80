#include "base/json.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <string>

#include "base/text.h"

namespace fleetpub::base {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string Nested(int depth) {
  return std::string(static_cast<std::size_t>(depth), '[') +
         std::string(static_cast<std::size_t>(depth), ']');
}

// The sentence of the refusal, or "" when the text was taken.
std::string Refusal(std::string_view text, JsonLimits limits = {}) {
  const auto document = ParseJson(text, limits);
  if (document) return "";
  EXPECT_EQ(document.error().kind, ErrorKind::kInvalid);
  return document.error().message;
}

// What comes out when the text goes in, or the refusal.
std::string RoundTrip(std::string_view text) {
  const auto document = ParseJson(text);
  return document ? ToJson(*document) : "refused: " + document.error().message;
}

TEST(ParseJson, TakesEveryKindOfValue) {
  for (const std::string text :
       {"null", "true", "false", "0", "-1", "1.5", R"("")", R"("text")", "[]", "{}", R"([1,[2]])",
        R"({"a":{"b":[null]}})", "18446744073709551615", "-9223372036854775808"}) {
    EXPECT_EQ(RoundTrip(text), text);
  }
}

TEST(ParseJson, PassesOverAByteOrderMark) { EXPECT_EQ(RoundTrip("\xEF\xBB\xBF{}"), "{}"); }

TEST(ParseJson, PassesOverWhiteSpaceAroundTheValue) { EXPECT_EQ(RoundTrip(" \t\r\n{} \n"), "{}"); }

TEST(ParseJson, RefusesWhatADoubleWouldMakeAnotherNumberWhereItIsSentOn) {
  for (const char* text : {"[18446744073709551616]", "[-9223372036854775809]",
                           R"({"a":{"b":99999999999999999999999}})"}) {
    EXPECT_TRUE(ParseJson(text)) << text;
    const auto refused = ParseJson(text, {.exact = true});
    ASSERT_FALSE(refused) << text;
    EXPECT_THAT(refused.error().message, HasSubstr("more than 64 bits"));
  }
  for (const char* text : {"[18446744073709551615]", "[-9223372036854775808]", "[1.5e22]",
                           R"(["99999999999999999999999"])"}) {
    EXPECT_TRUE(ParseJson(text, {.exact = true})) << text;
  }
}

TEST(ParseJson, KeepsDigitsOfADouble) {
  EXPECT_EQ(ParseJson("3.141592653589793")->GetDouble(), 3.141592653589793);
  EXPECT_EQ(ParseJson("5e-324")->GetDouble(), 5e-324);
  EXPECT_EQ(ParseJson("123456789012345678901234567890")->GetDouble(),
            123456789012345678901234567890.);
}

// RapidJSON normalises a significand of 0 there.
TEST(ParseJson, TakesAZeroWithAnExponent) {
  for (const char* text : {"0e-41", "0e0041", "-0.0e40", "0.000e-300", "0e1"}) {
    const auto document = ParseJson(text);
    ASSERT_TRUE(document) << text;
    EXPECT_EQ(document->GetDouble(), 0.0) << text;
  }
}

TEST(ParseJson, RefusesWhatIsNoJson) {
  for (const std::string_view text :
       {"",         " ",        "{",          "]",     "{]",       "[1,]",      R"({"a":1,})",
        "{a:1}",    "{'a':1}",  "nul",        "NaN",   "Infinity", "-Infinity", "+1",
        "01",       ".5",       "1.",         "1e",    "0x10",     "1 2",       "{}{}",
        "[1] x",    "// no\n1", "/* no */ 1", R"("a)", "\"a\nb\"", R"("\q")",   R"("\u12")",
        R"({"a"})", R"({1:2})"}) {
    EXPECT_NE(Refusal(text), "") << text;
  }
}

TEST(ParseJson, SaysWhereTheFaultIs) {
  EXPECT_THAT(Refusal("{\n  \"a\": 1,\n  \"b\": oops\n}"),
              StartsWith("not valid JSON at line 3, column 8: "));
  EXPECT_THAT(Refusal(""), StartsWith("not valid JSON at line 1, column 1: "));
}

TEST(ParseJson, EndsNoSentenceWithAFullStop) {
  EXPECT_NE(Refusal("[1,]").back(), '.');
  EXPECT_NE(Refusal("nul").back(), '.');
}

TEST(ParseJson, RefusesANulByteWhereverItStands) {
  using namespace std::string_view_literals;
  for (const auto text : {"\0"sv, "{}\0"sv, "\"a\0b\""sv, "[1,\0 2]"sv}) {
    EXPECT_THAT(Refusal(text), HasSubstr("NUL byte"));
  }
}

TEST(ParseJson, KeepsAnEscapedNulInAText) {
  const auto document = ParseJson(R"("a\u0000b")");
  ASSERT_TRUE(document);
  EXPECT_EQ(ToView(*document), std::string_view("a\0b", 3));
}

TEST(ParseJson, RefusesInvalidUtf8) {
  for (const std::string_view text : {"\"\xFF\"", "\"\xC0\x80\"", "\"\xC3\"", "\"\xED\xA0\x80\"",
                                      "\"\xF4\x90\x80\x80\"", "{\"\x80\":1}"}) {
    EXPECT_NE(Refusal(text), "") << Printable(text);
  }
}

TEST(ParseJson, SaysThatATextIsCutOff) {
  for (const char* text : {R"({"a":)", R"({"a":1)", "[1, \n", "{"}) {
    EXPECT_THAT(Refusal(text), HasSubstr("the text ends before it is complete")) << text;
  }
}

TEST(ParseJson, RefusesALoneSurrogate) {
  for (const std::string_view text :
       {R"("\ud800")", R"("\udc00")", R"("a\udfffb")", R"("\ud800x")", R"("\ud800\ud800")",
        R"("\udc00\ud800")", R"({"\udc00":1})"}) {
    EXPECT_THAT(Refusal(text), HasSubstr("surrogate")) << text;
  }
}

TEST(ParseJson, JoinsAPairOfSurrogates) {
  EXPECT_EQ(RoundTrip(R"("\ud83e\udd16")"), "\"\xF0\x9F\xA4\x96\"");
  EXPECT_EQ(RoundTrip("\"\xED\x95\x9C\""), "\"\xED\x95\x9C\"");  // U+D55C is a letter
}

TEST(ParseJson, ReadsTheSmallestNumbers) {
  EXPECT_EQ(ParseJson("1.000000990001000000e-340")->GetDouble(), 0.0);
  EXPECT_EQ(ParseJson("4.940656458412465441765687928682213723651e-324")->GetDouble(), 5e-324);
  EXPECT_EQ(ParseJson("2.4703282292062327208e-324")->GetDouble(), 0.0);
  EXPECT_TRUE(std::signbit(ParseJson("-1e-999")->GetDouble()));
}

TEST(ParseJson, KeepsWholeNumbersWhole) {
  EXPECT_TRUE(ParseJson("-0")->IsInt());
  EXPECT_EQ(ParseJson("4294967295")->GetUint(), 4'294'967'295U);
  EXPECT_EQ(ParseJson("-9223372036854775808")->GetInt64(), INT64_MIN);
  EXPECT_EQ(ParseJson("18446744073709551615")->GetUint64(), UINT64_MAX);
  EXPECT_FALSE(ParseJson("1.0")->IsInt64());
  EXPECT_FALSE(ParseJson("1e3")->IsInt64());
}

TEST(ParseJson, RefusesANumberThatNoDoubleHolds) {
  EXPECT_NE(Refusal("1e309"), "");
  EXPECT_NE(Refusal("-1e999999999"), "");
  EXPECT_NE(Refusal(std::string(400, '9')), "");
  EXPECT_EQ(Refusal("1e-999"), "");
}

TEST(ParseJson, TakesDepth64AndRefusesDepth65) {
  EXPECT_EQ(Refusal(Nested(64)), "");
  EXPECT_THAT(Refusal(Nested(65)),
              "not accepted at line 1, column 65: nested more than 64 levels deep");
  EXPECT_EQ(Refusal("[" + Nested(63) + "," + Nested(63) + "]"), "") << "depth, not brackets";
}

TEST(ParseJson, SurvivesAMillionBrackets) {
  EXPECT_THAT(Refusal(std::string(1'000'000, '[')), HasSubstr("nested more than 64 levels"));
  std::string objects;
  for (int i = 0; i < 1'000'000; ++i) objects += R"({"a":)";
  EXPECT_THAT(Refusal(objects), HasSubstr("nested more than 64 levels"));
}

TEST(ParseJson, RefusesWhatIsTooLarge) {
  EXPECT_EQ(Refusal("[1,2]", {.bytes = 5}), "");
  EXPECT_EQ(Refusal("[1,2 ]", {.bytes = 5}), "too large: 6 bytes, at most 5 are read");
}

TEST(ParseJson, RefusesARepeatedName) {
  constexpr std::pair<std::string_view, std::string_view> kCases[] = {
      {R"({"a":1,"a":2})", "/a appears twice"},
      {R"({"a":1,"\u0061":2})", "/a appears twice"},
      {R"({"":1,"":2})", "/ appears twice"},
      {R"({"o":{"x":[0,{"b":1,"c":2,"b":3}]}})", "/o/x/1/b appears twice"},
      {R"([[{"a/b":1,"a/b":2}]])", "/0/0/a~1b appears twice"},
      {R"({"m~n":{"a":1,"a":2}})", "/m~0n/a appears twice"},
  };
  for (const auto& [text, sentence] : kCases) EXPECT_EQ(Refusal(text), sentence) << text;
}

TEST(ParseJson, RefusesARepeatedNameAmongMany) {
  std::string members;
  for (int i = 0; i < 100; ++i) members += "\"k" + std::to_string(i) + "\":0,";
  EXPECT_EQ(Refusal("{" + members + "\"k100\":0}"), "");
  EXPECT_EQ(Refusal("{" + members + "\"k42\":0}"), "/k42 appears twice");
}

TEST(ParseJson, SeesARepeatedNameOnBothSidesOfTheLimitForFewMembers) {
  for (int count = 1; count < 40; ++count) {
    std::string members = R"("first":0)";
    for (int i = 1; i < count; ++i) members += ",\"k" + std::to_string(i) + "\":0";
    EXPECT_EQ(Refusal("{" + members + "}"), "") << count;
    EXPECT_EQ(Refusal("{" + members + R"(,"first":1})"), "/first appears twice") << count;
  }
}

TEST(ParseJson, DistinguishesNamesThatDifferInCaseOrBehindANul) {
  EXPECT_EQ(Refusal(R"({"a":1,"A":2,"a\u0000":3,"a ":4})"), "");
}

TEST(ParseJson, KeepsTheSameNameInDifferentObjects) {
  EXPECT_EQ(Refusal(R"([{"key":1},{"key":2,"value":{"key":3}}])"), "");
}

TEST(ToPrettyJson, IndentsByTwo) {
  EXPECT_EQ(ToPrettyJson(*ParseJson(R"({"a":[1]})")), "{\n  \"a\": [\n    1\n  ]\n}");
}

TEST(ShownJson, EscapesWhatNobodyWouldSeeAndChangesNoValue) {
  const std::string json = "{\n  \"a\u202Eb\": \"\u0085\x7F\u00AD\U000E0041 ü機\\n\\\\\"}";
  const std::string shown = ShownJson(json);
  EXPECT_EQ(shown, "{\n  \"a\\u202eb\": \"\\u0085\\u007f\\u00ad\\udb40\\udc41 ü機\\n\\\\\"}");
  EXPECT_EQ(*ParseJson(shown), *ParseJson(json));
  EXPECT_EQ(ShownJson("\"\x9B\xC3\""), R"("\ufffd\ufffd")");
}

TEST(JsonString, Escapes) {
  EXPECT_EQ(JsonString("a\"b\\c\n\x01"), R"("a\"b\\c\n\u0001")");
  EXPECT_EQ(JsonString(std::string_view("a\0b", 3)), R"("a\u0000b")");
  EXPECT_EQ(JsonString("Straße"), "\"Straße\"");
  EXPECT_EQ(JsonString(""), "\"\"");
}

TEST(FindMember, FindsWhatIsThere) {
  const auto document = ParseJson(R"({"a":1,"b":"text"})");
  ASSERT_NE(FindMember(*document, "a"), nullptr);
  EXPECT_EQ(FindMember(*document, "a")->GetInt(), 1);
  EXPECT_EQ(FindMember(*document, "c"), nullptr);
  EXPECT_EQ(FindMember(*ParseJson("[1]"), "a"), nullptr) << "no object";
}

TEST(StringMember, IsEmptyWhenItIsNoString) {
  const auto document = ParseJson(R"({"a":1,"b":"text"})");
  EXPECT_EQ(StringMember(*document, "b"), "text");
  EXPECT_EQ(StringMember(*document, "a"), "");
  EXPECT_EQ(StringMember(*document, "c"), "");
  EXPECT_EQ(StringMember(*ParseJson("null"), "a"), "");
}

TEST(PointerToken, EscapesTildeAndSlash) {
  EXPECT_EQ(PointerToken("a/b~c"), "a~1b~0c");
  EXPECT_EQ(PointerToken("~1"), "~01");
  EXPECT_EQ(PointerToken(""), "");
}

TEST(RapidJson, ThrowsWhereItWouldAbort) {
  const auto document = ParseJson("1");
  EXPECT_THROW(std::ignore = document->GetString(), JsonAssertion);
}

TEST(RenameMember, RenamesAMemberOfTheTopLevelOnly) {
  auto document = ParseJson(R"({"a":{"a":1},"b":2})");
  ASSERT_TRUE(document.has_value());
  RenameMember(*document, "a", "c");
  RenameMember(*document, "missing", "d");
  EXPECT_EQ(ToJson(*document), R"({"c":{"a":1},"b":2})");
}

// ── leniently ──

std::string Leniently(std::string_view text) {
  const auto document = ParseJsonLeniently(text);
  return document ? ToJson(*document) : "refused: " + document.error().message;
}

TEST(ParseJsonLeniently, TakesWhatCanOnlyMeanOneThing) {
  using namespace std::string_view_literals;
  for (const auto& [text, meaning] : {
           std::pair("{\"a\":1}\0\0\n\0"sv, R"({"a":1})"sv),
           std::pair("[NaN,-Infinity,Infinity,nan,-nan,inf]"sv,
                     "[null,null,null,null,null,null]"sv),
           std::pair(R"(["NaN",true,null,1e5])"sv, R"(["NaN",true,null,100000.0])"sv),
           std::pair("[\"Stra\xDF"
                     "e\"]"sv,
                     "[\"Stra\uFFFD"
                     "e\"]"sv),
           std::pair("[\"a\tb\n\x01\0\"]"sv, R"(["a\tb\n\u0001\u0000"])"sv),
           std::pair(R"(["\ud83d","\udc00","\ud83d\ude00"])"sv,
                     "[\"\uFFFD\",\"\uFFFD\",\"\U0001F600\"]"sv),
           std::pair(R"({"a":1,"b":{"c":1,"c":2},"a":3})"sv, R"({"b":{"c":2},"a":3})"sv),
           std::pair(R"(["\"NaN\\",NaN])"sv, R"(["\"NaN\\",null])"sv),
       }) {
    EXPECT_FALSE(ParseJson(text) && text != R"(["NaN",true,null,1e5])"sv) << text;
    EXPECT_EQ(Leniently(text), meaning);
  }
}

TEST(ParseJsonLeniently, GuessesNothing) {
  for (const std::string_view text : {"{\"a\":1", "{\"a\":1}}", "{'a':1}", "{\"a\":1,}", "{a:1}",
                                      "", "[1.]", "[nanny]", "[--inf]", "\"\\u12", "\"\\"}) {
    EXPECT_THAT(Leniently(text), StartsWith("refused: ")) << text;
  }
  EXPECT_THAT(Leniently(Nested(65)), HasSubstr("64 levels"));
}

}  // namespace
}  // namespace fleetpub::base
