#include "simulator/platform.h"

#include <gmock/gmock.h>

#include "base/json.h"
#include "soar/acknowledgement_tracker.h"
#include "soar/message.h"

namespace fleetpub::simulator {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAre;

constexpr const char* kEco1 = "soar.planet-ocean.ecosub.eco1";

// Platforms, someone who tells them what to do, and a clock that only moves when told.
class Platforms : public ::testing::Test {
 protected:
  void Make(PlatformSettings settings, const std::vector<std::string>& destinations = {kEco1}) {
    auto fleet = PlatformFleet::Make(
        std::move(settings), destinations, registry_,
        [this](std::string_view, const Event& event) { remarks_.push_back(event.text); });
    ASSERT_TRUE(fleet) << fleet.error().message;
    fleet_ = *std::move(fleet);
    fleet_->Start(now_, said_);
  }

  // Sends a plan of one waypoint; its message_ID.
  std::string SendPlan(const soar::Destination& destination) {
    const auto command = soar::BuildMessage(
        soar::MessageType::kMissionPlan, destination, {},
        R"({"message_type":"mission_plan","autonomy_engine_plan_ID":3,"platform_ID":9,)"
        R"("plan":[{"latitude_waypoint":1.5,"longitude_waypoint":2.5}]})");
    Hear({command.topic, command.payload.Render(0, now_.wall)});
    return command.actions[0].id;
  }
  static soar::Destination To(std::string_view text) {
    return *soar::ParseDestination(text, {}, soar::MessageType::kMissionPlan);
  }
  void Hear(const mqtt::Message& message) { fleet_->Receive(message, now_, said_); }
  void Wait(milliseconds time) {
    now_.steady += time;
    now_.wall += time;
    if (fleet_->Due() <= now_.steady) fleet_->Tick(now_, said_);
  }

  // `topic level` of all acknowledgements of this message.
  std::vector<std::string> Levels(const std::string& id) {
    std::vector<std::string> levels;
    for (const auto& message : said_) {
      const auto document = base::ParseJson(message.payload);
      const auto said =
          document ? soar::ReadAcknowledgement(message.topic, *document, {}) : std::nullopt;
      if (said && said->message_id == id) {
        levels.push_back(message.topic + " " + std::string(GetName(said->level)));
      }
    }
    return levels;
  }
  // The payloads of all statuses.
  std::vector<std::string> States() {
    std::vector<std::string> states;
    for (const auto& message : said_) {
      const auto document = base::ParseJson(message.payload);
      const auto& payload = (*document)["payload"];
      if (base::StringMember(payload, "message_type") != "platform_status") continue;
      EXPECT_EQ(message.topic, "soar/planet-ocean/ecosub/eco1/from_platform/platform_status");
      states.emplace_back(base::StringMember(payload, "platform_state"));
    }
    return states;
  }

