// What earlier versions left behind and offered, beside the present program (docs/stability.md). Each archive in
// tests/data/compatibility is of one version; `record` there makes them.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <stdexcept>

#include "base/json.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using base::FindMember;
using base::JsonValue;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;

/// `0.1`, and so on.
std::vector<std::string> Versions() {
  std::set<std::string> versions;
  for (const auto& entry :
       std::filesystem::directory_iterator(FLEETPUB_SOURCE_DIR "/tests/data/compatibility")) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with(".tar.gz")) versions.insert(name.substr(0, name.size() - 7));
  }
  return {versions.begin(), versions.end()};
}

std::string ReadText(const std::filesystem::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// With the earlier version's ledger as its own.
class Compatibility : public EndToEnd, public ::testing::WithParamInterface<std::string> {
 protected:
  Compatibility() {
    const std::string archive =
        FLEETPUB_SOURCE_DIR "/tests/data/compatibility/" + GetParam() + ".tar.gz";
    const Finished unpacked =
        testing::Run({.arguments = {"tar", "-xzf", archive, "-C", earlier_.path().string()}});
    if (unpacked.exit_code != 0) throw std::runtime_error(unpacked.errors);
    operator_.UseLedger(earlier_ / "ledger.db");
  }
  [[nodiscard]] std::string Earlier(const std::string& file) const {
    return ReadText(earlier_ / file);
  }
  [[nodiscard]] std::uint64_t Pause(const std::string& robot, const std::string& version) const {
    const auto sent = Json(Send({"pause", robot, "--vda", version, "-o", "json"}).output);
    return sent["headerId"].GetUint64();
  }

  TemporaryFolder earlier_;
};

std::string Name(const ::testing::TestParamInfo<std::string>& version) {
  std::string name = "Of" + version.param;
  for (char& c : name) c = c == '.' ? '_' : c;
  return name;
}
INSTANTIATE_TEST_SUITE_P(Versions, Compatibility, ::testing::ValuesIn(Versions()), Name);

TEST_P(Compatibility, HistoryIsReadAsItWas) {
  const std::vector<std::string> was = Lines(Earlier("history.jsonl"));
  const std::vector<std::string> is =
      Lines(Fleetpub({"history", "-o", "json", "--limit", "0"}).output);
  ASSERT_EQ(is.size(), was.size());
  ASSERT_GE(was.size(), 10U);
  for (std::size_t row = 0; row < was.size(); ++row) {
    const auto before = Json(was[row]);
    const auto now = Json(is[row]);
    for (const auto& member : before.GetObject()) {
      const JsonValue* same = FindMember(now, member.name.GetString());
      EXPECT_TRUE(same != nullptr && *same == member.value) << member.name.GetString() << "\n"
                                                            << was[row] << "\n"
                                                            << is[row];
    }
  }
}

TEST_P(Compatibility, HeaderIdsGoOn) {
  EXPECT_EQ(Pause("KIT/0001", "3.0"), 3U);
  EXPECT_EQ(Pause("KIT/0003", "2.0"), 1U);
  EXPECT_EQ(Pause("KIT/0002", "3.0"), 4'294'967'295U);
  EXPECT_EQ(Pause("KIT/0002", "3.0"), 0U);
  EXPECT_EQ(Pause("KIT/0005", "2.1"), 1U);  // whose last process was killed
  const auto rows = Lines(Fleetpub({"history", "-o", "json", "--limit", "0"}).output);
  EXPECT_EQ(rows.size(), Lines(Earlier("history.jsonl")).size() + 5);
}

TEST_P(Compatibility, HeaderIdsGoOnWhenOnlyTheMarksWereKept) {
  std::filesystem::remove(earlier_ / "ledger.db");
  std::filesystem::remove(earlier_ / "ledger.db-wal");
  EXPECT_EQ(Pause("KIT/0001", "3.0"), 3U);
  EXPECT_EQ(Pause("KIT/0002", "3.0"), 4'294'967'295U);
}

TEST_P(Compatibility, ConfigurationIsUnderstood) {
  std::filesystem::permissions(earlier_ / "config.toml", std::filesystem::perms::owner_read);
  const Finished check = Fleetpub({"config", "check", "--config", earlier_ / "config.toml"});
  EXPECT_EQ(check.exit_code, 0) << check.output << check.errors;
}

std::set<std::string> Texts(const JsonValue* array) {
  std::set<std::string> texts;
  if (array == nullptr) return texts;
  for (const JsonValue& text : array->GetArray()) texts.insert(base::ToJson(text));
  return texts;
}

/// What is in `now` for each `key` of the elements of an array; null where nothing is.
const JsonValue* FindElement(const JsonValue& array, const char* key, const JsonValue& value) {
  for (const JsonValue& element : array.GetArray()) {
    if (element[key] == value) return &element;
  }
  return nullptr;
}

/// The option that has all of these names; of one without names nothing is asked.
const JsonValue* FindOption(const JsonValue& options, const JsonValue& names) {
  for (const JsonValue& option : options.GetArray()) {
    const std::set<std::string> has = Texts(&option["names"]);
    const std::set<std::string> asked = Texts(&names);
    if (std::includes(has.begin(), has.end(), asked.begin(), asked.end())) return &option;
  }
  return nullptr;
}

void ExpectOptions(const JsonValue& was, const JsonValue& is, const std::string& command) {
  for (const JsonValue& before : was.GetArray()) {
    const std::string what = command + " " + base::ToJson(before);
    const JsonValue* now = FindOption(is, before["names"]);
    if (now == nullptr) {
      ADD_FAILURE() << "is gone: " << what;
      continue;
    }
    if (before["names"].Empty()) continue;
    EXPECT_EQ(FindMember(*now, "type") == nullptr, FindMember(before, "type") == nullptr) << what;
    EXPECT_FALSE(base::IsTrueMember(before, "repeatable") &&
                 !base::IsTrueMember(*now, "repeatable"))
        << what;
    EXPECT_EQ(base::StringMember(*now, "variable"), base::StringMember(before, "variable")) << what;
    // What takes any value by now takes the former ones too.
    if (const JsonValue* choices = FindMember(*now, "choices")) {
      EXPECT_THAT(Texts(choices), IsSupersetOf(Texts(FindMember(before, "choices")))) << what;
    }
  }
}

TEST_P(Compatibility, CommandsAndOptionsAreThere) {
  const auto was = Json(Earlier("help.json"));
  const auto is = Json(Fleetpub({"help", "-o", "json"}).output);
  ExpectOptions(was["options"], is["options"], "");
  for (const JsonValue& before : was["commands"].GetArray()) {
    const JsonValue* now = FindElement(is["commands"], "name", before["name"]);
    ASSERT_NE(now, nullptr) << base::ToJson(before["name"]);
    ExpectOptions(before["options"], (*now)["options"], before["name"].GetString());
  }
  for (const JsonValue& before : was["exitCodes"].GetArray()) {
    EXPECT_NE(FindElement(is["exitCodes"], "exitCode", before["exitCode"]), nullptr);
  }
}

/// What the earlier schema names, and this one not: `/properties/status`, and so on. `required`
/// counts for what we print; `enum` for what we read.
void FindLost(const JsonValue& was, const JsonValue& is, const char* lists, const std::string& at,
              std::vector<std::string>& lost) {
  for (const char* group : {"properties", "definitions", "patternProperties"}) {
    const JsonValue* members = FindMember(was, group);
    if (members == nullptr) continue;
    for (const auto& member : members->GetObject()) {
      const std::string path = at + "/" + group + "/" + member.name.GetString();
      const JsonValue* others = FindMember(is, group);
      const JsonValue* now = others ? FindMember(*others, member.name.GetString()) : nullptr;
      if (now == nullptr) {
        lost.push_back(path);
      } else {
        FindLost(member.value, *now, lists, path, lost);
      }
    }
  }
  const JsonValue* items = FindMember(was, "items");
  const JsonValue* items_now = FindMember(is, "items");
  if (items != nullptr && items_now != nullptr) {
    FindLost(*items, *items_now, lists, at + "/items", lost);
  }
  const std::set<std::string> now = Texts(FindMember(is, lists));
  if (lists == std::string("enum") && now.empty()) return;  // takes anything
  for (const std::string& text : Texts(FindMember(was, lists))) {
    if (!now.contains(text)) lost.push_back(at + "/" + lists + "/" + text);
  }
}

std::vector<std::string> Lost(const JsonValue& was, const JsonValue& is, const char* lists) {
  std::vector<std::string> lost;
  FindLost(was, is, lists, "", lost);
  return lost;
}

TEST(CompatibilityOfSchemas, FindsWhatIsLost) {
  const auto was = Json(R"({"required":["a"],"properties":{"a":{"items":{"properties":{"b":{}}}},
                            "c":{"enum":["x","y"]}}})");
  const auto is = Json(R"({"properties":{"a":{"items":{"properties":{}}},"c":{"enum":["x","z"]},
                           "d":{}}})");
  EXPECT_THAT(Lost(was, was, "required"), IsEmpty());
  EXPECT_THAT(Lost(was, is, "required"),
              ElementsAre("/properties/a/items/properties/b", "/required/\"a\""));
  EXPECT_THAT(Lost(was, is, "enum"),
              ElementsAre("/properties/a/items/properties/b", "/properties/c/enum/\"y\""));
}

TEST_P(Compatibility, JsonAndConfigurationKeepTheirMembers) {
  int schemas = 0;
  for (const auto& entry : std::filesystem::directory_iterator(earlier_ / "schemas")) {
    std::string name = entry.path().stem().string().substr(std::string("fleetpub.").size());
    for (char& c : name) c = c == '.' ? '/' : c;
    const Finished shown = Fleetpub({"schema", "show", name});
    ASSERT_EQ(shown.exit_code, 0) << name << shown.errors;
    const char* lists = name == "config" ? "enum" : "required";
    EXPECT_THAT(Lost(Json(ReadText(entry.path())), Json(shown.output), lists), IsEmpty()) << name;
    ++schemas;
  }
  EXPECT_GT(schemas, 20);
}

}  // namespace
}  // namespace fleetpub::testing
