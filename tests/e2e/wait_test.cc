// Waiting for the robot's word, with virtual robots on a real broker.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "support/operator.h"
#include "support/relay.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;

class Wait : public EndToEnd {};

TEST_F(Wait, IsTheRobotsOwnWordInEveryVersion) {
  for (const char* version : {"1.1.0", "2.0.0", "2.1.0", "3.0.0"}) {
    const auto robot = Robot({"KIT/0001", "--vda", version});
    for (const char* action : {"pause", "resume", "charge", "uncharge", "stateRequest"}) {
      const Finished run = Fleetpub({action, "KIT/0001", "--wait", "--vda", version});
      EXPECT_EQ(run.exit_code, 0) << version << run.output << run.errors;
      EXPECT_THAT(run.output, HasSubstr("FINISHED"));
    }
  }
}

TEST_F(Wait, LooksAsTheManualShowsIt) {
  const auto robot = Robot({"KIT/0001"});
  const Finished run = Fleetpub({"pause", "KIT/0001", "--wait"});
  EXPECT_THAT(run.output, MatchesRegex("KIT/0001  startPause  FINISHED  [0-9.]+ m?s\n"));
  EXPECT_EQ(run.errors, "");
  const auto rows = Lines(Fleetpub({"history", "-o", "json"}).output);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_STREQ(Json(rows[0])["status"].GetString(), "FINISHED");
}

TEST_F(Wait, TellsWhetherThereWasAnOrderToCancel) {
  const auto idle = Robot({"KIT/0001"});
  const Finished none = Fleetpub({"cancel", "KIT/0001", "--wait"});
  EXPECT_EQ(none.exit_code, 5);
  EXPECT_THAT(none.output, AllOf(HasSubstr("  NO_ORDER  "), HasSubstr("NO_ORDER_TO_CANCEL")));
  const Finished fine = Fleetpub({"cancel", "KIT/*", "--wait", "--if-any", "--yes", "-o", "json"});
  EXPECT_EQ(fine.exit_code, 0) << fine.errors;
  EXPECT_THAT(fine.output, AllOf(HasSubstr(R"("status":"NO_ORDER")"), HasSubstr(R"("noOrder":1,)"),
                                 HasSubstr(R"("exitCode":0)")));
  EXPECT_EQ(Fleetpub({"cancel", "KIT/0001", "--if-any"}).exit_code, 2) << "nobody would know";
  EXPECT_EQ(Fleetpub({"pause", "KIT/0001", "--wait", "--if-any"}).exit_code, 2);
  const auto busy = Robot({"KIT/0002", "--with-order", "--vda", "2.1"});
  const Finished cancelled = Fleetpub({"cancel", "KIT/0002", "--wait", "--vda", "2.1"});
  EXPECT_EQ(cancelled.exit_code, 0) << cancelled.output;
}

TEST_F(Wait, ClearsAFullListAndOneThatIsToBeTidy) {
  const auto robot = Robot({"KIT/0001", "--list-limit", "3"});
  const auto pause = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"pause", "KIT/0001", "--wait"});
    const Finished run = Fleetpub(std::move(more));
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(Lines(run.output), ::testing::SizeIs(1));
    return run.errors;
  };
  EXPECT_EQ(pause({}), "");
  EXPECT_THAT(pause({"--tidy"}), HasSubstr("KIT/0001: cleared"));
  EXPECT_EQ(pause({}), "") << "there is clearInstantActions beside it";
  EXPECT_THAT(pause({}), AllOf(HasSubstr("KIT/0001: its list"), HasSubstr("KIT/0001: cleared")));
  const std::string config = operator_.home().Write("tidy.toml", "tidy = true\n").string();
  EXPECT_THAT(pause({"--config", config}), HasSubstr("cleared"));
}

TEST_F(Wait, ReadsBothStylesOfRejection) {
  for (const char* style : {"state", "error"}) {
    const auto robot =
        Robot({"KIT/0001", "--vda", "2.1", "--reject", "startPause", "--reject-style", style});
    const Finished run = Fleetpub({"pause", "KIT/0001", "--wait", "--vda", "2.1"});
    EXPECT_EQ(run.exit_code, 5) << run.output;
    EXPECT_THAT(run.output, HasSubstr(std::string_view(style) == "state" ? "FAILED" : "REJECTED"));
  }
}

