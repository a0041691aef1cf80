// Robots as others build them, played by hand: their words are read as far as they have a meaning,
// and prove no more than they say.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

class RobotsAsBuilt : public EndToEnd {
 protected:
  // Publishes what the robot says, byte for byte.
  void Say(const std::string& topic, const std::string& payload, bool retained = false) const {
    Command command{.arguments = {"mosquitto_pub", "-p", std::to_string(broker_.port()), "-t",
                                  kBase + topic, "-q", "1", "-s"},
                    .input = payload};
    if (retained) command.arguments.emplace_back("-r");
    ASSERT_EQ(testing::Run(command).exit_code, 0);
  }
  void Connect(std::string_view state = "ONLINE") const {
    Say("connection", fmt::format(R"({{{},"connectionState":"{}"}})", kHeader, state), true);
  }
  // Commands the robot; returns once it has left.
  std::unique_ptr<Process> Start(std::vector<std::string> arguments) const {
    for (const char* argument : {"--debug", "--no-check"}) arguments.emplace_back(argument);
    auto run = std::make_unique<Process>(operator_.Prepare(std::move(arguments)));
    EXPECT_TRUE(run->AwaitErrors("-> PUBLISH")) << run->Errors();
    return run;
  }
  std::unique_ptr<Process> Pause(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments = {"pause",  "RIG/7", "--vda", "2.1",
                                          "--wait", "--id",  "p-1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Start(std::move(arguments));
  }
  static std::string Listed(std::string_view status, std::string_view more = "") {
    return fmt::format(R"({{{},"actionStates":[{{"actionId":"p-1","actionStatus":"{}"}}]{}}})",
                       kHeader, status, more);
  }
  static std::string Order(int update_id) {
    return fmt::format(R"({{"orderId":"o-1","orderUpdateId":{},"nodes":[
        {{"nodeId":"a","sequenceId":0,"released":true,"actions":[]}},
        {{"nodeId":"b","sequenceId":2,"released":true,"actions":[]}}],"edges":[
        {{"edgeId":"ab","sequenceId":1,"released":true,"startNodeId":"a","endNodeId":"b",
          "actions":[]}}]}})",
                       update_id);
  }
  std::unique_ptr<Process> SendOrder(int update_id, std::vector<std::string> more) const {
    std::vector<std::string> arguments = {
        "publish", "order",
        "RIG/7",   "--vda",
        "2.1",     "--wait",
        "-f",      operator_.home().Write("order.json", Order(update_id)).string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Start(std::move(arguments));
  }

  static constexpr std::string_view kHeader = R"("version":"2.1.0","manufacturer":"RIG")";
  const std::string kBase = "uagv/v2/RIG/7/";
};

TEST_F(RobotsAsBuilt, AreReadWhereTheirWordsHaveOneMeaning) {
  const std::string odd[] = {Listed("FINISHED") + std::string(3, '\0'),
                             Listed("FINISHED", R"(,"batteryState":{"x":-nan})"),
                             Listed("FINISHED",
                                    ",\"x\":\"M\xFC"
                                    "hle\t\""),
                             Listed("FINISHED", R"(,"paused":1,"paused":true)")};
  for (const std::string& state : odd) {
    const auto run = Pause({"-W", "60s"});
    Say("state", state);
    EXPECT_EQ(run->Wait(), 0) << run->Output();
  }
}

TEST_F(RobotsAsBuilt, AreNotCalledSilentNorAskedTwiceWhenTheyCannotBeRead) {
  const Subscriber subscriber(broker_, kBase + "instantActions");
  const auto run = Pause({"-W", "3s", "--resend", "2"});
  Say("state", "[" + Listed("RUNNING") + "]");
  Say("state", Listed("RUNNING").substr(1));
  EXPECT_EQ(run->Wait(), 6);
  EXPECT_THAT(run->Output(),
              AllOf(HasSubstr("2 of its messages"), Not(HasSubstr("no state since"))));
  EXPECT_THAT(subscriber.SoFar(), SizeIs(1));
}

