#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <regex>
#include <tuple>

#include "app/doctor.h"
#include "schema/schema.h"

namespace fleetpub::app {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

// By whom, and how.
struct Said {
  std::string serial = "0001";
  std::string place = "vda5050/v3";
  std::string version = "3.0.0";
  std::string named = "0001";  // by its header
  std::string timestamp = {};  // empty: now
};

// A fleet that a test plays, of KIT/0001 mostly.
class ExaminingAFleet : public ::testing::Test {
 protected:
  ExaminingAFleet() { listening_.broker = *mqtt::ParseBrokerUrl("mqtt://north"); }

  [[nodiscard]] std::string Header(int id, const Said& said) const {
    return fmt::format(
        R"("headerId":{},"timestamp":"{}","version":"{}","manufacturer":"KIT","serialNumber":"{}")",
        id, said.timestamp.empty() ? base::FormatTimestamp(now_) : said.timestamp, said.version,
        said.named);
  }
  // What a topic brings now.
  void Hear(const std::string& topic_name, const std::string& payload, bool is_retained,
            const Said& said = {}) {
    vda5050::TopicLevels levels{.robot = {"KIT", said.serial},
                                .interface_name = said.place.substr(0, said.place.find('/')),
                                .major = said.place.substr(said.place.find('/') + 1),
                                .topic_name = topic_name};
    evidence_.Take({.topic = said.place + "/KIT/" + said.serial + "/" + topic_name,
                    .payload = payload,
                    .retained = is_retained},
                   levels, {now_, elapsed_});
  }
  void HearState(int id, const Said& said = {}, const std::string& errors = "") {
    Hear("state",
         "{" + Header(id, said) +
             R"(,"orderId":"","orderUpdateId":0,"lastNodeId":"",)"
             R"("lastNodeSequenceId":0,"driving":false,"nodeStates":[],)"
             R"("edgeStates":[],"actionStates":[],"instantActionStates":[],)"
             R"("powerSupply":{"stateOfCharge":80,"charging":false},)"
             R"("operatingMode":"AUTOMATIC","errors":[)" +
             errors + R"(],"safetyState":{"activeEmergencyStop":"NONE","fieldViolation":false}})",
         false, said);
  }
  void HearConnection(const std::string& state, bool is_retained = true, const Said& said = {}) {
    Hear("connection", "{" + Header(7, said) + R"(,"connectionState":")" + state + "\"}",
         is_retained, said);
  }
  void HearFactsheet(const std::string& more, bool is_retained = true) {
    Hear("factsheet", "{" + Header(3, {}) + more + "}", is_retained);
  }
  void Pass(std::chrono::nanoseconds time) {
    elapsed_ += time;
    now_ += std::chrono::duration_cast<base::WallTime::duration>(time);
  }
  // A robot as it should be.
  void HearHealthy() {
    HearConnection("ONLINE");
    HearFactsheet(kFactsheet);
    for (int id = 5; id < 9; ++id) {
      HearState(id);
      Pass(seconds(10));
    }
  }
  std::map<std::string, Diagnosis> Examine() {
    listening_.elapsed = elapsed_;
    evidence_.ValidateRetained();
    std::map<std::string, Diagnosis> worst;
    ExamineFleet(evidence_, listening_, [&](const Diagnosis& found) {
      const auto weigh = [](Health health) {
        return health == Health::kUnknown ? -1 : int(health);
      };
      const auto [known, is_new] = worst.try_emplace(std::string(found.check), found);
      if (!is_new && weigh(found.health) > weigh(known->second.health)) known->second = found;
    });
    return worst;
  }
  // That this check finds it, and no other check finds a problem or has a warning.
  void ExpectOnly(const std::string& check, Health health, ErrorKind kind,
                  const std::string& text = "") {
    for (const auto& [name, found] : Examine()) {
      if (name == check) {
        EXPECT_EQ(found.health, health) << name << ": " << found.text;
        EXPECT_EQ(found.kind, kind);
        EXPECT_THAT(found.text, HasSubstr(text));
        EXPECT_FALSE(found.remedy.command.empty() && found.remedy.advice.empty()) << name;
      } else {
        EXPECT_TRUE(found.health == Health::kOk || found.health == Health::kUnknown)
            << name << ": " << found.subject << ": " << found.text;
      }
    }
  }

