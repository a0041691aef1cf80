#include "schema/bundle.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

#include "base/json.h"

namespace fleetpub::schema {
namespace {

using Texts = std::map<std::string, std::string, std::less<>>;

/// What becomes of the first document beside the others, or why nothing.
std::string Bundled(std::string_view text, const Texts& others,
                    std::string_view uri = "v/topic.json") {
  std::map<std::string, base::JsonDocument, std::less<>> documents;
  for (const auto& [name, other] : others) {
    documents.emplace(name, std::move(base::ParseJson(other).value()));
  }
  auto document = std::move(base::ParseJson(text).value());
  const auto done = Bundle(document, uri, [&](std::string_view wanted) -> const base::JsonValue* {
    const auto found = documents.find(wanted);
    return found == documents.end() ? nullptr : &found->second;
  });
  return done ? base::ToJson(document) : done.error().message;
}

TEST(Bundle, CopiesWhatIsReferredToAndWhatThatRefersTo) {
  EXPECT_EQ(
      Bundled(R"({"items":{"$ref":"shared.json#/definitions/a"}})",
              {{"v/shared.json", R"({"definitions":{"a":{"items":{"$ref":"#/definitions/b"}},)"
                                 R"("b":{"type":"string"},"c":{"type":"null"}}})"}}),
      R"({"items":{"$ref":"#/definitions/a"},)"
      R"("definitions":{"b":{"type":"string"},"a":{"items":{"$ref":"#/definitions/b"}}}})");
}

TEST(Bundle, CopiesOnceAndKeepsNamesApart) {
  EXPECT_EQ(Bundled(R"({"definitions":{"a":true},"allOf":[{"$ref":"x.json#/definitions/a"},)"
                    R"({"$ref":"x.json#/definitions/a"},{"$ref":"#/definitions/a"}]})",
                    {{"v/x.json", R"({"definitions":{"a":false}})"}}),
            R"({"definitions":{"a":true,"a2":false},"allOf":[{"$ref":"#/definitions/a2"},)"
            R"({"$ref":"#/definitions/a2"},{"$ref":"#/definitions/a"}]})");
}

TEST(Bundle, FollowsDocumentsThatReferToEachOther) {
  EXPECT_EQ(Bundled(R"({"properties":{"next":{"$ref":"x.json"}}})",
                    {{"v/x.json", R"({"$id":"x.json","items":{"$ref":"#"},)"
                                  R"("not":{"$ref":"topic.json#/properties"}})"}}),
            R"({"properties":{"next":{"$ref":"#/definitions/x"}},"definitions":{"x":)"
            R"({"items":{"$ref":"#/definitions/x"},"not":{"$ref":"#/properties"}}}})");
}

TEST(Bundle, SeesReferencesFromTheId) {
  EXPECT_EQ(Bundled(R"({"$id":"http://x/v1/state.json","not":{"$ref":"common.json#/d/a"}})",
                    {{"http://x/v1/common.json", R"({"d":{"a":true}})"}}),
            R"({"$id":"http://x/v1/state.json","not":{"$ref":"#/definitions/a"},)"
            R"("definitions":{"a":true}})");
}

TEST(Bundle, LeavesWhatItDoesNotKnowAndWhatIsNoReference) {
  for (const char* text :
       {R"({"$ref":"http://elsewhere/x.json"})", R"({"enum":[{"$ref":"x.json"}]})",
        R"({"properties":{"$ref":{"const":{"$ref":"x.json"}}}})", R"({"$ref":"#/definitions/a"})",
        "true", "[]"}) {
    EXPECT_EQ(Bundled(text, {{"v/x.json", "true"}}), text);
  }
}

TEST(Bundle, RefusesWhatIsNotInADocument) {
  EXPECT_EQ(Bundled(R"({"$ref":"x.json#/definitions/b"})", {{"v/x.json", "{}"}}),
            "v/x.json has no /definitions/b");
}

}  // namespace
}  // namespace fleetpub::schema
