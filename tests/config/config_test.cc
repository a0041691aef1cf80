#include "config/config.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <array>

#include "config/config_files.h"
#include "support/environment.h"
#include "support/temporary_folder.h"

namespace fleetpub::config {
namespace {

using fleetpub::testing::EnvironmentVariable;
using fleetpub::testing::TemporaryFolder;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::StartsWith;

Result<Config> Loaded(std::string_view text, const std::optional<std::string>& profile = {}) {
  Config config;
  if (auto ok = ReadConfig(text, "/f/c.toml", config); !ok) return Fail(ok.error());
  if (auto ok = Resolve(profile, config); !ok) return Fail(ok.error());
  return config;
}

std::string Fault(std::string_view text, const std::optional<std::string>& profile = {}) {
  const auto config = Loaded(text, profile);
  if (config) return "no fault";
  EXPECT_EQ(config.error().kind, ErrorKind::kUsage);
  return config.error().message;
}

std::string Text(const Config& config, std::string_view key) {
  const ConfigValue* value = config.Find(key);
  return value == nullptr ? "nothing" : value->texts.front();
}

TEST(Config, AnEmptyFileSaysNothing) {
  for (const char* text : {"", "\n", "# broker = \"mqtt://a\"\n", "\xEF\xBB\xBF"}) {
    const auto config = Loaded(text);
    ASSERT_TRUE(config) << config.error().message;
    EXPECT_THAT(config->settings, IsEmpty());
  }
}

TEST(Config, AProfileGoesBeforeTheRestOfTheFile) {
  constexpr std::string_view kText =
      "broker = \"mqtt://a\"\nqos = 1\n[profile.north]\nbroker = [\"mqtt://b\", \"mqtt://c\"]\n";
  const auto config = Loaded(kText, "north");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->profile, "north");
  ASSERT_THAT(config->Find("broker")->texts, SizeIs(2));
  EXPECT_EQ(config->Find("broker")->Origin(), "profile north of /f/c.toml:4");
  EXPECT_EQ(config->Find("qos")->Origin(), "/f/c.toml:2");
  EXPECT_EQ(Text(*Loaded(kText), "broker"), "mqtt://a");
}

TEST(Config, TheDefaultProfileIsUsedUnlessAnotherOrNoneIsAskedFor) {
  constexpr std::string_view kText =
      "default_profile = \"n\"\nqos = 0\n[profile.n]\nqos = 1\n[profile.s]\nqos = 2\n";
  EXPECT_EQ(Text(*Loaded(kText), "qos"), "1");
  EXPECT_EQ(Text(*Loaded(kText, "s"), "qos"), "2");
  EXPECT_EQ(Text(*Loaded(kText, ""), "qos"), "0");
}

TEST(Config, ARobotsOwnTableGoesBeforeEverything) {
  const auto config = Loaded(
      "vda = \"3.0.0\"\ninterface = \"x\"\n[robot.\"KIT/1\"]\nvda = \"2.1\"\nalias = \"one\"\n");
  ASSERT_TRUE(config) << config.error().message;
  const vda5050::RobotAddress robot{"KIT", "1"};
  EXPECT_EQ(config->Find(robot, "vda")->texts.front(), "2.1");
  EXPECT_EQ(config->Find(robot, "interface")->texts.front(), "x");
  EXPECT_EQ(config->Find({"KIT", "2"}, "vda")->texts.front(), "3.0.0");
  EXPECT_EQ(config->aliases.at("one"), robot);
}

TEST(Config, AGroupHoldsRobotsAndAliasesEachOnce) {
  const auto config = Loaded(
      "[robot.\"KIT/1\"]\nalias = \"one\"\n[group]\nhall = [\"KIT/2\", \"one\", \"KIT/1\"]\n");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_THAT(config->group_robots.at("hall"), SizeIs(2));
}

TEST(Config, AProgramIsAPathOfTheFilesFolderOrANameToBeLookedFor) {
  const auto command = [](const std::string& items) {
    return Loaded("password_command = [" + items + "]\n")->Find("password_command")->texts;
  };
  EXPECT_THAT(command(R"("pass", "show", "a/b")"), ElementsAre("pass", "show", "a/b"));
  EXPECT_THAT(command(R"("./token.sh", "./x")"), ElementsAre("/f/./token.sh", "./x"));
  EXPECT_THAT(command(R"("/bin/token", "")"), ElementsAre("/bin/token", ""));
  const EnvironmentVariable home("HOME", "/home/ann");
  EXPECT_THAT(command(R"("~/bin/token")"), ElementsAre("/home/ann/bin/token"));
}

// Both are keys for the same thing.
TEST(Config, ALaterFilesWayToAPasswordReplacesTheOther) {
  Config config;
  ASSERT_TRUE(ReadConfig("password_file = \"x\"\n[profile.n]\npassword_command = [\"a\"]\n",
                         "/etc/c.toml", config));
  ASSERT_TRUE(ReadConfig("password_command = [\"b\"]\n[profile.n]\npassword_file = \"y\"\n",
                         "/f/c.toml", config));
  EXPECT_FALSE(config.settings.contains("password_file"));
  EXPECT_EQ(config.settings.at("password_command").texts.front(), "b");
  EXPECT_FALSE(config.profiles.at("n").contains("password_command"));
  EXPECT_EQ(config.profiles.at("n").at("password_file").texts.front(), "/f/y");
}

TEST(Config, WhatIsNotUnderstoodIsRefusedWithItsPlace) {
  struct Case {
    const char* text;
    const char* fault;
  };
  for (const auto& [text, fault] : std::to_array<Case>({
           {"\nbrokr = \"mqtt://a\"\n",
            "c.toml:2:1: brokr: there is no such key: did you mean bro"},
           {"password-file = \"x\"\n",
            "c.toml:1:1: password-file: there is no such key: did you "
            "mean password_file?"},
           {"qos = \"1\"\n", "c.toml:1:1: qos: takes a whole number, not a text"},
           {"vda = 2.1\n", "vda: takes a text in quotation marks, not a number"},
           {"insecure = \"true\"\n", "insecure: takes true or false, not a text"},
           {"broker = []\n", "not an empty list"},
           {"broker = [1]\n", "broker: takes a text in quotation marks or a list of such"},
           {"vda = \"4\"\n", "c.toml:1:7: vda: "},
           {"output = \"xml\"\n", "output: takes text, json, csv, tsv, not 'xml'"},
           {"qos = 3\n", "qos: takes 0, 1, 2, not '3'"},
           {"output = \"openmetrics\"\n", "output: takes text, json, csv, tsv, not"},
           {"password_command = \"pass\"\n", "password_command: takes a list of texts"},
           {"password_command = []\n", "not an empty list"},
           {"password_command = [\"\"]\n", "password_command: takes a list of texts, the program"},
           {"password_command = [\"a\", 1]\n", "password_command: takes a list of texts"},
           {"password_command = [\"a\", \"\\u0000\"]\n", "c.toml:1:26: password_command: "},
           {"password_file = \"x\"\npassword_command = [\"a\"]\n",
            "c.toml:2:1: password_command: this table has a password_file"},
           {"keep_alive = 2026-01-01\n", "not a date or time"},
           {"profile = 1\n", "profile holds tables"},
           {"profile.a = 1\n", "profile.a is a table"},
           {"[profile.a]\nrobots = 1\n", "c.toml:2:1: robots: there is no such key"},
           {"[profile.a]\ndefault_profile = \"a\"\n", "there is no such key"},
           {"[robot.KIT]\n", "c.toml:1:8: "},
           {"[robot.\"KIT/+\"]\n", "wildcards"},
           {"[robot.\"KIT/1\"]\nbroker = \"mqtt://a\"\n", "broker: there is no such key"},
           {"[robot.\"KIT/1\"]\nallow_insecure = true\n", "there is no such key"},
           {"[robot.\"KIT/1\"]\nalias = \"a/b\"\n", "is not a name for a target"},
           {"[robot.\"KIT/1\"]\nalias = \"@a\"\n", "is not a name for a target"},
           {"[group]\na = \"KIT/1\"\n", "takes a list of robots"},
           {"[group]\na = []\n", "at least one"},
           {"[group]\n\"a b\" = [\"KIT/1\"]\n", "is not a name for a target"},
           {"group = 1\n", "group is a table"},
           {"a = 1\na = 2\n", "c.toml:2:"},
           {"broker = \"mqtt://a\nqos = 1\n", "c.toml:1:"},
       })) {
    EXPECT_THAT(Fault(text), HasSubstr(fault)) << text;
    EXPECT_THAT(Fault(text), StartsWith("/f/c.toml:"));
  }
}

TEST(Config, HostileTextIsRefused) {
  EXPECT_THAT(Fault("username = \"\xFF\""), HasSubstr("not valid TOML"));
  EXPECT_THAT(Fault("a = " + std::string(100'000, '[')), HasSubstr("not valid TOML"));
  EXPECT_THAT(Fault("broker" + std::string(100'000, '.') + " = 1"), HasSubstr("not valid TOML"));
  EXPECT_THAT(Fault(std::string("a\0b", 3)), HasSubstr("not valid TOML"));
  EXPECT_THAT(Fault("\"a\\u001b[2J\" = 1\n"), Not(HasSubstr("\x1b")));
}

TEST(Config, APasswordIsRefusedAndNotRepeated) {
  for (const char* text :
       {"password = \"hunter2\"\n", "key_password = \"hunter2\"\n",
        "[profile.a]\npassword = \"hunter2\"\n", "password = hunter2\n", "password = \"hunter2\n",
        "password = true hunter2\n", "broker = \"mqtt://me:hunter2@host\"\n",
        "proxy = \"http://me:hunter2@host\"\n"}) {
    EXPECT_THAT(Fault(text), AllOf(HasSubstr("c.toml:"), Not(HasSubstr("hunter")))) << text;
  }
  EXPECT_THAT(Fault("password = \"x\"\n"), HasSubstr("password_file"));
}

TEST(Config, InsecureNeedsAWordBesideIt) {
  EXPECT_THAT(Fault("\ninsecure = true\n"), AllOf(HasSubstr("c.toml:2:1: insecure = true"),
                                                  HasSubstr("allow_insecure = true beside it")));
  EXPECT_THAT(Fault("allow_insecure = false\ninsecure = true\n"), HasSubstr("allow_insecure"));
  EXPECT_THAT(Fault("allow_insecure = true\n[profile.a]\ninsecure = true\n"),
              HasSubstr("c.toml:3:1: insecure"));
  EXPECT_TRUE(Loaded("insecure = true\nallow_insecure = true\n"));
  EXPECT_TRUE(Loaded("insecure = false\n"));
}

TEST(Config, UnknownNamesAreRefusedWithTheNearest) {
  EXPECT_THAT(Fault("[profile.north]\n", "nroth"),
              AllOf(HasSubstr("no profile 'nroth': did you mean north?"), HasSubstr("/f/c.toml")));
  EXPECT_THAT(Fault("\ndefault_profile = \"x\"\n[profile.north]\n"), StartsWith("/f/c.toml:2:1: "));
  EXPECT_THAT(Fault("[group]\na = [\"KIT/1\",\n \"agv2\"]\n[robot.\"KIT/1\"]\nalias = \"agv1\"\n"),
              HasSubstr("c.toml:3:2: there is no robot with the alias 'agv2': did you mean agv1?"));
  EXPECT_THAT(Fault("[group]\na = [\"@b\"]\nb = [\"@a\"]\n"), HasSubstr("no other group"));
  EXPECT_THAT(Fault("[robot.\"A/1\"]\nalias = \"x\"\n[robot.\"A/2\"]\nalias = \"x\"\n"),
              AllOf(HasSubstr("c.toml:4:1: alias 'x' already names A/1"), HasSubstr("c.toml:2")));
}

TEST(Config, PathsAreRelativeToTheFile) {
  const EnvironmentVariable home("HOME", "/home/me");
  const auto config = Loaded(
      "password_file = \"pw\"\ncafile = \"/etc/ca\"\ncert = \"~/c\"\nledger = "
      "\"postgresql://a/b\"\n");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(Text(*config, "password_file"), "/f/pw");
  EXPECT_EQ(Text(*config, "cafile"), "/etc/ca");
  EXPECT_EQ(Text(*config, "cert"), "/home/me/c");
  EXPECT_EQ(Text(*config, "ledger"), "postgresql://a/b");
}

class ConfigFiles : public ::testing::Test {
 protected:
  [[nodiscard]] Result<Config> Load(Missing missing = Missing::kIsAllowed,
                                    const std::optional<std::string>& profile = {}) const {
    const std::array files = {folder_ / "host.toml", folder_ / "user.toml"};
    return LoadConfigFiles(files, missing, profile);
  }

  TemporaryFolder folder_;
};

TEST_F(ConfigFiles, TheUsersKeysGoBeforeTheHosts) {
  folder_.Write("host.toml",
                "qos = 1\nusername = \"host\"\n[profile.n]\nqos = 2\n"
                "[robot.\"KIT/1\"]\nvda = \"2.1\"\nalias = \"a\"\n");
  folder_.Write("user.toml",
                "qos = 0\n[profile.n]\nusername = \"me\"\n"
                "[robot.\"KIT/1\"]\nalias = \"b\"\n[group]\nall = [\"b\"]\n");
  const auto config = Load();
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(Text(*config, "qos"), "0");
  EXPECT_EQ(Text(*config, "username"), "host");
  EXPECT_EQ(config->Find({"KIT", "1"}, "vda")->texts.front(), "2.1");
  EXPECT_THAT(config->aliases, SizeIs(1));
  // A profile of either file goes before what stands outside of profiles in the other.
  const auto north = Load(Missing::kIsAllowed, "n");
  EXPECT_EQ(Text(*north, "qos"), "2");
  EXPECT_EQ(Text(*north, "username"), "me");
}

TEST_F(ConfigFiles, MayBeMissingUnlessTheyAreNamed) {
  const auto config = Load();
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_THAT(config->files, IsEmpty());
  EXPECT_THAT(Load(Missing::kIsAnError).error().message, EndsWith("No such file or directory"));
}

TEST_F(ConfigFiles, AreRefusedWhenTheyCannotBeTrustedOrRead) {
  const auto file = folder_.Write("user.toml", "qos = 1\n");
  chmod(file.c_str(), 0666);
  EXPECT_THAT(Load().error().message, HasSubstr("everybody can write it"));
  chmod(file.c_str(), 0600);
  EXPECT_TRUE(Load());
  std::filesystem::create_directory(folder_ / "host.toml");
  EXPECT_THAT(Load().error().message, HasSubstr("it is a folder"));
  std::filesystem::remove(folder_ / "host.toml");
  folder_.Write("host.toml", std::string((1U << 20U) + 1, '#'));
  EXPECT_THAT(Load().error().message, HasSubstr("too large"));
}

}  // namespace
}  // namespace fleetpub::config
