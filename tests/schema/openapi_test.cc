// What OpenAPI 3.0 says otherwise than JSON Schema.
#include "schema/openapi.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>

#include "base/json.h"
#include "schema/schema.h"

namespace fleetpub::schema {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string MakeDocument(std::string_view schemas) {
  return fmt::format(R"({{"openapi":"3.0.2","components":{{"schemas":{{{}}}}}}})", schemas);
}

// The violations of schema A, as `path: message`.
std::vector<std::string> Faults(std::string_view schemas, std::string_view message) {
  const auto schema = Schema::Compile(MakeDocument(schemas), "mine", "/components/schemas/A");
  if (!schema) return {schema.error().message};
  std::vector<std::string> faults;
  const auto value = base::ParseJson(message);
  for (const auto& [path, text] : schema->Validate(*value)) {
    faults.push_back(path + ": " + text);
  }
  return faults;
}

TEST(OpenApi, NullableAllowsNullBesideATypeAndChangesNothingWithoutOne) {
  EXPECT_THAT(Faults(R"("A":{"type":"string","nullable":true})", "null"), IsEmpty());
  EXPECT_THAT(Faults(R"("A":{"type":"string","nullable":false})", "null").size(), 1U);
  EXPECT_THAT(Faults(R"("A":{"type":"string","nullable":true})", "1").size(), 1U);
  EXPECT_THAT(Faults(R"("A":{"nullable":true})", "null"), IsEmpty());
  EXPECT_THAT(Faults(R"("A":{"nullable":true})", "[1]"), IsEmpty());
  EXPECT_THAT(Faults(R"("A":{"items":{"properties":{"b":{"type":"integer","nullable":true}}}})",
                     R"([{"b":null},{"b":1}])"),
              IsEmpty());
}

TEST(OpenApi, AnExclusiveLimitIsAFlag) {
  constexpr auto kAbove = R"("A":{"minimum":1,"exclusiveMinimum":true})";
  EXPECT_THAT(Faults(kAbove, "1").size(), 1U);
  EXPECT_THAT(Faults(kAbove, "1.5"), IsEmpty());
  EXPECT_THAT(Faults(R"("A":{"maximum":1,"exclusiveMaximum":false})", "1"), IsEmpty());
  EXPECT_THAT(Faults(R"("A":{"maximum":1,"exclusiveMaximum":true})", "1").size(), 1U);
}

TEST(OpenApi, ExamplesAndNumberFormatsConstrainNothing) {
  constexpr auto kSchema = R"("A":{"type":"number","format":"float","example":"far"})";
  EXPECT_THAT(Faults(kSchema, "1e300"), IsEmpty());
}

TEST(OpenApi, ADiscriminatorWithoutAlternativesConstrainsNothing) {
  EXPECT_THAT(
      Faults(R"("A":{"type":"object","discriminator":{"propertyName":"kind"}})", R"({"x":1})"),
      IsEmpty());
}

// B is so open that whatever satisfies C satisfies it too.
constexpr auto kChoice = R"(
    "A":{"oneOf":[{"$ref":"#/components/schemas/B"},{"$ref":"#/components/schemas/C"}],
         "discriminator":{"propertyName":"kind","mapping":{"bee":"#/components/schemas/B"}}},
    "B":{"type":"object","required":["id"]},
    "C":{"type":"object","required":["id","size"],"properties":{"size":{"type":"integer"}}})";

TEST(OpenApi, ADiscriminatorChoosesTheOneSchema) {
  EXPECT_THAT(Faults(kChoice, R"({"kind":"bee","id":1,"size":1})"), IsEmpty());
  EXPECT_THAT(Faults(kChoice, R"({"kind":"C","id":1,"size":1})"), IsEmpty())
      << "meant by its own name, and not refused for satisfying B as well";
  EXPECT_THAT(Faults(kChoice, R"({"kind":"C","id":1,"size":"big"})"),
              ElementsAre("/size: must be an integer, not a string"));
  EXPECT_THAT(Faults(kChoice, R"({"kind":"C","id":1})"),
              ElementsAre(": size is required but missing"));
}

