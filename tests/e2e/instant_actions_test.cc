// Commands from the command line to an independent subscriber.
#include <gmock/gmock.h>

#include "base/time.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::SizeIs;
using ::testing::StartsWith;

class InstantActions : public EndToEnd {};

TEST_F(InstantActions, PausesARobot) {
  const Subscriber subscriber(broker_);
  const Finished run = Send({"pause", "KIT/0001"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, MatchesRegex("KIT/0001  startPause  SENT  [0-9.]+ m?s\n"));
  const auto messages = subscriber.Await(1);
  ASSERT_THAT(messages, SizeIs(1));
  EXPECT_EQ(messages[0].topic, "vda5050/v3/KIT/0001/instantActions");
  const auto message = Json(messages[0].payload);
  EXPECT_EQ(message["headerId"].GetInt(), 0);
  EXPECT_STREQ(message["version"].GetString(), "3.0.0");
  EXPECT_STREQ(message["actions"][0]["actionType"].GetString(), "startPause");
  EXPECT_STREQ(message["actions"][0]["blockingType"].GetString(), "NONE");
  EXPECT_TRUE(base::ParseDateTime(message["timestamp"].GetString()).has_value());
}

TEST_F(InstantActions, NeverRetains) {
  EXPECT_EQ(Send({"pause", "KIT/0001", "-q", "1"}).exit_code, 0);
  const Subscriber late(broker_);
  EXPECT_EQ(Send({"resume", "KIT/0001", "-q", "1"}).exit_code, 0);
  const auto messages = late.Await(1);
  ASSERT_THAT(messages, SizeIs(1));
  EXPECT_FALSE(messages[0].retained);
  EXPECT_THAT(messages[0].payload, HasSubstr("stopPause"));
}

TEST_F(InstantActions, SendsNumbersAsNumbersAndNegativeOnes) {
  const Subscriber subscriber(broker_);
  const Finished run = Send({"initPosition", "KIT/0001", "--x", "1.5", "--y", "-2", "--theta",
                             "0.5", "--mapId", "hall-1", "--last-node-id", "n1", "--vda", "2.1"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_EQ(run.errors, "");
  const auto messages = subscriber.Await(1);
  ASSERT_THAT(messages, SizeIs(1));
  EXPECT_EQ(messages[0].topic, "uagv/v2/KIT/0001/instantActions");
  EXPECT_THAT(messages[0].payload,
              HasSubstr(R"("actionParameters":[{"key":"x","value":1.5},{"key":"y","value":-2},)"
                        R"({"key":"theta","value":0.5},{"key":"mapId","value":"hall-1"},)"
                        R"({"key":"lastNodeId","value":"n1"}])"));
}

TEST_F(InstantActions, SendsAManufacturersOwnActionToSeveralRobots) {
  const Subscriber subscriber(broker_);
  const Finished run =
      Send({"action", "beep", "-P", "duration:=3", "KIT/0001", "-P", "mode=loud", "KIT/0002"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(Lines(run.output), SizeIs(2));
  const auto messages = subscriber.Await(2);
  ASSERT_THAT(messages, SizeIs(2));
  EXPECT_EQ(messages[0].topic, "vda5050/v3/KIT/0001/instantActions");
  EXPECT_EQ(messages[1].topic, "vda5050/v3/KIT/0002/instantActions");
  for (const auto& message : messages) {
    EXPECT_THAT(message.payload,
                HasSubstr(R"([{"key":"duration","value":3},{"key":"mode","value":"loud"}])"));
  }
  EXPECT_NE(std::string(Json(messages[0].payload)["actions"][0]["actionId"].GetString()),
            Json(messages[1].payload)["actions"][0]["actionId"].GetString());
}

TEST_F(InstantActions, CountsHeaderIdsPerTopic) {
  const Subscriber subscriber(broker_);
  for (const char* robot : {"KIT/0001", "KIT/0001", "KIT/0002", "KIT/0001"}) {
    EXPECT_EQ(Send({"pause", robot}).exit_code, 0);
  }
  const auto messages = subscriber.Await(4);
  ASSERT_THAT(messages, SizeIs(4));
  const std::vector<int> expected = {0, 1, 0, 2};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(Json(messages[i].payload)["headerId"].GetInt(), expected[i]);
  }
}

TEST_F(InstantActions, IsAcknowledgedAtQos1And2OverBothVersionsOfMqtt) {
  const Subscriber subscriber(broker_, "#", 2);
  for (const char* version : {"3.1.1", "5"}) {
    for (const char* qos : {"1", "2"}) {
      const Finished run = Send({"pause", "KIT/0001", "-q", qos, "-V", version});
      EXPECT_EQ(run.exit_code, 0) << run.errors;
      EXPECT_THAT(run.output, HasSubstr("PUBLISHED"));
    }
  }
  const auto messages = subscriber.Await(4);
  ASSERT_THAT(messages, SizeIs(4));
  EXPECT_EQ(messages[0].qos, 1);
  EXPECT_EQ(messages[3].qos, 2);
}

TEST_F(InstantActions, SendsMqtt5PropertiesAlongWithEachMessage) {
  Process subscriber(
      {.arguments = {"stdbuf", "-oL", "mosquitto_sub", "-h", "127.0.0.1", "-p",
                     std::to_string(broker_.port()), "-V", "5", "-t", "#", "-F", "%E [%P]", "-d"}});
  ASSERT_TRUE(subscriber.AwaitOutput("SUBACK"));
  const Finished run =
      Send({"pause", "KIT/0001", "KIT/0002", "-V", "5", "--user-property", "desk=night shift",
            "--user-property", "ticket=a=b", "--message-expiry", "90s"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  ASSERT_TRUE(subscriber.AwaitOutput("90 [desk:night shift ticket:a=b]\n"));
}

TEST_F(InstantActions, TellsAScriptEverythingInJson) {
  const Finished run = Send({"pause", "KIT/0001", "-o", "json", "--id", "a-1", "--vda", "2"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  const auto result = Json(run.output);
  EXPECT_STREQ(result["target"].GetString(), "KIT/0001");
  EXPECT_STREQ(result["protocol"].GetString(), "vda5050");
  EXPECT_STREQ(result["version"].GetString(), "2.1.0");
  EXPECT_STREQ(result["topic"].GetString(), "uagv/v2/KIT/0001/instantActions");
  EXPECT_STREQ(result["actions"][0]["type"].GetString(), "startPause");
  EXPECT_STREQ(result["actions"][0]["id"].GetString(), "a-1");
  EXPECT_EQ(result["headerId"].GetInt(), 0);
  EXPECT_STREQ(result["status"].GetString(), "SENT");
  EXPECT_GT(result["elapsedMs"].GetDouble(), 0);
  EXPECT_FALSE(result.HasMember("versionAssumed"));
}

TEST_F(InstantActions, IsQuietWhenAsked) {
  const Finished run = Send({"pause", "KIT/0001", "--quiet"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.output + run.errors, "");
}

TEST_F(InstantActions, ADryRunSendsNothingAndUsesNoHeaderId) {
  const Subscriber subscriber(broker_);
  const Finished text = Send({"cancelOrder", "KIT/0001", "--vda", "2.1", "--dry-run"});
  EXPECT_EQ(text.exit_code, 0) << text.errors;
  EXPECT_THAT(text.output, StartsWith(R"({"headerId":0,"timestamp":")"));
  EXPECT_FALSE(std::filesystem::exists(operator_.LedgerPath()));
  const Finished json =
      Send({"cancelOrder", "KIT/0001", "--vda", "2.1", "--dry-run", "-o", "json"});
  const auto result = Json(json.output);
  EXPECT_STREQ(result["status"].GetString(), "DRY_RUN");
  EXPECT_STREQ(result["payload"]["actions"][0]["actionType"].GetString(), "cancelOrder");
  EXPECT_EQ(Send({"pause", "KIT/0001", "--vda", "2.1"}).exit_code, 0);
  const auto messages = subscriber.Await(1);
  ASSERT_THAT(messages, SizeIs(1));
  EXPECT_THAT(messages[0].payload, HasSubstr("startPause"));
  EXPECT_EQ(Json(messages[0].payload)["headerId"].GetInt(), 0);
}

TEST_F(InstantActions, ADryRunNeedsNoBroker) {
  operator_.UseBroker("mqtt://127.0.0.1:1");
  EXPECT_EQ(Send({"pause", "KIT/0001", "-n"}).exit_code, 0);
  EXPECT_EQ(Fleetpub({"pause", "KIT/0001", "-n", "--offline"}).exit_code, 0);
}

TEST_F(InstantActions, HeedsARobotsQuirks) {
  const Subscriber subscriber(broker_);
  const Finished run = Fleetpub(
      {"pause", "KIT/0001", "--vda", "2.0", "--actions-key", "instantActions", "--header-version",
       "v2", "--header-manufacturer", "Other", "--header-serial", "9", "--interface", "site"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  const auto messages = subscriber.Await(1);
  ASSERT_THAT(messages, SizeIs(1));
  EXPECT_EQ(messages[0].topic, "site/v2/KIT/0001/instantActions");
  const auto message = Json(messages[0].payload);
  EXPECT_TRUE(message.HasMember("instantActions"));
  EXPECT_STREQ(message["version"].GetString(), "v2");
  EXPECT_STREQ(message["manufacturer"].GetString(), "Other");
  EXPECT_STREQ(message["serialNumber"].GetString(), "9");
}

TEST_F(InstantActions, TakesAHeaderIdAboveTheLastOneOnly) {
  EXPECT_EQ(Send({"pause", "KIT/0001", "--header-id", "17"}).exit_code, 0);
  const Finished again = Send({"pause", "KIT/0001", "--header-id", "17"});
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_THAT(again.output, HasSubstr("17"));
  EXPECT_EQ(Json(Send({"pause", "KIT/0001", "-o", "json"}).output)["headerId"].GetInt(), 18);
}

TEST_F(InstantActions, ReadsTheBrokerFromHostAndPort) {
  operator_.UseBroker("");
  const Finished run =
      Send({"pause", "KIT/0001", "--host", "127.0.0.1", "-p", std::to_string(broker_.port())});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
}

TEST_F(InstantActions, IgnoresProxyVariables) {
  Command command = operator_.Prepare(WithoutLook({"pause", "KIT/0001"}));
  for (const char* name : {"http_proxy", "https_proxy", "HTTP_PROXY", "ALL_PROXY"}) {
    command.environment.emplace_back(name, "http://127.0.0.1:1");
  }
  EXPECT_EQ(testing::Run(command).exit_code, 0);
}

}  // namespace
}  // namespace fleetpub::testing
