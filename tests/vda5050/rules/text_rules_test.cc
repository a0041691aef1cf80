#include "vda5050/rules/text_rules.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "base/json.h"

namespace fleetpub::vda5050 {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// `error /path: sentence`, one per finding.
std::vector<std::string> Check(Version version, const std::string& message) {
  const auto document = base::ParseJson(message);
  if (!document) throw std::runtime_error(document.error().message);
  std::vector<std::string> lines;
  for (const auto& [violation, is_error] : CheckInstantActions(*document, version)) {
    lines.push_back(fmt::format("{} {}: {}", is_error ? "error" : "warning", violation.path,
                                violation.message));
  }
  return lines;
}

std::vector<std::string> CheckActions(Version version, const std::string& actions) {
  return Check(version, fmt::format(R"({{"{}":[{}]}})", GetFacts(version).actions_key, actions));
}

// One action with an unobjectionable id. `parameters` are members of `actionParameters`.
std::vector<std::string> CheckAction(Version version, std::string_view type,
                                     std::string_view parameters = "") {
  return CheckActions(
      version, fmt::format(R"({{"actionType":"{}","actionId":"a1","actionParameters":[{}]}})", type,
                           parameters));
}

constexpr std::string_view kPosition =
    R"({"key":"x","value":1},{"key":"y","value":2.5},{"key":"theta","value":-3.1},)"
    R"({"key":"mapId","value":"m"},{"key":"lastNodeId","value":"n"})";

TEST(CheckInstantActions, TakesWhatTheVersionAllows) {
  for (const Version version : kVersions) {
    EXPECT_THAT(CheckAction(version, "startPause"), IsEmpty());
    EXPECT_THAT(CheckAction(version, "beep", R"({"key":"duration","value":3})"), IsEmpty());
  }
  EXPECT_THAT(CheckAction(Version::k210, "initPosition", kPosition), IsEmpty());
  EXPECT_THAT(CheckAction(Version::k300, "initializePosition", kPosition), IsEmpty());
}

TEST(CheckInstantActions, TakesActionParametersThatAreLeftOut) {
  EXPECT_THAT(CheckActions(Version::k300, R"({"actionType":"startPause","actionId":"a1"})"),
              IsEmpty());
}

TEST(CheckInstantActions, WantsAtLeastOneAction) {
  EXPECT_THAT(Check(Version::k300, R"({"actions":[]})"),
              ElementsAre("error /actions: there must be at least one action"));
  EXPECT_THAT(Check(Version::k110, R"({"actions":[]})"),
              ElementsAre("error /instantActions: there must be at least one action"));
}

TEST(CheckInstantActions, WantsEachActionIdOnce) {
  const std::string action = R"({"actionType":"startPause","actionId":"a1"})";
  const std::string other = R"({"actionType":"startPause","actionId":"a2"})";
  EXPECT_THAT(CheckActions(Version::k300, action + "," + other), IsEmpty());
  EXPECT_THAT(
      CheckActions(Version::k300, action + "," + other + "," + action),
      ElementsAre("error /actions/2/actionId: actionId 'a1' is used by two actions: ids must be "
                  "unique"));
}

TEST(CheckInstantActions, WantsIdAndTypeThatAreNotEmpty) {
  EXPECT_THAT(CheckActions(Version::k300, R"({"actionType":"","actionId":""})"),
              ElementsAre("error /actions/0/actionId: actionId must not be empty",
                          "error /actions/0/actionType: actionType must not be empty"));
}

TEST(CheckInstantActions, WarnsOfCharactersInAnId) {
  EXPECT_THAT(
      CheckActions(Version::k300, R"({"actionType":"startPause","actionId":"a 1"})"),
      ElementsAre("warning /actions/0/actionId: actionId has characters other than the recommended "
                  "A-Z a-z 0-9 _ . : -"));
}

TEST(CheckInstantActions, RefusesWhatIsNeverInstant) {
  for (const Version version : kVersions) {
    for (const std::string type :
         {"pick", "drop", "detectObject", "finePositioning", "waitForTrigger"}) {
      EXPECT_THAT(CheckAction(version, type),
                  ElementsAre(fmt::format("error /{}/0/actionType: {} is never an instant action: "
                                          "it belongs to the nodes and edges of an order",
                                          GetFacts(version).actions_key, type)));
    }
  }
}

TEST(CheckInstantActions, NamesTheVersionsThatHaveAnAction) {
  EXPECT_THAT(CheckAction(Version::k200, "downloadMap"),
              ElementsAre("error /actions/0/actionType: downloadMap is not a predefined action in "
                          "version 2.0.0: it is one in 2.1.0, 3.0.0"));
  EXPECT_THAT(
      CheckAction(Version::k110, "factsheetRequest"),
      ElementsAre("error /instantActions/0/actionType: factsheetRequest is not a predefined "
                  "action in version 1.1.0: it is one in 2.0.0, 2.1.0, 3.0.0"));
}

TEST(CheckInstantActions, NamesARenamedActionAsTheVersionDoes) {
  EXPECT_THAT(CheckAction(Version::k300, "initPosition", kPosition),
              ElementsAre("error /actions/0/actionType: initPosition is called initializePosition "
                          "in version 3.0.0"));
  EXPECT_THAT(CheckAction(Version::k210, "initializePosition", kPosition),
              ElementsAre("error /actions/0/actionType: initializePosition is called initPosition "
                          "in version 2.1.0"));
}

TEST(CheckInstantActions, WarnsOfATypeThatNearlyIsAPredefinedOne) {
  constexpr std::pair<std::string_view, std::string_view> kCases[] = {
      {"startpause", "startPause"},    {"startPuase", "startPause"},
      {"pause", "startPause"},         {"initposition", "initializePosition"},
      {"cancelOrders", "cancelOrder"}, {"unpause", "stopPause"},
  };
  for (const char* own : {"disableMap", "unlock"}) {
    EXPECT_THAT(CheckAction(Version::k300, own), ::testing::IsEmpty()) << "never the opposite";
  }
  for (const auto& [type, meant] : kCases) {
    EXPECT_THAT(
        CheckAction(Version::k300, type),
        ElementsAre(fmt::format(
            "warning /actions/0/actionType: '{}' is not a predefined action, so it counts as "
            "a manufacturer's own: did you mean {}? (names are case-sensitive)",
            type, meant)));
  }
}

TEST(CheckInstantActions, ListsParametersThatAreMissing) {
  EXPECT_THAT(CheckAction(Version::k300, "initializePosition", R"({"key":"x","value":1})"),
              ElementsAre("error /actions/0: initializePosition needs the parameters y, theta, "
                          "mapId, lastNodeId"));
  EXPECT_THAT(CheckAction(Version::k210, "logReport"),
              ElementsAre("error /actions/0: logReport needs the parameter reason"));
}

TEST(CheckInstantActions, LetsOptionalParametersBeLeftOut) {
  EXPECT_THAT(CheckAction(Version::k300, "cancelOrder"), IsEmpty());
  EXPECT_THAT(CheckAction(Version::k300, "startHibernation"), IsEmpty());
}

TEST(CheckInstantActions, WantsValuesOfTheTablesTypes) {
  struct Case {
    std::string_view key;
    std::string_view value;
    std::string_view sentence;
  };
  for (const auto& [key, value, sentence] :
       {Case{"x", R"("1")", "x must be a number, not a string: robots refuse quoted numbers"},
        Case{"x", "true", "x must be a number"},
        Case{"theta", R"("0")",
             "theta must be a number, not a string: robots refuse quoted numbers"},
        Case{"theta", "[0]", "theta must be a number"},
        Case{"theta", "3.2", "theta must be an angle in radians between -π and π"},
        Case{"theta", "-3.1416", "theta must be an angle in radians between -π and π"},
        Case{"mapId", "7", "mapId must be a string"}}) {
    const std::string wrong = fmt::format(R"({{"key":"{}","value":{}}})", key, value);
    const auto lines = CheckAction(Version::k300, "initializePosition", wrong);
    ASSERT_FALSE(lines.empty());
    EXPECT_EQ(lines.front(),
              fmt::format("error /actions/0/actionParameters/0/value: {}", sentence));
  }
}

TEST(CheckInstantActions, TakesAnyNumberWhereTheTableSaysFloat) {
  const std::string position =
      R"({"key":"x","value":1e300},{"key":"y","value":-0},{"key":"theta","value":3.141592653589793},)"
      R"({"key":"mapId","value":""},{"key":"lastNodeId","value":"n"})";
  EXPECT_THAT(CheckAction(Version::k300, "initializePosition", position), IsEmpty());
}

TEST(CheckInstantActions, RefusesAParameterThatIsGivenTwice) {
  const std::string reason = R"({"key":"reason","value":"r"})";
  EXPECT_THAT(
      CheckAction(Version::k300, "logReport", reason + "," + reason),
      ElementsAre("error /actions/0/actionParameters/1: parameter 'reason' is given twice"));
}

TEST(CheckInstantActions, LetsFurtherParametersPass) {
  EXPECT_THAT(CheckAction(Version::k300, "startPause", R"({"key":"ramp","value":0.5})"), IsEmpty());
  EXPECT_THAT(CheckAction(Version::k300, "logReport",
                          R"({"key":"reason","value":"r"},{"key":"z","value":[{}]})"),
              IsEmpty());
}

TEST(CheckInstantActions, WarnsOfAKeyThatNearlyIsAPredefinedOne) {
  const std::string position(kPosition);
  for (const std::string key : {"mapID", "mapid", "mapIdd", "lastNodeID"}) {
    const auto lines = CheckAction(Version::k300, "initializePosition",
                                   position + R"(,{"key":")" + key + R"(","value":"v"})");
    const std::string meant = key.starts_with("map") ? "mapId" : "lastNodeId";
    EXPECT_THAT(lines,
                ElementsAre("warning /actions/0/actionParameters/5: '" + key +
                            "' is not a parameter that initializePosition has: did you mean " +
                            meant + "?"));
  }
}

TEST(CheckInstantActions, WarnsOfAParameterThatOnlyAnotherVersionPredefines) {
  EXPECT_THAT(CheckAction(Version::k210, "cancelOrder", R"({"key":"orderId","value":"o"})"),
              ElementsAre("warning /actions/0/actionParameters/0: cancelOrder has no predefined "
                          "parameter 'orderId' in this version: it is sent as an additional one"));
}

TEST(CheckInstantActions, PointsIntoTheRightAction) {
  EXPECT_THAT(CheckActions(Version::k110, R"({"actionType":"startPause","actionId":"a1"},)"
                                          R"({"actionType":"logReport","actionId":"a2"})"),
              ElementsAre("error /instantActions/1: logReport needs the parameter reason"));
}

TEST(CheckInstantActions, SurvivesWhatOnlyAUsersOwnSchemaLetsPass) {
  for (const std::string message :
       {"{}", "[]", "null", R"({"actions":{}})", R"({"actions":[1,null,"x"]})",
        R"({"actions":[{"actionType":1,"actionId":2}]})",
        R"({"actions":[{"actionType":"logReport","actionId":"a","actionParameters":7}]})",
        R"({"actions":[{"actionType":"logReport","actionId":"a","actionParameters":[1,{}]}]})",
        R"({"actions":[{"actionType":"logReport","actionId":"a",
                        "actionParameters":[{"key":"reason"}]}]})"}) {
    EXPECT_FALSE(Check(Version::k300, message).empty()) << message;
  }
}

TEST(CheckInstantActions, ShowsNoControlCharacterOfTheMessage) {
  const auto lines =
      CheckActions(Version::k300, R"({"actionType":"startPause\u001b","actionId":"\u009b"},)"
                                  R"({"actionType":"logReport","actionId":"\u009b",)"
                                  R"("actionParameters":[{"key":"reason\u0007","value":1},)"
                                  R"({"key":"reason\u0007","value":1}]})");
  EXPECT_GE(lines.size(), 5U);
  for (const std::string& line : lines) {
    for (const char c : line) EXPECT_GE(static_cast<unsigned char>(c), 0x20U) << line;
    EXPECT_EQ(line.find("\xC2\x9B"), std::string::npos) << line;
  }
}

}  // namespace
}  // namespace fleetpub::vda5050