TEST_F(Wait, RefusesWhatCannotBeObeyed) {
  const auto robot = Robot({"KIT/0001", "--mode", "MANUAL"});
  const Finished typo = Fleetpub({"resume", "KIT/0010", "--wait", "--discover", "60"});
  EXPECT_EQ(typo.exit_code, 7);
  EXPECT_THAT(typo.output,
              AllOf(HasSubstr("REFUSED"), HasSubstr("unknown"), HasSubstr("not sent")));
  const Finished manual = Fleetpub({"resume", "KIT/0001", "--wait"});
  EXPECT_EQ(manual.exit_code, 5) << "its mode is not known beforehand: the robot itself refuses";
  EXPECT_THAT(manual.output, HasSubstr("MANUAL"));
  const Finished other = Fleetpub({"action", "dance", "KIT/0001", "--wait"});
  EXPECT_EQ(other.exit_code, 7);
  EXPECT_THAT(other.output, AllOf(HasSubstr("factsheet"), HasSubstr("--no-check")));
  const Finished version = Fleetpub({"pause", "KIT/0001", "--check", "--vda", "2.1"});
  EXPECT_EQ(version.exit_code, 7);
  EXPECT_THAT(version.output, HasSubstr("speaks 3.0.0: use --vda auto"));
}

// The factsheet alone takes longer than the silence after which nothing retained is expected.
TEST_F(Wait, HoldsRobotsAgainstTheirFactsheetsOverASlowLine) {
  const auto robots = Robot({"KIT/0001", "KIT/0002"});
  const Relay slow(broker_.port(), std::chrono::milliseconds(5), 8);
  operator_.UseBroker(slow.Url());
  for (const char* target : {"KIT/0001", "KIT/*"}) {
    const Finished run =
        Fleetpub({"action", "dance", target, "--yes", "--discover", "150", "-o", "json"});
    EXPECT_EQ(run.exit_code, 7) << target << run.output << run.errors;
    EXPECT_THAT(run.output, HasSubstr("factsheet"));
    EXPECT_THAT(run.output, Not(HasSubstr("SENT"))) << target;
  }
}

TEST_F(Wait, CountsNoFactsheetThatARobotLeftAtAnotherTopic) {
  const std::string older = R"({"protocolFeatures":{"agvActions":[{"actionType":"dance",)"
                            R"("actionScopes":["INSTANT"]}]}})";
  Say("uagv/v2/KIT/0001/factsheet", older, true);
  const auto robot = Robot({"KIT/0001", "--vda", "3.0"});
  EXPECT_EQ(Fleetpub({"action", "dance", "KIT/0001"}).exit_code, 7);
}

TEST_F(Wait, SpeaksToEachRobotInItsOwnVersion) {
  const auto old = Robot({"KIT/0001", "--vda", "1.1.0"});
  const auto young = Robot({"KIT/0002", "--vda", "3.0.0"});
  const Finished run = Fleetpub({"pause", "KIT/0001", "KIT/0002", "--wait", "-o", "json"});
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  std::map<std::string, std::string> versions;
  for (const std::string& line : Lines(run.output)) {
    const auto report = Json(line);
    versions[report["target"].GetString()] = report["version"].GetString();
    EXPECT_STREQ(report["status"].GetString(), "FINISHED");
  }
  EXPECT_EQ(versions,
            (std::map<std::string, std::string>{{"KIT/0001", "1.1.0"}, {"KIT/0002", "3.0.0"}}));
  EXPECT_EQ(Fleetpub({"resume", "KIT/0003", "--no-check", "--discover", "60"}).exit_code, 7);
}

TEST_F(Wait, TellsThatARobotWasSwitchedOffHalfWay) {
  const auto robot = Robot({"KIT/0001", "--delay", "30s"});
  Process run(operator_.Prepare({"charge", "KIT/0001", "--wait", "--debug"}));
  ASSERT_TRUE(run.AwaitErrors("-> PUBLISH"));
  const Finished seen = Fleetpub({"pause", "KIT/0001", "--wait-for", "accepted"});
  EXPECT_EQ(seen.exit_code, 0) << seen.output;
  EXPECT_THAT(seen.output, HasSubstr("ACCEPTED"));
  robot->Signal(SIGKILL);
  EXPECT_EQ(run.Wait(), 6);
  EXPECT_THAT(run.Output(), HasSubstr("OFFLINE"));
}

