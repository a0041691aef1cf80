#include "vda5050/reports/robot_directory.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

namespace fleetpub::vda5050 {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::IsNull;
using ::testing::NotNull;

std::string Message(std::string_view version, std::string_view members, int second = 0) {
  return fmt::format(R"({{"headerId":1,"timestamp":"2026-01-02T03:04:{:02}.000Z","version":"{}",)"
                     R"("manufacturer":"KIT","serialNumber":"0001",{}}})",
                     second, version, members);
}

std::string Connection(std::string_view version, std::string_view state, int second = 0) {
  return Message(version, fmt::format(R"("connectionState":"{}")", state), second);
}

const RobotEntry* Deliver(RobotDirectory& directory, std::string_view topic,
                          std::string_view payload, Origin origin) {
  const ListedRobot* listed = directory.Deliver(topic, payload, origin);
  return listed == nullptr ? nullptr : &listed->second;
}

class RobotDirectoryTest : public ::testing::Test {
 protected:
  RobotDirectoryTest() {
    for (const char* text : {"paused=true", "version=2.1.0"}) {
      conditions_.push_back(*ParseCondition(text));
    }
  }
  // Takes whom KIT/* means, each in its own dialect.
  RobotDirectory Open() {
    RobotDirectory directory(conditions_, [this](const RobotAddress& robot) -> Admitted {
      if (robot.manufacturer != "KIT") return std::nullopt;
      return std::pair(base_, true);
    });
    directory.AddScheme(base_->topics);
    return directory;
  }
  using Admitted = std::optional<std::pair<std::shared_ptr<const Dialect>, bool>>;

