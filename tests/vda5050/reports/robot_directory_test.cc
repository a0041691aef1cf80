#include "vda5050/reports/robot_directory.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

namespace fleetpub::vda5050 {
namespace {

std::string Message(std::string_view version, std::string_view members, int second = 0) {
  return fmt::format(R"({{"headerId":1,"timestamp":"2026-01-02T03:04:{:02}.000Z","version":"{}",)"
                     R"("manufacturer":"KIT","serialNumber":"0001",{}}})",
                     second, version, members);
}

std::string Connection(std::string_view version, std::string_view state, int second = 0) {
  return Message(version, fmt::format(R"("connectionState":"{}")", state), second);
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
  const auto* old = directory.Deliver("uagv/v2/KIT/0001/connection", Connection("2.1.0", "ONLINE"),
                                      Origin::kRetained);
  ASSERT_NE(old, nullptr);
  EXPECT_TRUE(old->IsOnline());
  EXPECT_EQ(old->Spoken()->version, Version::k210);
  EXPECT_EQ(directory.Deliver("uagv/v2/ABC/0001/connection", Connection("2.1.0", "ONLINE"),
                              Origin::kRetained),
            nullptr);
  const auto* broken =
      directory.Deliver("uagv/v2/KIT/0002/connection", "no JSON", Origin::kRetained);
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
    directory.Deliver(topic + "factsheet", header + R"("protocolLimits":{}})", Origin::kRetained);
    entries[i] = directory.Deliver(topic + "connection", header + R"("connectionState":"ONLINE"})",
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
    return directory.Deliver(topic, payload, Origin::kRetained);
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
  const auto* entry = directory.Deliver("uagv/v2/KIT/0001/connection",
                                        Connection("2.1.0", "ONLINE"), Origin::kRetained);
  ASSERT_EQ(entry->unmet.size(), 2U);
  EXPECT_FALSE(entry->unmet[0].has_value()) << "no state was heard";
  EXPECT_EQ(entry->unmet[1], "");
  directory.Deliver("uagv/v2/KIT/0001/state", Message("2.1.0", R"("paused":false)"), Origin::kLive);
  EXPECT_EQ(entry->unmet[0], "paused is false");
  directory.Deliver("uagv/v2/KIT/0001/state", Message("2.1.0", R"("paused":true)"), Origin::kLive);
  EXPECT_EQ(entry->unmet[0], "");
  directory.Deliver("uagv/v2/KIT/0001/state", Message("2.1.0", R"("paused":false)"),
                    Origin::kRetained);
  EXPECT_EQ(entry->unmet[0], "") << "what was retained is the past";
}

TEST_F(RobotDirectoryTest, DecidesNothingByARetainedState) {
  RobotDirectory directory = Open();
  const auto* entry = directory.Deliver("uagv/v2/KIT/0001/connection",
                                        Connection("2.1.0", "ONLINE"), Origin::kRetained);
  directory.Deliver("uagv/v2/KIT/0001/state",
                    Message("2.1.0", R"("paused":true,"operatingMode":"MANUAL")"),
                    Origin::kRetained);
  EXPECT_FALSE(entry->state_heard);
  EXPECT_FALSE(entry->unmet[0].has_value());
  EXPECT_EQ(entry->Known().operating_mode, "");
  directory.Deliver("uagv/v2/KIT/0001/state",
                    Message("2.1.0", R"("paused":true,"operatingMode":"manual")"), Origin::kLive);
  EXPECT_EQ(entry->Known().operating_mode, "MANUAL") << "which the check heeds";
}

TEST_F(RobotDirectoryTest, BelievesThePlaceAtWhichARobotSpeaks) {
  RobotDirectory directory = Open();
  directory.Deliver("vda5050/v3/KIT/0001/factsheet", Message("3.0.0", R"("protocolLimits":{})"),
                    Origin::kRetained);
  const auto* entry = directory.Deliver("uagv/v2/KIT/0001/connection",
                                        Connection("2.1.0", "ONLINE", 30), Origin::kRetained);
  directory.Deliver("vda5050/v3/KIT/0001/connection", Connection("3.0.0", "ONLINE", 1),
                    Origin::kRetained);
  EXPECT_EQ(entry->Spoken()->version, Version::k210) << "the newer, while nothing tells them apart";
  EXPECT_EQ(entry->Known().other_topic, "vda5050/v3/KIT/0001/connection");
  EXPECT_EQ(entry->factsheet, nullptr) << "nothing is mixed";
  directory.Deliver("vda5050/v3/KIT/0001/state", Message("3.0.0", R"("paused":true)", 2),
                    Origin::kLive);
  EXPECT_EQ(entry->Spoken()->version, Version::k300);
  EXPECT_NE(entry->factsheet, nullptr);
  EXPECT_EQ(entry->Known().other_topic, "");
  EXPECT_EQ(entry->unmet[0], "");
  EXPECT_EQ(entry->unmet[1], "version is \"3.0.0\"");
}

TEST_F(RobotDirectoryTest, TakesARobotThatSendsStatesForAlive) {
  RobotDirectory directory = Open();
  const auto* entry = directory.Deliver("uagv/v2/KIT/0001/state",
                                        Message("2.1.0", R"("paused":true)"), Origin::kLive);
  ASSERT_NE(entry, nullptr);
  EXPECT_TRUE(entry->IsAlive()) << "without any connection message";
  EXPECT_EQ(entry->Spoken()->version, Version::k210);
  directory.Deliver("uagv/v2/KIT/0001/connection", Connection("2.1.0", "CONNECTIONBROKEN"),
                    Origin::kRetained);
  EXPECT_TRUE(entry->IsAlive()) << "the will of an older connection";
  EXPECT_FALSE(entry->IsOnline());
  directory.Deliver("uagv/v2/KIT/0001/connection", Connection("2.1.0", "OFFLINE", 30),
                    Origin::kLive);
  EXPECT_FALSE(entry->IsAlive()) << "it has just left";
}

TEST_F(RobotDirectoryTest, TakesNobodyForAliveByWhatIsRetained) {
  RobotDirectory directory = Open();
  const auto* entry = directory.Deliver("uagv/v2/KIT/0001/state",
                                        Message("2.1.0", R"("paused":true)"), Origin::kRetained);
  ASSERT_NE(entry, nullptr) << "there is, or was, such a robot";
  EXPECT_TRUE(entry->WasHeard());
  EXPECT_FALSE(entry->IsAlive());
  EXPECT_EQ(entry->Spoken()->version, Version::k210);
}

TEST_F(RobotDirectoryTest, LetsAHibernatingRobotHibernate) {
  RobotDirectory directory = Open();
  directory.Deliver("vda5050/v3/KIT/0001/connection", Connection("3.0.0", "HIBERNATING"),
                    Origin::kRetained);
  const auto* entry = directory.Deliver("vda5050/v3/KIT/0001/state",
                                        Message("3.0.0", R"("paused":true)", 9), Origin::kLive);
  EXPECT_FALSE(entry->IsAlive());
}

TEST_F(RobotDirectoryTest, SaysWhyAFactsheetCannotBeRead) {
  RobotDirectory directory = Open();
  directory.Deliver("uagv/v2/KIT/0001/connection", Connection("2.1.0", "ONLINE"),
                    Origin::kRetained);
  const auto* entry =
      directory.Deliver("uagv/v2/KIT/0001/factsheet", R"({"protocolLimits":)", Origin::kRetained);
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
  const auto* entry = directory.Deliver("amr/v2/A-1/connection", online, Origin::kRetained);
  ASSERT_NE(entry, nullptr);
  EXPECT_TRUE(entry->IsOnline());
  EXPECT_EQ(entry->Spoken()->version, Version::k210);
  EXPECT_EQ(directory.Deliver("amr/v2/A-2/connection", online, Origin::kRetained), nullptr);
}

TEST_F(RobotDirectoryTest, TakesNothingFromATopicThatIsOnlyForCommands) {
  Dialect dialect;
  dialect.topics.topic_template = "fts/{manufacturer}/{serial}/instantAction";
  RobotDirectory directory({}, {});
  directory.Add({"ff", "a7"}, std::make_shared<const Dialect>(dialect), true);
  EXPECT_EQ(directory.Deliver("fts/ff/a7/instantAction", R"({"version":"2.1.0"})", Origin::kLive),
            nullptr);
}

}  // namespace
}  // namespace fleetpub::vda5050
