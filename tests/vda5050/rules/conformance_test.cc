#include "vda5050/rules/conformance.h"

#include <gmock/gmock.h>

namespace fleetpub::vda5050 {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

std::string Connection(std::string_view version, std::string_view serial = "0001") {
  return R"({"headerId":17,"timestamp":"2026-01-02T03:04:05.678Z","version":")" +
         std::string(version) + R"(","manufacturer":"KIT","serialNumber":")" + std::string(serial) +
         R"(","connectionState":"ONLINE"})";
}

class Conforming : public ::testing::Test {
 protected:
  std::vector<std::string> Errors(std::string_view topic, std::string_view payload,
                                  ConformanceOptions options = {}) {
    auto result = Conformance(std::move(options), registry_).Validate(topic, payload);
    if (!result) return {"not validated"};
    std::vector<std::string> errors;
    for (const auto& [path, message] : result->findings.errors) {
      errors.push_back(path + ": " + message);
    }
    return errors;
  }
  schema::Registry registry_{""};
};

TEST_F(Conforming, HoldsEachMessageAgainstItsOwnVersion) {
  for (const char* version : {"2.0.0", "2.1.0"}) {
    EXPECT_THAT(Errors("uagv/v2/KIT/0001/connection", Connection(version)), IsEmpty());
  }
  EXPECT_THAT(Errors("vda5050/v3/KIT/0001/connection", Connection("3.0.0")), IsEmpty());
  EXPECT_THAT(Errors("uagv/v2/KIT/0001/connection", Connection("1.1.0")), IsEmpty());
}

TEST_F(Conforming, ComparesTheHeaderWithTheTopic) {
  EXPECT_THAT(Errors("uagv/v2/KIT/0001/connection", Connection("3.0.0")),
              ElementsAre("/version: is \"3.0.0\", but the topic says \"v2\""));
  EXPECT_THAT(Errors("uagv/v2/KIT/0002/connection", Connection("2.1.0")),
              ElementsAre("/serialNumber: is \"0001\", but the topic says \"0002\""));
  EXPECT_THAT(Errors("uagv/v2/KIT/0001/connection", Connection("2.1")),
              ElementsAre(HasSubstr("\"2.1\" is no release of VDA 5050: held against 2.1.0")));
  EXPECT_THAT(Errors("uagv/v2/KIT/0001/connection", Connection("2.0.4")), IsEmpty());
  EXPECT_THAT(Errors("uagv/v2/KIT/0001/connection", Connection("1.4.7")),
              ElementsAre(HasSubstr("\"1.4.7\" is no release of VDA 5050: held against 2.1.0")));
  EXPECT_THAT(Errors("uagv/v9/KIT/0001/connection", Connection("9")), SizeIs(1));
  EXPECT_THAT(
      Errors("uagv/v2/KIT/0001/connection", Connection("2.0.0"), {.version = Version::k210}),
      ElementsAre("/version: is \"2.0.0\", not \"2.1.0\""));
}

TEST_F(Conforming, SaysWhatBreaksTheSchema) {
  EXPECT_THAT(Errors("uagv/v2/KIT/0001/connection", "{"), ElementsAre(HasSubstr("not valid JSON")));
  EXPECT_THAT(Errors("uagv/v2/KIT/0001/state", Connection("2.1.0")),
              ElementsAre(HasSubstr("required but missing")));
  EXPECT_THAT(Errors("uagv/v2/KIT/0001/zoneSet", Connection("2.1.0")), SizeIs(1));
}

TEST_F(Conforming, PassesOverWhatIsNotMeant) {
  EXPECT_THAT(Errors("uagv/v2/KIT/0001/connection", ""), ElementsAre("not validated"));
  EXPECT_THAT(Errors("uagv/v2/KIT/0001/log", "x"), ElementsAre("not validated"));
  EXPECT_THAT(Errors("one/two", "x"), ElementsAre("not validated"));
  EXPECT_THAT(Errors("uagv/v2/KIT/0001/state", "x", {.pattern = {"KIT", "0002"}}),
              ElementsAre("not validated"));
}

TEST_F(Conforming, ListensToAllTopicsOrToOne) {
  EXPECT_THAT(Conformance({}, registry_).Filters().value(), SizeIs(AllTopics().size()));
  EXPECT_THAT(Conformance({.pattern = {"KIT", "*"}, .topic = "state"}, registry_).Filters().value(),
              ElementsAre("+/+/KIT/+/state"));
  EXPECT_FALSE(Conformance({.topic = "status"}, registry_).Filters());
}

}  // namespace
}  // namespace fleetpub::vda5050
