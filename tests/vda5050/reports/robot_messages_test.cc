#include "vda5050/reports/robot_messages.h"

#include <gmock/gmock.h>

namespace fleetpub::vda5050 {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

RobotState ParseState(std::string_view payload) {
  auto state = ReadState(payload);
  if (!state) throw std::runtime_error("no state");
  return std::move(*state);
}

TEST(ReadState, ReadsTheNamesUpTo21) {
  const auto state = ParseState(R"({
    "headerId": 7, "timestamp": "2026-01-02T03:04:05.678Z", "version": "2.1.0",
    "manufacturer": "KIT", "serialNumber": "0001", "orderId": "o1", "orderUpdateId": 2,
    "lastNodeId": "n1", "driving": true, "paused": false, "operatingMode": "AUTOMATIC",
    "batteryState": {"batteryCharge": 80.5, "charging": true},
    "agvPosition": {"x": 1, "y": -2.5, "theta": 0.5, "mapId": "hall", "positionInitialized": true},
    "actionStates": [{"actionId": "a1", "actionType": "logReport", "actionStatus": "FINISHED",
                      "resultDescription": "log-7.zip"}],
    "errors": [{"errorType": "noOrderToCancel", "errorLevel": "WARNING",
                "errorDescription": "none", "errorHint": "send one",
                "errorReferences": [{"referenceKey": "actionId", "referenceValue": "a1"}]}]})");
  EXPECT_EQ(state.header.header_id, 7U);
  EXPECT_EQ(state.header.timestamp, "2026-01-02T03:04:05.678Z");
  EXPECT_EQ(state.header.version, "2.1.0");
  EXPECT_EQ(state.header.manufacturer, "KIT");
  EXPECT_EQ(state.header.serial_number, "0001");
  EXPECT_EQ(state.order_id, "o1");
  EXPECT_EQ(state.order_update_id, 2U);
  EXPECT_EQ(state.last_node_id, "n1");
  EXPECT_EQ(state.driving, true);
  EXPECT_EQ(state.paused, false);
  EXPECT_EQ(state.operating_mode, "AUTOMATIC");
  EXPECT_EQ(state.battery_charge, 80.5);
  EXPECT_EQ(state.charging, true);
  ASSERT_TRUE(state.position);
  EXPECT_EQ(state.position->x, 1);
  EXPECT_EQ(state.position->y, -2.5);
  EXPECT_EQ(state.position->theta, 0.5);
  EXPECT_EQ(state.position->map_id, "hall");
  EXPECT_EQ(state.position->localized, true);
  ASSERT_THAT(state.action_states, SizeIs(1));
  EXPECT_EQ(state.action_states[0].type, "logReport");
  EXPECT_EQ(state.action_states[0].result, "log-7.zip");
  EXPECT_FALSE(state.has_instant_action_states);
  ASSERT_THAT(state.errors, SizeIs(1));
  EXPECT_EQ(state.errors[0].type, "noOrderToCancel");
  EXPECT_EQ(state.errors[0].level, "WARNING");
  EXPECT_EQ(state.errors[0].description, "none");
  EXPECT_EQ(state.errors[0].hint, "send one");
  ASSERT_THAT(state.errors[0].references, SizeIs(1));
  EXPECT_EQ(state.errors[0].references[0].key, "actionId");
  EXPECT_EQ(state.errors[0].references[0].value, "a1");
}

TEST(ReadState, ReadsTheNamesOf30) {
  const auto state = ParseState(R"({
    "powerSupply": {"stateOfCharge": 20, "charging": false},
    "mobileRobotPosition": {"x": 1, "y": 2, "theta": 3, "mapId": "m", "localized": false},
    "actionStates": [],
    "instantActionStates": [{"actionId": "a1", "actionStatus": "RETRIABLE", "actionResult": "r"}]})");
  EXPECT_EQ(state.battery_charge, 20);
  EXPECT_EQ(state.charging, false);
  ASSERT_TRUE(state.position);
  EXPECT_EQ(state.position->localized, false);
  EXPECT_TRUE(state.has_action_states);
  EXPECT_TRUE(state.has_instant_action_states);
  ASSERT_THAT(state.instant_action_states, SizeIs(1));
  EXPECT_EQ(state.instant_action_states[0].status, "RETRIABLE");
  EXPECT_EQ(state.instant_action_states[0].result, "r");
}