  std::shared_ptr<const Dialect> base_ = std::make_shared<const Dialect>();
  std::vector<Condition> conditions_;
};

TEST_F(RobotDirectoryTest, FindsWhomItAdmitsEachInItsOwnDialect) {
  RobotDirectory directory = Open();
  const auto* old = Deliver(directory, "uagv/v2/KIT/0001/connection", Connection("2.1.0", "ONLINE"),
                            Origin::kRetained);
  ASSERT_NE(old, nullptr);
  EXPECT_TRUE(old->IsOnline());
  EXPECT_EQ(old->Spoken()->version, Version::k210);
  EXPECT_EQ(Deliver(directory, "uagv/v2/ABC/0001/connection", Connection("2.1.0", "ONLINE"),
                    Origin::kRetained),
            nullptr);
  const auto* broken =
      Deliver(directory, "uagv/v2/KIT/0002/connection", "no JSON", Origin::kRetained);
  ASSERT_NE(broken, nullptr);
  EXPECT_NE(broken->connection->fault, "") << "there is a robot, and why it is not known how";
}

TEST_F(RobotDirectoryTest, SharesWhatRobotsOfOneMakeHaveInCommon) {
  RobotDirectory directory = Open();
  const RobotEntry* entries[2] = {};
  for (int i = 0; i < 2; ++i) {
    const std::string topic = fmt::format("vda5050/v3/KIT/000{}/", i + 1);
    const std::string header =
        fmt::format(R"({{"version":"3.0.0","manufacturer":"KIT","serialNumber":"000{}",)", i + 1);
    Deliver(directory, topic + "factsheet", header + R"("protocolLimits":{}})", Origin::kRetained);
    entries[i] = Deliver(directory, topic + "connection", header + R"("connectionState":"ONLINE"})",
                         Origin::kRetained);
    ASSERT_NE(entries[i], nullptr);
  }
  EXPECT_EQ(entries[0]->own, entries[1]->own);
  EXPECT_EQ(entries[0]->factsheet, entries[1]->factsheet);
  EXPECT_NE(entries[0]->factsheet, nullptr);
}

TEST_F(RobotDirectoryTest, BelievesTheMessageOfTheGreaterStanding) {
  RobotDirectory directory = Open();
  const auto deliver = [&](const char* topic, const std::string& payload) {
    return Deliver(directory, topic, payload, Origin::kRetained);
  };
  deliver("vda5050/v3/KIT/0001/connection", Connection("3.0.0", "OFFLINE", 9));
  const auto* entry = deliver("uagv/v2/KIT/0001/connection", Connection("2.1.0", "ONLINE", 1));
  EXPECT_EQ(entry->Spoken()->version, Version::k210) << "ONLINE goes before a newer one";
  deliver("uagv/v2/KIT/0001/factsheet", Message("2.1.0", R"("protocolLimits":{})", 30));
  EXPECT_EQ(entry->topic, "uagv/v2/KIT/0001/connection");
}

TEST_F(RobotDirectoryTest, TestsConditionsByTheTopicThatTheyAreAbout) {
  EXPECT_EQ(FindTopicName(*ParseCondition("connectionState=ONLINE")), "connection");
  EXPECT_EQ(FindTopicName(*ParseCondition("/typeSpecification/agvClass=FORKLIFT")), "factsheet");
  EXPECT_EQ(FindTopicName(*ParseCondition("/batteryState/batteryCharge<20")), "state");
  RobotDirectory directory = Open();
  const auto* entry = Deliver(directory, "uagv/v2/KIT/0001/connection",
                              Connection("2.1.0", "ONLINE"), Origin::kRetained);
  ASSERT_EQ(entry->unmet.size(), 2U);
  EXPECT_FALSE(entry->unmet[0].has_value()) << "no state was heard";
  EXPECT_EQ(entry->unmet[1], "");
  Deliver(directory, "uagv/v2/KIT/0001/state", Message("2.1.0", R"("paused":false)"),
          Origin::kLive);
  EXPECT_EQ(entry->unmet[0], "paused is false");
  Deliver(directory, "uagv/v2/KIT/0001/state", Message("2.1.0", R"("paused":true)"), Origin::kLive);
  EXPECT_EQ(entry->unmet[0], "");
  Deliver(directory, "uagv/v2/KIT/0001/state", Message("2.1.0", R"("paused":false)"),
          Origin::kRetained);
  EXPECT_EQ(entry->unmet[0], "") << "what was retained is the past";
}

TEST_F(RobotDirectoryTest, DecidesNothingByARetainedState) {
  RobotDirectory directory = Open();
  const auto* entry = Deliver(directory, "uagv/v2/KIT/0001/connection",
                              Connection("2.1.0", "ONLINE"), Origin::kRetained);
  Deliver(directory, "uagv/v2/KIT/0001/state",
          Message("2.1.0", R"("paused":true,"operatingMode":"MANUAL")"), Origin::kRetained);
  EXPECT_FALSE(entry->state_heard);
  EXPECT_FALSE(entry->unmet[0].has_value());
  EXPECT_EQ(entry->Known().operating_mode, "");
  Deliver(directory, "uagv/v2/KIT/0001/state",
          Message("2.1.0", R"("paused":true,"operatingMode":"manual")"), Origin::kLive);
  EXPECT_EQ(entry->Known().operating_mode, "MANUAL") << "which the check heeds";
}

TEST_F(RobotDirectoryTest, BelievesThePlaceAtWhichARobotSpeaks) {
  RobotDirectory directory = Open();
  Deliver(directory, "vda5050/v3/KIT/0001/factsheet", Message("3.0.0", R"("protocolLimits":{})"),
          Origin::kRetained);
  const auto* entry = Deliver(directory, "uagv/v2/KIT/0001/connection",
                              Connection("2.1.0", "ONLINE", 30), Origin::kRetained);
  Deliver(directory, "vda5050/v3/KIT/0001/connection", Connection("3.0.0", "ONLINE", 1),
          Origin::kRetained);
  EXPECT_EQ(entry->Spoken()->version, Version::k210) << "the newer, while nothing tells them apart";
  EXPECT_EQ(entry->Known().other_topic, "vda5050/v3/KIT/0001/connection");
  EXPECT_EQ(entry->factsheet, nullptr) << "nothing is mixed";
  Deliver(directory, "vda5050/v3/KIT/0001/state", Message("3.0.0", R"("paused":true)", 2),
          Origin::kLive);
  EXPECT_EQ(entry->Spoken()->version, Version::k300);
  EXPECT_NE(entry->factsheet, nullptr);
  EXPECT_EQ(entry->Known().other_topic, "");
  EXPECT_EQ(entry->unmet[0], "");
  EXPECT_EQ(entry->unmet[1], "version is \"3.0.0\"");
}

TEST_F(RobotDirectoryTest, TakesARobotThatSendsStatesForAlive) {
  RobotDirectory directory = Open();
  const auto* entry = Deliver(directory, "uagv/v2/KIT/0001/state",
                              Message("2.1.0", R"("paused":true)"), Origin::kLive);
  ASSERT_NE(entry, nullptr);
  EXPECT_TRUE(entry->IsAlive()) << "without any connection message";
  EXPECT_EQ(entry->Spoken()->version, Version::k210);
  Deliver(directory, "uagv/v2/KIT/0001/connection", Connection("2.1.0", "CONNECTIONBROKEN"),
          Origin::kRetained);
  EXPECT_TRUE(entry->IsAlive()) << "the will of an older connection";
  EXPECT_FALSE(entry->IsOnline());
  Deliver(directory, "uagv/v2/KIT/0001/connection", Connection("2.1.0", "OFFLINE", 30),
          Origin::kLive);
  EXPECT_FALSE(entry->IsAlive()) << "it has just left";
}

TEST_F(RobotDirectoryTest, TakesNobodyForAliveByWhatIsRetained) {
  RobotDirectory directory = Open();
  const auto* entry = Deliver(directory, "uagv/v2/KIT/0001/state",
                              Message("2.1.0", R"("paused":true)"), Origin::kRetained);
  ASSERT_NE(entry, nullptr) << "there is, or was, such a robot";
  EXPECT_TRUE(entry->WasHeard());
  EXPECT_FALSE(entry->IsAlive());
  EXPECT_EQ(entry->Spoken()->version, Version::k210);
}

TEST_F(RobotDirectoryTest, LetsAHibernatingRobotHibernate) {
  RobotDirectory directory = Open();
  Deliver(directory, "vda5050/v3/KIT/0001/connection", Connection("3.0.0", "HIBERNATING"),
          Origin::kRetained);
  const auto* entry = Deliver(directory, "vda5050/v3/KIT/0001/state",
                              Message("3.0.0", R"("paused":true)", 9), Origin::kLive);
  EXPECT_FALSE(entry->IsAlive());
}

TEST_F(RobotDirectoryTest, SaysWhyAFactsheetCannotBeRead) {
  RobotDirectory directory = Open();
  Deliver(directory, "uagv/v2/KIT/0001/connection", Connection("2.1.0", "ONLINE"),
          Origin::kRetained);
  const auto* entry =
      Deliver(directory, "uagv/v2/KIT/0001/factsheet", R"({"protocolLimits":)", Origin::kRetained);
  ASSERT_NE(entry, nullptr);
  EXPECT_EQ(entry->Spoken()->version, Version::k210);
  EXPECT_NE(entry->Known().factsheet_fault, "");
}

TEST_F(RobotDirectoryTest, KnowsANamedRobotWhoseTopicsTellNoManufacturer) {
  Dialect dialect;
  dialect.topics.topic_template = "amr/{major}/{serial}/{topic}";
  RobotDirectory directory({}, {});
  directory.Add({"seer", "A-1"}, std::make_shared<const Dialect>(dialect), true);
  const std::string online = R"({"version":"2.1.0","manufacturer":"seer","serialNumber":"A-1",)"
                             R"("connectionState":"ONLINE"})";
  const auto* entry = Deliver(directory, "amr/v2/A-1/connection", online, Origin::kRetained);
  ASSERT_NE(entry, nullptr);
  EXPECT_TRUE(entry->IsOnline());
  EXPECT_EQ(entry->Spoken()->version, Version::k210);
  EXPECT_EQ(Deliver(directory, "amr/v2/A-2/connection", online, Origin::kRetained), nullptr);
}

TEST_F(RobotDirectoryTest, TakesNothingFromATopicThatIsOnlyForCommands) {
  Dialect dialect;
  dialect.topics.topic_template = "fts/{manufacturer}/{serial}/instantAction";
  RobotDirectory directory({}, {});
  directory.Add({"ff", "a7"}, std::make_shared<const Dialect>(dialect), true);
  EXPECT_EQ(Deliver(directory, "fts/ff/a7/instantAction", R"({"version":"2.1.0"})", Origin::kLive),
            nullptr);
}

// ── states that are kept ──

std::string State(std::string_view version, std::string_view members, int second = 0) {
  return Message(version, members, second);
}

class RobotDirectoryWithStates : public ::testing::Test {
 protected:
  RobotDirectoryWithStates() {
    directory_.AddScheme(base_->topics);
    directory_.KeepStates();
  }
  const RobotEntry* Live(std::string_view topic, std::string_view payload) {
    return Deliver(directory_, topic, payload, Origin::kLive);
  }
  const RobotEntry* Retained(std::string_view topic, std::string_view payload) {
    return Deliver(directory_, topic, payload, Origin::kRetained);
  }
  [[nodiscard]] std::vector<std::string> Seen() const {
    std::vector<std::string> names;
    for (const auto& [robot, entry] : directory_.robots()) {
      if (entry.WasSeen()) names.push_back(robot.ToString());
    }
    return names;
  }
  [[nodiscard]] const RobotEntry& First() const { return directory_.robots().begin()->second; }