  static constexpr const char* kFactsheet =
      R"(,"typeSpecification":{"seriesName":"x","mobileRobotKinematics":"DIFFERENTIAL",)"
      R"("mobileRobotClass":"CARRIER","maximumLoadMass":1,"localizationTypes":["NATURAL"],)"
      R"("navigationTypes":["AUTONOMOUS"]},"physicalParameters":{"minimumSpeed":0,)"
      R"("maximumSpeed":1,"maximumAcceleration":1,"maximumDeceleration":1,"minimumHeight":1,)"
      R"("maximumHeight":1,"width":1,"length":1},"protocolLimits":{"maximumStringLengths":{},)"
      R"("maximumArrayLengths":{},"timing":{"minimumOrderInterval":0,"minimumStateInterval":4,)"
      R"("defaultStateInterval":10}},"protocolFeatures":{"optionalParameters":[],)"
      R"("mobileRobotActions":[{"actionType":"startPause","actionScopes":["INSTANT"],"pauseAllowed":false,"cancelAllowed":false}]},)"
      R"("mobileRobotGeometry":{},"loadSpecification":{})";

  schema::Registry registry_{""};
  vda5050::Conformance conformance_{{}, registry_};
  FleetEvidence evidence_{conformance_};
  ListeningFacts listening_;
  base::WallTime now_ = *base::ParseDateTime("2026-01-02T03:04:05.000Z");
  std::chrono::nanoseconds elapsed_{0};
};

TEST_F(ExaminingAFleet, FindsNothingWhereNothingIsWrong) {
  HearHealthy();
  for (const auto& [name, found] : Examine()) {
    EXPECT_EQ(found.health, Health::kOk) << name << ": " << found.text;
  }
}

TEST_F(ExaminingAFleet, FindsCommandsThatAreRetained) {
  HearHealthy();
  Hear("order", "{}", true);
  const auto found = Examine().at("retained");
  EXPECT_EQ(found.health, Health::kProblem);
  EXPECT_THAT(found.remedy.command, Contains("vda5050/v3/KIT/0001/order"));
  Hear("order", "", true);  // deleted
  EXPECT_EQ(Examine().at("retained").health, Health::kOk);
}

TEST_F(ExaminingAFleet, FindsStatesThatAreRetained) {
  Hear("state", "{}", true);
  EXPECT_EQ(Examine().at("retained").health, Health::kWarning);
}

TEST_F(ExaminingAFleet, FindsAConnectionMessageThatIsNotRetained) {
  HearFactsheet(kFactsheet);
  HearConnection("ONLINE", false);
  HearState(1);
  ExpectOnly("connection", Health::kProblem, ErrorKind::kInvalid);
}

TEST_F(ExaminingAFleet, JudgesNoRetainedMessagesOfABrokerWithoutAny) {
  HearState(1);
  listening_.knows_retained = false;
  const auto found = Examine();
  EXPECT_EQ(found.at("connection").health, Health::kUnknown);
  EXPECT_EQ(found.at("factsheet").health, Health::kUnknown);
}

TEST_F(ExaminingAFleet, FindsWhoOnlySeemsToBeOnline) {
  HearConnection("ONLINE");
  HearFactsheet(kFactsheet);
  Pass(seconds(20));
  EXPECT_EQ(Examine().at("online").health, Health::kUnknown);
  Pass(seconds(20));
  ExpectOnly("online", Health::kProblem, ErrorKind::kUnconfirmed, "40 s");
}