TEST(ReadState, TakesATranslationWhenThereIsNoText) {
  const auto state = ParseState(R"({"errors": [
    {"errorType": "E", "errorDescriptionTranslations": [
       {"translationKey": "de", "translationValue": "Kein Auftrag"},
       {"translationKey": "en", "translationValue": "no order"},
       {"translationKey": "fr", "translationValue": "pas de commande"}],
     "errorHintTranslations": [{"translationKey": "de", "translationValue": "Warten"}]},
    {"errorDescription": "own", "errorDescriptionTranslations": [
       {"translationKey": "en", "translationValue": "other"}]}]})");
  ASSERT_THAT(state.errors, SizeIs(2));
  EXPECT_EQ(state.errors[0].description, "no order");
  EXPECT_EQ(state.errors[0].hint, "Warten");
  EXPECT_EQ(state.errors[1].description, "own");
}

TEST(ReadState, TakesLowerCaseStatusesOf11) {
  const auto state =
      ParseState(R"({"actionStates": [{"actionId": "a", "actionStatus": "finished"}]})");
  EXPECT_EQ(state.action_states[0].status, "FINISHED");
}

TEST(ReadState, TakesNumbersAndTruthsInPlaceOfTexts) {
  const auto state = ParseState(R"({"headerId": "7", "paused": "TRUE", "orderId": 12,
    "batteryState": {"batteryCharge": "80"},
    "actionStates": [{"actionId": 4711, "actionStatus": "RUNNING", "resultDescription": true}],
    "errors": [{"errorReferences": [{"referenceKey": "headerId", "referenceValue": 18}]}]})");
  EXPECT_EQ(state.header.header_id, 7U);
  EXPECT_EQ(state.paused, true);
  EXPECT_EQ(state.order_id, "12");
  EXPECT_EQ(state.battery_charge, 80);
  EXPECT_EQ(state.action_states[0].id, "4711");
  EXPECT_EQ(state.action_states[0].result, "true");
  EXPECT_EQ(state.errors[0].references[0].value, "18");
}

class BrokenState : public ::testing::TestWithParam<std::string_view> {};

TEST_P(BrokenState, IsReadAsFarAsItGoes) {
  const auto state = ReadState(GetParam());
  ASSERT_TRUE(state);
  ASSERT_NE(FindActionState(*state, "a1"), nullptr);
  EXPECT_EQ(FindActionState(*state, "a1")->status, "FINISHED");
}

#define ENTRY R"({"actionId":"a1","actionStatus":"FINISHED"})"
INSTANTIATE_TEST_SUITE_P(
    Every, BrokenState,
    ::testing::Values(
        R"({"actionStates":[)" ENTRY R"(]})", R"({"actionStates":[null,3,"x",[],{},)" ENTRY R"(]})",
        R"({"actionStates":7,"instantActionStates":[)" ENTRY R"(]})",
        R"({"headerId":-1,"timestamp":5,"errors":{},"batteryState":[],"agvPosition":"?",)"
        R"("operatingMode":null,"paused":[],"actionStates":[)" ENTRY R"(]})",
        R"({"headerId":1e99,"orderUpdateId":1.5,"errors":[null,7,{"errorType":{},)"
        R"("errorReferences":[1,{}]}],"unknown":{"a":1},"actionStates":[)" ENTRY R"(]})",
        R"({"errors":[{"errorReferences":"x","errorHintTranslations":[1]}],)"
        R"("powerSupply":{"stateOfCharge":"full"},"actionStates":[)" ENTRY R"(]})"));

