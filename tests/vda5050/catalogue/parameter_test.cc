#include "vda5050/catalogue/parameter.h"

#include <gmock/gmock.h>

#include "base/json.h"
#include "support/temporary_folder.h"

namespace fleetpub::vda5050 {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr ParameterSpec kX{"x", ParameterType::kLength, true, ""};
constexpr ParameterSpec kTheta{"theta", ParameterType::kAngle, true, ""};
constexpr ParameterSpec kMapId{"mapId", ParameterType::kString, true, ""};
constexpr ParameterSpec kTriggerType{"triggerType", ParameterType::kStringArray, true, ""};

// The JSON made of what was typed, or the refusal.
std::string Typed(const ParameterSpec& spec, std::string_view text) {
  const auto parameter = ParseParameter(spec, text);
  if (!parameter) {
    EXPECT_EQ(parameter.error().kind, ErrorKind::kUsage);
    return "refused: " + parameter.error().message;
  }
  EXPECT_EQ(parameter->key, spec.name);
  return parameter->json;
}

// `key json`, or the refusal.
std::string Assigned(std::string_view text) {
  const auto parameter = ParseAssignment(text);
  return parameter ? parameter->key + " " + parameter->json : parameter.error().message;
}

TEST(ParseParameter, LeavesAJsonNumberAsItWasTyped) {
  for (const std::string_view text : {"0", "-0", "1", "1.5", "-2", "1.50", "1e3", "1E-3", "0.1"}) {
    EXPECT_EQ(Typed(kX, text), text);
  }
}

TEST(ParseParameter, MakesJsonOfWhatPeopleWrite) {
  constexpr std::pair<std::string_view, std::string_view> kCases[] = {
      {"+1", "1"}, {".5", "0.5"}, {"-.5", "-0.5"}, {"1.", "1"}, {"007", "7"}, {"+1.5e2", "150"}};
  for (const auto& [text, json] : kCases) {
    EXPECT_EQ(Typed(kX, text), json) << text;
    EXPECT_TRUE(base::ParseJson(Typed(kX, text))->IsNumber());
  }
}

TEST(ParseParameter, RefusesWhatIsNoFiniteNumber) {
  for (const std::string_view text :
       {"", "nan", "NaN", "inf", "-inf", "infinity", "1e999", "0x10", "1 ", " 1", "1km", "1deg",
        "m", "++1", "+-1", "-+1", "-", "+", "."}) {
    EXPECT_EQ(Typed(kX, text),
              "refused: x must be a finite number, not '" + std::string(text) + "'");
  }
}

TEST(ParseParameter, TakesUnitsOfItsKind) {
  constexpr std::pair<std::string_view, std::string_view> kLengths[] = {
      {"1.5m", "1.5"}, {"2 m", "2"}, {"-150cm", "-1.5"}, {"+2500mm", "2.5"}, {".5m", "0.5"}};
  for (const auto& [text, json] : kLengths) EXPECT_EQ(Typed(kX, text), json) << text;
  constexpr std::pair<std::string_view, double> kAngles[] = {
      {"1.57rad", 1.57}, {"90deg", 1.5707963}, {"-180 deg", -3.1415926}, {"45°", 0.7853981}};
  for (const auto& [text, radians] : kAngles) {
    EXPECT_NEAR(base::ParseJson(Typed(kTheta, text))->GetDouble(), radians, 1e-6) << text;
  }
  EXPECT_THAT(Typed(kX, "90deg"), StartsWith("refused"));
  EXPECT_THAT(Typed(kTheta, "1.5m"), StartsWith("refused"));
}

TEST(ParseParameter, SaysWhatASlipShouldHaveBeen) {
  constexpr std::pair<std::string_view, std::string_view> kSlips[] = {
      {"1,5", "write 1.5"},        {"-0,25", "write -0.25"},    {"90", "write 90deg, or 1.57"},
      {"180", "or 3.1415 in"},     {"270", "write -90deg"},     {"270deg", "write -90deg"},
      {"4.71", "that is -1.5731"}, {"1,57rad", "write 1.57rad"}};
  for (const auto& [text, hint] : kSlips) EXPECT_THAT(Typed(kTheta, text), HasSubstr(hint)) << text;
  for (const std::string_view text : {"1,5,2", "1,234.5", ",5", "720", "5,"}) {
    EXPECT_THAT(Typed(kTheta, text), ::testing::EndsWith("not '" + std::string(text) + "'"))
        << text;
  }
  // What is suggested is taken.
  EXPECT_TRUE(ParseParameter(kTheta, "180deg"));
  EXPECT_TRUE(ParseParameter(kTheta, "3.1415"));
}

TEST(ParseParameter, TakesPiAsThePublishedSchemasWriteIt) {
  for (const char* text : {"3.14159265359", "-3.14159265359", "3.141592653589793"}) {
    EXPECT_TRUE(ParseParameter(kTheta, text)) << text;
  }
  for (const char* text : {"3.1416", "-3.1416", "3.141593"}) {
    EXPECT_FALSE(ParseParameter(kTheta, text)) << text;
  }
}

TEST(ParseParameter, HoldsAnAngleBetweenMinusPiAndPi) {
  for (const std::string_view text : {"3.141592653589793", "-3.141592653589793", "0", "3.14"}) {
    EXPECT_EQ(Typed(kTheta, text), text);
  }
  for (const std::string_view text : {"3.1415926536", "-3.15", "90", "1e300"}) {
    EXPECT_THAT(Typed(kTheta, text),
                StartsWith("refused: theta must be an angle in radians between -π and π, not '" +
                           std::string(text) + "'"));
  }
  EXPECT_EQ(Typed(kX, "90"), "90") << "other numbers are no angles";
}

TEST(ParseParameter, KeepsAStringWhateverItLooksLike) {
  EXPECT_EQ(Typed(kMapId, "1"), R"("1")");
  EXPECT_EQ(Typed(kMapId, "true"), R"("true")");
  EXPECT_EQ(Typed(kMapId, "@file"), R"("@file")");
  EXPECT_EQ(Typed(kMapId, ""), R"("")");
  EXPECT_EQ(Typed(kMapId, "hall \"1\"\n"), R"("hall \"1\"\n")");
}

TEST(ParseParameter, SplitsAnArrayAtCommas) {
  EXPECT_EQ(Typed(kTriggerType, "LOCAL"), R"(["LOCAL"])");
  EXPECT_EQ(Typed(kTriggerType, "FLEET_CONTROL,LOCAL"), R"(["FLEET_CONTROL","LOCAL"])");
}

TEST(ParseParameter, RefusesInvalidUtf8OfEveryType) {
  for (const ParameterSpec& spec : {kX, kTheta, kMapId, kTriggerType}) {
    EXPECT_THAT(Typed(spec, "\xFF"), HasSubstr("must be valid UTF-8, not '\\xff'"));
  }
}

TEST(ParseAssignment, TakesTextAndJson) {
  constexpr std::pair<std::string_view, std::string_view> kCases[] = {
      {"mode=loud", R"(mode "loud")"},
      {"mode=", R"(mode "")"},
      {"n=3", R"(n "3")"},
      {"n:=3", "n 3"},
      {"n:=-1.5e3", "n -1500.0"},
      {"b:=true", "b true"},
      {"s:=\"3\"", R"(s "3")"},
      {"a:=[1, {\"b\": []}]", R"(a [1,{"b":[]}])"},
      {"url=http://host/?a=b", R"(url "http://host/?a=b")"},
      {"a=:=1", R"(a ":=1")"},
      {"a:b=c", R"(a:b "c")"},
      {"a::=1", "a: 1"},
      {"größe=ü", "größe \"ü\""},
  };
  for (const auto& [text, expected] : kCases) EXPECT_EQ(Assigned(text), expected) << text;
}

TEST(ParseAssignment, ReadsAFile) {
  const testing::TemporaryFolder folder;
  const std::string text = folder.Write("text", "line 1\nline 2\n").string();
  const std::string json = folder.Write("area.json", "{ \"a\": 1 }\n").string();
  EXPECT_EQ(Assigned("note=@" + text), R"(note "line 1\nline 2\n")");
  EXPECT_EQ(Assigned("area:=@" + json), R"(area {"a":1})");
  EXPECT_EQ(Assigned("area=@" + json), R"(area "{ \"a\": 1 }\n")");
}

TEST(ParseAssignment, NamesAFileThatCannotBeRead) {
  const auto parameter = ParseAssignment("area:=@/nowhere/area.json");
  ASSERT_FALSE(parameter);
  EXPECT_EQ(parameter.error().kind, ErrorKind::kLedger);
  EXPECT_EQ(parameter.error().message, "cannot open /nowhere/area.json: No such file or directory");
}

TEST(ParseAssignment, NeverRepeatsWhatMayBeAPassword) {
  for (const std::string_view text : {"s3cret", "s3cret:", "@s3cret", ":s3cret"}) {
    const auto parameter = ParseAssignment(text);
    ASSERT_FALSE(parameter) << text;
    EXPECT_EQ(parameter.error().kind, ErrorKind::kUsage);
    EXPECT_THAT(parameter.error().message, Not(HasSubstr("s3cret")));
    EXPECT_THAT(parameter.error().message, HasSubstr("--password-file"));
    EXPECT_THAT(parameter.error().detail, Not(HasSubstr("s3cret")));
  }
}

TEST(ParseAssignment, WantsAKey) {
  for (const std::string_view text : {"=s3cret", ":=s3cret", "\xFF=1"}) {
    EXPECT_EQ(Assigned(text), "-P: the key before the '=' is empty or not valid UTF-8");
  }
}

TEST(ParseAssignment, RefusesWhatIsNoJson) {
  EXPECT_THAT(Assigned("mode:=loud"), StartsWith("-P mode:= takes JSON: not valid JSON at line 1, "
                                                 "column 1: "));
  EXPECT_THAT(Assigned("mode:=loud"), ::testing::EndsWith("(for plain text: -P mode=…)"));
  for (const std::string_view text :
       {"a:=", "a:={\"b\":1,\"b\":2}", "a:=NaN", "a:=1e999", "a:=\"\\udc00\"", "a:=[1,]"}) {
    const auto parameter = ParseAssignment(text);
    ASSERT_FALSE(parameter) << text;
    EXPECT_EQ(parameter.error().kind, ErrorKind::kUsage);
  }
}

TEST(ParseAssignment, RefusesTextThatIsNotUtf8) {
  const auto parameter = ParseAssignment("a\x1b=\xFF");
  ASSERT_FALSE(parameter);
  EXPECT_EQ(parameter.error().kind, ErrorKind::kUsage);
  EXPECT_EQ(parameter.error().message, "-P a\\x1b: the text is not valid UTF-8");
}

}  // namespace
}  // namespace fleetpub::vda5050
