#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <string>

#include "base/json.h"
#include "schema/schema.h"
#include "schema/schema_loader.h"
#include "support/temporary_folder.h"

namespace fleetpub::schema {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

using testing::TemporaryFolder;

std::string Origin(const Registry& registry, std::string_view name) {
  for (const auto& [known, origin] : registry.List()) {
    if (known == name) return origin;
  }
  return "unknown";
}

TEST(Embedded, AreSortedAndCompile) {
  const auto all = EmbeddedSchemas();
  EXPECT_TRUE(std::is_sorted(all.begin(), all.end(),
                             [](const auto& a, const auto& b) { return a.name < b.name; }));
  for (const Embedded& embedded : all) {
    if (embedded.name.starts_with("soar/")) continue;  // a document of several schemas
    for (const auto& schema :
         {Schema::Compile(embedded.text, embedded.name), Schema::Compile(embedded)}) {
      EXPECT_TRUE(schema) << schema.error().message;
    }
  }
}

TEST(Embedded, RulesAreReadAsTheyAreWrittenAndDescribeNothing) {
  for (const Embedded& embedded : EmbeddedSchemas()) {
    const bool soar = embedded.name.starts_with("soar/");
    const auto checked = LoadSchema(embedded.rules, soar ? "/components/schemas/MESSAGE" : "",
                                    SchemaOrigin::kBuiltIn);
    ASSERT_TRUE(checked) << embedded.name << ": " << checked.error().message;
    EXPECT_EQ(base::ToJson((*checked)->document), embedded.rules) << embedded.name;
    EXPECT_EQ(embedded.rules.find("\"description\":\""), std::string_view::npos);
    EXPECT_EQ(embedded.rules.find("\"discriminator\""), std::string_view::npos);
  }
}

TEST(Embedded, StateTheirOrigin) {
  for (const Embedded& embedded : EmbeddedSchemas()) {
    if (!embedded.name.starts_with("vda5050/")) continue;
    const auto document = base::ParseJson(embedded.text);
    ASSERT_TRUE(document) << document.error().message;
    EXPECT_FALSE(base::StringMember(*document, "$comment").empty()) << embedded.name;
    EXPECT_FALSE(base::StringMember(*document, "title").empty()) << embedded.name;
  }
}

TEST(Registry, FindsBuiltInSchemasAndCompilesThemOnce) {
  Registry registry;
  const auto first = registry.Find("vda5050/3.0.0/instantActions");
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_EQ(registry.Find("vda5050/3.0.0/instantActions").value(), *first);
  EXPECT_EQ(Origin(registry, "vda5050/1.1.0/connection"), "built-in");
}

TEST(Registry, SuggestsTheNearestName) {
  Registry registry;
  const auto schema = registry.Find("vda5050/3.0.0/instantAction");
  ASSERT_FALSE(schema);
  EXPECT_EQ(schema.error().kind, ErrorKind::kUsage);
  EXPECT_THAT(schema.error().message, HasSubstr("did you mean vda5050/3.0.0/instantActions?"));
  EXPECT_THAT(registry.Text("zzz").error().message,
              AllOf(HasSubstr("zzz"), HasSubstr("fleetpub schema list")));
}

TEST(Registry, PutsAFolderBeforeTheBuiltInOnes) {
  const TemporaryFolder folder;
  const auto file =
      folder.Write("vda5050/3.0.0/instantActions.schema.json", R"({"required":["mine"]})");
  Registry registry(folder.path());
  EXPECT_EQ(Origin(registry, "vda5050/3.0.0/instantActions"), file.string());
  EXPECT_EQ(Origin(registry, "vda5050/2.1.0/instantActions"), "built-in");
  EXPECT_EQ(registry.Text("vda5050/3.0.0/instantActions").value(), R"({"required":["mine"]})");
  const auto schema = registry.Find("vda5050/3.0.0/instantActions");
  ASSERT_TRUE(schema) << schema.error().message;
  base::JsonDocument message(rapidjson::kObjectType);
  EXPECT_EQ((*schema)->Validate(message).at(0).message, "mine is required but missing");
}

TEST(Registry, TakesThePublishedNamesAndAnyOthers) {
  const TemporaryFolder folder;
  folder.Write("3.0.0/zoneSet.schema", "true");
  folder.Write("2.1.0/order.schema.json", "true");
  folder.Write("site/robot.schema.json", "true");
  folder.Write("notes.txt", "not a schema");
  folder.Write("data.json", "{}");
  Registry registry(folder.path());
  EXPECT_TRUE(registry.Find("vda5050/3.0.0/zoneSet"));
  EXPECT_TRUE(registry.Find("vda5050/2.1.0/order"));
  EXPECT_TRUE(registry.Find("site/robot"));
  for (const auto& [name, origin] : registry.List()) {
    EXPECT_NE(name, "notes");
    EXPECT_NE(name, "data");
  }
}

TEST(Registry, FindsAPartOfADocument) {
  const TemporaryFolder folder;
  folder.Write("mine.openapi.json",
               R"({"openapi":"3.0.2","components":{"schemas":{"A":{"type":"string"}}}})");
  Registry registry(folder.path());
  EXPECT_TRUE(registry.Find("mine#/components/schemas/A"));
  EXPECT_FALSE(registry.Find("mine#/components/schemas/B"));
  EXPECT_FALSE(registry.Find("mine"));
}

TEST(Registry, SaysWhereAFileIsNoJsonAndThatItIsKnown) {
  const TemporaryFolder folder;
  const auto broken = folder.Write("3.0.0/order.schema.json", "{\n  \"type\": \"object\",\n}");
  folder.Write("mine.schema.json", "{,}");
  Registry registry(folder.path());
  const std::string known = registry.Find("vda5050/3.0.0/order").error().message;
  EXPECT_TRUE(known.starts_with(
      fmt::format("schema {}: not valid JSON at line 3, column 1: ", broken.string())))
      << known;
  EXPECT_NE(known.find("are known not to be valid JSON"), std::string::npos) << known;
  const std::string mine = registry.Find("mine").error().message;
  EXPECT_NE(mine.find("line 1, column 2"), std::string::npos) << mine;
  EXPECT_EQ(mine.find("known"), std::string::npos) << mine;
}

TEST(Registry, ReportsAFolderThatCannotBeRead) {
  const TemporaryFolder folder;
  Registry registry(folder / "missing");
  const auto schema = registry.Find("vda5050/3.0.0/instantActions");
  ASSERT_FALSE(schema);
  EXPECT_EQ(schema.error().kind, ErrorKind::kUsage);
  EXPECT_NE(schema.error().message.find("missing"), std::string::npos);
}

}  // namespace
}  // namespace fleetpub::schema
