#include "vda5050/reports/discovery.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>

namespace fleetpub::vda5050 {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr std::array<std::string_view, 1> kConnection = {"connection"};
constexpr std::array<std::string_view, 3> kAll = {"connection", "factsheet", "state"};

std::vector<std::string> ListFilters(const TopicScheme& scheme, const RobotFilter& filter = {},
                                     std::span<const std::string_view> names = kConnection) {
  auto filters = DiscoveryFilters(scheme, filter, names);
  if (!filters) return {"refused: " + filters.error().message};
  return std::move(*filters);
}

std::string Message(std::string_view version, std::string_view more = "") {
  return fmt::format(R"({{"version":"{}"{}}})", version, more);
}

// ── filters ──

TEST(DiscoveryFilters, LeaveOpenWhatIsNotKnown) {
  EXPECT_THAT(ListFilters({}), ElementsAre("+/+/+/+/connection"));
  EXPECT_THAT(ListFilters({}, {.manufacturer = "KIT"}), ElementsAre("+/+/KIT/+/connection"));
  EXPECT_THAT(
      ListFilters({}, {"KIT", "0001"}, kAll),
      ElementsAre("+/+/KIT/0001/connection", "+/+/KIT/0001/factsheet", "+/+/KIT/0001/state"));
}

TEST(SpecifiedTopics, AreThoseOfEveryReleaseEachOnce) {
  const RobotAddress robot{"KIT", "0001"};
  EXPECT_THAT(SpecifiedTopics({}, robot, kConnection).value(),
              ElementsAre("uagv/v1/KIT/0001/connection", "uagv/v2/KIT/0001/connection",
                          "vda5050/v3/KIT/0001/connection"));
  EXPECT_THAT(SpecifiedTopics({.interface_name = "fts",
                               .topic_template = "{interface}/{manufacturer}/{serial}/{topic}"},
                              robot, kConnection)
                  .value(),
              ElementsAre("fts/KIT/0001/connection"));
}

TEST(DiscoveryFilters, KeepWhatIsStated) {
  EXPECT_THAT(ListFilters({.interface_name = "fts"}), ElementsAre("fts/+/+/+/connection"));
  EXPECT_THAT(
      ListFilters({.topic_template = "/site/{interface}/v2/{manufacturer}/{serial}/{topic}"}),
      ElementsAre("/site/+/v2/+/+/connection"));
  EXPECT_THAT(
      ListFilters({.topic_template = "a-{interface}-{major}/{manufacturer}.{serial}/{topic}"},
                  {"KIT", "0001"}),
      ElementsAre("+/KIT.0001/connection"));
}

TEST(DiscoveryFilters, AreRefusedWhereTheTopicWouldBe) {
  EXPECT_THAT(ListFilters({.topic_template = "{nothing}/{manufacturer}/{serial}/{topic}"}),
              ElementsAre(HasSubstr("is not a placeholder")));
  EXPECT_THAT(ListFilters({.interface_name = "#"}), ElementsAre(HasSubstr("wildcards")));
  EXPECT_THAT(ListFilters({}, {"KIT", "+"}), ElementsAre(HasSubstr("wildcards")));
}

// ── topics ──

TEST(ReadTopic, ReadsTheLevelsBack) {
  const auto levels = ReadTopic({}, "uagv/v2/KIT/0001/connection");
  ASSERT_TRUE(levels);
  EXPECT_EQ(levels->robot.ToString(), "KIT/0001");
  EXPECT_EQ(levels->interface_name, "uagv");
  EXPECT_EQ(levels->major, "v2");
  EXPECT_EQ(levels->topic_name, "connection");
}

TEST(ReadTopic, ReadsWhatATemplateOfOnesOwnMade) {
  const auto levels = ReadTopic({.topic_template = "a/x-{major}-{interface}/{manufacturer}/"
                                                   "agv-{serial}/{topic}.json"},
                                "a/x-v2-u-a/KIT/agv-7/state.json");
  ASSERT_TRUE(levels);
  EXPECT_EQ(levels->robot.ToString(), "KIT/7");
  EXPECT_EQ(levels->interface_name, "u-a");
  EXPECT_EQ(levels->major, "v2");
  EXPECT_EQ(levels->topic_name, "state");
}

TEST(ReadTopic, ReadsAStatedInterfaceOfSeveralLevels) {
  const TopicScheme scheme{.interface_name = "site/hall"};
  EXPECT_TRUE(ReadTopic(scheme, "site/hall/v3/KIT/0001/connection"));
  EXPECT_FALSE(ReadTopic(scheme, "site/shed/v3/KIT/0001/connection"));
}

TEST(TopicBeside, LiesInTheSamePlace) {
  const std::pair<TopicScheme, std::string> places[] = {
      {{}, "fts/v2/KIT/0001/"},
      {{.interface_name = "fts"}, "fts/v1/KIT/0001/"},
      {{.interface_name = "site/hall"}, "site/hall/v3/KIT/0001/"},
      {{.interface_name = "fts", .topic_template = "{interface}-{major}/{serial}/{topic}"},
       "fts-v7/0001/"},
      {{.interface_name = "fts", .topic_template = "a/{manufacturer}/{serial}/{topic}"},
       "a/KIT/0001/"}};
  for (const auto& [scheme, place] : places) {
    const auto levels = ReadTopic(scheme, place + "connection", "KIT");
    ASSERT_TRUE(levels) << place;
    EXPECT_EQ(TopicBeside(scheme, *levels, "factsheet"), place + "factsheet");
  }
}

TEST(ReadTopic, IsNothingForATopicOfAnotherShape) {
  for (const std::string_view topic :
       {"", "/", "uagv/v2/KIT/0001", "uagv/v2/KIT/0001/connection/x", "uagv/v2//0001/connection",
        "uagv/v2/KIT//connection", "uagv//KIT/0001/connection", "uagv/v2/K$T/0001/connection",
        "uagv/v2/KIT/0001/"}) {
    EXPECT_FALSE(ReadTopic({}, topic)) << topic;
  }
  const TopicScheme prefixed{.topic_template = "x-{interface}/{manufacturer}/{serial}/{topic}"};
  EXPECT_FALSE(ReadTopic(prefixed, "y-u/KIT/0001/state"));
  EXPECT_FALSE(ReadTopic(prefixed, "x-/KIT/0001/state"));
}

TEST(ReadTopic, HoldsARepeatedPlaceholderToOneValue) {
  const TopicScheme scheme{.topic_template = "{serial}/{manufacturer}/{serial}/{topic}"};
  EXPECT_TRUE(ReadTopic(scheme, "1/KIT/1/state"));
  EXPECT_FALSE(ReadTopic(scheme, "1/KIT/2/state"));
}

// ── dialects ──

TEST(DialectFrom, RemembersAVersionThatIsNoRelease) {
  const auto dialect = [](std::string_view topic, std::string_view version) {
    return *DialectFrom({}, topic, std::string(R"({"version":")") + std::string(version) + "\"}")
                ->dialect;
  };
  const Dialect odd = dialect("uagv/v2/RIG/7/connection", "1.4.7");
  EXPECT_EQ(odd.version, Version::k210);
  EXPECT_EQ(odd.version_said, "1.4.7");
  EXPECT_EQ(odd.header_version, "1.4.7");
  EXPECT_EQ(dialect("uagv/v2/RIG/7/connection", "2.0.0+rig").version_said, "2.0.0+rig");
  const Dialect patch = dialect("uagv/v2/RIG/7/connection", "2.0.4");
  EXPECT_EQ(patch.version, Version::k200);
  EXPECT_EQ(patch.version_said, "");
  EXPECT_EQ(patch.header_version, "2.0.4");
}

TEST(DialectFrom, SpeaksEachVersionAtItsOwnTopics) {
  for (const Version version : kVersions) {
    const auto topic = *TopicFor({}, version, {"KIT", "0001"}, "connection");
    const auto found =
        DialectFrom({.assumed = true}, topic,
                    Message(GetFacts(version).name, R"(,"connectionState":"ONLINE")"));
    ASSERT_TRUE(found && found->dialect);
    EXPECT_EQ(found->robot.ToString(), "KIT/0001");
    EXPECT_EQ(found->topic_name, "connection");
    EXPECT_EQ(found->message.connection_state, "ONLINE");
    const Dialect& dialect = *found->dialect;
    EXPECT_EQ(dialect.version, version);
    EXPECT_FALSE(dialect.assumed);
    EXPECT_EQ(dialect.topics.interface_name, "");
    EXPECT_EQ(dialect.topics.topic_template, TopicScheme().topic_template);
    EXPECT_EQ(dialect.header_version, "");
  }
}

// The topic at which a robot found at `topic` is commanded.
std::string FindCommandTopic(std::string_view topic, std::string_view payload,
                             const Dialect& base = {}) {
  const auto found = DialectFrom(base, topic, payload);
  if (!found || !found->dialect) return "";
  return *TopicFor(found->dialect->topics, found->dialect->version, found->robot, "order");
}

TEST(DialectFrom, KeepsTheRobotsOwnInterfaceAndLevel) {
  EXPECT_EQ(FindCommandTopic("fts/v3/KIT/0001/connection", Message("3.0.0")),
            "fts/v3/KIT/0001/order");
  EXPECT_EQ(FindCommandTopic("uagv/v2/KIT/0001/connection", Message("1.1.0")),
            "uagv/v2/KIT/0001/order");
  EXPECT_EQ(FindCommandTopic("uagv/v1/KIT/0001/connection", Message("2.0.0")),
            "uagv/v1/KIT/0001/order");
  EXPECT_EQ(FindCommandTopic("uagv/v3/KIT/0001/connection", Message("3.0.0")),
            "uagv/v3/KIT/0001/order");
  const Dialect own{.topics = {.topic_template = "{major}.{interface}/{manufacturer}/{serial}/"
                                                 "{topic}"}};
  EXPECT_EQ(FindCommandTopic("v1.fts/KIT/0001/state", Message("2.1.0"), own),
            "v1.fts/KIT/0001/order");
}

TEST(DialectFrom, TakesAFactsheetOrAStateToo) {
  for (const std::string name : {"factsheet", "state"}) {
    const auto found = DialectFrom({}, "uagv/v2/KIT/0001/" + name, Message("2.0.0"));
    ASSERT_TRUE(found && found->dialect);
    EXPECT_EQ(found->dialect->version, Version::k200);
    EXPECT_EQ(found->topic_name, name);
  }
}

TEST(DialectFrom, SaysTheVersionAsTheRobotDoes) {
  // Robots compare for equality.
  const auto header_version = [](std::string_view spoken) {
    return DialectFrom({}, "uagv/v2/KIT/0001/connection", Message(spoken))->dialect->header_version;
  };
  EXPECT_EQ(header_version("v2"), "v2");
  EXPECT_EQ(header_version("2.1"), "2.1");
  EXPECT_EQ(header_version("2.2.0"), "2.2.0");
  EXPECT_EQ(header_version("2.1.0"), "");
  EXPECT_EQ(header_version(""), "");
  EXPECT_EQ(header_version("latest"), "");
  EXPECT_EQ(header_version("2.1.0 by KIT"), "");
  EXPECT_EQ(header_version("2.1.000000000000000"), "");
}

TEST(DialectFrom, SaysTheRobotsNameAsItsHeaderDoes) {
  const auto found =
      DialectFrom({}, "uagv/v2/KIT/0001/connection",
                  Message("2.1.0", R"(,"manufacturer":"Kit Lab","serialNumber":"0001")"));
  ASSERT_TRUE(found && found->dialect);
  EXPECT_EQ(found->dialect->header_manufacturer, "Kit Lab");
  EXPECT_EQ(found->dialect->header_serial, "");
  EXPECT_EQ(found->robot.ToString(), "KIT/0001");
}

TEST(DialectFrom, KeepsWhatTheUserStates) {
  const Dialect stated{.version = Version::k300,
                       .topics = {.interface_name = "fts"},
                       .actions_key = "instantActions",
                       .header_version = "2.0",
                       .header_manufacturer = "M",
                       .header_serial = "S"};
  const auto found = DialectFrom(stated, "fts/v2/KIT/0001/connection",
                                 Message("v2", R"(,"manufacturer":"A","serialNumber":"B")"));
  ASSERT_TRUE(found && found->dialect);
  EXPECT_EQ(found->dialect->version, Version::k210);
  EXPECT_EQ(found->dialect->topics.interface_name, "fts");
  EXPECT_EQ(found->dialect->actions_key, "instantActions");
  EXPECT_EQ(found->dialect->header_version, "2.0");
  EXPECT_EQ(found->dialect->header_manufacturer, "M");
  EXPECT_EQ(found->dialect->header_serial, "S");
}

TEST(DialectFrom, FindsARobotWhoseVersionIsNotOurs) {
  const auto found = DialectFrom({}, "vda5050/v4/KIT/0001/connection", Message("4.0.0"));
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->dialect);
  EXPECT_EQ(found->message.header.version, "4.0.0");
}

