#include "vda5050/messages/instant_actions.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>

#include "base/file.h"
#include "delivery/validate.h"

namespace fleetpub::vda5050 {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr base::WallTime kNow{1767323045678ms};  // 2026-01-02T03:04:05.678Z
constexpr std::uint32_t kHeaderId = 7;
const RobotAddress kRobot{"KIT", "0001"};

InstantAction Pause() { return {.type = "startPause", .id = "a1"}; }

InstantAction Position() {
  return {.type = "initPosition",
          .id = "3f2c8a2e-7b51-4c4e-9d0a-5a4f0f6d1c22",
          .descriptor = "after the \"restart\"",
          .parameters = {{"x", "1.5"},
                         {"y", "-2"},
                         {"theta", "0.5"},
                         {"mapId", "\"hall-1\""},
                         {"lastNodeId", "\"n1\""}}};
}

message::Command Build(const Dialect& dialect, const std::vector<InstantAction>& actions,
                       const RobotAddress& robot = kRobot) {
  auto command = BuildInstantActions(robot, dialect, actions);
  if (!command) throw std::runtime_error(command.error().message);
  return std::move(*command);
}

std::string BuildPayload(const Dialect& dialect, const std::vector<InstantAction>& actions,
                         const RobotAddress& robot = kRobot) {
  return Build(dialect, actions, robot).payload.Render(kHeaderId, kNow);
}

// `error /path: sentence` and `warning …`, one per finding.
std::vector<std::string> ListFindings(const message::Command& command) {
  schema::Registry registry;
  const auto findings = delivery::Validate(command, registry);
  if (!findings) return {"refused: " + findings.error().message};
  std::vector<std::string> lines;
  for (const auto& [path, message] : findings->errors)
    lines.push_back("error " + path + ": " + message);
  for (const auto& [path, message] : findings->warnings)
    lines.push_back("warning " + path + ": " + message);
  return lines;
}

class InstantActions : public ::testing::TestWithParam<Version> {
 protected:
  // The message as it stands in tests/data/vda5050/golden/<version>/<name>.json.
  static std::string Golden(std::string_view name) {
    auto text =
        base::ReadFile(fmt::format(FLEETPUB_SOURCE_DIR "/tests/data/vda5050/golden/{}/{}.json",
                                   GetFacts(GetParam()).name, name));
    if (!text) throw std::runtime_error(text.error().message);
    while (text->ends_with('\n')) text->pop_back();
    return *text;
  }
  static Dialect In() { return {.version = GetParam()}; }
};

TEST_P(InstantActions, LooksAsTheGoldenMessage) {
  EXPECT_EQ(BuildPayload(In(), {Pause()}), Golden("startPause"));
}

TEST_P(InstantActions, WithParametersLooksAsTheGoldenMessage) {
  EXPECT_EQ(BuildPayload(In(), {Position()}), Golden("initPosition"));
}

TEST_P(InstantActions, WithSeveralActionsLooksAsTheGoldenMessage) {
  const InstantAction beep{.type = "beep", .id = "a2", .parameters = {{"tones", "[{\"hz\":440}]"}}};
  EXPECT_EQ(BuildPayload(In(), {Pause(), beep}), Golden("several"));
}

TEST_P(InstantActions, SatisfiesSchemaAndText) {
  EXPECT_THAT(ListFindings(Build(In(), {Pause()})), IsEmpty());
  EXPECT_THAT(ListFindings(Build(In(), {Position()})), IsEmpty());
}

TEST_P(InstantActions, KnowsTopicSchemaAndVersion) {
  const auto command = Build(In(), {Pause()});
  EXPECT_EQ(command.target, "KIT/0001");
  EXPECT_EQ(command.protocol, "vda5050");
  EXPECT_EQ(command.version, GetFacts(GetParam()).name);
  EXPECT_EQ(command.topic, *TopicFor({}, GetParam(), kRobot, "instantActions"));
  EXPECT_EQ(command.schema, fmt::format("vda5050/{}/instantActions", GetFacts(GetParam()).name));
  EXPECT_THAT(command.actions, ElementsAre(message::ActionRef{"startPause", "a1"}));
  EXPECT_TRUE(command.payload.counted);
}

TEST_P(InstantActions, AllowsOtherBlockingTypesOnlyBefore30) {
  for (const std::string type : {"NONE", "SOFT", "HARD"}) {
    InstantAction action = Pause();
    action.blocking_type = type;
    const auto command = Build(In(), {action});
    EXPECT_THAT(command.payload.Render(0, kNow), HasSubstr(R"("blockingType":")" + type + "\""));
    const bool allowed = type == "NONE" || GetParam() != Version::k300;
    EXPECT_EQ(ListFindings(command).empty(), allowed) << type;
  }
}

TEST_P(InstantActions, RefusesAnUnknownBlockingType) {
  InstantAction action = Pause();
  action.blocking_type = "LOUD";
  EXPECT_THAT(ListFindings(Build(In(), {action})),
              ElementsAre(HasSubstr(
                  fmt::format("/{}/0/blockingType: ", GetFacts(GetParam()).actions_key))));
}

TEST_P(InstantActions, RefusesAnEmptyList) {
  EXPECT_THAT(ListFindings(Build(In(), {})),
              ElementsAre(HasSubstr("there must be at least one action")));
}

TEST_P(InstantActions, RefusesAValueThatIsNull) {
  InstantAction action = Pause();
  action.parameters = {{"a", "null"}};
  EXPECT_THAT(ListFindings(Build(In(), {action})),
              ElementsAre(HasSubstr("/actionParameters/0/value: ")));
}

