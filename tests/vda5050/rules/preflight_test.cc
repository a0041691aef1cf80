#include "vda5050/rules/preflight.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <set>

namespace fleetpub::vda5050 {
namespace {

std::shared_ptr<const Factsheet> Shared(std::string_view payload) {
  return std::make_shared<const Factsheet>(ReadFactsheet(payload).value());
}

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::MatchesRegex;
using ::testing::StartsWith;

const RobotAddress kRobot{"KIT", "0001"};
constexpr std::string_view kUuid = "3f2c8a2e-7b51-4c4e-9d0a-5a4f0f6d1c22";

InstantAction Action(std::string type) {
  return {.type = std::move(type), .id = std::string(kUuid)};
}

KnownRobot Online(std::string_view version = "3.0.0") {
  KnownRobot known;
  known.connection =
      ReadConnection(fmt::format(R"({{"version":"{}","connectionState":"ONLINE"}})", version))
          .value();
  return known;
}

KnownRobot In(std::string_view connection_state) {
  KnownRobot known;
  known.connection =
      ReadConnection(
          fmt::format(
              R"({{"version":"3.0.0","timestamp":"2026-01-02T03:04:05.678Z","connectionState":"{}"}})",
              connection_state))
          .value();
  return known;
}

KnownRobot InMode(std::string_view mode) {
  KnownRobot known = Online();
  known.operating_mode = NormalisedMode(mode);
  return known;
}

// With `protocolFeatures` and `protocolLimits` of 3.0.
KnownRobot WithActions(std::string_view actions) {
  KnownRobot known = Online();
  known.factsheet =
      Shared(fmt::format(R"({{"protocolFeatures":{{"mobileRobotActions":[{}]}}}})", actions));
  return known;
}

KnownRobot WithLimits(std::string_view strings, std::string_view arrays = "") {
  KnownRobot known = Online();
  known.factsheet = Shared(fmt::format(
      R"({{"protocolLimits":{{"maximumStringLengths":{{{}}},"maximumArrayLengths":{{{}}}}}}})",
      strings, arrays));
  return known;
}

// `refused: …` and `warning: …`, one per finding.
std::vector<std::string> Findings(const KnownRobot& known, const InstantAction& action,
                                  const Dialect& dialect = {}, std::size_t payload_bytes = 0) {
  const auto findings = CheckRobot(kRobot, dialect, std::span(&action, 1), known, payload_bytes);
  std::vector<std::string> lines;
  for (const auto& sentence : findings.refusals) lines.push_back("refused: " + sentence);
  for (const auto& sentence : findings.warnings) lines.push_back("warning: " + sentence);
  return lines;
}

// ── connection ──

TEST(Preflight, FindsNothingWrongWithARobotThatIsOnline) {
  EXPECT_THAT(Findings(Online(), Action("startPause")), IsEmpty());
}

TEST(Preflight, RefusesARobotOfWhichNothingTellsThatItIsThere) {
  for (const std::string type : {"cancelOrder", "stopPause", "stopHibernation"}) {
    EXPECT_THAT(Findings({}, Action(type)),
                ElementsAre(AllOf(StartsWith("refused: KIT/0001"), HasSubstr("connection message"),
                                  HasSubstr("--no-check"))));
  }
  EXPECT_THAT(Findings({}, Action("startPause")), ElementsAre(StartsWith("warning: KIT/0001")))
      << "to stop is never held back";
}

TEST(Preflight, OnlyWarnsOfARobotThatSendsStatesWithoutBeingOnline) {
  KnownRobot silent_about_it;
  silent_about_it.speaks = true;
  silent_about_it.said_version = "3.0.0";
  EXPECT_THAT(Findings(silent_about_it, Action("cancelOrder")),
              ElementsAre(AllOf(StartsWith("warning: "), HasSubstr("sends states"))));
  KnownRobot old_will = In("CONNECTIONBROKEN");
  old_will.speaks = true;
  EXPECT_THAT(Findings(old_will, Action("cancelOrder")),
              ElementsAre(AllOf(StartsWith("warning: "), HasSubstr("CONNECTION_BROKEN"),
                                HasSubstr("sends states"))));
  KnownRobot asleep = In("HIBERNATING");
  asleep.speaks = true;
  EXPECT_THAT(Findings(asleep, Action("cancelOrder")), ElementsAre(StartsWith("refused: ")));
}

TEST(Preflight, HoldsTheVersionOfAStateAgainstTheDialectToo) {
  KnownRobot known;
  known.speaks = true;
  known.said_version = "2.1.0";
  EXPECT_THAT(Findings(known, Action("cancelOrder")),
              Contains(AllOf(StartsWith("refused: "), HasSubstr("speaks 2.1.0"))));
}

TEST(Preflight, RefusesARobotThatIsNotOnline) {
  for (const std::string state : {"OFFLINE", "DISCONNECTED", "disconnected"}) {
    EXPECT_THAT(Findings(In(state), Action("cancelOrder")),
                ElementsAre("refused: KIT/0001 is OFFLINE since 2026-01-02T03:04:05.678Z; "
                            "--no-check sends it anyway"));
  }
  EXPECT_THAT(Findings(In("CONNECTIONBROKEN"), Action("cancelOrder")),
              ElementsAre(HasSubstr("CONNECTION_BROKEN (connected at 2026-01-02T03:04:05.678Z)")))
      << "a last will is as old as the connection";
  EXPECT_THAT(Findings(In(""), Action("cancelOrder")),
              ElementsAre(HasSubstr("is without a connectionState since")));
}

TEST(Preflight, SaysHowToWakeARobotThatHibernates) {
  EXPECT_THAT(Findings(In("HIBERNATING"), Action("shutdown")),
              ElementsAre("refused: KIT/0001 is HIBERNATING since 2026-01-02T03:04:05.678Z: wake "
                          "it with stopHibernation, or --no-check"));
}

TEST(Preflight, SendsAPauseToARobotThatLooksOffline) {
  for (const std::string state : {"OFFLINE", "CONNECTION_BROKEN", "HIBERNATING", ""}) {
    EXPECT_THAT(Findings(In(state), Action("startPause")),
                ElementsAre(MatchesRegex("warning: KIT/0001 is .*; startPause is sent anyway")));
  }
}

TEST(Preflight, WakesOnlyARobotThatHibernates) {
  EXPECT_THAT(Findings(In("HIBERNATING"), Action("stopHibernation")), IsEmpty());
  EXPECT_THAT(Findings(In("ONLINE"), Action("stopHibernation")),
              ElementsAre("warning: KIT/0001 is ONLINE: there is no hibernation to stop"));
  for (const std::string state : {"OFFLINE", "CONNECTION_BROKEN"}) {
    EXPECT_THAT(Findings(In(state), Action("stopHibernation")),
                ElementsAre(MatchesRegex("refused: KIT/0001 is " + state +
                                         ".*, not HIBERNATING; --no-check .*")));
  }
}

TEST(Preflight, MakesNoExceptionForAMessageOfSeveralActions) {
  const std::vector actions{Action("startPause"), Action("cancelOrder")};
  EXPECT_THAT(CheckRobot(kRobot, {}, actions, In("OFFLINE")).refusals,
              ElementsAre(HasSubstr("is OFFLINE")));
  EXPECT_THAT(CheckRobot(kRobot, {}, actions, InMode("INTERVENED")).refusals,
              ElementsAre(HasSubstr("is in INTERVENED")));
}

// ── version and topics ──

TEST(Preflight, NamesTheVersionThatTheRobotSpeaks) {
  for (const bool assumed : {true, false}) {
    EXPECT_THAT(Findings(Online("2.1.0"), Action("startPause"), {.assumed = assumed}),
                ElementsAre("refused: KIT/0001 speaks 2.1.0: use --vda auto, or --no-check"));
  }
  EXPECT_THAT(Findings(Online("2.0.0"), Action("startPause"), {.version = Version::k210}),
              ElementsAre("refused: KIT/0001 speaks 2.0.0: use --vda auto, or --no-check"));
  EXPECT_THAT(Findings(Online("v2"), Action("startPause")),
              ElementsAre("refused: KIT/0001 speaks v2: use --vda auto, or --no-check"));
  EXPECT_THAT(Findings(Online("4.0.0"), Action("startPause")),
              ElementsAre("refused: KIT/0001 speaks 4.0.0, which fleetpub does not; --no-check "
                          "sends it anyway"));
}

TEST(Preflight, TakesAVersionThatIsSaidInOtherWords) {
  const std::pair<std::string_view, Version> unsaid[] = {{"", Version::k200},
                                                         {"latest", Version::k110},
                                                         {"2.0.4", Version::k200},
                                                         {"3.0.7", Version::k300}};
  for (const auto& [spoken, ours] : unsaid) {
    EXPECT_THAT(Findings(Online(spoken), Action("startPause"), {.version = ours}), IsEmpty())
        << spoken;
  }
  const std::pair<std::string_view, Version> no_release[] = {
      {"3.0", Version::k300}, {"v3", Version::k300}, {"3.1.0", Version::k300},
      {"2", Version::k200},   {"v2", Version::k210}, {"2.2.0", Version::k210}};
  for (const auto& [spoken, ours] : no_release) {
    EXPECT_THAT(Findings(Online(spoken), Action("startPause"), {.version = ours}),
                ElementsAre(AllOf(StartsWith("warning"), HasSubstr(GetFacts(ours).name))))
        << spoken;
  }
}

TEST(Preflight, WeighsTheTopicOfAVersionThatIsNoRelease) {
  KnownRobot known = Online("1.4.7");
  known.topic = "uagv/v2/KIT/0001/connection";
  EXPECT_THAT(Findings(known, Action("startPause"), {.version = Version::k210}),
              ElementsAre(AllOf(StartsWith("warning"), HasSubstr("1.4.7"), HasSubstr("2.1.0"))));
}

TEST(Preflight, DoesNotCheckTheVersionBesideAHeaderVersionOfItsOwn) {
  EXPECT_THAT(Findings(Online("2.1.0"), Action("startPause"),
                       {.version = Version::k200, .header_version = "2.1.0"}),
              IsEmpty());
}

KnownRobot At(std::string topic, std::string_view version) {
  KnownRobot known = Online(version);
  known.topic = std::move(topic);
  return known;
}

TEST(Preflight, RefusesARobotThatWouldNotHearUs) {
  EXPECT_THAT(Findings(At("vda5050/v3/KIT/0001/connection", "3.0.0"), Action("startPause")),
              IsEmpty());
  for (const std::string header_version : {"", "3.0"}) {
    EXPECT_THAT(Findings(At("fts/v3/KIT/0001/connection", "3.0.0"), Action("startPause"),
                         {.header_version = header_version}),
                ElementsAre(AllOf(StartsWith("refused: "), HasSubstr("fts/v3/KIT/0001/connection"),
                                  HasSubstr("--topic-template, or --no-check"))));
  }
}

TEST(Preflight, AdvisesAutoWhenTheVersionAloneDoesNotHelp) {
  EXPECT_THAT(Findings(At("uagv/v2/KIT/0001/connection", "2.1.0"), Action("startPause")),
              ElementsAre(HasSubstr("use --vda auto,")));
  EXPECT_THAT(Findings(At("fts/v2/KIT/0001/connection", "2.1.0"), Action("startPause")),
              ElementsAre(HasSubstr("use --vda auto,")));
}

// ── operating mode ──

TEST(Preflight, ObeysTheTableOfModes) {
  for (const std::string mode : {"AUTOMATIC", "SEMIAUTOMATIC", "semi-automatic", "", "PARTY"}) {
    EXPECT_THAT(Findings(InMode(mode), Action("startPause")), IsEmpty()) << mode;
  }
  for (const std::string mode : {"MANUAL", "SERVICE", "TEACH_IN", "STARTUP"}) {
    for (const std::string type :
         {"stopPause", "cancelOrder", "stateRequest", "factsheetRequest", "initializePosition"}) {
      EXPECT_THAT(Findings(InMode(mode), Action(type)),
                  ElementsAre(AllOf(StartsWith("refused: KIT/0001 is in " + mode),
                                    HasSubstr("no instant action; --no-check"))));
    }
  }
  EXPECT_THAT(CheckRobot(kRobot, {}, {}, InMode("MANUAL")).refusals,
              ElementsAre(HasSubstr("obeys no command; --no-check")));
  EXPECT_THAT(Findings(InMode("teachin"), Action("startPause")),
              ElementsAre(MatchesRegex("warning: .* is in TEACH_IN.*")));
}

TEST(Preflight, CancelsAnOrderOfARobotThatIsIntervened) {
  EXPECT_THAT(Findings(InMode("INTERVENED"), Action("cancelOrder")), IsEmpty());
  EXPECT_THAT(Findings(InMode("INTERVENED"), Action("stopPause")),
              ElementsAre(AllOf(StartsWith("refused: KIT/0001 is in INTERVENED"),
                                HasSubstr("cancelOrder only; --no-check"))));
}

// ── factsheet: actions ──

TEST(Preflight, RefusesAnActionThatTheFactsheetDoesNotList) {
  const auto known = WithActions(R"({"actionType":"startPause","actionScopes":["INSTANT"]})");
  EXPECT_THAT(Findings(known, Action("startPause")), IsEmpty());
  EXPECT_THAT(
      Findings(known, Action("beep")),
      ElementsAre("refused: KIT/0001's factsheet does not list beep; --no-check sends it anyway"));
}

TEST(Preflight, RefusesAnActionThatIsNotInstant) {
  EXPECT_THAT(
      Findings(WithActions(R"({"actionType":"beep","actionScopes":["NODE","EDGE"]})"),
               Action("beep")),
      ElementsAre("refused: KIT/0001's factsheet lists beep for NODE, EDGE only, not INSTANT; "
                  "--no-check sends it anyway"));
  EXPECT_THAT(Findings(WithActions(R"({"actionType":"beep"})"), Action("beep")), IsEmpty());
}

TEST(Preflight, TakesAFactsheetThatListsNothingForOneThatSaysNothing) {
  EXPECT_THAT(Findings(WithActions(""), Action("beep")), IsEmpty());
}

TEST(Preflight, LooksForTheNameThatTheVersionKnows) {
  KnownRobot known = Online("2.1.0");
  known.factsheet =
      Shared(R"({"protocolFeatures":{"agvActions":[{"actionType":"initPosition"}]}})");
  EXPECT_THAT(Findings(known, Action("initializePosition"), {.version = Version::k210}), IsEmpty());
}

constexpr std::string_view kBeep =
    R"({"actionType":"beep","actionParameters":[{"key":"tone","isOptional":false},)"
    R"({"key":"volume"},{"key":"colour","isOptional":true}]})";

TEST(Preflight, RefusesAnActionWithoutAParameterThatTheFactsheetNeeds) {
  InstantAction action = Action("beep");
  action.parameters = {{"volume", "1"}};
  EXPECT_THAT(Findings(WithActions(kBeep), action),
              ElementsAre("refused: KIT/0001's factsheet has the parameter tone for beep and "
                          "requires it; --no-check sends it anyway"));
}

TEST(Preflight, WarnsOfAParameterOfWhichTheFactsheetDoesNotSayIfItIsOptional) {
  InstantAction action = Action("beep");
  action.parameters = {{"tone", "1"}};
  EXPECT_THAT(
      Findings(WithActions(kBeep), action),
      ElementsAre("warning: KIT/0001's factsheet has the parameter volume for beep and does "
                  "not call it optional"));
}

TEST(Preflight, WarnsOfAParameterThatTheFactsheetDoesNotHave) {
  InstantAction action = Action("beep");
  action.parameters = {{"tone", "1"}, {"volume", "1"}, {"tune", "1"}};
  EXPECT_THAT(Findings(WithActions(kBeep), action),
              ElementsAre("warning: KIT/0001's factsheet has no parameter tune for beep"));
  EXPECT_THAT(Findings(WithActions(R"({"actionType":"beep"})"), action), IsEmpty());
}

TEST(Preflight, NamesABlockingTypeThatTheRobotTakes) {
  KnownRobot known = Online("2.1.0");
  known.factsheet = Shared(
      R"({"protocolFeatures":{"agvActions":[{"actionType":"beep","blockingTypes":["SOFT","HARD"]}]}})");
  const Dialect dialect{.version = Version::k210};
  InstantAction action = Action("beep");
  EXPECT_THAT(Findings(known, action, dialect),
              ElementsAre("refused: KIT/0001's factsheet does not list the blocking type NONE for "
                          "beep: use --blocking-type SOFT or HARD, or --no-check"));
  action.blocking_type = "HARD";
  EXPECT_THAT(Findings(known, action, dialect), IsEmpty());
}

TEST(Preflight, OnlyWarnsOfTheBlockingTypeWhereThereIsNoOther) {
  EXPECT_THAT(
      Findings(WithActions(R"({"actionType":"beep","blockingTypes":["HARD"]})"), Action("beep")),
      ElementsAre(HasSubstr("warning: KIT/0001's factsheet does not list the blocking")));
}

// ── factsheet: limits ──

TEST(Preflight, RefusesAnActionIdThatTheRobotDoesNotTake) {
  const auto refusal = [](std::string_view fitting) {
    return fmt::format(
        "refused: KIT/0001 does not take the actionId {}: its factsheet allows {}: give another "
        "--id, or none, or --no-check",
        kUuid, fitting);
  };
  EXPECT_THAT(Findings(WithLimits(R"("maximumIdLength":35)"), Action("startPause")),
              ElementsAre(refusal("any characters, at most 35")));
  EXPECT_THAT(Findings(WithLimits(R"("idNumericalOnly":true)"), Action("startPause")),
              ElementsAre(refusal("only digits")));
  EXPECT_THAT(
      Findings(WithLimits(R"("idNumericalOnly":true,"maximumIdLength":8)"), Action("startPause")),
      ElementsAre(refusal("only digits, at most 8")));
  EXPECT_THAT(Findings(WithLimits(R"("maximumIdLength":36)"), Action("startPause")), IsEmpty());
  EXPECT_THAT(Findings(WithLimits(R"("maximumIdLength":0)"), Action("startPause")), IsEmpty());
  EXPECT_THAT(Findings(WithLimits(R"("idNumericalOnly":true)"),
                       InstantAction{.type = "startPause", .id = "42"}),
              IsEmpty());
}

TEST(Preflight, RefusesWhatIsMoreThanTheRobotTakes) {
  InstantAction action = Action("beep");
  action.parameters = {{"a", "1"}, {"b", "1"}};
  EXPECT_THAT(Findings(WithLimits("", R"("actions.actionsParameters":1)"), action),
              ElementsAre(HasSubstr("allows 1 parameters for an action, beep has 2")));
  EXPECT_THAT(Findings(WithLimits("", R"("actions.actionsParameters":2)"), action), IsEmpty());
  EXPECT_THAT(Findings(WithLimits(R"("maximumMessageLength":100)"), action, {}, 101),
              ElementsAre(HasSubstr("allows messages of 100 bytes, this one has 101")));
  EXPECT_THAT(Findings(WithLimits(R"("maximumMessageLength":100)"), action, {}, 100), IsEmpty());
  const std::vector actions{Action("beep"), Action("beep")};
  EXPECT_THAT(CheckRobot(kRobot, {}, actions, WithLimits("", R"("instantActions":1)")).refusals,
              ElementsAre(HasSubstr("allows 1 actions in a message, there are 2")));
}

TEST(Preflight, ShowsNothingOfARobotThatMovesACursor) {
  KnownRobot known = In("OFF\\u001b[2J");
  EXPECT_THAT(Findings(known, Action("cancelOrder")), ElementsAre(HasSubstr("OFF\\x1b[2J")));
}

TEST(Preflight, FindsEverythingAtOnce) {
  KnownRobot known = InMode("MANUAL");
  known.connection->connection_state = "OFFLINE";
  known.factsheet = Shared(R"({"protocolLimits":{"maxStringLens":{"idLen":5}},
    "protocolFeatures":{"agvActions":[{"actionType":"beep"}]}})");
  EXPECT_THAT(Findings(known, Action("startCharging")),
              ElementsAre(HasSubstr("OFFLINE"), HasSubstr("MANUAL"), HasSubstr("does not list"),
                          HasSubstr("does not take the actionId")));
}

TEST(Preflight, NeverStandsInTheWayOfStopping) {
  const auto known = WithActions(R"({"actionType":"beep"})");
  for (const char* type : {"startPause", "stopPause", "cancelOrder", "factsheetRequest"}) {
    EXPECT_THAT(Findings(known, Action(type)),
                ElementsAre(MatchesRegex("warning: .*" + std::string(type) + ".*")));
  }
  EXPECT_THAT(Findings(known, Action("startCharging")), ElementsAre(MatchesRegex("refused: .*")));
}

TEST(Preflight, NamesBothPlacesOfARobotThatIsFoundTwice) {
  KnownRobot known = Online();
  known.other_topic = "uagv/v2/KIT/0001/connection";
  EXPECT_THAT(Findings(known, Action("stopPause")),
              ElementsAre(MatchesRegex("warning: .*uagv/v2/KIT/0001/connection.*")));
}

TEST(Preflight, TellsWhatCannotBeRead) {
  KnownRobot known = Online();
  known.factsheet_fault = "line 7";
  EXPECT_THAT(Findings(known, Action("stopPause")),
              ElementsAre(MatchesRegex("warning: .*factsheet cannot be read.*line 7")));
  known = Online();
  known.connection = ConnectionMessage{.fault = "line 8"};
  EXPECT_THAT(Findings(known, Action("stopPause")),
              ElementsAre(MatchesRegex("refused: .*cannot be read: line 8.*")));
  EXPECT_THAT(Findings(known, Action("startPause")),
              ElementsAre(MatchesRegex("warning: .*line 8.*")));
}

TEST(Preflight, TakesScopesThatAreWrittenInOneText) {
  const auto scopes = [](std::string_view text) {
    return WithActions(fmt::format(R"({{"actionType":"beep","actionScopes":"{}"}})", text));
  };
  EXPECT_THAT(Findings(scopes("node, Instant"), Action("beep")), IsEmpty());
  EXPECT_THAT(Findings(scopes("INSTANT"), Action("beep")), IsEmpty());
  EXPECT_THAT(Findings(scopes("NODE"), Action("beep")), ElementsAre(HasSubstr("NODE only")));
}

// ── ids ──

Factsheet WithIds(bool numerical_only, std::size_t length) {
  Factsheet factsheet;
  factsheet.limits.id_numerical_only = numerical_only;
  factsheet.limits.id_length = length;
  return factsheet;
}

TEST(MakeActionId, IsAUuidWhereItCanBe) {
  const char* const uuid = "[0-9a-f]+-[0-9a-f]+-4[0-9a-f]+-[0-9a-f]+-[0-9a-f]+";
  EXPECT_THAT(MakeActionId(nullptr), MatchesRegex(uuid));
  for (const std::size_t length : {0U, 36U, 100U}) {
    const auto factsheet = WithIds(false, length);
    EXPECT_THAT(MakeActionId(&factsheet), MatchesRegex(uuid));
  }
}

TEST(MakeActionId, IsANumberWhereItMustBe) {
  const std::tuple<bool, std::size_t, std::size_t> cases[] = {
      {true, 0, 18}, {true, 100, 18}, {true, 10, 10}, {true, 1, 1}, {false, 35, 18}, {false, 4, 4}};
  for (const auto& [numerical_only, length, digits] : cases) {
    const auto factsheet = WithIds(numerical_only, length);
    const std::string id = MakeActionId(&factsheet);
    EXPECT_EQ(id.size(), digits);
    EXPECT_THAT(id, MatchesRegex("[1-9][0-9]*"));
  }
}

TEST(MakeActionId, PassesThePreflightAndIsNeverTheSame) {
  std::set<std::string> ids;
  const KnownRobot known = WithLimits(R"("idNumericalOnly":true,"maximumIdLength":12)");
  for (int i = 0; i < 100; ++i) {
    const std::string id = MakeActionId(&*known.factsheet);
    EXPECT_THAT(Findings(known, InstantAction{.type = "startPause", .id = id}), IsEmpty());
    ids.insert(id);
  }
  EXPECT_EQ(ids.size(), 100U);
}

}  // namespace
}  // namespace fleetpub::vda5050