TEST_F(ExaminingAFleet, FindsWhoSaysThatItIsAwayAndSendsStates) {
  HearConnection("OFFLINE");
  HearFactsheet(kFactsheet);
  HearState(1);
  ExpectOnly("online", Health::kWarning, ErrorKind::kUnconfirmed, "OFFLINE");
}

TEST_F(ExaminingAFleet, MeasuresIntervals) {
  HearHealthy();
  Pass(seconds(15));  // 25 since the last
  ExpectOnly("intervals", Health::kWarning, ErrorKind::kInvalid, "every 10");
  Pass(seconds(11));
  ExpectOnly("intervals", Health::kProblem, ErrorKind::kInvalid, "36");
}

TEST_F(ExaminingAFleet, ExpectsNothingOfARobotBeforeItComesAndAfterItLeaves) {
  HearFactsheet(kFactsheet);
  HearConnection("OFFLINE");
  Pass(seconds(100));
  HearConnection("ONLINE", false, {.timestamp = "2026-01-02T03:05:45.000Z"});
  EXPECT_EQ(Examine().at("online").health, Health::kUnknown);
  HearState(1);
  EXPECT_EQ(Examine().at("intervals").health, Health::kOk);
  HearConnection("OFFLINE", false, {.timestamp = "2026-01-02T03:05:46.000Z"});
  Pass(seconds(100));
  EXPECT_EQ(Examine().at("intervals").health, Health::kOk);
}

TEST_F(ExaminingAFleet, BlamesNoRobotForALostConnection) {
  HearHealthy();
  Pass(seconds(300));
  evidence_.Resume(elapsed_);
  HearState(500);
  const auto found = Examine();
  EXPECT_EQ(found.at("intervals").health, Health::kOk) << found.at("intervals").text;
  EXPECT_EQ(found.at("header-ids").health, Health::kOk);
}

TEST_F(ExaminingAFleet, FindsAClockThatIsWrong) {
  HearConnection("OFFLINE");
  Said late;
  late.timestamp = base::FormatTimestamp(now_ - seconds(10));
  HearState(1, late);
  EXPECT_EQ(Examine().at("clock").health, Health::kWarning);
  Pass(seconds(60));
  HearState(2, late);  // the least difference counts
  EXPECT_EQ(Examine().at("clock").health, Health::kWarning);
  Said early{.serial = "0002", .named = "0002"};
  early.timestamp = base::FormatTimestamp(now_ + seconds(70));
  HearState(1, early);
  const auto found = Examine().at("clock");
  EXPECT_EQ(found.health, Health::kProblem);
  EXPECT_EQ(found.subject, "KIT/0002");
}

TEST_F(ExaminingAFleet, FindsATimeThatIsNotInUtc) {
  HearHealthy();
  Said local;
  local.timestamp = "2026-01-02T03:04:45.000";
  HearState(9, local);
  ExpectOnly("clock", Health::kWarning, ErrorKind::kInvalid, "timestamp");
}

TEST_F(ExaminingAFleet, FindsWhatHeaderIdsTell) {
  const std::tuple<std::vector<int>, Health, const char*> cases[] = {
      {{1, 2, 3}, Health::kOk, "by one"},
      {{1, 2, 5}, Health::kWarning, "2 ids missing"},
      {{8, 9, 0, 1}, Health::kWarning, "anew 1 time"},
      {{4, 4, 4}, Health::kProblem, "always 4"},
      {{90, 5, 91, 6, 92}, Health::kProblem, "two publishers"},
  };
  for (const auto& [ids, health, text] : cases) {
    evidence_ = FleetEvidence(conformance_);
    for (const int id : ids) {
      HearState(id);
      Pass(milliseconds(100));
    }
    const auto found = Examine().at("header-ids");
    EXPECT_EQ(found.health, health) << text;
    EXPECT_THAT(found.text, HasSubstr(text));
  }
}

