// The built-in schemas against messages: tests/data/schema/<topic>.json holds one good message and
// what is done to it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/file.h"
#include "base/json.h"
#include "schema/schema.h"

namespace fleetpub::schema {
namespace {

using Document = base::JsonDocument;
using Value = base::JsonValue;

constexpr std::array<std::string_view, 4> kVersions = {"1.1.0", "2.0.0", "2.1.0", "3.0.0"};

Document ReadCases(std::string_view topic) {
  const auto text =
      base::ReadFile(fmt::format("{}/tests/data/schema/{}.json", FLEETPUB_SOURCE_DIR, topic));
  auto cases = base::ParseJson(text.value());
  return std::move(cases.value());
}

// In 1.1.0 the array has another name.
std::string Renamed(std::string text, std::string_view version) {
  const std::size_t at = text.find("actions");
  const bool alone = at <= 1 && version == "1.1.0";
  return alone ? text.replace(at, std::string_view("actions").size(), "instantActions") : text;
}

Document MakeMessage(const Value& base, const Value& change, std::string_view version) {
  Document message;
  message.CopyFrom(base, message.GetAllocator());
  if (const Value* set = base::FindMember(change, "set")) {
    for (const auto& [pointer, value] : set->GetObject()) {
      base::JsonPointer(pointer.GetString()).Set(message, value);
    }
  }
  if (const Value* remove = base::FindMember(change, "remove")) {
    for (const Value& pointer : remove->GetArray()) {
      base::JsonPointer(pointer.GetString()).Erase(message);
    }
  }
  const auto array = message.FindMember("actions");
  if (version == "1.1.0" && array != message.MemberEnd()) array->name.SetString("instantActions");
  return message;
}

bool ConcernsVersion(const Value& change, std::string_view version) {
  const Value* versions = base::FindMember(change, "versions");
  if (versions == nullptr) return true;
  return std::any_of(versions->Begin(), versions->End(),
                     [&](const Value& each) { return base::ToView(each) == version; });
}

std::vector<std::string> Expected(const Value& change, std::string_view version) {
  std::vector<std::string> violations;
  if (const Value* expected = base::FindMember(change, "violations")) {
    for (const Value& each : expected->GetArray()) {
      violations.push_back(Renamed(each.GetString(), version));
    }
  }
  return violations;
}

std::vector<std::string> Found(const Schema& schema, const Value& message) {
  std::vector<std::string> violations;
  for (const Violation& each : schema.Validate(message)) {
    violations.push_back(each.path + " " + each.message);
  }
  return violations;
}

class Messages : public ::testing::TestWithParam<const char*> {};

TEST_P(Messages, AreValidatedInEveryVersion) {
  const Document cases = ReadCases(GetParam());
  Registry registry;
  for (const std::string_view version : kVersions) {
    const auto schema = registry.Find(fmt::format("vda5050/{}/{}", version, GetParam()));
    ASSERT_TRUE(schema) << schema.error().message;
    for (const Value& each : cases["cases"].GetArray()) {
      if (!ConcernsVersion(each, version)) continue;
      const Document message = MakeMessage(cases["base"], each, version);
      EXPECT_EQ(Found(**schema, message), Expected(each, version))
          << version << ", " << each["name"].GetString() << ": " << base::ToJson(message);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Topics, Messages, ::testing::Values("instantActions", "connection"));

// What a robot's maker may hold against a finding of ours.
TEST(Corrections, AreSaidToBeOnes) {
  const auto is_said = [](std::string_view schema, std::string_view message,
                          std::string_view path) {
    Registry registry;
    const auto found = registry.Find(schema);
    const auto document = base::ParseJson(message);
    for (const Violation& violation : (*found)->Validate(*document)) {
      if (violation.path != path) continue;
      return violation.message.find("correction of ours") != std::string::npos ? "yes" : "no";
    }
    return "not found";
  };
  for (const std::string_view version : kVersions) {
    for (const char* topic : {"state", "instantActions"}) {
      const std::string schema = fmt::format("vda5050/{}/{}", version, topic);
      for (const char* value : {"-1", "4294967296"}) {
        EXPECT_STREQ(is_said(schema, fmt::format(R"({{"headerId":{}}})", value), "/headerId"),
                     "yes")
            << schema << value;
      }
      EXPECT_STREQ(is_said(schema, R"({"headerId":"1"})", "/headerId"), "no") << schema;
      EXPECT_STREQ(is_said(schema, "{}", ""), "no") << schema;
    }
  }
  EXPECT_STREQ(is_said("vda5050/2.1.0/factsheet", R"({"headerId":-1})", "/headerId"), "no");
  EXPECT_STREQ(is_said("vda5050/2.1.0/factsheet", R"({"headerId":9999999999})", "/headerId"),
               "yes");
  EXPECT_STREQ(is_said("vda5050/2.1.0/factsheet", R"({"headerId":1,"timestamp":""})", ""), "no");
  EXPECT_STREQ(is_said("vda5050/2.1.0/factsheet", R"({"headerId":1})", ""), "yes");
  EXPECT_STREQ(is_said("vda5050/2.0.0/visualization", R"({"headerId":1})", ""), "yes");
  EXPECT_STREQ(is_said("vda5050/3.0.0/visualization", R"({"headerId":1})", ""), "no");
}

}  // namespace
}  // namespace fleetpub::schema