TEST_F(Wait, TimesOutAndSaysWhatWasHeard) {
  const auto silent = Robot({"KIT/0001", "--silent"});
  const Finished unseen = Fleetpub({"pause", "KIT/0001", "--wait", "-W", "300ms"});
  EXPECT_EQ(unseen.exit_code, 6);
  EXPECT_THAT(unseen.output, AllOf(HasSubstr("TIMEOUT"), HasSubstr("no state")));
  const auto slow = Robot({"KIT/0002", "--delay", "30s"});
  const Finished seen = Fleetpub({"charge", "KIT/0002", "--wait", "-W", "2s"});
  EXPECT_EQ(seen.exit_code, 6);
  EXPECT_THAT(seen.output, AllOf(HasSubstr("TIMEOUT"), HasSubstr("RUNNING")));
}

TEST_F(Wait, RepeatsOnRequestWithTheSameActionId) {
  const auto silent = Robot({"KIT/0001", "--silent"});
  const Subscriber subscriber(broker_, "+/+/+/+/instantActions");
  const Finished run = Fleetpub({"pause", "KIT/0001", "--wait", "-W", "3s", "--resend", "2"});
  EXPECT_EQ(run.exit_code, 6);
  const auto messages = subscriber.Await(3);
  ASSERT_EQ(messages.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    const auto message = Json(messages[static_cast<std::size_t>(i)].payload);
    EXPECT_EQ(message["headerId"].GetInt(), i);
    EXPECT_STREQ(message["actions"][0]["actionId"].GetString(),
                 Json(messages[0].payload)["actions"][0]["actionId"].GetString());
  }
}

TEST_F(Wait, KnowsThePeculiarEndings) {
  const auto robot = Robot({"KIT/0001", "KIT/0002"});  // the second keeps what the first left
  for (const char* action : {"factsheetRequest", "clearInstantActions", "startHibernation",
                             "stopHibernation", "shutdown"}) {
    const Finished run = Fleetpub({action, "KIT/0001", "--wait", "-W", "60s"});
    EXPECT_EQ(run.exit_code, 0) << action << run.output << run.errors;
  }
  const Finished gone = Fleetpub({"resume", "KIT/0001", "--wait"});
  EXPECT_EQ(gone.exit_code, 7);
  EXPECT_THAT(gone.output, HasSubstr("OFFLINE"));
}

TEST_F(Wait, StaysNeitherDoneNorFailedWhenRetriable) {
  const auto robot = Robot({"KIT/0001", "--retriable", "startCharging"});
  const Finished run = Fleetpub({"charge", "KIT/0001", "--wait", "--id", "c-1"});
  EXPECT_EQ(run.exit_code, 6);
  EXPECT_THAT(run.output, AllOf(HasSubstr("RETRIABLE"), HasSubstr("skipRetry")));
  EXPECT_EQ(Fleetpub({"retry", "KIT/0001", "--actionId", "c-1", "--wait"}).exit_code, 0);
}

TEST_F(Wait, CtrlCWhileWaitingSaysWhatIsKnown) {
  const auto robot = Robot({"KIT/0001", "--delay", "30s"});
  Process run(operator_.Prepare({"charge", "KIT/0001", "--wait", "--debug"}));
  ASSERT_TRUE(run.AwaitErrors("-> PUBLISH"));
  ASSERT_TRUE(Subscriber(broker_, "+/+/+/+/connection").Await(1).size() == 1);
  run.Signal(SIGINT);
  EXPECT_EQ(run.Wait(), 130);
  EXPECT_THAT(run.Output(), MatchesRegex("KIT/0001  startCharging  INTERRUPTED .*\n"));
}

TEST_F(Wait, ReportsEveryOneOfAThousandRobots) {
  const auto robots = Robot({"KIT/0001", "--count", "1000"});
  std::vector<std::string> arguments = {"pause", "--wait", "-o", "json", "--no-check"};
  for (int i = 1; i <= 1000; ++i) arguments.push_back(fmt::format("KIT/{:04}", i));
  const Finished run = Fleetpub(arguments);
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  std::size_t finished = 0;
  for (const std::string& line : Lines(run.output)) {
    finished += Json(line)["status"] == "FINISHED" ? 1U : 0U;
  }
  EXPECT_EQ(finished, 1000U);
}

TEST_F(Wait, UsageOfWaiting) {
  EXPECT_EQ(Fleetpub({"pause", "KIT/0001", "-W", "3s"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"pause", "KIT/0001", "--wait-for", "done"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"pause", "KIT/0001", "--check", "--no-check"}).exit_code, 2);
  EXPECT_THAT(Fleetpub({"pause", "KIT/0001", "--wait", "-W", "soon"}).errors,
              AllOf(HasSubstr("takes a duration"), Not(HasSubstr("terminate"))));
}

}  // namespace
}  // namespace fleetpub::testing