TEST_F(RobotsAsBuilt, ProveNothingByAStateThatComesLate) {
  const auto run = Pause({"-W", "60s"});
  const auto say = [&](int id, std::string_view entries) {
    Say("state", fmt::format(R"({{{},"headerId":{},"timestamp":"2026-01-02T03:04:05",)"
                             R"("actionStates":[{}]}})",
                             kHeader, id, entries));
  };
  say(41, R"({"actionId":"p-1","actionStatus":"RUNNING"})");
  say(40, "");
  say(42, R"({"actionId":"p-1","actionStatus":"FINISHED"})");
  EXPECT_EQ(run->Wait(), 0) << run->Output();
}

TEST_F(RobotsAsBuilt, DoNoOrderAgainThatTheyHaveDone) {
  const auto run = SendOrder(0, {"--wait-for", "finished", "-W", "2s"});
  Say("state", fmt::format(R"({{{},"orderId":"o-1","orderUpdateId":0,"nodeStates":[],)"
                           R"("edgeStates":[],"lastNodeId":"b","lastNodeSequenceId":2}})",
                           kHeader));
  EXPECT_EQ(run->Wait(), 6);
  EXPECT_THAT(run->Output(), HasSubstr("TIMEOUT"));
}

TEST_F(RobotsAsBuilt, AreHeardAtOnceWhenAnOrderGoesWrong) {
  const auto run = SendOrder(0, {"--wait-for", "finished", "-W", "60s"});
  const auto say = [&](std::string_view left, std::string_view errors) {
    Say("state", fmt::format(R"({{{},"orderId":"o-1","orderUpdateId":0,"nodeStates":[{}],)"
                             R"("edgeStates":[],"lastNodeId":"b","lastNodeSequenceId":2,)"
                             R"("errors":[{}]}})",
                             kHeader, left, errors));
  };
  say(R"({"nodeId":"b","sequenceId":2})", "");
  say(R"({"nodeId":"b","sequenceId":2})",
      R"({"errorType":"wheelLost","errorLevel":"FATAL","errorReferences":[
          {"referenceKey":"orderId","referenceValue":"o-1"}]})");
  EXPECT_TRUE(run->AwaitErrors("RIG/7: wheelLost")) << "before the end: " << run->Errors();
  EXPECT_EQ(run->Output(), "");
  say("", "");
  EXPECT_EQ(run->Wait(), 0) << run->Output();
}

