// `fleet`, `watch` and `await` with virtual robots.
#include <gmock/gmock.h>

#include <thread>

#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::StartsWith;

class FleetWatchAwait : public EndToEnd {
 protected:
  // Robots that are online when this returns.
  std::unique_ptr<Process> Simulate(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "simulate");
    auto robots = Start(std::move(arguments));
    EXPECT_TRUE(robots->AwaitErrors("online at")) << robots->Errors();
    return robots;
  }
  std::unique_ptr<Process> Start(std::vector<std::string> arguments) {
    return std::make_unique<Process>(operator_.Prepare(std::move(arguments)));
  }
};

// ── await ──

TEST_F(FleetWatchAwait, AwaitsWhatAnotherProcessBringsAbout) {
  const auto robot = Simulate({"KIT/0001", "--state-interval", "200ms"});
  const auto waiting =
      Start({"await", "KIT/0001", "state", "paused=true", "battery>50", "-W", "60s", "-o", "json"});
  ASSERT_TRUE(broker_.AwaitSubscription("+/+/KIT/0001/state (QoS 0)"));
  EXPECT_FALSE(waiting->Wait(std::chrono::milliseconds(400)));
  EXPECT_EQ(Fleetpub({"pause", "KIT/0001"}).exit_code, 0);
  EXPECT_EQ(waiting->Wait(), 0) << waiting->Errors();
  const auto message = Json(waiting->Output());
  EXPECT_TRUE(message["paused"].GetBool());
  EXPECT_STREQ(message["serialNumber"].GetString(), "0001");
}

TEST_F(FleetWatchAwait, AwaitsWithARetainedMessageOfAnyVersion) {
  const auto robot = Simulate({"KIT/0001", "--vda", "2.0"});
  const Finished run =
      Fleetpub({"await", "KIT/0001", "connection", "connectionState=ONLINE", "-W", "60s"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, StartsWith("KIT/0001  connection: connectionState=ONLINE  after "));
  EXPECT_THAT(Lines(run.output), SizeIs(1));
  EXPECT_THAT(
      Fleetpub({"await", "KIT/0001", "connection", "connectionState=ONLINE", "--print"}).output,
      AllOf(StartsWith("{"), HasSubstr(R"("connectionState":"ONLINE")")));
  EXPECT_EQ(Fleetpub({"await", "KIT/0001", "factsheet", "version=2.0.0", "--vda", "2", "-W", "60s"})
                .exit_code,
            0);
  const Finished other = Fleetpub(
      {"await", "KIT/0001", "connection", "connectionState=ONLINE", "--vda", "3", "-W", "300ms"});
  EXPECT_EQ(other.exit_code, 6);
  EXPECT_THAT(other.errors, HasSubstr("KIT/0001: no connection message came within 300 ms"));
}

TEST_F(FleetWatchAwait, TellsWhatTheLastMessageSaidWhenTimeIsUp) {
  const auto robot = Simulate({"KIT/0001", "--state-interval", "100ms"});
  const Finished run = Fleetpub({"await", "KIT/0001", "state", "paused=true", "driving=false",
                                 "operatingMode=MANUAL", "/a/b=1", "-W", "500ms"});
  EXPECT_EQ(run.exit_code, 6);
  EXPECT_THAT(run.output, IsEmpty());
  EXPECT_THAT(run.errors, AllOf(HasSubstr("500 ms"), HasSubstr("paused is false"),
                                HasSubstr(R"(operatingMode is "AUTOMATIC")"), HasSubstr("/a/b")));
}

TEST_F(FleetWatchAwait, RefusesConditionsThatCannotBeMeant) {
  const std::pair<const char*, const char*> cases[] = {
      {"paused", "quotation marks"}, {"=1", "names no member"}, {"/a~2=1", "JSON Pointer"}};
  for (const auto& [condition, reason] : cases) {
    const Finished run = Fleetpub({"await", "KIT/0001", "state", condition});
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.errors, HasSubstr(reason));
  }
  EXPECT_EQ(Fleetpub({"await", "KIT/0001", "state"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"await", "KIT", "state", "a=1"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"await", "KIT/0001", "sta+te", "a=1"}).exit_code, 2);
  EXPECT_THAT(Fleetpub({"await", "KIT/0001", "sate", "a=1", "-W", "10ms"}).errors,
              HasSubstr("did you mean state?"));
}

