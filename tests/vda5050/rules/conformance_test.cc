#include "vda5050/rules/conformance.h"

#include <gmock/gmock.h>

#include "base/json.h"

namespace fleetpub::vda5050 {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

std::string Connection(std::string_view version, std::string_view serial = "0001") {
  return R"({"headerId":17,"timestamp":"2026-01-02T03:04:05.678Z","version":")" +
         std::string(version) + R"(","manufacturer":"KIT","serialNumber":")" + std::string(serial) +
         R"(","connectionState":"ONLINE"})";
}

class Conforming : public ::testing::Test {
 protected:
  // Violations, and warnings behind `warning: `.
  std::vector<std::string> Findings(std::string_view topic, std::string_view payload,
                                    ConformanceOptions options = {}) {
    const auto result = Conformance(std::move(options), registry_).Validate(topic, payload);
    if (!result) return {"not validated"};
    std::vector<std::string> all;
    for (const auto& [path, message] : result->findings.errors) {
      all.push_back(path + ": " + message);
    }
    for (const auto& [path, message] : result->findings.warnings) {
      all.push_back("warning: " + path + ": " + message);
    }
    return all;
  }
  schema::Registry registry_{""};
};

TEST_F(Conforming, HoldsEachMessageAgainstItsOwnVersion) {
  for (const char* version : {"2.0.0", "2.1.0"}) {
    EXPECT_THAT(Findings("uagv/v2/KIT/0001/connection", Connection(version)), IsEmpty());
  }
  EXPECT_THAT(Findings("vda5050/v3/KIT/0001/connection", Connection("3.0.0")), IsEmpty());
  EXPECT_THAT(Findings("uagv/v2/KIT/0001/connection", Connection("1.1.0")), IsEmpty());
}

TEST_F(Conforming, WarnsOfAHeaderThatDiffersFromTheTopic) {
  const auto differs = [](std::string_view path) {
    return ElementsAre(
        AllOf(StartsWith("warning: " + std::string(path) + ": "), HasSubstr("but the topic says")));
  };
  EXPECT_THAT(Findings("uagv/v2/KIT/0001/connection", Connection("3.0.0")), differs("/version"));
  EXPECT_THAT(Findings("uagv/v2/KIT/0002/connection", Connection("2.1.0")),
              differs("/serialNumber"));
  EXPECT_THAT(Findings("uagv/v2/kit/0001/connection", Connection("2.1.0")),
              differs("/manufacturer"));
  EXPECT_THAT(Findings("uagv/v2/KIT/0002/connection", Connection("2.1.0"), {.strict = true}),
              ElementsAre(StartsWith("/serialNumber: ")));
}

TEST_F(Conforming, TakesAVersionThatIsNoReleaseAsTheNearestOne) {
  EXPECT_THAT(Findings("uagv/v2/KIT/0001/connection", Connection("2.1")),
              ElementsAre(AllOf(StartsWith("warning: /version"), HasSubstr("2.1.0"))));
  EXPECT_THAT(Findings("uagv/v2/KIT/0001/connection", Connection("2.0.4")), IsEmpty());
  EXPECT_THAT(Findings("uagv/v2/KIT/0001/connection", Connection("1.4.7")),
              ElementsAre(AllOf(StartsWith("warning: /version"), HasSubstr("2.1.0"))));
  EXPECT_THAT(Findings("uagv/v9/KIT/0001/connection", Connection("9")),
              ElementsAre(StartsWith("/version")));
  EXPECT_THAT(
      Findings("uagv/v2/KIT/0001/connection", Connection("2.0.0"), {.version = Version::k210}),
      ElementsAre("/version: is \"2.0.0\", not \"2.1.0\""));
}