TEST_F(RobotsAsBuilt, RefuseAnUpdateThatIsLowerThanTheirs) {
  constexpr std::string_view kState =
      R"({{{},"orderId":"o-1","orderUpdateId":6,"errors":[{{"errorType":"tooOld","errorReferences":[{}]}}]}})";
  auto run = SendOrder(4, {"-W", "60s"});
  Say("state", fmt::format(kState, kHeader,
                           R"({"referenceKey":"orderId","referenceValue":"o-1"},
                     {"referenceKey":"newUpdate.orderUpdateId","referenceValue":"4"},
                     {"referenceKey":"own.orderUpdateId","referenceValue":"6"})"));
  EXPECT_EQ(run->Wait(), 5) << run->Output();
  run = SendOrder(4, {"-W", "2s"});
  Say("state", fmt::format(kState, kHeader, ""));
  EXPECT_EQ(run->Wait(), 6) << run->Output();
  EXPECT_THAT(run->Output(), AllOf(HasSubstr("possibly related"), HasSubstr("tooOld")));
}

TEST_F(RobotsAsBuilt, AreNotJudgedByAStateOfYesterday) {
  Connect("online");
  Say("state", fmt::format(R"({{{},"paused":true}})", kHeader), true);
  const std::vector<std::string> command = {"cancel",       "RIG/*", "--where", "paused=true",
                                            "--state-wait", "300ms", "--yes"};
  EXPECT_EQ(Fleetpub(command).exit_code, 7);
  const auto fleet = Json(Fleetpub({"fleet", "--state-wait", "200ms", "-o", "json"}).output);
  EXPECT_TRUE(fleet["paused"].IsNull());
  EXPECT_STREQ(fleet["connectionState"].GetString(), "ONLINE");
  EXPECT_EQ(Fleetpub({"await", "RIG/7", "connection", "connectionState=ONLINE"}).exit_code, 0);
}

TEST_F(RobotsAsBuilt, ThatAreOfflineAreSoHoweverTheyAreNamed) {
  Connect("OFFLINE");
  for (const char* target : {"RIG/7", "RIG/*"}) {
    const auto run = [&](const char* action) {
      return Fleetpub({action, target, "--vda", "auto", "--wait", "-o", "json"});
    };
    const Finished refused = run("resume");
    EXPECT_EQ(refused.exit_code, 7) << target << refused.errors;
    const auto none = Json(Lines(refused.output).at(0));
    EXPECT_STREQ(none["status"].GetString(), "OFFLINE");
    EXPECT_FALSE(none.HasMember("headerId"));
    const Finished pause = run("pause");
    EXPECT_EQ(pause.exit_code, 6) << target << pause.errors;
    const auto sent = Json(Lines(pause.output).at(0));
    EXPECT_STREQ(sent["status"].GetString(), "OFFLINE");
    EXPECT_TRUE(sent.HasMember("headerId"));
    EXPECT_LT(sent["elapsedMs"].GetDouble(), 15'000) << "nobody waits for it";
  }
}

TEST_F(RobotsAsBuilt, OfTheOtherKeyAreAskedUnderItButNotMovedByIt) {
  const auto keys = [&](std::vector<std::string> arguments) {
    const Subscriber subscriber(broker_, kBase + "instantActions");
    for (const char* more : {"RIG/7", "--wait", "-W", "4s", "--resend", "1", "--id", "p-1"}) {
      arguments.emplace_back(more);
    }
    const auto run = Start(std::move(arguments));
    std::string found;
    for (const auto& message : subscriber.Await(2)) {
      found += Json(message.payload).HasMember("actions") ? "actions " : "instantActions ";
    }
    Say("state", Listed("FINISHED"));
    EXPECT_EQ(run->Wait(), 0) << run->Output() << run->Errors();
    return found;
  };
  EXPECT_EQ(keys({"stateRequest", "--vda", "2.0"}), "actions instantActions ");
  EXPECT_EQ(keys({"stateRequest", "--vda", "2.0", "--actions-key", "actions"}), "actions actions ");
  EXPECT_EQ(keys({"stateRequest", "--vda", "2.1"}), "actions actions ");
  EXPECT_EQ(keys({"pause", "--vda", "2.0"}), "actions actions ");
}

TEST_F(RobotsAsBuilt, ThatAreFoundTwiceAreNamedTwice) {
  Connect();
  ASSERT_EQ(testing::Run({.arguments = {"mosquitto_pub", "-p", std::to_string(broker_.port()), "-r",
                                        "-t", "vda5050/v3/RIG/7/connection", "-m",
                                        R"({"version":"3.0.0","connectionState":"ONLINE"})"}})
                .exit_code,
            0);
  const Finished run = Fleetpub({"pause", "RIG/*", "--yes"});
  EXPECT_THAT(run.errors, AllOf(HasSubstr("uagv/v2/RIG/7"), HasSubstr("vda5050/v3/RIG/7")));
  const Finished unchecked = Fleetpub({"pause", "RIG/*", "--yes", "--no-check"});
  EXPECT_THAT(unchecked.errors, AllOf(HasSubstr("uagv/v2/RIG/7"), HasSubstr("vda5050/v3/RIG/7")));
  const Finished fleet = Fleetpub({"fleet", "--state-wait", "100ms"});
  EXPECT_THAT(fleet.errors, AllOf(HasSubstr("uagv/v2"), HasSubstr("vda5050/v3")));
}

TEST_F(RobotsAsBuilt, WhoseVersionIsNoReleaseAreToldOf) {
  ASSERT_EQ(testing::Run({.arguments = {"mosquitto_pub", "-p", std::to_string(broker_.port()), "-r",
                                        "-t", kBase + "connection", "-m",
                                        R"({"version":"1.4.7","connectionState":"ONLINE"})"}})
                .exit_code,
            0);
  for (const char* check : {"--check", "--no-check"}) {
    const Finished run = Fleetpub({"pause", "RIG/7", "--vda", "auto", check, "-o", "json"});
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(run.errors, AllOf(HasSubstr("1.4.7"), HasSubstr("2.1.0")));
    EXPECT_STREQ(Json(run.output)["version"].GetString(), "2.1.0");
  }
  EXPECT_THAT(Fleetpub({"pause", "RIG/7", "--vda", "2.1.6", "--check"}).errors, HasSubstr("1.4.7"));
}

}  // namespace
}  // namespace fleetpub::testing
