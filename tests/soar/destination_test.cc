#include "soar/destination.h"

#include <gmock/gmock.h>

#include <array>

namespace fleetpub::soar {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr auto kPlan = MessageType::kMissionPlan;

Destination Parsed(std::string_view text, MessageType type = kPlan, const Prefix& prefix = {}) {
  const auto destination = ParseDestination(text, prefix, type);
  EXPECT_TRUE(destination) << text << ": " << destination.error().message;
  return destination.value_or(Destination());
}

TEST(SoarDestination, AppendsDirectionAndMessageType) {
  const auto plan = Parsed("soar.planet-ocean.ecosub.eco1");
  EXPECT_EQ(plan.name, "soar.planet-ocean.ecosub.eco1");
  EXPECT_EQ(plan.header, "soar.planet-ocean.ecosub.eco1.to_platform.mission_plan");
  EXPECT_EQ(plan.topic, "soar/planet-ocean/ecosub/eco1/to_platform/mission_plan");
  EXPECT_FALSE(plan.broadcast);
  EXPECT_EQ(plan.platform, (Platform{"planet-ocean", "ecosub", "eco1"}));
  EXPECT_THAT(plan.warnings, IsEmpty());
  EXPECT_EQ(Parsed("soar.noc.autosub.ah1", MessageType::kPlatformStatus).topic,
            "soar/noc/autosub/ah1/from_platform/platform_status");
}

TEST(SoarDestination, TakesAWholeOneAsItIs) {
  const auto whole = Parsed("soar.noc.autosub.ah1.to_platform.mission_plan");
  EXPECT_EQ(whole.name, "soar.noc.autosub.ah1");
  EXPECT_EQ(whole.header, "soar.noc.autosub.ah1.to_platform.mission_plan");
  EXPECT_EQ(Parsed("soar.noc.autosub.ah1.to_platform").header, whole.header);
  const auto odd = Parsed("soar.noc.autosub.ah1.from_platform");
  EXPECT_EQ(odd.topic, "soar/noc/autosub/ah1/from_platform/mission_plan");
  EXPECT_THAT(odd.warnings, ElementsAre(HasSubstr("usually goes to_platform")));
}

TEST(SoarDestination, SendsAShortOneAsItStandsUnderThePrefix) {
  for (const char* text : {"ah1", "autonomy_engine"}) {
    const auto destination = Parsed(text);
    EXPECT_EQ(destination.header, text);
    EXPECT_EQ(destination.topic, "soar/" + std::string(text));
    EXPECT_FALSE(destination.platform);
    EXPECT_THAT(destination.warnings, IsEmpty());
  }
  EXPECT_EQ(Parsed("soar.ah1").topic, "soar/ah1");
  EXPECT_EQ(Parsed("soar.ah1").header, "soar.ah1");
  const auto forgotten = Parsed("noc.autosub.ah1");
  EXPECT_EQ(forgotten.topic, "soar/noc/autosub/ah1");
  EXPECT_THAT(forgotten.warnings, ElementsAre(HasSubstr("soar.noc.autosub.ah1")));
}

TEST(SoarDestination, KnowsAnotherPrefix) {
  const auto prefix = ParsePrefix("sea.trial");
  ASSERT_TRUE(prefix);
  EXPECT_EQ(Parsed("sea.trial.noc.autosub.ah1", kPlan, *prefix).topic,
            "sea/trial/noc/autosub/ah1/to_platform/mission_plan");
  EXPECT_EQ(Parsed("ah1", kPlan, *prefix).topic, "sea/trial/ah1");
  EXPECT_EQ(Broadcast(*prefix).topic, "sea/trial/broadcast");
}

TEST(SoarDestination, IsBroadcast) {
  const auto everybody = Broadcast({});
  EXPECT_EQ(everybody.header, "broadcast");
  EXPECT_EQ(everybody.topic, "soar/broadcast");
  EXPECT_TRUE(everybody.broadcast);
}

TEST(SoarDestination, RefusesWhatIsNone) {
  struct Case {
    std::string_view text;
    std::string_view why;
  };
  constexpr std::array kCases = {
      Case{"", "empty"},
      Case{"soar", "only the prefix"},
      Case{".", "a level is empty"},
      Case{"soar..ecosub.eco1", "a level is empty"},
      Case{"soar.noc.autosub.", "a level is empty"},
      Case{"soar/noc/autosub/ah1", "separated by dots"},
      Case{"soar.noc.autosub.+", "wildcards"},
      Case{"soar.noc.autosub.#", "wildcards"},
      Case{"soar.noc.autosub.*", "wildcards"},
      Case{"soar.noc.auto\nsub.ah1", "control character"},
      Case{"soar.noc.autosub.\xFF", "UTF-8"},
      Case{"sea.noc.autosub.ah1", "begins with the prefix soar"},
      Case{"soar.noc.autosub.ah1.mission_plan", "to_platform or from_platform"},
      Case{"soar.noc.autosub.ah1.to_platform.observation", "the message is a mission_plan"},
      Case{"soar.noc.autosub.ah1.to_platform.mission_plan.x", "more levels"},
      Case{"broadcast", "--broadcast"},
  };
  for (const auto& [text, why] : kCases) {
    const auto destination = ParseDestination(text, {}, kPlan);
    ASSERT_FALSE(destination) << text;
    EXPECT_EQ(destination.error().kind, ErrorKind::kUsage);
    EXPECT_THAT(destination.error().message, HasSubstr(why)) << text;
  }
  EXPECT_FALSE(ParseDestination(std::string(70'000, 'a'), {}, kPlan));
}

TEST(SoarDestination, WarnsOfATopicThatAmqpCannotRoute) {
  const auto longest = Parsed(std::string(250, 'a'));
  EXPECT_THAT(longest.warnings, IsEmpty()) << longest.topic.size();
  EXPECT_THAT(Parsed(std::string(251, 'a')).warnings, ElementsAre(HasSubstr("256 bytes")));
}

TEST(SoarPrefix, RefusesWhatIsNone) {
  for (const char* text : {"", "soar.", "a/b", "+", "$SYS"})
    EXPECT_FALSE(ParsePrefix(text)) << text;
  EXPECT_EQ(ParsePrefix("a.b")->Dotted(), "a.b");
}

TEST(SoarSource, IsCheckedAsALevelIs) {
  EXPECT_TRUE(CheckSource("autonomy_engine"));
  EXPECT_TRUE(CheckSource("soar.noc"));
  for (const char* text : {"", "a/b", "a..b", "#"}) EXPECT_FALSE(CheckSource(text)) << text;
}

TEST(AcknowledgementTopics, AreThePlatformsOwn) {
  EXPECT_THAT(AcknowledgementTopics(Parsed("soar.noc.autosub.ah1"), {}, "me"),
              ElementsAre("soar/noc/autosub/ah1/from_platform/acknowledgement"));
}

TEST(AcknowledgementTopics, AreThoseOfAllPlatformsAndTheSourceOtherwise) {
  for (const auto& destination : {Parsed("ah1"), Broadcast({})}) {
    EXPECT_THAT(AcknowledgementTopics(destination, {}, "ui.one"),
                ElementsAre("soar/+/+/+/from_platform/acknowledgement", "soar/ui/one"));
  }
}

TEST(FindPlatform, ReadsAPlatformsTopic) {
  EXPECT_EQ(FindPlatform("soar/noc/autosub/ah1/from_platform/observation", {}),
            (Platform{"noc", "autosub", "ah1"}));
  for (const char* topic :
       {"", "soar/ah1", "sea/noc/autosub/ah1/from_platform/observation",
        "soar/noc/autosub/ah1/to/observation", "soar/noc/autosub/ah1/from_platform"}) {
    EXPECT_FALSE(FindPlatform(topic, {})) << topic;
  }
}

}  // namespace
}  // namespace fleetpub::soar
