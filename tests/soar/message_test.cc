#include "soar/message.h"

#include <gmock/gmock.h>

#include "base/json.h"
#include "delivery/validate.h"

namespace fleetpub::soar {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::MatchesRegex;

const base::WallTime kNow = *base::ParseDateTime("2026-01-02T03:04:05.678Z");

Destination Eco1(MessageType type = MessageType::kAcknowledgement) {
  return *ParseDestination("soar.planet-ocean.ecosub.eco1", {}, type);
}

std::string Acknowledged() {
  const std::vector<Member> members = {{"acknowledged_message_ID", R"("id-1")"},
                                       {"status", R"("executed")"}};
  return BuildPayload(MessageType::kAcknowledgement, members);
}

TEST(SoarMessage, HasAllSevenHeaderFields) {
  Sender sender;
  sender.source = "autonomy_engine";
  const auto command = BuildMessage(MessageType::kAcknowledgement, Eco1(), sender, Acknowledged());
  EXPECT_THAT(
      command.payload.Render(7, kNow),
      MatchesRegex(
          R"(\{"header":\{"message_ID":"[0-9a-f-]{36}","timestamp":"2026-01-02T03:04:05.678Z",)"
          R"("version":1.0,"source":"autonomy_engine",)"
          R"("destination":"soar.planet-ocean.ecosub.eco1.from_platform.acknowledgement",)"
          R"("delivery_type":"publish","encoded":false\},)"
          R"("payload":\{"message_type":"acknowledgement","acknowledged_message_ID":"id-1",)"
          R"("status":"executed"\}\})"));
}

TEST(SoarMessage, IsACommandThatCountsNoHeaderIds) {
  const auto command = BuildMessage(MessageType::kAcknowledgement, Eco1(), {}, Acknowledged());
  EXPECT_FALSE(command.payload.counted);
  EXPECT_EQ(command.protocol, "soar");
  EXPECT_EQ(command.version, "1.0");
  EXPECT_EQ(command.target, "soar.planet-ocean.ecosub.eco1");
  EXPECT_EQ(command.topic, "soar/planet-ocean/ecosub/eco1/from_platform/acknowledgement");
  ASSERT_EQ(command.actions.size(), 1U);
  EXPECT_EQ(command.actions[0].type, "acknowledgement");
  const auto message = base::ParseJson(command.payload.Render(0, kNow));
  EXPECT_EQ((*message)["header"]["message_ID"], command.actions[0].id);
  const auto another = BuildMessage(MessageType::kAcknowledgement, Eco1(), {}, Acknowledged());
  EXPECT_NE(another.actions[0].id, command.actions[0].id);
  schema::Registry registry;
  EXPECT_THAT(delivery::Validate(command, registry)->errors, IsEmpty());
}

TEST(SoarMessage, SaysThatItIsABroadcast) {
  const auto command =
      BuildMessage(MessageType::kAcknowledgement, Broadcast({}), {}, Acknowledged());
  EXPECT_EQ(command.topic, "soar/broadcast");
  EXPECT_THAT(command.payload.Render(0, kNow),
              HasSubstr(R"("destination":"broadcast","delivery_type":"broadcast")"));
}

TEST(SoarMessage, EscapesWhatTheSourceMayContain) {
  Sender sender;
  sender.source = R"(a"b)";
  sender.header_version = "2.0";
  const auto command = BuildMessage(MessageType::kAcknowledgement, Eco1(), sender, Acknowledged());
  const auto message = base::ParseJson(command.payload.Render(0, kNow));
  ASSERT_TRUE(message);
  EXPECT_STREQ((*message)["header"]["source"].GetString(), R"(a"b)");
  EXPECT_EQ((*message)["header"]["version"].GetDouble(), 2.0);
}

TEST(SoarPayload, PutsMembersOfOneParentIntoOneObject) {
  const std::vector<Member> members = {{"platform_ID", "1"},
                                       {"sensor_on", "true", "sensor_config"},
                                       {"additional_data", "[]", "sensor_config"},
                                       {"depth", "2"}};
  EXPECT_EQ(BuildPayload(MessageType::kPlatformStatus, members),
            R"({"message_type":"platform_status","platform_ID":1,"sensor_config":)"
            R"({"sensor_on":true,"additional_data":[]},"depth":2})");
  EXPECT_EQ(BuildPayload(MessageType::kPlatformStatus, std::span(members).subspan(1, 1)),
            R"({"message_type":"platform_status","sensor_config":{"sensor_on":true}})");
  EXPECT_EQ(BuildPayload(MessageType::kObservation, {}), R"({"message_type":"observation"})");
}

TEST(PlanningConfiguration, KeepsWhatTheFileSays) {
  constexpr auto kFile = R"({"squads":[],"planning_config_ID":3,"exclusion_zones":[],"more":1.50})";
  EXPECT_EQ(ParsePlanningConfiguration(kFile, "").value(),
            R"({"message_type":"planning_configuration","squads":[],"planning_config_ID":3,)"
            R"("exclusion_zones":[],"more":1.5})");
  EXPECT_EQ(ParsePlanningConfiguration(kFile, "4").value(),
            R"({"message_type":"planning_configuration","planning_config_ID":4,"squads":[],)"
            R"("exclusion_zones":[],"more":1.5})");
  EXPECT_EQ(ParsePlanningConfiguration(R"({"message_type":"planning_configuration"})", "").value(),
            R"({"message_type":"planning_configuration"})");
}

TEST(PlanningConfiguration, RefusesWhatIsNone) {
  for (const char* text : {"", "[]", "7", "{", R"({"message_type":"mission_plan"})",
                           R"({"message_type":7})", R"({"a":1,"a":2})"}) {
    const auto payload = ParsePlanningConfiguration(text, "");
    ASSERT_FALSE(payload) << text;
    EXPECT_EQ(payload.error().kind, ErrorKind::kInvalid);
  }
  EXPECT_FALSE(ParsePlanningConfiguration(std::string(100'000, '['), ""));
}

}  // namespace
}  // namespace fleetpub::soar