TEST_F(ExaminingAFleet, FindsVersionsThatDisagree) {
  HearHealthy();
  HearState(9, {.version = "2.1.0"});  // below v3
  EXPECT_EQ(Examine().at("version").health, Health::kProblem);
}

TEST_F(ExaminingAFleet, FindsAHeaderThatNamesAnotherRobot) {
  HearHealthy();
  HearState(9, {.named = "0002"});
  ExpectOnly("names", Health::kProblem, ErrorKind::kInvalid, "0002");
}

TEST_F(ExaminingAFleet, FindsRobotsWithoutAUsefulFactsheet) {
  HearConnection("ONLINE");
  HearState(1);
  ExpectOnly("factsheet", Health::kProblem, ErrorKind::kPreflight, "no factsheet");
  HearFactsheet(kFactsheet, false);
  ExpectOnly("factsheet", Health::kProblem, ErrorKind::kPreflight, "not retained");
  const std::string none =
      std::regex_replace(std::string(kFactsheet), std::regex(R"(\[\{"actionType.*?\}\])"), "[]");
  HearFactsheet(none);
  ExpectOnly("factsheet", Health::kWarning, ErrorKind::kPreflight, "no actions");
}

TEST_F(ExaminingAFleet, AsksNoRobotOf11ForAFactsheet) {
  HearConnection("ONLINE", true, {.place = "uagv/v1", .version = "1.1.0"});
  EXPECT_EQ(Examine().at("factsheet").health, Health::kUnknown);
}

TEST_F(ExaminingAFleet, FindsAListOfActionsThatIsFull) {
  HearHealthy();
  HearState(9, {},
            R"({"errorType":"INSTANT_ACTION_STATES_FULL","errorLevel":"URGENT",)"
            R"("errorReferences":[]})");
  ExpectOnly("action-lists", Health::kProblem, ErrorKind::kPreflight, "STATES_FULL");
  HearState(10);
  EXPECT_EQ(Examine().at("action-lists").health, Health::kOk);
}

TEST_F(ExaminingAFleet, FindsMessagesThatBreakTheirSchema) {
  HearHealthy();
  Hear("state", "{" + Header(9, {}) + R"(,"orderId":7})", false);
  ExpectOnly("messages", Health::kProblem, ErrorKind::kInvalid, "1 message");
}

TEST_F(ExaminingAFleet, FindsOneNameAtTwoPlaces) {
  HearHealthy();
  const Said old{.place = "uagv/v2", .version = "2.1.0"};
  HearConnection("OFFLINE", true, old);
  EXPECT_EQ(Examine().at("places").health, Health::kWarning);
  HearConnection("ONLINE", true, old);
  EXPECT_EQ(Examine().at("places").health, Health::kProblem);
}

TEST_F(ExaminingAFleet, MissesRobotsThatAreExpected) {
  HearHealthy();
  listening_.expected = {{{"KIT", "0008"}, {}, false}};
  EXPECT_EQ(Examine().at("presence").health, Health::kUnknown);
  listening_.expected.push_back({{"KIT", "0009"}, {}, true});
  ExpectOnly("presence", Health::kWarning, ErrorKind::kPreflight, "commanded");
  listening_.named = {{"KIT", "0009"}};
  ExpectOnly("presence", Health::kProblem, ErrorKind::kPreflight);
}

TEST_F(ExaminingAFleet, FindsThatNobodyIsThere) {
  ExpectOnly("presence", Health::kProblem, ErrorKind::kPreflight, "none was heard");
}

TEST_F(ExaminingAFleet, ShowsNoTextThatARobotMeansForATerminal) {
  Hear("state", "{" + Header(1, {.version = "\\u001b[2J"}) + "}", false);
  Hear("order", "{}", true, {.place = "uagv/v\x1b"});
  ExamineFleet(evidence_, listening_, [&](const Diagnosis& found) {
    EXPECT_THAT(found.text + found.remedy.advice, Not(HasSubstr("\x1b")));
  });
}

}  // namespace
}  // namespace fleetpub::app
