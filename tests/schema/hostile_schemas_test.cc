// Schemas and messages that crash, hang or mislead validators. Each must end in an answer, and
// soon.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/json.h"
#include "schema/schema.h"
#include "schema/schema_loader.h"
#include "schema/violations.h"
#include "support/patience.h"

namespace fleetpub::schema {
namespace {

constexpr std::chrono::seconds kSoon(60 * testing::kSlowness);

Schema Compiled(std::string_view text) {
  auto schema = Schema::Compile(text, "test");
  if (!schema) throw std::runtime_error(schema.error().message);
  return std::move(*schema);
}

std::vector<Violation> Validate(std::string_view schema, std::string_view message) {
  const auto document = base::ParseJson(message);
  if (!document) return {{"parser", document.error().message}};
  const auto begin = std::chrono::steady_clock::now();
  auto violations = Compiled(schema).Validate(*document);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, kSoon);
  return violations;
}

bool IsValid(std::string_view schema, std::string_view message) {
  return Validate(schema, message).empty();
}

std::string Repeat(std::string_view text, int times) {
  std::string result;
  for (int i = 0; i < times; ++i) result += text;
  return result;
}

TEST(HostileSchemas, DeepSchemasAndMessagesAreRefused) {
  const std::string deep(1'000'000, '[');
  EXPECT_EQ(Validate("true", deep).at(0).path, "parser");
  const auto schema = Schema::Compile(Repeat(R"({"items":)", 100'000), "deep");
  ASSERT_FALSE(schema);
  EXPECT_NE(schema.error().message.find("nested more than 64 levels"), std::string::npos);
}

TEST(HostileSchemas, TextsThatAreNoJsonAreRefused) {
  const std::string nul("{\"a\":1}\0garbage", 15);
  for (const std::string& text :
       {nul, std::string("\"\xff\""), std::string("\"\xed\xa0\x80\""), std::string("{} {}"),
        std::string(R"({"a":1,"a":2})"), std::string(R"({"a":1,})"), std::string("NaN")}) {
    EXPECT_FALSE(Schema::Compile(text, "bad")) << text;
    EXPECT_EQ(Validate("true", text).at(0).path, "parser") << text;
  }
}

TEST(HostileSchemas, RegularExpressionsTakeLinearTime) {
  const std::string bomb = "\"" + std::string(100'000, 'a') + "!\"";
  EXPECT_FALSE(IsValid(R"({"pattern":"^(a+)+$"})", bomb));
  EXPECT_FALSE(IsValid(R"({"pattern":"^(a|aa)+$"})", bomb));
  EXPECT_TRUE(IsValid(R"({"pattern":"!$"})", bomb));
  EXPECT_FALSE(
      IsValid(R"({"patternProperties":{"^(a+)+$":false,"!$":false}})", "{" + bomb + ":1}"));
  EXPECT_FALSE(Schema::Compile(R"re({"pattern":"((((a{1,99}){1,99}){1,99}){1,99})"})re", "huge"));
}

TEST(HostileSchemas, LongStringsAreOnlyStrings) {
  const std::string text = "\"" + std::string(1'000'000, 'x') + "\"";
  EXPECT_FALSE(IsValid(R"({"format":"date-time"})", text));
  EXPECT_TRUE(IsValid(R"({"minLength":1000000,"maxLength":1000000})", text));
  EXPECT_TRUE(IsValid(R"({"pattern":"x$"})", text));
  EXPECT_EQ(Validate("true", "\"" + std::string(17'000'000, 'x') + "\"").at(0).path, "parser");
}

TEST(HostileSchemas, ManyItemsAreComparedInReasonableTime) {
  std::string different = "[0";
  for (int i = 1; i < 50'000; ++i) different += fmt::format(",{}", i);
  EXPECT_TRUE(IsValid(R"({"uniqueItems":true})", different + "]"));
  const auto twice = Validate(R"({"uniqueItems":true})", different + ",7.0]");
  ASSERT_EQ(twice.size(), 1U);
  EXPECT_EQ(twice[0].message, "must not hold an item twice: items 7 and 50000 are equal");
}

TEST(HostileSchemas, ALateFaultInALongMessageIsFound) {
  const auto found =
      Validate(R"({"items":{"$ref":"#/definitions/a"},"definitions":{"a":{"type":"integer"}}})",
               "[" + Repeat("1,", 100'000) + "\"x\"]");
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].path, "/100000");
}

TEST(HostileSchemas, RecursiveSchemasFollowTheMessage) {
  constexpr std::string_view kTree =
      R"({"properties":{"child":{"$ref":"#"},"n":{"type":"integer"}},"additionalProperties":false})";
  const auto nested = [](std::string_view inner) {
    return Repeat(R"({"n":1,"child":)", 60) + std::string(inner) + std::string(60, '}');
  };
  EXPECT_TRUE(IsValid(kTree, nested("{}")));
  const auto found = Validate(kTree, nested(R"({"n":"x"})"));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].path, Repeat("/child", 60) + "/n");
}

TEST(HostileSchemas, TheLongestChainAtTheGreatestDepthFitsTheStack) {
  std::string definitions = R"("a0":{"properties":{"c":{"$ref":"#"}},"type":"object"})";
  for (int i = 1; i < 32; ++i) {
    definitions += fmt::format(R"(,"a{}":{{"$ref":"#/definitions/a{}"}})", i, i - 1);
  }
  // In 2020-12 a reference is one step of its own for the validator.
  const auto schema = fmt::format(
      R"({{"$schema":"https://json-schema.org/draft/2020-12/schema","definitions":{{{}}},
           "$ref":"#/definitions/a30"}})",
      definitions);
  EXPECT_TRUE(IsValid(schema, Repeat(R"({"c":)", 63) + "{}" + std::string(63, '}')));
  EXPECT_EQ(Validate(schema, Repeat(R"({"c":)", 63) + "1" + std::string(63, '}')).at(0).message,
            "must be an object, not a number");
}

// Each level of the message doubles the visits.
constexpr std::string_view kTwice =
    R"({"properties":{"a":{"$ref":"#"}},"patternProperties":{"a":{"$ref":"#"}}})";

bool IsTooMuchWork(std::string_view schema, int levels, int most_work) {
  const auto message = base::ParseJson(Repeat(R"({"a":)", levels) + "1" + Repeat("}", levels));
  const auto checked = LoadSchema(schema);
  if (!checked) throw std::runtime_error(checked.error().message);
  const auto found = CollectViolations(**checked, *message, most_work);
  return found.size() == 1 && found[0].message.find("too much work") != std::string::npos;
}

TEST(HostileSchemas, ExponentialWorkIsGivenUp) {
  EXPECT_TRUE(IsTooMuchWork(kTwice, 60, 10'000));
  EXPECT_TRUE(IsTooMuchWork(fmt::format(R"({{"not":{}}})", kTwice), 60, 10'000));
  EXPECT_TRUE(IsTooMuchWork(fmt::format(R"({{"oneOf":[{0},{0}]}})", kTwice), 60, 10'000));
}

TEST(HostileSchemas, WorkIsGivenUpWhileTheNearestAlternativeIsSought) {
  constexpr std::string_view kLate =
      R"({"anyOf":[{"$ref":"#/definitions/a"},{"$ref":"#/definitions/a"}],
          "definitions":{"a":{"allOf":[{"$ref":"#/definitions/b"},{"type":"array"}]},
                         "b":{"properties":{"a":{"$ref":"#/definitions/b"}},
                              "patternProperties":{"a":{"$ref":"#/definitions/b"}}}}})";
  EXPECT_TRUE(IsTooMuchWork(kLate, 12, 20'000));  // four times some 8,000
  EXPECT_FALSE(IsTooMuchWork(kLate, 12, 40'000));
}

TEST(HostileSchemas, TheLargestMessageIsNotTooMuchWork) {
  // The shortest item takes two bytes.
  EXPECT_GT(static_cast<std::size_t>(kMostWork), base::JsonLimits().bytes / 2);
}

TEST(HostileSchemas, NumbersMeanWhatTheySay) {
  EXPECT_TRUE(IsValid(R"({"type":"integer"})", "1.0"));
  EXPECT_TRUE(IsValid(R"({"type":"integer"})", "1e300"));
  EXPECT_FALSE(IsValid(R"({"type":"integer"})", "1.5"));
  EXPECT_TRUE(IsValid(R"({"minimum":0})", "18446744073709551615"));
  EXPECT_FALSE(IsValid(R"({"maximum":0})", "18446744073709551615"));
  EXPECT_TRUE(IsValid(R"({"const":1})", "1.0"));
  EXPECT_FALSE(IsValid(R"({"const":9007199254740993})", "9007199254740992"));
  EXPECT_FALSE(IsValid(R"({"const":1})", "true"));
  EXPECT_FALSE(IsValid(R"({"multipleOf":1})", "1.5"));
  EXPECT_TRUE(IsValid(R"({"multipleOf":0.0001})", "0.0075"));
  EXPECT_FALSE(IsValid(R"({"multipleOf":0.123456789})", "1e308"));
  EXPECT_TRUE(IsValid(R"({"maxLength":3.0})", "\"abc\""));
}

TEST(HostileSchemas, ANulIsACharacterLikeAnyOther) {
  EXPECT_TRUE(IsValid(R"({"minLength":3,"maxLength":3})", R"("a\u0000b")"));
  EXPECT_FALSE(IsValid(R"({"enum":["a"]})", R"("a\u0000b")"));
  EXPECT_TRUE(IsValid(R"({"enum":["a\u0000b"]})", R"("a\u0000b")"));
  EXPECT_FALSE(IsValid(R"({"required":["a"]})", R"({"a\u0000b":1})"));
  EXPECT_FALSE(IsValid(R"({"required":["a\u0000b"]})", R"({"a":1})"));
  EXPECT_TRUE(IsValid(R"({"required":["a\u0000b"]})", R"({"a\u0000b":1})"));
  EXPECT_FALSE(IsValid(R"({"dependencies":{"a\u0000b":["c"]}})", R"({"a\u0000b":1})"));
  EXPECT_FALSE(IsValid(R"({"properties":{"a\u0000b":{"type":"string"}}})", R"({"a\u0000b":1})"));
  EXPECT_TRUE(IsValid(R"({"properties":{"a\u0000b":{"type":"string"}}})", R"({"a":1})"));
  EXPECT_FALSE(IsValid(R"({"propertyNames":{"enum":["a"]}})", R"({"a\u0000b":1})"));
}

TEST(HostileSchemas, ReferencesMeanWhatTheySay) {
  // A name with a slash is no path.
  EXPECT_TRUE(IsValid(R"({"properties":{"a/properties/b":{"type":"string"},
      "a":{"properties":{"b":{"type":"integer"}}},"c":{"$ref":"#/properties/a/properties/b"}}})",
                      R"({"c":1})"));
  // `propertyNames` beside a reference to the whole.
  EXPECT_FALSE(IsValid(R"({"properties":{"x":{"$ref":"#"}},"propertyNames":{"maxLength":3}})",
                       R"({"x":{"long name":1}})"));
  // An empty name is a name.
  EXPECT_FALSE(IsValid(R"({"$ref":"#/definitions/","definitions":{"":{"type":"string"}}})", "1"));
  // `id` is no keyword of draft-07.
  EXPECT_FALSE(IsValid(R"({"id":"http://x/","items":{"$ref":"#/definitions/a"},
      "definitions":{"a":{"type":"string"}}})",
                       "[1]"));
}

TEST(HostileSchemas, SiblingsOfAReferenceCountFrom2019On) {
  const auto schema = [](std::string_view edition) {
    return fmt::format(R"({{"$schema":"{}","items":{{"$ref":"#/definitions/a","maximum":5}},
        "definitions":{{"a":{{"type":"integer"}}}}}})",
                       edition);
  };
  EXPECT_TRUE(IsValid(schema("http://json-schema.org/draft-07/schema#"), "[9]"));
  const auto later = schema("https://json-schema.org/draft/2020-12/schema");
  EXPECT_FALSE(IsValid(later, "[9]"));
  EXPECT_FALSE(IsValid(later, "[1.5]"));
  EXPECT_TRUE(IsValid(later, "[5]"));
}

}  // namespace
}  // namespace fleetpub::schema