TEST(DialectFrom, IsNothingForADeletedMessageOrAnotherTopic) {
  EXPECT_FALSE(DialectFrom({}, "uagv/v2/KIT/0001/connection", ""));
  EXPECT_FALSE(DialectFrom({}, "uagv/v2/KIT/0001/connection", "[]"));
  EXPECT_FALSE(DialectFrom({}, "home/kitchen/light", Message("2.1.0")));
}

// ── standing ──

Discovered Found(std::string_view topic, std::string_view version, std::string_view state = "",
                 std::string_view timestamp = "") {
  auto found = DialectFrom(
      {}, topic,
      Message(version,
              fmt::format(R"(,"connectionState":"{}","timestamp":"{}")", state, timestamp)));
  if (!found) throw std::runtime_error("not found");
  return std::move(*found);
}

TEST(Standing, IsGreaterOfTheBetterMessage) {
  const std::string_view older = "2026-01-02T03:04:05.678Z";
  const std::string_view newer = "2026-01-02T03:04:06.678Z";
  // Each better than the one before.
  const std::vector<Discovered> ladder = {
      Found("vda5050/v3/KIT/1/state", "3.0.0", "", newer),
      Found("uagv/v2/KIT/1/connection", "2.1.0", "OFFLINE", older),
      Found("uagv/v1/KIT/1/connection", "1.1.0", "CONNECTIONBROKEN", newer),
      Found("vda5050/v3/KIT/1/connection", "3.0.0", "HIBERNATING", older),
      Found("vda5050/v4/KIT/1/connection", "4.0.0", "ONLINE", ""),
      Found("vda5050/v3/KIT/1/connection", "3.0.0", "ONLINE", ""),
      Found("uagv/v2/KIT/1/connection", "2.0.0", "ONLINE", older),
      Found("uagv/v2/KIT/1/connection", "2.1.0", "ONLINE", older),
      Found("uagv/v1/KIT/1/connection", "1.1.0", "ONLINE", newer),
  };
  for (std::size_t i = 1; i < ladder.size(); ++i) {
    EXPECT_LT(ToStanding(ladder[i - 1]), ToStanding(ladder[i])) << i;
  }
}

}  // namespace
}  // namespace fleetpub::vda5050