  schema::Registry registry_;
  std::unique_ptr<PlatformFleet> fleet_;
  Moment now_{std::chrono::steady_clock::now(), base::WallTime::clock::now()};
  std::vector<mqtt::Message> said_;
  std::vector<std::string> remarks_;
};

TEST_F(Platforms, AcknowledgeStepByStep) {
  Make({.delay = seconds(2)});
  const std::string id = SendPlan(To(kEco1));
  const std::string topic = "soar/planet-ocean/ecosub/eco1/from_platform/acknowledgement ";
  EXPECT_THAT(Levels(id), ElementsAre(topic + "c2_received"));
  Wait(milliseconds(1'999));
  EXPECT_THAT(Levels(id), SizeIs(1));
  Wait(milliseconds(1));
  EXPECT_THAT(Levels(id), SizeIs(2));
  Wait(seconds(2));
  EXPECT_THAT(Levels(id), ElementsAre(topic + "c2_received", topic + "operator_approved_and_sent",
                                      topic + "executed"));
  EXPECT_THAT(States(), ElementsAre("IDLE", "EXECUTING", "IDLE"));
  const auto last = base::ParseJson(said_.back().payload);
  EXPECT_EQ((*last)["payload"]["latitude"].GetDouble(), 1.5);
  EXPECT_EQ((*last)["payload"]["platform_ID"].GetInt(), 9);
  EXPECT_EQ((*last)["payload"]["autonomy_engine_plan_ID"].GetInt(), 3);
}

TEST_F(Platforms, SayOnlyWhatIsValid) {
  Make({});
  SendPlan(To(kEco1));
  const auto schema = registry_.Find(soar::kMessageSchema);
  EXPECT_THAT(said_, SizeIs(6));
  for (const auto& message : said_) {
    const auto document = base::ParseJson(message.payload);
    EXPECT_THAT((*schema)->Validate(*document), IsEmpty()) << message.payload;
    EXPECT_THAT(soar::CheckMessage(*document, soar::Strictness::kRefuse), IsEmpty());
    EXPECT_FALSE(message.retained);
  }
}

TEST_F(Platforms, GoNoFurtherThanTold) {
  Make({.stop_at = soar::Level::kC2Received});
  const std::string id = SendPlan(To(kEco1));
  Wait(seconds(5));
  EXPECT_THAT(Levels(id), SizeIs(1));
}

TEST_F(Platforms, SayNothingWhenSilent) {
  Make({.silent = true});
  SendPlan(To(kEco1));
  Wait(seconds(100));
  EXPECT_THAT(said_, IsEmpty());
  EXPECT_THAT(remarks_, ElementsAre(HasSubstr("mission_plan ")));
}

TEST_F(Platforms, RepeatTheirStatus) {
  Make({.status_interval = seconds(10)});
  EXPECT_THAT(States(), SizeIs(1));
  Wait(seconds(10));
  Wait(seconds(10));
  EXPECT_THAT(States(), SizeIs(3));
}

TEST_F(Platforms, AllHearABroadcast) {
  Make({}, {kEco1, "autonomy_engine"});
  const std::string id = SendPlan(soar::Broadcast({}));
  EXPECT_THAT(Levels(id), SizeIs(6));
  EXPECT_THAT(Levels(id), ::testing::Contains("soar/fleetpub executed"))
      << "a short name answers to the source";
}

TEST_F(Platforms, ObeyAMessageOnce) {
  Make({});
  const auto command = soar::BuildMessage(
      soar::MessageType::kMissionPlan, To(kEco1), {},
      R"({"message_type":"mission_plan","autonomy_engine_plan_ID":3,"platform_ID":9,"plan":[]})");
  for (int i = 0; i < 2; ++i) Hear({command.topic, command.payload.Render(0, now_.wall)});
  EXPECT_THAT(Levels(command.actions[0].id), SizeIs(3));
}

TEST_F(Platforms, TellWhatBreaksTheFormat) {
  Make({});
  said_.clear();
  const std::string topic = "soar/planet-ocean/ecosub/eco1/to_platform/mission_plan";
  Hear({topic, "{"});
  Hear({topic, "{}"});
  Hear({topic, R"({"header":{},"payload":{"message_type":"mission_plan",
                   "autonomy_engine_plan_ID":3,"platform_ID":9,"plan":[]}})"});
  Hear({.topic = topic, .payload = "{}", .retained = true});
  Hear({topic, R"({"header":{},"payload":{"message_type":"observation","platform_ID":1}})"});
  EXPECT_THAT(remarks_, ElementsAre(HasSubstr("not valid JSON"), HasSubstr("required but missing"),
                                    HasSubstr("without a message_ID"), HasSubstr("retained")));
  EXPECT_THAT(said_, IsEmpty());
}

TEST_F(Platforms, ListenToTheirOwnTopicsAndToEverybodys) {
  Make({}, {kEco1, "ah1"});
  EXPECT_THAT(fleet_->Subscriptions(),
              UnorderedElementsAre("soar/broadcast", "soar/ah1",
                                   "soar/planet-ocean/ecosub/eco1/to_platform/+"));
}

TEST_F(Platforms, RefuseOneNameTwice) {
  for (const auto& names : std::vector<std::vector<std::string>>{{"ah1", "ah1"}, {"a..b"}}) {
    const auto fleet = PlatformFleet::Make({}, names, registry_, {});
    ASSERT_FALSE(fleet);
    EXPECT_EQ(fleet.error().kind, ErrorKind::kUsage);
  }
}

}  // namespace
}  // namespace fleetpub::simulator
