// The official JSON Schema Test Suite for draft-07, where Debian's package json-schema-test-suite
// is installed.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string>
#include <string_view>

#include "base/file.h"
#include "base/json.h"
#include "schema/schema_loader.h"
#include "schema/violations.h"

namespace fleetpub::schema {
namespace {

using Value = base::JsonValue;

constexpr std::string_view kSuite = "/usr/share/json-schema-test-suite/tests/draft7";

// What asks for another document: the meta-schema at json-schema.org, or the suite's own server. We
// refuse such references.
constexpr std::array<std::string_view, 10> kRemote = {
    "definitions.json: valid definition",
    "definitions.json: invalid definition",
    "ref.json: remote ref, containing refs itself",
    "refRemote.json: remote ref",
    "refRemote.json: fragment within remote ref",
    "refRemote.json: ref within remote ref",
    "refRemote.json: base URI change",
    "refRemote.json: base URI change - change folder",
    "refRemote.json: base URI change - change folder in subschema",
    "refRemote.json: root ref in remote ref",
};

// Of the optional parts: the one format that we assert, and numbers.
constexpr std::array<std::string_view, 3> kOptional = {
    "optional/bignum.json", "optional/zeroTerminatedFloats.json", "optional/format/date-time.json"};

void CheckGroup(const std::string& name, const Value& group) {
  SCOPED_TRACE(name + ": " + base::ToJson(group["schema"]));
  const bool remote = std::find(kRemote.begin(), kRemote.end(), name) != kRemote.end();
  const auto checked = LoadSchema(base::ToJson(group["schema"]));
  ASSERT_EQ(checked.has_value(), !remote) << (checked ? "" : checked.error().message);
  if (remote) {
    EXPECT_NE(checked.error().message.find("another document"), std::string::npos);
    return;
  }
  // Within `not` the walk only tries, and must say the same. A reference would lead elsewhere.
  const std::string text = base::ToJson(group["schema"]);
  const bool refers = text.find("$ref") != std::string::npos;
  const auto excluded = LoadSchema(refers ? "true" : R"({"not":)" + text + "}");
  ASSERT_TRUE(excluded);
  for (const Value& test : group["tests"].GetArray()) {
    const bool valid = test["valid"].GetBool();
    EXPECT_EQ(CollectViolations(**checked, test["data"]).empty(), valid)
        << test["description"].GetString();
    EXPECT_EQ(CollectViolations(**excluded, test["data"]).empty(), refers || !valid)
        << test["description"].GetString();
  }
}

void CheckFile(const std::filesystem::path& file) {
  const auto text = base::ReadFile(file);
  ASSERT_TRUE(text) << text.error().message;
  const auto groups = base::ParseJson(*text);
  ASSERT_TRUE(groups) << groups.error().message;
  for (const Value& group : groups->GetArray()) {
    CheckGroup(file.filename().string() + ": " + group["description"].GetString(), group);
  }
}

TEST(OfficialSuite, GivesTheOfficialVerdictOnDraft07) {
  ASSERT_TRUE(std::filesystem::exists(kSuite)) << "scripts/setup installs json-schema-test-suite";
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kSuite)) {
    if (entry.path().extension() != ".json") continue;
    CheckFile(entry.path());
    ++files;
  }
  for (const std::string_view file : kOptional) {
    CheckFile(std::filesystem::path(kSuite) / file);
  }
  EXPECT_GT(files, 30);
}

}  // namespace
}  // namespace fleetpub::schema
