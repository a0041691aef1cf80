// The validator says whether, the explanation says why: two walks over schema and message that must
// agree on everything.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "base/json.h"
#include "schema/explain.h"
#include "schema/schema.h"
#include "schema/validator.h"
#include "schema/vet.h"

namespace fleetpub::schema {
namespace {

constexpr const char* kSchemas[] = {
    R"(true)",
    R"(false)",
    R"({"type":"integer","minimum":0,"maximum":4294967295})",
    R"({"type":["string","null"],"format":"date-time"})",
    R"({"exclusiveMinimum":1,"exclusiveMaximum":3,"multipleOf":0.5})",
    R"({"minLength":1,"maxLength":3,"pattern":"^[a-z]*$"})",
    R"({"enum":[1,"a",{"a":1},[1]]})",
    R"({"const":1})",
    R"({"enum":[]})",
    R"({"required":["a","b"],"minProperties":1,"maxProperties":2})",
    R"({"properties":{"a":{"type":"integer"}},"patternProperties":{"^b":{"type":"string"}},
        "additionalProperties":false})",
    R"({"patternProperties":{"a|b":{"minimum":2}},"additionalProperties":{"type":"null"}})",
    R"({"propertyNames":{"maxLength":1,"enum":["a","b"]}})",
    R"({"dependencies":{"a":["b"],"b":{"properties":{"a":{"const":1}}}}})",
    R"({"items":{"type":"integer"},"minItems":1,"uniqueItems":true})",
    R"({"items":[{"type":"integer"},{"type":"string"}],"additionalItems":{"type":"null"}})",
    R"({"items":[true],"additionalItems":false})",
    R"({"contains":{"const":1},"maxItems":2})",
};

constexpr const char* kMessages[] = {
    "null",
    "true",
    "0",
    "1",
    "1.0",
    "2",
    "2.5",
    "3",
    "-1",
    "4294967296",
    "1e300",
    "18446744073709551615",
    R"("")",
    R"("a")",
    R"("abc")",
    R"("abcd")",
    R"("A")",
    R"("\u0000")",
    R"("2026-01-02T03:04:05Z")",
    "[]",
    "[1]",
    "[1,1.0]",
    R"([1,"a"])",
    R"([1,"a",null])",
    R"(["a"])",
    "[{},{}]",
    "[[1],[1.0]]",
    "{}",
    R"({"a":1})",
    R"({"a":1.0,"b":"x"})",
    R"({"a":2,"b":"x"})",
    R"({"b":1})",
    R"({"a":1,"b":"x","c":null})",
    R"({"long":1})",
    R"({"a":{"a":1}})",
    R"({"b":null,"a":[]})",
};

void Compare(const std::string& schema) {
  const auto vetted = Vet(schema);
  ASSERT_TRUE(vetted) << schema << ": " << vetted.error().message;
  const Validator validator(**vetted);
  for (const char* message : kMessages) {
    const auto document = base::ParseJson(message);
    ASSERT_TRUE(document) << message;
    EXPECT_EQ(validator.IsValid(*document),
              Explain(**vetted, *document, Schema::kMostViolations).empty())
        << schema << " <- " << message;
  }
}

TEST(Consistency, HoldsForEveryKeyword) {
  for (const char* schema : kSchemas) Compare(schema);
}

TEST(Consistency, HoldsForCombinations) {
  for (const char* a : kSchemas) {
    Compare(fmt::format(R"({{"not":{}}})", a));
    Compare(fmt::format(R"({{"items":{0},"additionalProperties":{0}}})", a));
    Compare(fmt::format(R"({{"contains":{}}})", a));
    for (const char* b : kSchemas) {
      Compare(fmt::format(R"({{"allOf":[{},{}]}})", a, b));
      Compare(fmt::format(R"({{"anyOf":[{},{}]}})", a, b));
      Compare(fmt::format(R"({{"oneOf":[{},{},{{"type":"boolean"}}]}})", a, b));
      Compare(fmt::format(R"({{"if":{},"then":{},"else":false}})", a, b));
      Compare(fmt::format(R"({{"definitions":{{"x":{}}},"items":{{"$ref":"#/definitions/x"}},
                              "properties":{{"a":{{"$ref":"#"}},"b":{}}}}})",
                          a, b));
    }
  }
}

}  // namespace
}  // namespace fleetpub::schema