TEST(ReadState, IsNothingForWhatIsNoObject) {
  for (const std::string_view payload : {"", "x", "[]", "7", "null", "{", "{\"a\":1,}"}) {
    EXPECT_FALSE(ReadState(payload)) << payload;
    EXPECT_FALSE(ReadConnection(payload)) << payload;
    EXPECT_FALSE(ReadFactsheet(payload)) << payload;
  }
  EXPECT_FALSE(ReadState(std::string(100'000, '[')));
}

TEST(ReadState, KeepsWhatIsNotSaidApartFromFalse) {
  const auto state = ParseState("{}");
  EXPECT_EQ(state.paused, std::nullopt);
  EXPECT_EQ(state.charging, std::nullopt);
  EXPECT_EQ(state.battery_charge, std::nullopt);
  EXPECT_EQ(state.header.header_id, std::nullopt);
  EXPECT_FALSE(state.position);
  EXPECT_EQ(state.operating_mode, "");
}

bool IsBefore(std::string_view id_a, std::string_view time_a, std::string_view id_b,
              std::string_view time_b) {
  const auto header = [](std::string_view id, std::string_view time) {
    return ParseState(fmt::format(R"({{"headerId":{},"timestamp":{}}})", id, time)).header;
  };
  return vda5050::IsBefore(header(id_a, time_a), header(id_b, time_b));
}

TEST(IsBefore, WantsHeaderIdAndTimestampToSaySo) {
  constexpr std::string_view kNow = R"("2026-01-02T03:04:05.678Z")";
  constexpr std::string_view kEarlier = R"("2026-01-02T03:04:04.678Z")";
  EXPECT_TRUE(IsBefore("6", kEarlier, "7", kNow));
  EXPECT_TRUE(IsBefore("7", kEarlier, "7", kNow));
  EXPECT_TRUE(IsBefore("6", kNow, "7", kNow)) << "some write whole seconds";
  EXPECT_FALSE(IsBefore("7", kNow, "7", kNow));
  EXPECT_FALSE(IsBefore("0", kNow, "7", kEarlier)) << "restarted";
  EXPECT_FALSE(IsBefore("8", kEarlier, "7", kNow)) << "its clock was set back";
  EXPECT_FALSE(IsBefore("null", kEarlier, "7", kNow));
  EXPECT_FALSE(IsBefore("6", R"("yesterday")", "7", kNow));
  EXPECT_FALSE(IsBefore("6", kEarlier, "null", "null"));
}

TEST(IsBefore, ReadsWhatRobotsWrite) {
  EXPECT_TRUE(IsBefore("1767323044678", "1", "1767323045678", "2")) << "ids beyond 32 bits";
  for (const auto& [earlier, later] :
       {std::pair(R"("2026-01-02T03:04:04")", R"("2026-01-02T03:04:05")"),
        std::pair(R"("2026-01-02 03:04:04.1")", R"("2026-01-02 03:04:04.2")"),
        std::pair(R"("2026-01-02T03:04:04+0100")", R"("2026-01-02T03:04:04Z")"),
        std::pair("1767323044678", "1767323045678")}) {
    EXPECT_TRUE(IsBefore("6", earlier, "7", later)) << earlier;
    EXPECT_FALSE(IsBefore("6", later, "7", earlier)) << earlier;
  }
}

TEST(ReadState, ReadsWhatCanOnlyMeanOneThing) {
  const auto read = [](std::string_view payload) {
    const auto state = ReadState(payload);
    return state ? state->order_id + "/" + state->operating_mode : state.error().message;
  };
  EXPECT_EQ(read(std::string_view("{\"orderId\":\"o\"}\0\0\0", 16)), "o/");
  EXPECT_EQ(read("{\"orderId\":\"F\xFC\xDF\"}"), "F\uFFFD\uFFFD/");
  EXPECT_EQ(read(R"({"orderId":"o","orderId":"p","batteryState":{"batteryCharge":NaN}})"), "p/");
  for (const std::string_view payload :
       {R"([{"orderId":"o"}])", R"({"orderId":"o")", R"({"orderId":"o"} {})", "o"}) {
    EXPECT_FALSE(ReadState(payload)) << payload;
  }
}

TEST(FindActionState, LooksInBothArrays) {
  const auto state = ParseState(R"({"actionStates":[{"actionId":"a","actionStatus":"RUNNING"}],
    "instantActionStates":[{"actionId":"b","actionStatus":"WAITING"}]})");
  EXPECT_EQ(FindActionState(state, "a")->status, "RUNNING");
  EXPECT_EQ(FindActionState(state, "b")->status, "WAITING");
  EXPECT_EQ(FindActionState(state, "c"), nullptr);
}

TEST(FindActionState, TakesTheEntryThatHasComeFurthest) {
  // ros_amr_interop lists a repeated action a second time, WAITING for ever.
  const auto state = ParseState(R"({"actionStates":[{"actionId":"a","actionStatus":"FINISHED"},
    {"actionId":"a","actionStatus":"WAITING"},{"actionId":"a","actionStatus":"SLEEPING"}]})");
  EXPECT_EQ(FindActionState(state, "a")->status, "FINISHED");
}

TEST(FindActionState, TakesAFailureBeforeASuccess) {
  const auto state = ParseState(R"({"actionStates":[{"actionId":"a","actionStatus":"FINISHED"}],
    "instantActionStates":[{"actionId":"a","actionStatus":"failed"}]})");
  EXPECT_EQ(FindActionState(state, "a")->status, "FAILED");
}

