// `fleetpub show`, `fleet --ask` and the trouble that virtual robots rehearse.
#include <gmock/gmock.h>

#include "base/json.h"
#include "base/width.h"
#include "support/operator.h"
#include "support/terminal.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::StartsWith;

class Show : public EndToEnd {
 protected:
  /// The one object that is printed.
  [[nodiscard]] base::JsonDocument ShowJson(const std::string& robot) const {
    const Finished run = Fleetpub({"show", robot, "-o", "json", "--discover", "50"});
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(Lines(run.output), SizeIs(1));
    return Json(run.output);
  }
  /// The actionTypes in the history, oldest first.
  [[nodiscard]] std::vector<std::string> Sent() const {
    std::vector<std::string> types;
    for (const std::string& line : Lines(Fleetpub({"history", "-o", "json"}).output)) {
      types.emplace_back(Json(line)["actions"][0]["type"].GetString());
    }
    return types;
  }
  void LeaveOffline(const std::string& robot) const {
    Say("uagv/v2/" + robot + "/connection",
        R"({"headerId":1,"timestamp":"2026-01-02T03:04:05.678Z","version":"2.0.0",)"
        R"("manufacturer":"KIT","serialNumber":"0009","connectionState":"OFFLINE"})",
        true);
  }
};

TEST_F(Show, ShowsTroubleInEachVersion) {
  for (const std::string version : {"1.1.0", "2.0.0", "2.1.0", "3.0.0"}) {
    const bool is_30 = version == "3.0.0";
    const auto robot =
        Robot({"KIT/0001", "--vda", version, "--battery", "15", "--error",
               "motorFault:FATAL:motor 2 is hot", "--error", "slow:WARNING",
               is_30 ? "--emergency-stop=REMOTE" : "--emergency-stop=AUTO_ACK", "--field-violation",
               "--position", "1.5,-2,0.5,hall-1", "--at", "n5", "--with-order"});
    const auto shown = ShowJson("KIT/0001");
    EXPECT_STREQ(shown["version"].GetString(), version.c_str());
    EXPECT_STREQ(shown["connectionState"].GetString(), "ONLINE");
    EXPECT_STREQ(shown["emergencyStop"].GetString(), is_30 ? "REMOTE" : "AUTOACK") << version;
    EXPECT_TRUE(shown["fieldViolation"].GetBool()) << version;
    EXPECT_FALSE(shown["driving"].GetBool()) << version;
    EXPECT_EQ(shown["batteryCharge"].GetDouble(), 15) << version;
    EXPECT_STREQ(shown["position"]["mapId"].GetString(), "hall-1") << version;
    EXPECT_STREQ(shown["lastNodeId"].GetString(), "n5") << version;
    EXPECT_STREQ(shown["errors"][0]["errorType"].GetString(), "motorFault") << version;
    EXPECT_STREQ(shown["state"]["version"].GetString(), version.c_str());
    EXPECT_EQ(shown["factsheet"].IsNull(), version == "1.1.0");

    const Finished text = Fleetpub({"status", "KIT/0001"});
    EXPECT_EQ(text.exit_code, 0) << text.errors;
    EXPECT_THAT(text.output,
                AllOf(StartsWith("KIT/0001\n"), HasSubstr("EMERGENCY STOP"),
                      HasSubstr("FIELD VIOLATION"), HasSubstr("motor 2 is hot"),
                      HasSubstr("last node n5"), HasSubstr("15 %"), HasSubstr("node 1 of 3")));
    EXPECT_EQ(robot->Running(), true);
    robot->Signal(SIGTERM);
    EXPECT_EQ(robot->Wait(), 0);
  }
}

