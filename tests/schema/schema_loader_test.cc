// Schemas that are refused, each with the place and the reason.
#include "schema/schema_loader.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "schema/schema.h"

namespace fleetpub::schema {
namespace {

struct Bad {
  std::string schema;
  std::string_view reason;
};

std::string Refusal(std::string_view schema) {
  const auto checked = LoadSchema(schema);
  return checked ? "accepted" : checked.error().message;
}

TEST(SchemaLoader, RefusesWhatIsNoSchema) {
  const std::vector<Bad> table = {
      {"3", "the schema must be a schema (an object, true or false), not 3"},
      {"[]", "the schema must be a schema (an object, true or false), not an array"},
      {"", "not valid JSON at line 1, column 1: nothing is there"},
      {R"({"properties":{"a":1}})",
       "/properties/a must be a schema (an object, true or false), not 1"},
      {R"({"properties":[]})", "/properties must be an object of schemas, not an array"},
      {R"({"items":"x"})", "/items must be a schema (an object, true or false), not \"x\""},
      {R"({"items":[true,null]})",
       "/items/1 must be a schema (an object, true or false), not null"},
      {R"({"allOf":{}})", "/allOf must be an array, not an object"},
      {R"({"anyOf":[]})", "/anyOf must hold at least one schema"},
      {R"({"not":[]})", "/not must be a schema (an object, true or false), not an array"},
      {R"({"a~/b":1,"definitions":{"a~/b":1}})",
       "/definitions/a~0~1b must be a schema (an object, true or false), not 1"},
  };
  for (const auto& [schema, reason] : table) EXPECT_EQ(Refusal(schema), reason) << schema;
}

TEST(SchemaLoader, RefusesMalformedKeywords) {
  const std::vector<Bad> table = {
      {R"({"type":"int"})",
       "/type must be one of array, boolean, integer, null, number, object, string, not \"int\""},
      {R"({"type":[]})", "/type must name at least one type"},
      {R"({"type":["string","string"]})", "/type must not name a type twice"},
      {R"({"type":["string",1]})",
       "/type/1 must be one of array, boolean, integer, null, number, object, string, not 1"},
      {R"({"required":"a"})", "/required must be an array, not \"a\""},
      {R"({"required":[1]})", "/required/0 must be a string, not 1"},
      {R"({"required":["a","a"]})", "/required must not name anything twice"},
      {R"({"required":true})", "/required must be an array, not true"},
      {R"({"minimum":"0"})", "/minimum must be a number, not \"0\""},
      {R"({"exclusiveMinimum":true})", "/exclusiveMinimum must be a number, not true"},
      {R"({"multipleOf":0})", "/multipleOf must be a number above 0, not 0"},
      {R"({"multipleOf":-2})", "/multipleOf must be a number above 0, not -2"},
      {R"({"minLength":-1})", "/minLength must be an integer from 0 on, not -1"},
      {R"({"maxItems":1.5})", "/maxItems must be an integer from 0 on, not 1.5"},
      {R"({"uniqueItems":"yes"})", "/uniqueItems must be true or false, not \"yes\""},
      {R"({"enum":"a"})", "/enum must be an array, not \"a\""},
      {R"({"format":1})", "/format must be a string, not 1"},
      {R"({"title":1})", "/title must be a string, not 1"},
      {R"({"dependencies":{"a":1}})",
       "/dependencies/a must be a schema (an object, true or false), not 1"},
      {R"({"$ref":1})", "/$ref must be a string, not 1"},
      {R"({"$id":{}})", "/$id must be a string, not an object"},
      {R"({"if":1})", "/if must be a schema (an object, true or false), not 1"},
  };
  for (const auto& [schema, reason] : table) EXPECT_EQ(Refusal(schema), reason) << schema;
}

TEST(SchemaLoader, RefusesKeywordsThatItWouldNotCheck) {
  for (const char* keyword :
       {"unevaluatedProperties", "unevaluatedItems", "$dynamicRef", "$recursiveRef", "prefixItems",
        "dependentRequired", "dependentSchemas", "minContains", "maxContains", "divisibleBy",
        "disallow", "extends"}) {
    EXPECT_EQ(Refusal(fmt::format(R"({{"items":{{"{}":{{}}}}}})", keyword)),
              fmt::format("/items/{} is a keyword that draft-07 does not have and that would not "
                          "be checked",
                          keyword));
  }
}

TEST(SchemaLoader, TakesKeywordsThatConstrainNothing) {
  for (
      const char* schema :
      {R"({"title":"t","description":"d","$comment":"c","examples":[1],"default":{}})",
       R"({"readOnly":true,"writeOnly":false,"contentMediaType":"a/b","contentEncoding":"base64"})",
       R"({"unit":"m","subtopic":"/state","documentVersion":"1.1","format":"uint32","required":[]})",
       R"({"properties":{"prefixItems":{"type":"string"},"$ref":{"type":"string"}}})",
       R"({"enum":[]})", "true", "false", "{}"}) {
    EXPECT_EQ(Refusal(schema), "accepted") << schema;
  }
}

TEST(SchemaLoader, KnowsWhichEditionsItCanCheck) {
  for (const char* edition :
       {"http://json-schema.org/draft-07/schema#", "https://json-schema.org/draft-07/schema",
        "http://json-schema.org/draft-06/schema#", "https://json-schema.org/draft/2019-09/schema",
        "http://json-schema.org/draft/2020-12/schema"}) {
    EXPECT_EQ(Refusal(fmt::format(R"({{"$schema":"{}"}})", edition)), "accepted");
  }
  EXPECT_EQ(Refusal(R"({"$schema":"http://json-schema.org/draft-04/schema#"})"),
            "/$schema must be draft-07, not \"http://json-schema.org/draft-04/schema#\"");
  EXPECT_EQ(Refusal(R"({"$schema":"https://json-schema.org/draft/2020-12/schema","items":[true]})"),
            "/items must be a schema (an object, true or false), not an array");
}

TEST(SchemaLoader, RefusesReferencesThatLeadNowhere) {
  const std::vector<Bad> table = {
      {R"({"$ref":"#/definitions/a"})", "/$ref refers to #/definitions/a, which is not there"},
      {R"({"items":{"$ref":"#name"}})", "/items/$ref refers to #name, which is not there"},
      {R"({"items":[{"$ref":"#/items/00"}]})",
       "/items/0/$ref refers to #/items/00, which is not there"},
      {R"({"$ref":"#/definitions/a","definitions":{"a":3}})",
       "/definitions/a must be a schema (an object, true or false), not 3"},
      {R"({"$ref":"http://other/x.json"})",
       "/$ref refers to another document, http://other/x.json: what is needed of it must be "
       "under definitions"},
      {R"({"$ref":"common.json#/definitions/header"})",
       "/$ref refers to another document, common.json#/definitions/header: what is needed of it "
       "must be under definitions"},
      {R"({"definitions":{"a":{"$id":"http://x/a"},"b":{"$id":"http://x/a"}}})",
       "/definitions/b/$id stands there for a second schema"},
  };
  for (const auto& [schema, reason] : table) EXPECT_EQ(Refusal(schema), reason) << schema;
}

TEST(SchemaLoader, RefusesReferencesInACircle) {
  const std::vector<Bad> table = {
      {R"({"$ref":"#"})", "/$ref"},
      {R"({"allOf":[{"$ref":"#"}]})", "/allOf/0/$ref"},
      {R"({"not":{"$ref":"#"}})", "/not/$ref"},
      {R"({"if":{"$ref":"#"}})", "/if/$ref"},
      {R"({"dependencies":{"a":{"$ref":"#"}}})", "/dependencies/a/$ref"},
      {R"({"definitions":{"a":{"$ref":"#/definitions/b"},"b":{"anyOf":[{"$ref":"#/definitions/a"}]}},
           "$ref":"#/definitions/a"})",
       "/$ref"},
  };
  for (const auto& [schema, place] : table) {
    EXPECT_EQ(Refusal(schema),
              fmt::format("{} leads in a circle through nothing but references", place));
  }
}

TEST(SchemaLoader, RefusesChainsThatWouldExhaustTheStack) {
  std::string definitions = R"("a0":true)";
  for (int i = 1; i < 2'000; ++i) {
    definitions += fmt::format(R"(,"a{}":{{"allOf":[{{"$ref":"#/definitions/a{}"}}]}})", i, i - 1);
  }
  const auto schema =
      fmt::format(R"({{"definitions":{{{}}},"$ref":"#/definitions/a1999"}})", definitions);
  EXPECT_NE(Refusal(schema).find("belongs to a chain of more than 32 schemas"), std::string::npos);
}

TEST(SchemaLoader, RefusesPatternsThatNeedMoreThanLinearTime) {
  const std::vector<Bad> table = {
      {R"re({"pattern":"^(?=a)b"})re",
       "/pattern is a pattern that cannot be used: looks around with (?=, which takes more than "
       "linear time"},
      {R"re({"pattern":"(a)\\1"})re",
       "/pattern is a pattern that cannot be used: refers back with \\1, which takes more than "
       "linear time"},
      {R"re({"pattern":"("})re",
       "/pattern is a pattern that cannot be used: has a ( without a ), or the other way round"},
      {R"re({"patternProperties":{"(?!x)":true}})re",
       "/patternProperties/(?!x) is a pattern that cannot be used: looks around with (?!, which "
       "takes more than linear time"},
  };
  for (const auto& [schema, reason] : table) EXPECT_EQ(Refusal(schema), reason) << schema;
}

TEST(SchemaLoader, RefusesAnOpenApiDocumentUnlessAPartIsNamed) {
  constexpr std::string_view kDocument =
      R"({"openapi":"3.0.2","components":{"schemas":{"A":{"type":"array","items":{"$ref":
          "#/components/schemas/B"}},"B":{"type":"string"}}}})";
  EXPECT_EQ(Refusal(kDocument),
            "the schema is an OpenAPI document: one of its schemas must be named, with "
            "#/components/schemas/…");
  const auto missing = LoadSchema(kDocument, "/components/schemas/C");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().message, "/components/schemas/C is not there");
  EXPECT_TRUE(LoadSchema(kDocument, "/components/schemas/A"));
}

TEST(Compile, NamesTheSchemaInItsErrors) {
  const auto schema = Schema::Compile(R"({"type":1})", "mine");
  ASSERT_FALSE(schema);
  EXPECT_EQ(schema.error().kind, ErrorKind::kInvalid);
  EXPECT_TRUE(schema.error().message.starts_with("schema mine: /type must be"))
      << schema.error().message;
}

}  // namespace
}  // namespace fleetpub::schema
