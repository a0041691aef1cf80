// schemas/fleetpub/config.schema.json, held against the keys that are read.
#include <gmock/gmock.h>

#include <set>

#include "base/json.h"
#include "config/config_settings.h"
#include "config/toml_text.h"
#include "schema/schema.h"

namespace fleetpub::config {
namespace {

std::set<std::string> NamesIn(const base::JsonValue& object) {
  std::set<std::string> names;
  for (const auto& member : object.GetObject()) names.emplace(base::ToView(member.name));
  return names;
}

std::set<std::string> ListKeys(std::span<const Setting> settings,
                               std::initializer_list<const char*> more) {
  std::set<std::string> keys(more.begin(), more.end());
  for (const Setting& setting : settings) keys.emplace(setting.key);
  return keys;
}

class ConfigSchema : public ::testing::Test {
 protected:
  [[nodiscard]] bool Takes(std::string_view toml) {
    const auto json = TomlToJson(toml);
    return (*registry_.Find("fleetpub/config"))->Validate(*base::ParseJson(*json)).empty();
  }

  schema::Registry registry_;
};

TEST_F(ConfigSchema, HasTheKeysThatAreRead) {
  const auto document = base::ParseJson(*registry_.Text("fleetpub/config"));
  const auto& top = (*document)["properties"];
  EXPECT_EQ(NamesIn(top), ListKeys(Settings(), {"allow_insecure", "default_profile", "profile",
                                                "robot", "group"}));
  const auto profile = NamesIn(top["profile"]["additionalProperties"]["properties"]);
  EXPECT_EQ(profile, ListKeys(Settings(), {"allow_insecure"}));
  const auto robot = NamesIn(top["robot"]["additionalProperties"]["properties"]);
  EXPECT_EQ(robot, ListKeys(RobotSettings(), {}));
}

TEST_F(ConfigSchema, TakesWhatIsRightOnly) {
  EXPECT_TRUE(
      Takes("broker = [\"mqtt://a\", \"mqtt://b\"]\nqos = 1\noutput = \"csv\"\n"
            "[profile.north]\nusername = \"ann\"\n"
            "[robot.\"KIT/0001\"]\nalias = \"agv1\"\n[group]\nhall = [\"agv1\"]\n"));
  EXPECT_FALSE(Takes("brokr = \"mqtt://a\"\n"));
  EXPECT_FALSE(Takes("qos = 3\n"));
  EXPECT_FALSE(Takes("[profile.north]\nalias = \"x\"\n"));
  EXPECT_FALSE(Takes("[group]\nhall = \"agv1\"\n"));
}

}  // namespace
}  // namespace fleetpub::config