TEST_F(Show, WhatIsRehearsedIsValid) {
  for (const std::string version : {"1.1", "2.0", "2.1", "3.0"}) {
    const auto robot = Robot({"KIT/0001", "--vda", version, "--battery", "0", "--error",
                              "a:WARNING", "--emergency-stop", "--position", "0,0,3"});
    const auto shown = ShowJson("KIT/0001");
    const auto file = operator_.home().Write("state.json", base::ToJson(shown["state"]));
    const Finished checked =
        Fleetpub({"validate", "--vda", version, "--topic", "state", file.string()});
    EXPECT_EQ(checked.exit_code, 0) << checked.output << checked.errors;
    EXPECT_STREQ(shown["emergencyStop"].GetString(), "MANUAL");
    robot->Signal(SIGTERM);
    EXPECT_EQ(robot->Wait(), 0);
  }
}

TEST_F(Show, RefusesToRehearseWhatTheVersionDoesNotHave) {
  const std::vector<std::vector<std::string>> cases = {{"--error", "slip:URGENT", "--vda", "2.1"},
                                                       {"--error", "slip"},
                                                       {"--emergency-stop=AUTOACK"},
                                                       {"--emergency-stop=SOON"},
                                                       {"--battery", "101"},
                                                       {"--position", "1,2"},
                                                       {"--protocol", "soar", "--field-violation"}};
  for (std::vector<std::string> arguments : cases) {
    arguments.insert(arguments.begin(), {"simulate", "KIT/0001"});
    const Finished run = Fleetpub(arguments);
    EXPECT_EQ(run.exit_code, 2) << arguments[2] << run.errors;
  }
}

TEST_F(Show, AsksForStatesUnlessToldNotToAndRecordsThat) {
  const auto robot = Robot({"KIT/0001", "--state-interval", "1h"});
  const Finished unasked = Fleetpub({"show", "KIT/0001", "--no-ask", "--state-wait", "100ms"});
  EXPECT_EQ(unasked.exit_code, 0);
  EXPECT_THAT(unasked.output,
              AllOf(HasSubstr("state        not known"), HasSubstr("--state-wait")));
  EXPECT_THAT(Sent(), IsEmpty());
  const Finished asked = Fleetpub({"show", "KIT/0001", "--state-wait", "10s"});
  EXPECT_THAT(asked.output, HasSubstr("AUTOMATIC"));
  EXPECT_THAT(Sent(), ::testing::ElementsAre("stateRequest"));
}

TEST_F(Show, FleetAsksOnDemand) {
  const auto robots = Robot({"KIT/0001", "--count", "2", "--state-interval", "1h"});
  LeaveOffline("KIT/0009");
  EXPECT_THAT(Fleetpub({"fleet", "--state-wait", "50ms"}).output, Not(HasSubstr("AUTOMATIC")));
  EXPECT_THAT(Sent(), IsEmpty());
  const Finished asked =
      Fleetpub({"fleet", "--ask", "--state-wait", "10s", "-o", "json", "--discover", "50"});
  EXPECT_EQ(asked.exit_code, 0) << asked.errors;
  const auto lines = Lines(asked.output);
  ASSERT_THAT(lines, SizeIs(3));
  for (const std::string& line : {lines[0], lines[1]}) {
    EXPECT_STREQ(Json(line)["operatingMode"].GetString(), "AUTOMATIC");
  }
  EXPECT_THAT(Sent(), SizeIs(2)) << "nobody asks who is offline";
}

TEST_F(Show, ShowsTheLastCommandsButNoRequestsForStates) {
  const auto robot = Robot({"KIT/0001", "--reject", "startCharging"});
  EXPECT_EQ(Fleetpub({"pause", "KIT/0001", "--wait"}).exit_code, 0);
  EXPECT_EQ(Fleetpub({"charge", "KIT/0001", "--wait"}).exit_code, 5);
  ASSERT_EQ(Fleetpub({"show", "KIT/0001"}).exit_code, 0);
  const auto shown = ShowJson("KIT/0001");
  const auto& commands = shown["commands"];
  ASSERT_EQ(commands.Size(), 2U);
  EXPECT_STREQ(commands[0]["actions"][0]["type"].GetString(), "startPause");
  EXPECT_STREQ(commands[0]["status"].GetString(), "FINISHED");
  EXPECT_STREQ(commands[1]["actions"][0]["type"].GetString(), "startCharging");
  EXPECT_TRUE(commands[1].HasMember("message"));
}