TEST(FindActionState, PassesOverAnotherActionType) {
  const auto state = ParseState(
      R"({"actionStates":[{"actionId":"a","actionType":"pick","actionStatus":"FINISHED"}]})");
  EXPECT_EQ(FindActionState(state, "a", "drop"), nullptr);
  EXPECT_NE(FindActionState(state, "a", "pick"), nullptr);
}

TEST(OtherSender, IsNobodyWhereTheHeaderDoesNotSay) {
  const RobotAddress names[] = {{"KIT", "0001"}, {"KIT Robotics", "0001"}};
  const auto of = [&](std::string_view manufacturer, std::string_view serial) {
    MessageHeader header;
    header.manufacturer = manufacturer;
    header.serial_number = serial;
    return OtherSender(header, names);
  };
  for (const char* manufacturer : {"", "KIT", "kit", "KIT Robotics"}) {
    EXPECT_EQ(of(manufacturer, "0001"), "") << manufacturer;
    EXPECT_EQ(of(manufacturer, ""), "") << manufacturer;
  }
  EXPECT_EQ(of("", "0002"), "KIT/0002");
  EXPECT_EQ(of("ACME", ""), "ACME/0001");
}

TEST(ReadState, TellsWhyItCannotBeRead) {
  const std::string deep(100, '[');
  EXPECT_NE(ReadState(R"({"x":)" + deep).error().message.find("64 levels"), std::string::npos);
  const std::string large(std::size_t{17} << 20U, ' ');
  EXPECT_NE(ReadState("{" + large + "}").error().message.find("too large"), std::string::npos);
}

TEST(ReadConnection, NormalisesTheConnectionState) {
  const std::pair<std::string_view, std::string_view> cases[] = {
      {"ONLINE", "ONLINE"},
      {"online", "ONLINE"},
      {"CONNECTIONBROKEN", "CONNECTION_BROKEN"},
      {"connectionBroken", "CONNECTION_BROKEN"},
      {"CONNECTION_BROKEN", "CONNECTION_BROKEN"},
      {"Hibernating", "HIBERNATING"},
      {"DISCONNECTED", "OFFLINE"},
      {"SLEEPING", "SLEEPING"},
  };
  for (const auto& [text, normal] : cases) {
    const auto message = ReadConnection("{\"connectionState\":\"" + std::string(text) + "\"}");
    ASSERT_TRUE(message);
    EXPECT_EQ(message->connection_state, normal);
  }
  EXPECT_EQ(ReadConnection("{}")->connection_state, "");
}

