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
#include "schema/explain.h"
#include "schema/schema.h"
#include "schema/validator.h"
#include "schema/vet.h"

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

void CheckCase(const Vetted& vetted, const Validator& validator, const Value& test) {
  const bool valid = test["valid"].GetBool();
  EXPECT_EQ(validator.IsValid(test["data"]), valid) << test["description"].GetString();
  // Validator and explanation are two walks that must agree.
  EXPECT_EQ(Explain(vetted, test["data"], Schema::kMostViolations).empty(), valid)
      << test["description"].GetString();
}

void CheckGroup(const std::string& name, const Value& group) {
  SCOPED_TRACE(name + ": " + base::ToJson(group["schema"]));
  const bool remote = std::find(kRemote.begin(), kRemote.end(), name) != kRemote.end();
  const auto vetted = Vet(base::ToJson(group["schema"]));
  ASSERT_EQ(vetted.has_value(), !remote) << (vetted ? "" : vetted.error().message);
  if (remote) {
    EXPECT_NE(vetted.error().message.find("another document"), std::string::npos);
    return;
  }
  const Validator validator(**vetted);
  for (const Value& test : group["tests"].GetArray()) CheckCase(**vetted, validator, test);
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