TEST_F(Show, ShowsARobotThatIsOffline) {
  LeaveOffline("KIT/0009");
  const Finished run = Fleetpub({"show", "KIT/0009", "--discover", "50"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, AllOf(HasSubstr("OFFLINE since 2026-01-0"), HasSubstr("not known")));
  const auto shown = ShowJson("KIT/0009");
  EXPECT_TRUE(shown["operatingMode"].IsNull());
  EXPECT_STREQ(shown["connection"]["connectionState"].GetString(), "OFFLINE");
  EXPECT_THAT(Sent(), IsEmpty());
}

TEST_F(Show, ShowsABlockOfEachOfSeveral) {
  const auto robots = Robot({"KIT/0001", "--count", "3", "--error", "slip:FATAL"});
  const Finished run = Fleetpub({"show", "KIT/*", "--except", "KIT/0002", "--discover", "50"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, AllOf(StartsWith("KIT/0001\n"), HasSubstr("\n\nKIT/0003\n"),
                                HasSubstr("FATAL slip"), Not(HasSubstr("KIT/0002"))));
  EXPECT_THAT(Lines(run.output), SizeIs(::testing::Lt(24U)));
  EXPECT_THAT(Lines(Fleetpub({"show", "--all", "-o", "json", "--discover", "50"}).output),
              SizeIs(3));
}

TEST_F(Show, AsksBeforeAConditionIsDecided) {
  const auto low = Robot({"KIT/0001", "--battery", "11", "--state-interval", "1h"});
  const auto full = Robot({"KIT/0002", "--vda", "2.1", "--state-interval", "1h"});
  const Finished run = Fleetpub(
      {"show", "--all", "--where", "battery<20", "--state-wait", "10s", "--discover", "50"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, AllOf(StartsWith("KIT/0001\n"), Not(HasSubstr("KIT/0002"))));
  EXPECT_THAT(Sent(), SizeIs(2));
  const Finished none = Fleetpub({"show", "--all", "--where", "version=2.0.0", "--discover", "50"});
  EXPECT_EQ(none.exit_code, 7);
  EXPECT_THAT(Sent(), SizeIs(2)) << "nobody is asked of whom it is false anyway";
}

TEST_F(Show, NamesWhoIsNotKnownAndShowsTheOthers) {
  const auto robot = Robot({"KIT/0001"});
  const Finished run = Fleetpub({"show", "KIT/0002", "KIT/0001", "--discover", "50"});
  EXPECT_EQ(run.exit_code, 7);
  EXPECT_THAT(run.output, StartsWith("KIT/0001\n"));
  EXPECT_THAT(run.errors, AllOf(HasSubstr("KIT/0002"), HasSubstr("did you mean KIT/0001?")));
  const Finished json = Fleetpub({"show", "KIT/0002", "-o", "json", "--discover", "50"});
  EXPECT_EQ(json.exit_code, 7);
  EXPECT_EQ(Json(json.output)["error"]["exitCode"].GetInt(), 7);
  EXPECT_EQ(Fleetpub({"show"}).exit_code, 2);
}

TEST_F(Show, FitsATerminalAndEscapesWhatRobotsWrite) {
  const auto robot =
      Robot({"KIT/0001", "--error", "slip:FATAL:\x1b[2Jgone " + std::string(60, 'x') + " yonder"});
  const Command command = operator_.Prepare({"show", "KIT/0001"});
  Terminal terminal(ShellLine(command) + "; echo done; sleep 60", 80, 40);
  ASSERT_TRUE(terminal.Await("done"));
  const std::string shown = terminal.Shown();
  EXPECT_THAT(shown, AllOf(HasSubstr("\\x1b[2Jgone"), HasSubstr("\n               yonder")));
  for (const std::string& line : Lines(shown)) EXPECT_LE(base::MeasureWidth(line), 80U) << line;
}

}  // namespace
}  // namespace fleetpub::testing
