#include "schema/schema_files.h"

#include <gmock/gmock.h>

#include "schema/schema.h"
#include "support/temporary_folder.h"

namespace fleetpub::schema {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using testing::TemporaryFolder;

/// Under which name the only file of a folder is found.
std::string FindName(const std::string& file) {
  const TemporaryFolder folder;
  folder.Write(file, "true");
  const auto files = ScanSchemaFolder(folder.path());
  if (!files) return files.error().message;
  return files->size() == 1 ? files->begin()->first : "several";
}

TEST(SchemaFiles, HaveTheNamesOfWhatTheyStandFor) {
  const std::pair<const char*, const char*> table[] = {
      {"vda5050/3.0.0/order.schema.json", "vda5050/3.0.0/order"},
      {"3.0.0/order.schema", "vda5050/3.0.0/order"},
      {"v3.0/zone-set.schema.json", "vda5050/3.0.0/zoneSet"},
      {"1.1.0-community/instant-actions.schema.json", "vda5050/1.1.0/instantActions"},
      {"3.0.0/json_schemas/state.schema", "vda5050/3.0.0/state"},
      {"2.1/common.schema.json", "vda5050/2.1.0/common"},
      {"4.0.0/order.schema", "vda5050/4.0.0/order"},
      {"site/robot.schema.json", "site/robot"},
      {"3.0.0.beta/order.schema", "3.0.0.beta/order"},
      {"hand-made.schema", "hand-made"},
      {"soar/1.0/messages.openapi.json", "soar/1.0/messages"},
  };
  for (const auto& [file, name] : table) EXPECT_EQ(FindName(file), name) << file;
}

TEST(SchemaFiles, OfATopicAloneStandForItInEveryVersionWithoutItsOwn) {
  const TemporaryFolder folder;
  const auto common = folder.Write("instantActions.schema", "true");
  const auto order = folder.Write("json_schemas/order.schema", "true");
  const auto own = folder.Write("2.1.0/instantActions.schema", "false");
  const auto files = ScanSchemaFolder(folder.path());
  ASSERT_TRUE(files) << files.error().message;
  EXPECT_EQ(files->at("vda5050/3.0.0/instantActions"), common);
  EXPECT_EQ(files->at("vda5050/1.1.0/instantActions"), common);
  EXPECT_EQ(files->at("vda5050/2.1.0/instantActions"), own);
  EXPECT_EQ(files->at("vda5050/3.0.0/order"), order);
  EXPECT_EQ(files->count("vda5050/3.0.0/state"), 0U);
}

TEST(SchemaFiles, AreRefusedWhenTwoStandForOneName) {
  const TemporaryFolder folder;
  folder.Write("3.0.0/order.schema", "true");
  folder.Write("3.0.0/order.schema.json", "true");
  const auto files = ScanSchemaFolder(folder.path());
  ASSERT_FALSE(files);
  EXPECT_EQ(files.error().kind, ErrorKind::kUsage);
  EXPECT_THAT(files.error().message,
              AllOf(HasSubstr("vda5050/3.0.0/order twice"), HasSubstr("order.schema.json")));
}

TEST(SchemaFiles, AreMissedWhereThereAreNone) {
  const TemporaryFolder folder;
  folder.Write("order.json", "true");
  const auto files = ScanSchemaFolder(folder.path());
  ASSERT_FALSE(files);
  EXPECT_EQ(files.error().kind, ErrorKind::kUsage);
  EXPECT_THAT(files.error().message, HasSubstr("holds no file that ends in"));
}

TEST(SchemaFiles, ReferToEachOtherByPathAndById) {
  const TemporaryFolder folder;
  folder.Write("1.1.0/order.schema.json",
               R"({"allOf":[{"$ref":"../shared.schema.json#/definitions/a"},)"
               R"({"$ref":"http://site/common.json#/definitions/b"}]})");
  folder.Write("shared.schema.json", R"({"definitions":{"a":{"required":["a"]}}})");
  folder.Write("1.1.0/common.schema.json",
               R"({"$id":"http://site/common.json#","definitions":{"b":{"required":["b"]}}})");
  Registry registry(folder.path());
  const auto schema = registry.Find("vda5050/1.1.0/order");
  ASSERT_TRUE(schema) << schema.error().message;
  const base::JsonDocument empty(rapidjson::kObjectType);
  EXPECT_EQ((*schema)->Validate(empty).size(), 2U);
  EXPECT_THAT(registry.Text("vda5050/1.1.0/order").value(),
              HasSubstr(R"("definitions":{"a":{"required":["a"]},"b":{"required":["b"]}})"));
}

TEST(SchemaFiles, SayWhatCannotBeHadOfAnother) {
  const TemporaryFolder folder;
  const auto file =
      folder.Write("a.schema", R"({"allOf":[{"$ref":"b.schema#/definitions/none"}]})");
  folder.Write("b.schema", "{}");
  const auto missing = ReadSchemaFile(file, FilesBeside(file));
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().message,
              AllOf(StartsWith("schema " + file.string()), HasSubstr("has no /definitions/none")));
  folder.Write("b.schema", "{,}");
  EXPECT_THAT(ReadSchemaFile(file, FilesBeside(file)).error().message,
              AllOf(HasSubstr("b.schema: not valid JSON at line 1, column 2")));
}

TEST(SchemaFiles, AreReadAsTheyStandWhenTheyReferToNothing) {
  const TemporaryFolder folder;
  for (const char* text : {"{ \"type\" : \"object\" }", "{,}", R"({"$ref": "#/definitions/a"})"}) {
    const auto file = folder.Write("a.schema", text);
    EXPECT_EQ(ReadSchemaFile(file, FilesBeside(file)).value(), text);
  }
}

}  // namespace
}  // namespace fleetpub::schema