  std::shared_ptr<const Dialect> base_ = std::make_shared<const Dialect>();
  RobotDirectory directory_{{}, [this](const auto&) { return std::pair(base_, true); }};
};

TEST_F(RobotDirectoryWithStates, KnowsARobotByItsConnection) {
  const RobotEntry* robot =
      Retained("uagv/v2/KIT/1/connection", Connection("2.0.0", "CONNECTIONBROKEN"));
  ASSERT_THAT(robot, NotNull());
  EXPECT_EQ(robot->own->version, Version::k200);
  EXPECT_EQ(robot->InterfaceName(), "uagv");
  EXPECT_EQ(robot->TopicLevel(), "v2");
  EXPECT_EQ(robot->connection->connection_state, "CONNECTION_BROKEN");
  EXPECT_EQ(robot->last_said, base::ParseDateTime("2026-01-02T03:04:00.000Z"));
  EXPECT_FALSE(robot->IsOnline());
  EXPECT_THAT(robot->state, IsNull());
}

TEST_F(RobotDirectoryWithStates, KnowsARobotThatOnlySendsStates) {
  const RobotEntry* robot = Live("vda5050/v3/KIT/1/state", State("3.0.0", R"("paused":true)"));
  ASSERT_THAT(robot, NotNull());
  EXPECT_EQ(robot->own->version, Version::k300);
  EXPECT_FALSE(robot->connection);
  EXPECT_EQ(robot->state->paused, true);
}

TEST_F(RobotDirectoryWithStates, JoinsWhatBelongsToOneRobotAndOrdersByAddress) {
  Retained("vda5050/v3/KIT/2/connection", Connection("3.0.0", "ONLINE"));
  Retained("vda5050/v3/KIT/1/connection", Connection("3.0.0", "ONLINE"));
  Retained("uagv/v2/ACME/9/connection", Connection("2.1.0", "OFFLINE"));
  const RobotEntry* robot = Live("vda5050/v3/KIT/1/state", State("3.0.0", R"("driving":false)"));
  EXPECT_THAT(Seen(), ElementsAre("ACME/9", "KIT/1", "KIT/2"));
  EXPECT_TRUE(robot->IsOnline());
  EXPECT_EQ(robot->state->driving, false);
}

TEST_F(RobotDirectoryWithStates, PrefersTheConnectionThatIsOnline) {
  Retained("uagv/v2/KIT/1/connection", Connection("2.1.0", "OFFLINE", 9));
  const RobotEntry* robot =
      Retained("vda5050/v3/KIT/1/connection", Connection("3.0.0", "ONLINE", 1));
  EXPECT_EQ(robot->own->version, Version::k300);
  Live("vda5050/v3/KIT/1/connection", Connection("3.0.0", "OFFLINE", 10));
  EXPECT_EQ(robot->connection->connection_state, "OFFLINE");
}

TEST_F(RobotDirectoryWithStates, TakesWhatABrokerRepeatsAfterALostConnection) {
  const RobotEntry* robot =
      Retained("vda5050/v3/KIT/1/connection", Connection("3.0.0", "ONLINE", 1));
  Retained("vda5050/v3/KIT/1/connection", Connection("3.0.0", "OFFLINE", 9));
  EXPECT_EQ(robot->connection->connection_state, "OFFLINE");
}

TEST_F(RobotDirectoryWithStates, ForgetsAConnectionThatIsDeleted) {
  Retained("vda5050/v3/KIT/1/connection", Connection("3.0.0", "ONLINE"));
  const RobotEntry* robot = Live("vda5050/v3/KIT/1/connection", "");
  ASSERT_THAT(robot, NotNull());
  EXPECT_FALSE(robot->connection);
  EXPECT_THAT(Live("vda5050/v3/KIT/1/connection", ""), IsNull());
}

TEST_F(RobotDirectoryWithStates, ShowsNobodyByARetainedState) {
  const RobotEntry* robot = Retained("uagv/v2/KIT/1/state", State("2.1.0", R"("paused":true)", 5));
  ASSERT_THAT(robot, NotNull()) << "there is a robot";
  EXPECT_THAT(Seen(), ElementsAre("KIT/1"));
  EXPECT_EQ(robot->own->version, Version::k210);
  EXPECT_THAT(robot->state, IsNull()) << "how it is, nobody knows";
  EXPECT_FALSE(robot->HasSpoken());
  Live("uagv/v2/KIT/1/state", State("2.1.0", R"("paused":false)", 1));
  Retained("uagv/v2/KIT/1/state", State("2.1.0", R"("paused":true)", 9));
  EXPECT_EQ(robot->state->paused, false);
}

TEST_F(RobotDirectoryWithStates, TakesNoOlderStateThatArrivesLate) {
  const auto paused = [&] { return First().state->paused; };
  Live("uagv/v2/KIT/1/state", State("2.1.0", R"("paused":true)", 5));
  EXPECT_THAT(Live("uagv/v2/KIT/1/state", State("2.1.0", R"("paused":false)", 4)), IsNull());
  EXPECT_EQ(paused(), true);
  Live("uagv/v2/KIT/1/connection", Connection("2.1.0", "ONLINE", 3));
  Live("uagv/v2/KIT/1/state", State("2.1.0", R"("paused":false)", 3));
  EXPECT_EQ(paused(), false) << "it has begun anew";
}

TEST_F(RobotDirectoryWithStates, ShowsARobotWhereItSpeaksAndNamesTheOtherPlace) {
  Retained("uagv/v2/KIT/1/connection", Connection("2.1.0", "ONLINE", 50));
  const RobotEntry* robot =
      Retained("vda5050/v3/KIT/1/connection", Connection("3.0.0", "ONLINE", 1));
  EXPECT_EQ(robot->AlsoAt(), "vda5050/v3");
  Live("vda5050/v3/KIT/1/state", State("3.0.0", R"("operatingMode":"AUTOMATIC")", 2));
  EXPECT_EQ(robot->own->version, Version::k300);
  EXPECT_EQ(robot->AlsoAt(), "uagv/v2");
  EXPECT_EQ(robot->connection->header.timestamp, "2026-01-02T03:04:01.000Z");
  Live("uagv/v2/KIT/1/state", State("2.1.0", R"("operatingMode":"MANUAL")", 51));
  EXPECT_EQ(robot->state->operating_mode, "AUTOMATIC") << "nothing is mixed";
  Live("vda5050/v3/KIT/1/connection", Connection("3.0.0", "OFFLINE", 3));
  EXPECT_EQ(robot->own->version, Version::k210);
  EXPECT_EQ(robot->state->operating_mode, "MANUAL") << "what was said at this place";
}

TEST_F(RobotDirectoryWithStates, TellsThatAConnectionCannotBeRead) {
  const RobotEntry* robot =
      Retained("uagv/v2/KIT/1/connection", R"([{"connectionState":"ONLINE"}])");
  ASSERT_THAT(robot, NotNull());
  EXPECT_NE(robot->connection->fault, "");
  EXPECT_FALSE(robot->IsOnline());
  EXPECT_TRUE(HasProblem(*robot));
  Live("uagv/v2/KIT/1/connection", Connection("2.1.0", "ONLINE"));
  EXPECT_EQ(robot->connection->fault, "");
}

TEST_F(RobotDirectoryWithStates, SeesNobodyInWhatTellsNothing) {
  EXPECT_THAT(Live("vda5050/v3/KIT/1/connection", ""), IsNull());
  for (const char* payload : {"", "{", "[]", "\xFF"}) {
    Live("vda5050/v3/KIT/1/state", payload);
    EXPECT_THAT(Seen(), IsEmpty()) << payload;
  }
  EXPECT_THAT(Live("vda5050/v3/KIT/1/order", State("3.0.0", R"("a":1)")), IsNull());
  EXPECT_THAT(Live("a/b/c", Connection("3.0.0", "ONLINE")), IsNull());
  EXPECT_EQ(directory_.CountSeen(), 0U);
}

TEST_F(RobotDirectoryWithStates, TellsThatAStateCannotBeRead) {
  Live("vda5050/v3/KIT/1/connection", Connection("3.0.0", "ONLINE"));
  const RobotEntry* robot = Live("vda5050/v3/KIT/1/state",
                                 R"({"x":)" + std::string(65, '[') + std::string(65, ']') + "}");
  ASSERT_THAT(robot, NotNull());
  EXPECT_THAT(robot->state_fault, ::testing::HasSubstr("64 levels"));
  EXPECT_TRUE(robot->HasSpoken());
  Live("vda5050/v3/KIT/1/state", State("3.0.0", R"("paused":true)"));
  EXPECT_EQ(robot->state_fault, "");
}

TEST_F(RobotDirectoryWithStates, ShowsARobotOfAnUnknownVersion) {
  const RobotEntry* robot = Live("x/v9/KIT/1/connection", Connection("9.1.0", "ONLINE"));
  ASSERT_THAT(robot, NotNull());
  EXPECT_EQ(robot->own, nullptr);
  EXPECT_EQ(robot->said_version, "9.1.0");
}

TEST_F(RobotDirectoryWithStates, WeighsTrouble) {
  const auto weigh = [&](std::string_view members) {
    const RobotEntry* robot = Live("vda5050/v3/KIT/1/state", State("3.0.0", members));
    return robot == nullptr ? -1 : WeighTrouble(*robot);
  };
  const std::string_view rising[] = {
      R"("paused":false,"operatingMode":"AUTOMATIC","safetyState":{"fieldViolation":false})",
      R"("paused":true)",
      R"("errors":[{"errorLevel":"WARNING"}])",
      R"("errors":[{"errorLevel":"odd"}])",
      R"("errors":[{"errorLevel":"WARNING"},{"errorLevel":"URGENT"}])",
      R"("errors":[{"errorLevel":"critical"}])",
      R"("safetyState":{"eStop":"NONE","fieldViolation":true})",
      R"("errors":[{"errorLevel":"FATAL"}])",
      R"("safetyState":{"activeEmergencyStop":"MANUAL"})"};
  int last = -1;
  for (const std::string_view members : rising) {
    const int weight = weigh(members);
    EXPECT_GT(weight, last) << members;
    last = weight;
    EXPECT_EQ(HasProblem(First()), weight >= 3);
  }
  EXPECT_EQ(weigh(R"("safetyState":{"eStop":"autoAck"})"), last) << "as 1.1 writes it";
  Retained("uagv/v2/ACME/1/connection", Connection("2.1.0", "CONNECTIONBROKEN"));
  EXPECT_TRUE(HasProblem(First()));
  Live("uagv/v2/ACME/1/state", State("2.1.0", R"("paused":false)"));
  EXPECT_FALSE(HasProblem(First())) << "it speaks";
  Live("uagv/v2/ACME/1/connection", Connection("2.1.0", "OFFLINE"));
  EXPECT_FALSE(HasProblem(First())) << "it was switched off";
}

}  // namespace
}  // namespace fleetpub::vda5050
