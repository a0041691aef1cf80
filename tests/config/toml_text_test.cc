#include "config/toml_text.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

namespace fleetpub::config {
namespace {

using ::testing::HasSubstr;

std::string Json(std::string_view toml) {
  const auto json = TomlToJson(toml);
  return json ? *json : "error: " + json.error().message;
}

TEST(TomlText, BecomesJson) {
  EXPECT_EQ(Json(""), "{}");
  EXPECT_EQ(Json("a = 1\nb = 1.5\nc = true\nd = \"say \\\"so\\\"\"\n"),
            R"({"a":1,"b":1.5,"c":true,"d":"say \"so\""})");
  EXPECT_EQ(Json("[[s]]\nx = [1, [2]]\n[[s]]\n[s.t]\ny = {}\n"),
            R"({"s":[{"x":[1,[2]]},{"t":{"y":{}}}]})");
  EXPECT_EQ(Json("a = 2026-01-02\nb = 03:04:05\nc = 2026-01-02T03:04:05Z"),
            R"({"a":"2026-01-02","b":"03:04:05","c":"2026-01-02T03:04:05Z"})");
}

TEST(TomlText, SaysWhichLineIsNone) {
  EXPECT_THAT(Json("a = 1\nb = \n"), HasSubstr("line 2: not valid TOML"));
  EXPECT_THAT(Json("a = 1\na = 2\n"), HasSubstr("line 2"));
  EXPECT_THAT(Json("\na = nan\n"), HasSubstr("line 2: JSON has no such number as nan"));
  EXPECT_THAT(Json("a = [inf]"), HasSubstr("no such number"));
  EXPECT_THAT(Json("a = \"\xFF\""), HasSubstr("error"));
  EXPECT_THAT(Json("a = " + std::string(100'000, '[')), HasSubstr("error"));
  EXPECT_EQ(TomlToJson("=").error().kind, ErrorKind::kInvalid);
}

std::string Times(int count, std::string_view part) {
  std::string text;
  for (int i = 0; i < count; ++i) text += part;
  return text;
}

// The library limits how deep values lie in each other, not how many parts a key has.
TEST(TomlText, RefusesWhatIsTooDeepHoweverItIsWritten) {
  const std::string before = "s = '''it's'''\nt = \"\"\"a\\\"\"\"\"\"\nu = '\\' # '\n";
  const std::string deep = Times(100'000, "a.") + "a";
  const std::string quoted = Times(100'000, " 'a' . \"b\\\"\" . ") + "a";
  for (const std::string& text :
       {deep + " = 1\n", "[" + deep + "]\nb = 1\n", "[[" + quoted + "]]\n",
        before + deep + " = 1\n", "x = {" + deep + " = 1}\n", "x = [1, {" + deep + " = 1}]\n",
        deep + " = !\n", "a = " + Times(65, "[") + Times(65, "]"),
        "a = " + Times(40, "{ b.b.b = ") + "1" + Times(40, " }"),
        "[" + Times(40, "a.") + "a]\n" + Times(40, "b.") + "b = 1\n"}) {
    EXPECT_THAT(Json(text), HasSubstr("more than 64 levels")) << text.substr(0, 60);
    const auto value = ParseToml(text);
    ASSERT_FALSE(value) << text.substr(0, 60);
    EXPECT_EQ(value.error().kind, ErrorKind::kUsage);
  }
}

TEST(TomlText, CountsNoDotsOfStringsCommentsAndOtherKeys) {
  const std::string dots = Times(200, "a.");
  EXPECT_TRUE(
      TomlToJson("x = '" + dots + "' # " + dots + "\ny = \"" + dots + "\\\"" + dots + "\""));
  EXPECT_TRUE(TomlToJson("x = \"\"\"\n" + dots + "\"\"" + dots + "\"\"\"\nb.c = 1\n"));
  std::string many;
  for (int i = 0; i < 100; ++i) many += fmt::format("a.k{} = 1.5\n[t.u{}]\n", i, i);
  EXPECT_TRUE(TomlToJson(many));
  EXPECT_TRUE(ParseToml(Times(62, "a.") + "a = 1\n"));
}

// The library asserts that a digit stands there.
TEST(TomlText, SurvivesATimeThatIsNone) {
  EXPECT_THAT(Json("a = 1979-05-27Tx:00:00\n"), HasSubstr("not valid TOML"));
  const auto value = ParseToml("a = [1979-05-27T\x01:00]\n");
  ASSERT_FALSE(value);
  EXPECT_EQ(value.error().kind, ErrorKind::kUsage);
}

// The library takes this character for one that cannot stand there.
TEST(TomlText, SurvivesALetterBehindANumber) {
  EXPECT_THAT(Json("a = [1, 2.5,99999999999999999999999999999\u01FF9999000"),
              HasSubstr("not valid TOML"));
}

}  // namespace
}  // namespace fleetpub::config