TEST_F(Conforming, WarnsOfTimesThatAreNotInUtc) {
  const auto at = [&](std::string_view version, const std::string& time, bool strict = false) {
    std::string payload = Connection(version);
    payload.replace(payload.find("2026-01"), std::string("2026-01-02T03:04:05.678Z").size(), time);
    return Findings("uagv/v2/KIT/0001/connection", payload, {.strict = strict});
  };
  for (const char* time : {"2026-01-02T03:04:05.678+02:00", "2026-01-02T03:04:05+00:00",
                           "2026-01-02T03:04:05.678-09:30"}) {
    EXPECT_THAT(at("2.1.0", time), ElementsAre(StartsWith("warning: /timestamp")));
    EXPECT_THAT(at("2.1.0", time, true), ElementsAre(StartsWith("/timestamp")));
  }
  EXPECT_THAT(at("2.1.0", "2026-01-02T03:04:05.678"), ElementsAre(StartsWith("/timestamp")))
      << "the schema's own violation, once";
  EXPECT_THAT(at("2.1.0", "2026-01-02T03:04:05Z"), IsEmpty());
}

TEST_F(Conforming, PutsTheRulesOfTheTextBeforeOtherWarnings) {
  const auto message = base::ParseJson(
      R"({"headerId":1,"timestamp":"2026-01-02T03:04:05.678+01:00","version":"2.1.0",)"
      R"("manufacturer":"KIT","serialNumber":"0001","actions":[]})");
  ASSERT_TRUE(message);
  const auto paths = [](const std::vector<schema::Violation>& list) {
    std::vector<std::string> all;
    for (const auto& violation : list) all.push_back(violation.path);
    return all;
  };
  for (const bool strict : {false, true}) {
    const auto findings = CheckMessage(*message, Version::k210, "instantActions", strict, registry_,
                                       {{"/version", "odd"}});
    const auto& full = strict ? findings.errors : findings.warnings;
    EXPECT_THAT(paths(full), ElementsAre("/actions", "/timestamp", "/version"));
    EXPECT_THAT(strict ? findings.warnings : findings.errors, IsEmpty());
  }
}

TEST_F(Conforming, KnowsWhereAConnectionMessageMustBe) {
  const Conformance any({}, registry_);
  EXPECT_EQ(any.ConnectionTopic("uagv/v2/KIT/0001/state"), "uagv/v2/KIT/0001/connection");
  EXPECT_EQ(any.ConnectionTopic("x/v7/state/state/state"), "x/v7/state/state/connection");
  EXPECT_FALSE(any.ConnectionTopic("uagv/v2/KIT/0001/visualization"));
  EXPECT_FALSE(Conformance({.topic = "state"}, registry_).ConnectionTopic("a/v2/KIT/1/state"));
}

TEST_F(Conforming, SaysWhatBreaksTheSchema) {
  EXPECT_THAT(Findings("uagv/v2/KIT/0001/connection", "{"),
              ElementsAre(HasSubstr("not valid JSON")));
  EXPECT_THAT(Findings("uagv/v2/KIT/0001/state", Connection("2.1.0")),
              ElementsAre(HasSubstr("required but missing")));
  EXPECT_THAT(Findings("uagv/v2/KIT/0001/zoneSet", Connection("2.1.0")), SizeIs(1));
}

TEST_F(Conforming, PassesOverWhatIsNotMeant) {
  EXPECT_THAT(Findings("uagv/v2/KIT/0001/connection", ""), ElementsAre("not validated"));
  EXPECT_THAT(Findings("uagv/v2/KIT/0001/log", "x"), ElementsAre("not validated"));
  EXPECT_THAT(Findings("one/two", "x"), ElementsAre("not validated"));
  EXPECT_THAT(Findings("uagv/v2/KIT/0001/state", "x", {.patterns = {{"KIT", "0002"}}}),
              ElementsAre("not validated"));
}

TEST_F(Conforming, ListensToAllTopicsOrToOne) {
  EXPECT_THAT(Conformance({}, registry_).Filters().value(), SizeIs(kTopicNames.size()));
  EXPECT_THAT(
      Conformance({.patterns = {{"KIT", "*"}}, .topic = "state"}, registry_).Filters().value(),
      ElementsAre("+/+/KIT/+/state"));
  EXPECT_FALSE(Conformance({.topic = "status"}, registry_).Filters());
}

}  // namespace
}  // namespace fleetpub::vda5050
