// The catalogue, held against the specification's tables of predefined actions. The tables are
// written out here once more, each version whole and row by row as it is printed, so that a slip in
// the one is not a slip in the other.
#include "vda5050/catalogue/catalogue.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>

namespace fleetpub::vda5050 {
namespace {

using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using ::testing::IsEmpty;
using ::testing::Optional;
using namespace std::string_view_literals;

/// A row as text: type | counter action | scopes | parameters, `?` optional | linked state |
/// idempotent.
using Rows = std::vector<std::string>;

constexpr std::string_view kPosition =
    "x float64, y float64, theta float64, mapId string, lastNodeId string";
constexpr std::string_view kAgvPosition =
    "agvPosition.x, agvPosition.y, agvPosition.theta, agvPosition.mapId, lastNodeId";
constexpr std::string_view kMobileRobotPosition =
    "mobileRobotPosition.x, mobileRobotPosition.y, mobileRobotPosition.theta, "
    "mobileRobotPosition.mapId, lastNodeId, maps";

Rows TableOf11() {
  return {
      "startPause | stopPause | I | | paused | yes",
      "stopPause | startPause | I | | paused | yes",
      "startCharging | stopCharging | IN | | batteryState.charging | yes",
      "stopCharging | startCharging | IN | | batteryState.charging | yes",
      fmt::format("initPosition | | IN | {} | {} | yes", kPosition, kAgvPosition),
      "stateRequest | | I | | | yes",
      "logReport | | I | reason string | | yes",
      "pick | drop | NE | lhd string?, stationType string, stationName string?, loadType string, "
      "loadId string?, height float64?, depth float64?, side string? | load | no",
      "drop | pick | NE | lhd string?, stationType string?, stationName string?, loadType string?, "
      "loadId string?, height float64?, depth float64? | load | no",
      "detectObject | | NE | objectType string? | | yes",
      "finePositioning | | NE | stationType string?, stationName string? | | yes",
      "waitForTrigger | | N | triggerType string | | yes",
      "cancelOrder | | I | | | yes",
  };
}

Rows TableOf20() {
  Rows rows = TableOf11();
  rows.push_back("factsheetRequest | | I | | | yes");
  return rows;
}

Rows TableOf21() {
  Rows rows = TableOf20();
  std::replace(rows.begin(), rows.end(),
               fmt::format("initPosition | | IN | {} | {} | yes", kPosition, kAgvPosition),
               fmt::format("initPosition | | IN | {} | {}, maps | yes", kPosition, kAgvPosition));
  rows.push_back("enableMap | | IN | mapId string, mapVersion string | maps | yes");
  rows.push_back(
      "downloadMap | | I | mapId string, mapVersion string, mapDownloadLink string, "
      "mapHash string? | maps | yes");
  rows.push_back("deleteMap | | I | mapId string, mapVersion string | maps | yes");
  return rows;
}

Rows TableOf30() {
  return {
      "startPause | stopPause | I | | paused | yes",
      "stopPause | startPause | I | | paused | yes",
      "startHibernation | stopHibernation | I | wakeUpTime string? | | yes",
      "stopHibernation | startHibernation | I | | | yes",
      "shutdown | | I | | | yes",
      "startCharging | stopCharging | IN | | powerSupply.charging | yes",
      "stopCharging | startCharging | IN | | powerSupply.charging | yes",
      fmt::format("initializePosition | | IN | {} | {} | yes", kPosition, kMobileRobotPosition),
      "enableMap | | IN | mapId string, mapVersion string | maps | yes",
      "downloadMap | | I | mapId string, mapVersion string, mapDownloadLink string, "
      "mapHash string? | maps | yes",
      "deleteMap | | I | mapId string, mapVersion string | maps | yes",
      "downloadZoneSet | | I | zoneSetId string, zoneSetDownloadLink string, zoneSetHash string? | "
      "zoneSets | yes",
      "enableZoneSet | | IN | zoneSetId string | zoneSets | yes",
      "deleteZoneSet | | I | zoneSetId string | zoneSets | yes",
      "clearInstantActions | | IN | | instantActionStates | yes",
      "clearZoneActions | | IN | | zoneActionStates | yes",
      "stateRequest | | I | | | yes",
      "logReport | | I | reason string | | yes",
      "pick | drop | NE | lhd string?, stationType string?, stationName string?, loadType string?, "
      "loadId string?, height float64?, depth float64?, side string? | load | no",
      "drop | pick | NE | lhd string?, stationType string?, stationName string?, loadType string?, "
      "loadId string?, height float64?, depth float64? | load | no",
      "detectObject | | NEZ | objectType string? | | yes",
      "finePositioning | | NEZ | stationType string?, stationName string? | | yes",
      "waitForTrigger | | NZ | triggerType array of string | | yes",
      "trigger | | I | | | yes",
      "retry | | I | actionId string | | yes",
      "skipRetry | | I | actionId string | | yes",
      "cancelOrder | | I | orderId string? | | yes",
      "factsheetRequest | | I | | | yes",
      "updateCertificate | | I | service string, keyDownloadLink string, "
      "certificateDownloadLink string, certificateAuthorityDownloadLink string? | | yes",
  };
}

Rows ReadTable(Version version) {
  switch (version) {
    case Version::k110:
      return TableOf11();
    case Version::k200:
      return TableOf20();
    case Version::k210:
      return TableOf21();
    case Version::k300:
      return TableOf30();
  }
  return {};
}

std::string ScopesText(const Scopes& scopes) {
  return fmt::format("{}{}{}{}", scopes.instant ? "I" : "", scopes.node ? "N" : "",
                     scopes.edge ? "E" : "", scopes.zone ? "Z" : "");
}

// The row in the form above; an empty cell has one blank.
std::string RowText(const ActionSpec& action) {
  std::string parameters;
  for (const ParameterSpec& parameter : action.parameters) {
    parameters += fmt::format("{}{} {}{}", parameters.empty() ? "" : ", ", parameter.name,
                              GetName(parameter.type), parameter.required ? "" : "?");
  }
  std::string row(action.type);
  for (const std::string& cell :
       {std::string(action.counter_action), ScopesText(action.scopes), parameters,
        std::string(action.linked_state), std::string(action.idempotent ? "yes" : "no")}) {
    row += cell.empty() ? " |" : " | " + cell;
  }
  return row;
}

Rows ListCatalogue(Version version) {
  Rows rows;
  for (const ActionSpec* action : ListActions(version)) rows.push_back(RowText(*action));
  return rows;
}

class Catalogue : public ::testing::TestWithParam<Version> {};

TEST_P(Catalogue, HasTheRowsOfTheSpecificationsTable) {
  EXPECT_THAT(ListCatalogue(GetParam()),
              ::testing::UnorderedElementsAreArray(ReadTable(GetParam())));
}

TEST_P(Catalogue, FindsEachActionByItsExactName) {
  for (const ActionSpec* action : ListActions(GetParam())) {
    EXPECT_EQ(FindAction(GetParam(), action->type), action);
  }
  EXPECT_EQ(FindAction(GetParam(), "STARTPAUSE"), nullptr) << "names are case-sensitive";
  EXPECT_EQ(FindAction(GetParam(), "pause"), nullptr) << "a short name is not on the wire";
}

TEST_P(Catalogue, NamesCounterActionsThatExistAndPointBack) {
  for (const ActionSpec* action : ListActions(GetParam())) {
    if (action->counter_action.empty()) continue;
    const ActionSpec* counter = FindAction(GetParam(), action->counter_action);
    ASSERT_NE(counter, nullptr) << action->type;
    EXPECT_EQ(counter->counter_action, action->type);
  }
}

TEST_P(Catalogue, SaysOfEveryActionAndParameterWhatItIsFor) {
  for (const ActionSpec* action : ListActions(GetParam())) {
    EXPECT_NE(action->summary, "") << action->type;
    for (const ParameterSpec& parameter : action->parameters) {
      EXPECT_NE(parameter.meaning, "") << action->type << " " << parameter.name;
    }
  }
}

TEST_P(Catalogue, ChecksThetaAsAnAngle) {
  const ActionSpec* action = FindAction(GetParam(), NameIn(GetParam(), "initPosition"));
  ASSERT_NE(action, nullptr);
  EXPECT_EQ(action->parameters[2].name, "theta");
  EXPECT_EQ(action->parameters[2].type, ParameterType::kAngle);
}

INSTANTIATE_TEST_SUITE_P(Every, Catalogue, ::testing::ValuesIn(kVersions), [](const auto& version) {
  std::string name(GetFacts(version.param).name);
  std::replace(name.begin(), name.end(), '.', '_');
  return "Version" + name;
});

TEST(Catalogue, CountsAsTheSpecificationDoes) {
  std::vector<std::size_t> all;
  std::vector<std::ptrdiff_t> instant;
  for (const Version version : kVersions) {
    const auto actions = ListActions(version);
    all.push_back(actions.size());
    instant.push_back(std::count_if(actions.begin(), actions.end(),
                                    [](const auto* action) { return action->scopes.instant; }));
  }
  EXPECT_THAT(all, ElementsAre(13, 14, 17, 29));
  EXPECT_THAT(instant, ElementsAre(8, 9, 12, 24));
}

TEST(Catalogue, StandsInTheOrderOfTheNewestTable) {
  EXPECT_THAT(ListCatalogue(Version::k300), ElementsAreArray(TableOf30()));
}

TEST(AllActionNames, ListsEachActionOnceUnderItsNewestName) {
  Rows expected;
  for (const std::string& row : TableOf30()) expected.push_back(row.substr(0, row.find(' ')));
  EXPECT_THAT(AllActionNames(), ElementsAreArray(expected));
}

TEST(NameIn, TranslatesTheRenamedAction) {
  for (const Version version : {Version::k110, Version::k200, Version::k210}) {
    EXPECT_EQ(NameIn(version, "initializePosition"), "initPosition");
    EXPECT_EQ(NameIn(version, "initPosition"), "initPosition");
  }
  EXPECT_EQ(NameIn(Version::k300, "initPosition"), "initializePosition");
  EXPECT_EQ(NameIn(Version::k300, "initializePosition"), "initializePosition");
}

TEST(NameIn, LeavesEveryOtherNameAlone) {
  EXPECT_EQ(NameIn(Version::k110, "startPause"), "startPause");
  EXPECT_EQ(NameIn(Version::k110, "downloadMap"), "downloadMap") << "1.1.0 does not have it";
  EXPECT_EQ(NameIn(Version::k300, "beep"), "beep");
  EXPECT_EQ(NameIn(Version::k300, "INITPOSITION"), "INITPOSITION");
}

TEST(ActionCalled, UnderstandsShortNames) {
  constexpr std::pair<std::string_view, std::string_view> kCases[] = {
      {"pause", "startPause"},     {"resume", "stopPause"},
      {"cancel", "cancelOrder"},   {"initPosition", "initializePosition"},
      {"charge", "startCharging"}, {"uncharge", "stopCharging"},
      {"PAUSE", "startPause"},     {"Initposition", "initializePosition"},
  };
  for (const auto& [word, type] : kCases) EXPECT_THAT(ActionCalled(word), Optional(type)) << word;
}

TEST(ActionCalled, UnderstandsPredefinedNamesInAnyLetterCase) {
  for (const std::string_view name : AllActionNames()) {
    std::string shouted(name);
    for (char& c : shouted) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    EXPECT_THAT(ActionCalled(name), Optional(name));
    EXPECT_THAT(ActionCalled(shouted), Optional(name));
  }
}

TEST(ActionCalled, KnowsNothingElse) {
  for (const std::string_view word :
       {"", "beep", "pauses", "start", "start-pause", "startPause "}) {
    EXPECT_EQ(ActionCalled(word), std::nullopt) << word;
  }
}

TEST(ListShortNames, AreThoseOfThePredefinedName) {
  EXPECT_THAT(ListShortNames("startPause"), ElementsAre("pause"));
  EXPECT_THAT(ListShortNames("initializePosition"), ElementsAre("initPosition"));
  EXPECT_THAT(ListShortNames("shutdown"), IsEmpty());
}

TEST(IsEverInstant, TellsOrderActionsApart) {
  for (const std::string_view type :
       {"startPause", "initPosition", "initializePosition", "trigger"}) {
    EXPECT_TRUE(IsEverInstant(type)) << type;
  }
  for (const std::string_view type :
       {"pick", "drop", "detectObject", "finePositioning", "waitForTrigger", "beep"}) {
    EXPECT_FALSE(IsEverInstant(type)) << type;
  }
}

TEST(VersionsWithInstant, ListsThemForAMessage) {
  EXPECT_EQ(VersionsWithInstant("downloadMap"), "2.1.0, 3.0.0");
  EXPECT_EQ(VersionsWithInstant("factsheetRequest"), "2.0.0, 2.1.0, 3.0.0");
  EXPECT_EQ(VersionsWithInstant("shutdown"), "3.0.0");
  EXPECT_EQ(VersionsWithInstant("initPosition"), "1.1.0, 2.0.0, 2.1.0, 3.0.0");
  EXPECT_EQ(VersionsWithInstant("pick"), "");
}

std::vector<std::string_view> ListNames(const std::vector<ParameterSpec>& parameters) {
  std::vector<std::string_view> names;
  for (const ParameterSpec& parameter : parameters) names.push_back(parameter.name);
  return names;
}

TEST(ParametersInAnyVersion, ListsEachOnce) {
  EXPECT_THAT(ListNames(ParametersInAnyVersion("initPosition")),
              ElementsAre("x", "y", "theta", "mapId", "lastNodeId"));
  EXPECT_THAT(ListNames(ParametersInAnyVersion("cancelOrder")), ElementsAre("orderId"));
  EXPECT_THAT(ParametersInAnyVersion("startPause"), IsEmpty());
  EXPECT_THAT(ParametersInAnyVersion("beep"), IsEmpty());
}

TEST(ParametersInAnyVersion, LetsTheNewestRowWin) {
  const auto parameters = ParametersInAnyVersion("waitForTrigger");
  ASSERT_EQ(parameters.size(), 1U);
  EXPECT_EQ(parameters.front().type, ParameterType::kStringArray);
}

TEST(ActionMeant, IsWhatUndoesAnActionAndNotTheAction) {
  for (const auto& [word, meant] : {std::pair("unpause", "resume"),
                                    {"unPause", "resume"},
                                    {"un-pause", "resume"},
                                    {"unpaus", "resume"},
                                    {"unhibernation", "stopHibernation"},
                                    {"stopChargin", "uncharge"},
                                    {"stoppause", "resume"}}) {
    EXPECT_EQ(ActionMeant(word), meant) << word;
  }
  for (const char* word : {"disableMap", "disableZoneSet", "unlock", "unretry", "stop", "start",
                           "halt", "estop", "abort", "go"}) {
    EXPECT_EQ(ActionMeant(word), std::nullopt) << word;
  }
  EXPECT_EQ(ActionMeant("puase"), "pause");
  EXPECT_EQ(ActionMeant("cancle"), "cancel");
  constexpr auto kOthers = std::to_array<std::string_view>({"watch", "fleet"});
  EXPECT_EQ(ActionMeant("flete", kOthers), "fleet");
  EXPECT_EQ(ActionMeant("unwatch", kOthers), std::nullopt);
}

}  // namespace
}  // namespace fleetpub::vda5050