TEST(OpenApi, AnUnknownValueOfADiscriminatorListsTheKnownOnes) {
  EXPECT_THAT(Faults(kChoice, R"({"kind":"wasp","id":1})"),
              ElementsAre(R"(/kind: must be one of bee, C, not "wasp")"));
  EXPECT_THAT(Faults(kChoice, R"({"kind":7,"id":1})"),
              ElementsAre(HasSubstr("/kind: must be one of bee")));
  EXPECT_THAT(Faults(kChoice, R"({"id":1})"), ElementsAre(": kind is required but missing"));
  EXPECT_THAT(Faults(kChoice, "3").size(), 1U);
}

TEST(OpenApi, AMappingMayGiveTheBareNameOfASchema) {
  constexpr auto kBare = R"(
      "A":{"anyOf":[{"$ref":"#/components/schemas/B"}],"allOf":[{"maxProperties":2}],
           "discriminator":{"propertyName":"kind","mapping":{"bee":"B"}}},
      "B":{"required":["id"]})";
  EXPECT_THAT(Faults(kBare, R"({"kind":"bee","id":1})"), IsEmpty());
  EXPECT_THAT(Faults(kBare, R"({"kind":"bee"})").size(), 1U);
  EXPECT_THAT(Faults(kBare, R"({"kind":"bee","id":1,"more":1})").size(), 1U) << "allOf still holds";
  EXPECT_THAT(Faults(kBare, R"({"kind":"B","id":1})").size(), 1U);
}

TEST(OpenApi, SaysWhatIsWrongWithADocument) {
  struct Case {
    std::string_view schemas;
    std::string_view fault;
  };
  constexpr std::array kCases = {
      Case{R"("A":{"oneOf":[{"type":"object"}],"discriminator":{"propertyName":"k"}})",
           "/components/schemas/A/oneOf/0 must be a reference"},
      Case{R"("A":{"oneOf":[],"discriminator":{}})",
           "/components/schemas/A/discriminator must name a property"},
      Case{R"("A":{"oneOf":[],"discriminator":7})",
           "/components/schemas/A/discriminator must name a property"},
      Case{R"("A":{"oneOf":[],"discriminator":{"propertyName":"k","mapping":{"b":1}}})",
           "/components/schemas/A/discriminator/mapping/b must be a string"},
      Case{R"("A":{"oneOf":{},"discriminator":{"propertyName":"k"}})",
           "/components/schemas/A/oneOf must be an array"},
      Case{R"("A":{"oneOf":[{"$ref":"#/components/schemas/Z"}],
                   "discriminator":{"propertyName":"k"}})",
           "refers to #/components/schemas/Z, which is not there"},
      Case{R"("A":{"properties":7})", "/components/schemas/A/properties must be an object"},
      Case{R"("A":{"items":{"oneOf":7,"discriminator":{"propertyName":"k"}}})",
           "/components/schemas/A/items/oneOf must be an array"},
  };
  for (const auto& [schemas, fault] : kCases) {
    EXPECT_THAT(Faults(schemas, "{}"), ElementsAre(HasSubstr(fault))) << schemas;
  }
}

TEST(OpenApi, RefusesAnotherEdition) {
  const auto schema = Schema::Compile(R"({"openapi":"3.1.0","components":{"schemas":{"A":{}}}})",
                                      "mine", "/components/schemas/A");
  ASSERT_FALSE(schema);
  EXPECT_THAT(schema.error().message, HasSubstr(R"(/openapi must be 3.0.x, not "3.1.0")"));
}

TEST(OpenApi, TakesADocumentWithoutComponents) {
  auto document = base::ParseJson(R"({"openapi":"3.0.0","components":[]})");
  EXPECT_TRUE(IsOpenApi(*document));
  EXPECT_TRUE(TranslateOpenApi(*document));
  EXPECT_FALSE(IsOpenApi(*base::ParseJson("[]")));
}

}  // namespace
}  // namespace fleetpub::schema
