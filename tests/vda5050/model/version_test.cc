#include "vda5050/model/version.h"

#include <gmock/gmock.h>

namespace fleetpub::vda5050 {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(ParseVersion, TakesFullAndShortForms) {
  constexpr std::pair<std::string_view, Version> kCases[] = {
      {"1", Version::k110},     {"1.1", Version::k110},    {"1.1.0", Version::k110},
      {"2.0", Version::k200},   {"2.0.0", Version::k200},  {"2", Version::k210},
      {"2.1", Version::k210},   {"2.1.0", Version::k210},  {"3", Version::k300},
      {"3.0", Version::k300},   {"3.0.0", Version::k300},  {"1.1.9", Version::k110},
      {"2.0.4", Version::k200}, {"2.1.12", Version::k210}, {"3.0.7", Version::k300},
  };
  for (const auto& [text, version] : kCases) EXPECT_EQ(ParseVersion(text), version) << text;
}

TEST(ParseVersion, RefusesTheRestAndNamesWhatThereIs) {
  for (const std::string_view text : {"", "4", "1.0", "2.2", "1.3.2", "v3", "3.", " 3", "3.0.0 ",
                                      "3.0.", "3.0.0.1", "3.0.0-rc", "3.-1", "3.0.x"}) {
    const auto version = ParseVersion(text);
    ASSERT_FALSE(version) << text;
    EXPECT_EQ(version.error().kind, ErrorKind::kUsage);
  }
  EXPECT_THAT(ParseVersion("v3\x1b").error().message,
              AllOf(HasSubstr(R"('v3\x1b')"), HasSubstr("1.1.0, 2.0.0, 2.1.0 or 3.0.0")));
}

TEST(VersionSpoken, IsReadLenientlyAndTellsWhatIsNoRelease) {
  const std::tuple<std::string_view, std::string_view, std::optional<SpokenVersion>> cases[] = {
      {"1.1.0", "", SpokenVersion{Version::k110, true}},
      {"1.1.0", "v2", SpokenVersion{Version::k110, true}},
      {"2.0.0", "v2", SpokenVersion{Version::k200, true}},
      {"2.0.4", "", SpokenVersion{Version::k200, true}},
      {"3.0.12", "v3", SpokenVersion{Version::k300, true}},
      {"2.0", "", SpokenVersion{Version::k200, false}},
      {"v2.1", "", SpokenVersion{Version::k210, false}},
      {" V2.0.0 ", "", SpokenVersion{Version::k200, false}},
      {"2", "", SpokenVersion{Version::k210, false}},
      {"1", "", SpokenVersion{Version::k110, false}},
      {"1.0.0", "", SpokenVersion{Version::k110, false}},
      {"2.0.0-rc", "", SpokenVersion{Version::k200, false}},
      {"2.0.0.1", "", SpokenVersion{Version::k200, false}},
      // Not known: the newest of the topic's major version, else of its own.
      {"2.2.0", "", SpokenVersion{Version::k210, false}},
      {"3.1.0", "v3", SpokenVersion{Version::k300, false}},
      {"1.4.7", "v2", SpokenVersion{Version::k210, false}},
      {"1.4.7", "v1", SpokenVersion{Version::k110, false}},
      {"1.4.7", "v9", SpokenVersion{Version::k110, false}},
      {"4.0.0", "v3", std::nullopt},  // said, and not ours
      {"0.9", "v2", std::nullopt},
      // Unreadable.
      {"", "v2", SpokenVersion{Version::k210, false}},
      {"latest", "v1", SpokenVersion{Version::k110, false}},
      {"2.x", "v2", SpokenVersion{Version::k210, false}},
      {"-2", "v3", SpokenVersion{Version::k300, false}},
      {"99999999999999999999", "v3", SpokenVersion{Version::k300, false}},
      {"", "", std::nullopt},
      {"", "prod", std::nullopt},
  };
  for (const auto& [header, major, spoken] : cases) {
    EXPECT_EQ(VersionSpoken(header, major), spoken) << header << " at " << major;
  }
}

TEST(NoReleaseText, IsSafeToShow) {
  EXPECT_THAT(NoReleaseText("2.0\x1b", Version::k200),
              AllOf(HasSubstr(R"("2.0\x1b")"), HasSubstr("2.0.0")));
}

TEST(GetFacts, StandInTheOrderOfTheVersions) {
  for (const Version version : kVersions) EXPECT_EQ(GetFacts(version).version, version);
}

TEST(GetFacts, NameAVersionAsItIsParsed) {
  for (const Version version : kVersions) EXPECT_EQ(ParseVersion(GetFacts(version).name), version);
}

TEST(GetFacts, TellWhatDiffers) {
  struct Case {
    Version version;
    std::string_view topic_levels;
    std::string_view actions;
    std::string_view descriptor;
  };
  for (const auto& [version, levels, actions, descriptor] :
       {Case{Version::k110, "uagv/v1", "instantActions", "actionDescription"},
        Case{Version::k200, "uagv/v2", "actions", "actionDescription"},
        Case{Version::k210, "uagv/v2", "actions", "actionDescription"},
        Case{Version::k300, "vda5050/v3", "actions", "actionDescriptor"}}) {
    const VersionFacts& facts = GetFacts(version);
    EXPECT_EQ(std::string(facts.interface_name) + "/" + std::string(facts.major), levels);
    EXPECT_EQ(facts.actions_key, actions);
    EXPECT_EQ(facts.descriptor_key, descriptor);
    EXPECT_EQ(facts.only_blocking_type_none, version == Version::k300);
    EXPECT_EQ(facts.empty_parameters, version == Version::k110);
  }
}

}  // namespace
}  // namespace fleetpub::vda5050