TEST(ReadState, NormalisesTheOperatingMode) {
  const std::pair<std::string_view, std::string_view> cases[] = {
      {"automatic", "AUTOMATIC"},
      {"SEMI-AUTOMATIC", "SEMIAUTOMATIC"},
      {"SEMIAUTOMATIC", "SEMIAUTOMATIC"},
      {"TEACHIN", "TEACH_IN"},
      {"TEACHING", "TEACH_IN"},
      {"TEACH_IN", "TEACH_IN"},
      {"Party", "PARTY"},
      {"", ""},
  };
  for (const auto& [text, normal] : cases) EXPECT_EQ(NormalisedMode(text), normal) << text;
}

TEST(ReadFactsheet, ReadsTheNamesUpTo21) {
  const auto factsheet = ReadFactsheet(R"({
    "protocolLimits": {
      "maxStringLens": {"msgLen": 4096, "topicSerialLen": 20, "topicElemLen": 30, "idLen": 10,
                        "idNumericalOnly": true, "enumLen": 5},
      "maxArrayLens": {"instantActions": 1, "actions.actionsParameters": 4}},
    "protocolFeatures": {"agvActions": [{
      "actionType": "initPosition", "actionScopes": ["INSTANT", "node"],
      "actionParameters": [{"key": "x", "valueDataType": "float", "isOptional": false},
                           {"key": "y", "valueDataType": "FLOAT"}],
      "blockingTypes": ["none"]}]}})");
  ASSERT_TRUE(factsheet);
  EXPECT_EQ(factsheet->limits.message_length, 4096U);
  EXPECT_EQ(factsheet->limits.topic_serial_length, 20U);
  EXPECT_EQ(factsheet->limits.topic_element_length, 30U);
  EXPECT_EQ(factsheet->limits.id_length, 10U);
  EXPECT_TRUE(factsheet->limits.id_numerical_only);
  EXPECT_EQ(factsheet->limits.instant_actions, 1U);
  EXPECT_EQ(factsheet->limits.action_parameters, 4U);
  const auto* action = FindAction(*factsheet, "initPosition");
  ASSERT_NE(action, nullptr);
  EXPECT_THAT(action->scopes, ElementsAre("INSTANT", "NODE"));
  EXPECT_THAT(action->blocking_types, ElementsAre("NONE"));
  ASSERT_THAT(action->parameters, SizeIs(2));
  EXPECT_EQ(action->parameters[0].key, "x");
  EXPECT_EQ(action->parameters[0].value_type, "FLOAT");
  EXPECT_EQ(action->parameters[0].is_optional, false);
  EXPECT_EQ(action->parameters[1].is_optional, std::nullopt);
  EXPECT_EQ(FindAction(*factsheet, "initposition"), nullptr);
}

TEST(ReadFactsheet, ReadsTheNamesOf30) {
  const auto factsheet = ReadFactsheet(R"({
    "protocolLimits": {
      "maximumStringLengths": {"maximumMessageLength": 1, "maximumTopicSerialLength": 2,
        "maximumTopicElementLength": 3, "maximumIdLength": 4, "idNumericalOnly": false},
      "maximumArrayLengths": {"instantActions": 5, "actions.actionsParameters": 6}},
    "protocolFeatures": {"mobileRobotActions": [{"actionType": "beep"}]}})");
  ASSERT_TRUE(factsheet);
  EXPECT_EQ(factsheet->limits.message_length, 1U);
  EXPECT_EQ(factsheet->limits.topic_serial_length, 2U);
  EXPECT_EQ(factsheet->limits.topic_element_length, 3U);
  EXPECT_EQ(factsheet->limits.id_length, 4U);
  EXPECT_EQ(factsheet->limits.instant_actions, 5U);
  EXPECT_EQ(factsheet->limits.action_parameters, 6U);
  const auto* action = FindAction(*factsheet, "beep");
  ASSERT_NE(action, nullptr);
  EXPECT_THAT(action->scopes, IsEmpty());
  EXPECT_FALSE(action->has_parameters);
}

