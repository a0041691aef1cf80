// What a person is told.
#include "schema/violations.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/json.h"
#include "schema/schema.h"

namespace fleetpub::schema {
namespace {

struct Case {
  std::string schema;
  std::string message;
  std::vector<std::string> violations;  // path, blank, message
};

std::vector<std::string> Collect(const std::string& schema, const std::string& message) {
  const auto compiled = Schema::Compile(schema, "test");
  if (!compiled) return {compiled.error().message};
  const auto document = base::ParseJson(message);
  if (!document) return {document.error().message};
  std::vector<std::string> found;
  for (const Violation& each : compiled->Validate(*document)) {
    found.push_back(each.path + " " + each.message);
  }
  return found;
}

void Check(const std::vector<Case>& table) {
  for (const auto& [schema, message, violations] : table) {
    EXPECT_EQ(Collect(schema, message), violations) << schema << " <- " << message;
  }
}

TEST(Violations, SaysWhichTypeIsWanted) {
  Check({
      {R"({"type":"string"})", "1", {" must be a string, not a number"}},
      {R"({"type":"boolean"})", "\"x\"", {" must be true or false, not a string"}},
      {R"({"type":["string","null"]})", "{}", {" must be a string or null, not an object"}},
      {R"({"type":"integer"})", "1.5", {" must be an integer, not 1.5"}},
      {R"({"type":"integer","minimum":1})",
       "\"1\"",
       {" must be an integer, at least 1, not a string"}},
      {R"({"type":"number","exclusiveMinimum":0})", "0", {" must be a number, more than 0, not 0"}},
      {R"({"minimum":0,"exclusiveMaximum":1})",
       "1",
       {" must be at least 0 and less than 1, not 1"}},
      {R"({"enum":[1,"a b",null,"C"]})", "2", {" must be one of 1, \"a b\", null, C, not 2"}},
      {R"({"const":"a"})", "\"b\"", {" must be \"a\", not \"b\""}},
      {R"({"multipleOf":0.1})", "0.25", {" must be a multiple of 0.1, not 0.25"}},
  });
}

TEST(Violations, CountsWithANoun) {
  Check({
      {R"({"minItems":3})", "[1,2]", {" must have at least 3 items, has 2"}},
      {R"({"maxItems":1})", "[1,2]", {" must have at most 1 item, has 2"}},
      {R"({"minLength":2})", "\"ä\"", {" must have at least 2 characters, has 1"}},
      {R"({"maxProperties":0})", R"({"a":1})", {" must have at most 0 members, has 1"}},
      {R"({"items":[true],"additionalItems":false})",
       "[1,2]",
       {" must have at most 1 item, has 2"}},
      {R"({"uniqueItems":true})",
       "[1,2,1.0]",
       {" must not hold an item twice: items 0 and 2 are equal"}},
  });
}

TEST(Violations, NamesWhatIsMissingOrUnknown) {
  Check({
      {R"({"required":["a","b"]})", R"({"b":1})", {" a is required but missing"}},
      {R"({"required":["a","b"]})", "{}", {" a, b are required but missing"}},
      {R"({"dependencies":{"a":["b"]}})", R"({"a":1})", {" b is required beside a but missing"}},
      {R"({"properties":{"actionId":true},"additionalProperties":false})",
       R"({"actionID":1})",
       {"/actionID is not known here; did you mean actionId?"}},
      {R"({"additionalProperties":false})", R"({"a/b~c":1})", {"/a~1b~0c is not known here"}},
      {R"({"propertyNames":{"maxLength":2}})",
       R"({"abc":1})",
       {"/abc has a name that must have at most 2 characters, has 3"}},
      {R"({"not":{"required":["a"]}})", R"({"a":1})", {" must not have a"}},
      {R"({"not":{"type":"string"}})", "\"a\"", {" must not be a string"}},
  });
}

TEST(Violations, ListsCausesOnceInTheOrderOfTheMessage) {
  Check({
      {R"({"properties":{"a":{"type":"string"},"b":{"items":{"type":"string"}}},"required":["c"]})",
       R"({"b":[1,"x",2],"a":1})",
       {" c is required but missing", "/b/0 must be a string, not a number",
        "/b/2 must be a string, not a number", "/a must be a string, not a number"}},
      {R"({"allOf":[{"type":"string"},{"type":"string"}]})",
       "1",
       {" must be a string, not a number"}},
      {R"({"type":"string","minLength":3,"pattern":"x","enum":["y"]})",
       "1",
       {" must be y, not a number"}},
  });
}

TEST(Violations, PicksTheAlternativeThatCameNearest) {
  constexpr const char* kShapes =
      R"({"oneOf":[{"properties":{"kind":{"const":"circle"},"radius":{"minimum":0}},
                    "required":["kind","radius"]},
                   {"properties":{"kind":{"const":"square"},"side":{"minimum":0}},
                    "required":["kind","side"]}]})";
  Check({
      {kShapes, R"({"kind":"circle"})", {" radius is required but missing"}},
      {R"({"anyOf":[{"type":"string"},{"type":"array"}]})",
       "1",
       {" must be a string or an array, not a number"}},
      {R"({"anyOf":[{"type":"string"},{"minimum":5,"type":"number"},{"type":"null"}]})",
       "{}",
       {" must be a string, a number, at least 5 or null, not an object"}},
      {R"({"oneOf":[{"minimum":1},{"minimum":2},{"minimum":9}]})",
       "3",
       {" matches 2 of 3 alternatives, must match exactly one"}},
      {R"({"anyOf":[{"required":["a"]},{"required":["b"]}]})",
       "{}",
       {" matches none of 2 alternatives: a is required but missing or b is required but missing"}},
      {R"({"if":{"required":["a"]},"then":{"required":["b"]}})",
       R"({"a":1})",
       {" b is required but missing"}},
  });
}

TEST(Violations, KeepsHostileValuesShortAndHarmless) {
  const std::string shown =
      Collect(R"({"enum":["a"]})", fmt::format("\"\\u001b[2J{}\"", std::string(50'000, 'x'))).at(0);
  EXPECT_EQ(shown.find('\x1b'), std::string::npos);
  EXPECT_LT(shown.size(), 200U);
  EXPECT_NE(shown.find("(50004 characters)"), std::string::npos) << shown;
  EXPECT_EQ(Collect(R"({"additionalProperties":{"type":"string"}})", R"({"\u001b":1})").at(0),
            "/\x1b must be a string, not a number");  // a pointer is exact
}

TEST(Violations, StopsListingAtTheLimit) {
  std::string message = "[0";
  for (int i = 0; i < 5000; ++i) message += ",0";
  const auto found = Collect(R"({"items":{"type":"string"}})", message + "]");
  ASSERT_EQ(found.size(), Schema::kMostViolations + 1);
  EXPECT_EQ(found.back(), " has more than 1000 violations; the rest is not listed");
}

}  // namespace
}  // namespace fleetpub::schema