INSTANTIATE_TEST_SUITE_P(Every, InstantActions, ::testing::ValuesIn(kVersions),
                         [](const auto& version) {
                           std::string name(GetFacts(version.param).name);
                           std::replace(name.begin(), name.end(), '.', '_');
                           return "Version" + name;
                         });

TEST(BuildInstantActions, NamesTheActionAsTheVersionDoesAndSaysSo) {
  const auto newer = Build({.version = Version::k300}, {Position()});
  EXPECT_THAT(newer.warnings, ElementsAre("initPosition is called initializePosition in version "
                                          "3.0.0: sent as initializePosition"));
  EXPECT_EQ(newer.actions.front().type, "initializePosition");
  InstantAction action = Position();
  action.type = "initializePosition";
  const auto older = Build({.version = Version::k210}, {action});
  EXPECT_THAT(older.warnings, ElementsAre("initializePosition is called initPosition in version "
                                          "2.1.0: sent as initPosition"));
  EXPECT_EQ(older.actions.front().type, "initPosition");
}

TEST(BuildInstantActions, WarnsOfNothingElse) {
  EXPECT_THAT(Build({.version = Version::k210}, {Position()}).warnings, IsEmpty());
  EXPECT_THAT(Build({}, {Pause()}).warnings, IsEmpty());
}

TEST(BuildInstantActions, LeavesNoHoleButHeaderIdAndTimestamp) {
  const auto command = Build({}, {Pause()});
  EXPECT_EQ(command.payload.before_id, R"({"headerId":)");
  EXPECT_EQ(command.payload.before_time, R"(,"timestamp":")");
  EXPECT_EQ(command.payload.Render(4294967295U, kNow).substr(0, 60),
            R"({"headerId":4294967295,"timestamp":"2026-01-02T03:04:05.678Z)");
}

TEST(BuildInstantActions, CarriesTheHeaderIdAskedFor) {
  const std::vector actions{Pause()};
  EXPECT_EQ(BuildInstantActions(kRobot, {}, actions, 42)->header_id, 42U);
  EXPECT_EQ(BuildInstantActions(kRobot, {}, actions)->header_id, std::nullopt);
}

TEST(BuildInstantActions, RemembersThatTheVersionIsAssumed) {
  EXPECT_TRUE(Build({.assumed = true}, {Pause()}).version_assumed);
  EXPECT_FALSE(Build({}, {Pause()}).version_assumed);
}

TEST(BuildInstantActions, TakesAHeaderThatDiffersFromTheTopic) {
  const auto command = Build({.version = Version::k210,
                              .header_version = "v2",
                              .header_manufacturer = "Kit \"Lab\"",
                              .header_serial = "AGV 1"},
                             {Pause()});
  EXPECT_EQ(command.topic, "uagv/v2/KIT/0001/instantActions");
  EXPECT_EQ(command.target, "KIT/0001");
  EXPECT_THAT(command.payload.Render(0, kNow),
              HasSubstr(R"("version":"v2","manufacturer":"Kit \"Lab\"","serialNumber":"AGV 1")"));
  EXPECT_THAT(ListFindings(command), IsEmpty());
}

TEST(BuildInstantActions, TakesAnotherInterfaceAndTemplate) {
  EXPECT_EQ(Build({.topics = {.interface_name = "fts"}}, {Pause()}).topic,
            "fts/v3/KIT/0001/instantActions");
  EXPECT_EQ(
      Build({.topics = {.topic_template = "x/{manufacturer}/{serial}/{topic}"}}, {Pause()}).topic,
      "x/KIT/0001/instantActions");
}

TEST(BuildInstantActions, RefusesATopicThatCannotBe) {
  const std::vector actions{Pause()};
  const auto command = BuildInstantActions(kRobot, {.topics = {.interface_name = "#"}}, actions);
  ASSERT_FALSE(command);
  EXPECT_EQ(command.error().kind, ErrorKind::kUsage);
}

TEST(BuildInstantActions, SendsTheArrayUnderTheNameThatTheRobotExpects) {
  const auto quirky = Build({.version = Version::k200, .actions_key = "instantActions"}, {Pause()});
  EXPECT_THAT(quirky.payload.Render(0, kNow), HasSubstr(R"("instantActions":[)"));
  EXPECT_THAT(quirky.payload.Render(0, kNow), Not(HasSubstr(R"("actions")")));
  EXPECT_THAT(ListFindings(quirky), IsEmpty());

  const auto old = Build({.version = Version::k110, .actions_key = "actions"}, {Pause()});
  EXPECT_THAT(old.payload.Render(0, kNow), HasSubstr(R"("actions":[)"));
  EXPECT_THAT(ListFindings(old), IsEmpty());
}

TEST(BuildInstantActions, ValidatesAQuirkyMessageAsStrictly) {
  const auto command = Build({.version = Version::k200, .actions_key = "instantActions"},
                             {{.type = "logReport", .id = "a1"}});
  EXPECT_THAT(ListFindings(command),
              ElementsAre("error /actions/0: logReport needs the parameter reason"));
}

TEST(BuildInstantActions, TakesTheVersionsOwnKeyForNoQuirk) {
  EXPECT_EQ(
      Build({.version = Version::k200, .actions_key = "actions"}, {Pause()}).renamed_member.first,
      "");
}

TEST(BuildInstantActions, WarnsOfASerialNumberWithOtherCharacters) {
  EXPECT_THAT(Build({}, {Pause()}, {"KIT", "AGV 1"}).warnings,
              ElementsAre("serial number 'AGV 1' has characters other than A-Z a-z 0-9 _ . : -"));
  EXPECT_THAT(Build({}, {Pause()}, {"Bär & Co", "1"}).warnings, IsEmpty())
      << "the manufacturer may have them";
}

}  // namespace
}  // namespace fleetpub::vda5050
