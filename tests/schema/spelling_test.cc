#include "schema/spelling.h"

#include <gmock/gmock.h>

#include <string>

#include "base/json.h"

namespace fleetpub::schema {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// Each as `pointer: the name that is meant`.
std::vector<std::string> Slips(const std::string& schema, const std::string& message) {
  const auto compiled = Schema::Compile(schema, "test");
  const auto document = base::ParseJson(message);
  if (!compiled || !document) return {"not read"};
  std::vector<std::string> slips;
  for (const auto& [path, words] : compiled->FindMisspellings(*document)) {
    slips.push_back(path + words.substr(words.rfind(':')));
  }
  return slips;
}

constexpr const char* kSchema = R"({
  "properties": {"zones": {"type": "array", "items": {"$ref": "#/definitions/zone"}},
                 "labels": {"additionalProperties": {"properties": {"colour": true}}},
                 "free": true},
  "definitions": {"zone": {"allOf": [{"properties": {"zoneId": true, "maxSpeed": true}}],
                           "properties": {"corner": {"properties": {"xPosition": true}}}}}})";

TEST(Spelling, FindsSlipsAtAnyLevelThroughReferences) {
  EXPECT_THAT(Slips(kSchema, R"({"zone":[]})"), ElementsAre("/zone: did you mean zones?"));
  EXPECT_THAT(Slips(kSchema, R"({"zones":[{},{"zone_id":1,"maxSpeeds":2}]})"),
              ElementsAre("/zones/1/zone_id: did you mean zoneId?",
                          "/zones/1/maxSpeeds: did you mean maxSpeed?"));
  EXPECT_THAT(Slips(kSchema, R"({"zones":[{"corner":{"x-position":0}}]})"),
              ElementsAre("/zones/0/corner/x-position: did you mean xPosition?"));
}

TEST(Spelling, LeavesOtherWordsAlone) {
  for (const char* message :
       {R"({"vendor":1})", R"({"free":{"zone":1}})", R"({"zones":[],"zone":1})",
        R"({"labels":{"zone":{}}})", "[1]", "1"}) {
    EXPECT_THAT(Slips(kSchema, message), IsEmpty()) << message;
  }
  EXPECT_THAT(Slips(kSchema, R"({"labels":{"any":{"color":1}}})"),
              ElementsAre("/labels/any/color: did you mean colour?"));
}

TEST(Spelling, IsNotToldWhereItIsAViolation) {
  EXPECT_THAT(
      Slips(R"({"properties":{"nodes":true},"additionalProperties":false})", R"({"node":1})"),
      IsEmpty());
}

TEST(Spelling, KnowsThePatternsOfNames) {
  EXPECT_THAT(
      Slips(R"({"properties":{"x_1":true},"patternProperties":{"^x_":true}})", R"({"x_2":1})"),
      IsEmpty());
}

}  // namespace
}  // namespace fleetpub::schema