TEST(ReadFactsheet, TakesZeroAndNonsenseForNoLimit) {
  const auto factsheet = ReadFactsheet(R"({"protocolLimits": {
    "maxStringLens": {"msgLen": 0, "idLen": -1, "idNumericalOnly": "maybe"},
    "maxArrayLens": {"instantActions": 1e300}}, "protocolFeatures": []})");
  ASSERT_TRUE(factsheet);
  EXPECT_EQ(factsheet->limits.message_length, 0U);
  EXPECT_EQ(factsheet->limits.id_length, 0U);
  EXPECT_FALSE(factsheet->limits.id_numerical_only);
  EXPECT_EQ(factsheet->limits.instant_actions, 0U);
}

TEST(ReadState, ReadsSafetyPowerLoadsAndInformationOfEveryVersion) {
  const auto old = ParseState(R"({"safetyState": {"eStop": "autoAck", "fieldViolation": "true"},
    "batteryState": {"batteryVoltage": 24.5, "batteryHealth": "90", "reach": 1200},
    "loads": [{"loadId": "L", "loadType": "EPAL", "loadPosition": "fork", "weight": 3}],
    "informations": [{"infoType": "door", "infoLevel": "info", "infoDescription": "open",
      "infoReferences": [{"referenceKey": "k", "referenceValue": 7}]}]})");
  EXPECT_EQ(old.emergency_stop, "AUTOACK");
  EXPECT_EQ(old.field_violation, true);
  EXPECT_EQ(old.battery_voltage, 24.5);
  EXPECT_EQ(old.battery_health, 90);
  EXPECT_EQ(old.range, 1200);
  ASSERT_TRUE(old.loads);
  EXPECT_EQ(old.loads->at(0).position, "fork");
  EXPECT_EQ(old.loads->at(0).weight, 3);
  EXPECT_EQ(old.information.at(0).description, "open");
  EXPECT_EQ(old.information.at(0).references.at(0).value, "7");
  const auto now = ParseState(R"({"safetyState": {"activeEmergencyStop": "REMOTE"},
    "powerSupply": {"range": 5}, "information": [{"infoDescriptor": "shut"}],
    "zoneActionStates": [{"actionId": "z", "actionStatus": "RUNNING"}]})");
  EXPECT_EQ(now.emergency_stop, "REMOTE");
  EXPECT_EQ(now.field_violation, std::nullopt);
  EXPECT_EQ(now.range, 5);
  EXPECT_FALSE(now.loads) << "it cannot tell";
  EXPECT_EQ(now.information.at(0).description, "shut");
  EXPECT_THAT(now.zone_action_states, SizeIs(1));
}

TEST(ReadFactsheet, ReadsWhatTheRobotIsInTheNamesOfEveryVersion) {
  const auto old = ReadFactsheet(R"({"typeSpecification": {"seriesName": "S", "agvClass": "TUGGER",
      "agvKinematic": "OMNI", "maxLoadMass": 5}, "physicalParameters": {"speedMax": 2}})");
  const auto now = ReadFactsheet(R"({"typeSpecification": {"seriesName": "S",
      "mobileRobotClass": "TUGGER", "mobileRobotKinematics": "OMNI", "maximumLoadMass": 5},
      "physicalParameters": {"maximumSpeed": 2}})");
  EXPECT_EQ(old->specification, now->specification);
  EXPECT_EQ(now->specification.robot_class, "TUGGER");
  EXPECT_EQ(now->specification.maximum_speed, 2);
}

TEST(ToOneLine, KeepsTheWordsOfTheRobot) {
  EXPECT_EQ(ToOneLine(R"({"x": 1.50})"), R"({"x": 1.50})");
  EXPECT_EQ(ToOneLine("{\n\"x\": 2}"), R"({"x":2})");
  EXPECT_EQ(ToOneLine("[1]"), "");
  EXPECT_EQ(ToOneLine("{"), "");
}

TEST(Shown, IsPrintableAndShort) {
  EXPECT_EQ(Shown("fine"), "fine");
  EXPECT_EQ(Shown("a\x1b[2J\nb"), "a\\x1b[2J\\nb");
  EXPECT_EQ(Shown("abcdef", 3), "abc…");
  EXPECT_EQ(Shown("äöü", 3), "ä…");  // never half a character
}

}  // namespace
}  // namespace fleetpub::vda5050