TEST_F(FleetWatchAwait, AwaitsThroughARestartOfTheBroker) {
  const auto waiting = Start({"await", "KIT/0001", "state", "paused=true", "-W", "60s"});
  ASSERT_TRUE(broker_.AwaitSubscription("KIT/0001/state"));
  broker_.Kill();
  ASSERT_TRUE(waiting->AwaitErrors("connecting again"));
  broker_.Restart();
  ASSERT_TRUE(waiting->AwaitErrors("connected again")) << waiting->Errors();
  const auto robot = Simulate({"KIT/0001"});
  EXPECT_EQ(Fleetpub({"pause", "KIT/0001"}).exit_code, 0);
  EXPECT_EQ(waiting->Wait(), 0) << waiting->Errors();
}

TEST_F(FleetWatchAwait, SaysThatTheBrokerIsNotThere) {
  operator_.UseBroker("mqtt://127.0.0.1:1");
  for (const auto& arguments : std::vector<std::vector<std::string>>{
           {"await", "KIT/0001", "state", "a=1", "-W", "300ms"}, {"fleet"}, {"watch"}}) {
    EXPECT_EQ(Fleetpub(arguments).exit_code, 4) << arguments.front();
  }
}

// ── fleet ──

TEST_F(FleetWatchAwait, ShowsTheFleet) {
  const auto old =
      Simulate({"ACME/7", "--vda", "1.1", "--mode", "MANUAL", "--state-interval", "100ms"});
  const auto robots = Simulate({"KIT/0001", "--count", "2", "--state-interval", "100ms"});
  const Finished run = Fleetpub({"fleet"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  const auto lines = Lines(run.output);
  ASSERT_THAT(lines, SizeIs(4));
  EXPECT_THAT(lines[0], StartsWith("TARGET    VERSION  CONNECTION  SINCE"));
  EXPECT_THAT(lines[1], AllOf(StartsWith("ACME/7    1.1.0    ONLINE"), HasSubstr("MANUAL")));
  EXPECT_THAT(lines[2], AllOf(StartsWith("KIT/0001  3.0.0    ONLINE"), HasSubstr("80%")));
  EXPECT_THAT(run.errors, IsEmpty());
}

TEST_F(FleetWatchAwait, ShowsTheRobotsOfAPatternAsJson) {
  EXPECT_EQ(testing::Run({.arguments = {"mosquitto_pub", "-p", std::to_string(broker_.port()), "-r",
                                        "-t", "uagv/v2/KIT/0002/connection", "-m",
                                        R"({"version":"2.1.0","connectionState":"OFFLINE"})"}})
                .exit_code,
            0);
  const auto online = Simulate({"KIT/0010", "--with-order", "--state-interval", "100ms"});
  const auto lines = Lines(Fleetpub({"fleet", "*/00?[", "-o", "json"}).output);
  ASSERT_THAT(lines, SizeIs(1));
  EXPECT_EQ(Json(lines[0])["error"]["exitCode"].GetInt(), 7);
  const auto some = Lines(Fleetpub({"fleet", "K*/001?", "-o", "json"}).output);
  ASSERT_THAT(some, SizeIs(1));
  const auto robot = Json(some[0]);
  EXPECT_STREQ(robot["target"].GetString(), "KIT/0010");
  EXPECT_STREQ(robot["connectionState"].GetString(), "ONLINE");
  EXPECT_FALSE(std::string(robot["orderId"].GetString()).empty());
  EXPECT_TRUE(robot["errors"].IsArray());
  const auto gone = Json(Lines(Fleetpub({"fleet", "KIT/0002", "-o", "json"}).output).at(0));
  EXPECT_STREQ(gone["version"].GetString(), "2.1.0");
  EXPECT_STREQ(gone["connectionState"].GetString(), "OFFLINE");
  EXPECT_TRUE(gone["paused"].IsNull());
}

TEST_F(FleetWatchAwait, WarnsOfRobotsThatKeepTheirStateToThemselves) {
  const auto robot = Simulate({"KIT/0001", "--silent"});
  const Finished run = Fleetpub({"fleet", "--state-wait", "400ms"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.errors, HasSubstr("1 of 1 robot sent no state within 400 ms"));
  EXPECT_THAT(Fleetpub({"fleet", "--state-wait", "0", "--discover", "100"}).errors, IsEmpty());
}

TEST_F(FleetWatchAwait, SaysThatThereIsNobody) {
  const Finished all = Fleetpub({"fleet"});
  EXPECT_EQ(all.exit_code, 7);
  EXPECT_THAT(all.errors, HasSubstr("knows no robot: "));
  const Finished some = Fleetpub({"fleet", "KIT/*", "-o", "json"});
  EXPECT_EQ(some.exit_code, 7);
  EXPECT_THAT(Json(some.output)["error"]["message"].GetString(),
              HasSubstr("knows no robot KIT/*: "));
  EXPECT_THAT(some.errors, HasSubstr("knows no robot KIT/*: "));
  EXPECT_EQ(Fleetpub({"fleet", "KIT"}).exit_code, 2);
}

// Three robots that are played by hand: in trouble, well, and gone for long.
class FleetInTrouble : public FleetWatchAwait {
 protected:
  FleetInTrouble() {
    Connect("0001", "ONLINE");
    Connect("0002", "ONLINE");
    Connect("0009", "OFFLINE");
  }
  void Connect(const std::string& serial, const std::string& state) const {
    Say("vda5050/v3/KIT/" + serial + "/connection",
        R"({"headerId":1,"timestamp":"2020-01-02T03:04:05.000Z","version":"3.0.0",)"
        R"("connectionState":")" +
            state + "\"}",
        true);
  }
  // Runs it, while the living say how they are again and again.
  Finished Look(std::vector<std::string> arguments) const {
    Process run(operator_.Prepare(std::move(arguments)));
    do {
      Say("vda5050/v3/KIT/0001/state",
          R"({"version":"3.0.0","operatingMode":"AUTOMATIC","paused":false,)"
          R"("powerSupply":{"stateOfCharge":15,"charging":false},)"
          R"("safetyState":{"activeEmergencyStop":"NONE","fieldViolation":false},"errors":[]})",
          false);
      Say("vda5050/v3/KIT/0002/state",
          R"({"version":"3.0.0","operatingMode":"AUTOMATIC","paused":false,)"
          R"("powerSupply":{"stateOfCharge":80,"charging":true},)"
          R"("safetyState":{"activeEmergencyStop":"MANUAL","fieldViolation":false},)"
          R"("errors":[{"errorType":"motorFault","errorLevel":"FATAL",)"
          R"("errorDescription":"the left wheel is stuck"}]})",
          false);
    } while (!run.Wait(std::chrono::milliseconds(20)));
    return {run.Wait().value_or(-1), run.Output(), run.Errors()};
  }
  static std::string Targets(const Finished& run) {
    std::string serials;
    for (const std::string& line : Lines(run.output)) {
      const auto robot = Json(line);
      if (robot.HasMember("serialNumber")) serials += robot["serialNumber"].GetString()[3];
    }
    return serials;
  }
};

TEST_F(FleetInTrouble, TroubleComesFirstAndLeftoversLast) {
  const Finished run = Look({"fleet", "--state-wait", "20s"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  const auto lines = Lines(run.output);
  ASSERT_THAT(lines, SizeIs(4));
  EXPECT_THAT(lines[1], AllOf(StartsWith("KIT/0002"), HasSubstr("E-STOP"),
                              HasSubstr("1 FATAL motorFault: the left wheel is stuck")));
  EXPECT_THAT(lines[2], AllOf(StartsWith("KIT/0001"), HasSubstr("  ok  ")));
  EXPECT_THAT(lines[3], AllOf(StartsWith("KIT/0009"), HasSubstr("last seen ")));
}

TEST_F(FleetInTrouble, TakesTheWordsThatCommandsTake) {
  const auto shown = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"fleet", "-o", "json", "--state-wait", "20s"});
    return Targets(Look(std::move(arguments)));
  };
  EXPECT_EQ(shown({}), "129");
  EXPECT_EQ(shown({"--online"}), "12");
  EXPECT_EQ(shown({"--problems"}), "2");
  EXPECT_EQ(shown({"--where", "battery<20"}), "1");
  EXPECT_EQ(shown({"KIT/*", "--except", "KIT/0001"}), "29");
  EXPECT_EQ(shown({"KIT/0001", "KIT/0009"}), "19");
  EXPECT_EQ(shown({"--sort", "battery"}), "129");
  EXPECT_EQ(shown({"--sort", "trouble", "--online"}), "21");
}

TEST_F(FleetInTrouble, TellsSafetyAndLastSignsAsJson) {
  const auto lines = Lines(Look({"fleet", "-o", "json", "--state-wait", "20s"}).output);
  ASSERT_THAT(lines, SizeIs(3));
  EXPECT_STREQ(Json(lines[1])["safety"]["emergencyStop"].GetString(), "MANUAL");
  EXPECT_FALSE(Json(lines[0])["safety"]["fieldViolation"].GetBool());
  EXPECT_STREQ(Json(lines[2])["lastSeen"].GetString(), "2020-01-02T03:04:05.000Z");
}

TEST_F(FleetInTrouble, SaysThatNobodyIsMeant) {
  const Finished run = Fleetpub({"fleet", "--problems", "--state-wait", "0"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.output, IsEmpty());
  EXPECT_THAT(run.errors, HasSubstr("3 robots found"));
}

TEST_F(FleetInTrouble, OnlineLeavesOutWhoIsOfflineWithoutAFailure) {
  const auto live = Simulate({"KIT/0003"});
  const Finished some = Fleetpub({"pause", "KIT/0003", "KIT/0009", "--online", "--wait"});
  EXPECT_EQ(some.exit_code, 0) << some.output << some.errors;
  EXPECT_THAT(some.output, AllOf(HasSubstr("FINISHED"), Not(HasSubstr("KIT/0009"))));
  EXPECT_THAT(some.errors, HasSubstr("KIT/0009"));
  const Finished none = Fleetpub({"resume", "KIT/0009", "--online", "--discover", "50"});
  EXPECT_EQ(none.exit_code, 0) << none.errors;
  EXPECT_THAT(none.errors, HasSubstr("KIT/0009"));
  const Finished unknown = Fleetpub({"pause", "KIT/0O03", "--online", "--discover", "50"});
  EXPECT_EQ(unknown.exit_code, 7) << "a name that nobody knows is no robot that is offline";
  EXPECT_EQ(Fleetpub({"pause", "KIT/0003", "--online", "--dry-run", "--offline"}).exit_code, 2);
}

// ── watch ──

TEST_F(FleetWatchAwait, WritesALineForEachChange) {
  const auto robot = Simulate({"KIT/0001", "--state-interval", "50ms"});
  const auto watch = Start({"watch", "KIT/*", "--for", "20s"});
  ASSERT_TRUE(watch->AwaitOutput("paused no"));
  EXPECT_EQ(Fleetpub({"pause", "KIT/0001"}).exit_code, 0);
  ASSERT_TRUE(watch->AwaitOutput("paused yes"));
  watch->Signal(SIGINT);
  EXPECT_EQ(watch->Wait(), 0);
  // Unknown, known, paused: repeated states are no change.
  EXPECT_LE(Lines(watch->Output()).size(), 3U) << watch->Output();
  EXPECT_THAT(watch->Output(), Not(HasSubstr("\x1b")));
}

TEST_F(FleetWatchAwait, WritesChangesAsJsonUntilTimeIsUp) {
  const auto robot = Simulate({"KIT/0001", "--state-interval", "50ms"});
  const Finished run = Fleetpub({"watch", "-o", "json", "--for", "500ms"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  const auto lines = Lines(run.output);
  ASSERT_FALSE(lines.empty());
  EXPECT_LE(lines.size(), 2U);
  const auto last = Json(lines.back());
  EXPECT_STREQ(last["target"].GetString(), "KIT/0001");
  EXPECT_FALSE(last["paused"].GetBool());
  EXPECT_TRUE(last["time"].IsString());
}

TEST_F(FleetWatchAwait, ComesBackAfterARestartOfTheBroker) {
  const auto watch = Start({"watch"});
  ASSERT_TRUE(broker_.AwaitSubscription("+/+/+/+/connection"));
  broker_.Kill();
  ASSERT_TRUE(watch->AwaitErrors("was lost"));
  broker_.Restart();
  ASSERT_TRUE(watch->AwaitErrors("connected again"));
  const auto robot = Simulate({"KIT/0001"});
  EXPECT_TRUE(watch->AwaitOutput("KIT/0001  3.0.0  ONLINE"));
  watch->Signal(SIGTERM);
  EXPECT_EQ(watch->Wait(), 0);
}

}  // namespace
}  // namespace fleetpub::testing
