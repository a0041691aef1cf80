// Whom a command is for: patterns, exclusions, filters, standard input, and who must be asked
// first.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <set>

#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

class Targets : public EndToEnd {
 protected:
  // A mixed fleet: KIT/0001 … 0003 of 1.1.0, ABC/0001 … 0002 of 2.1.0 and XYZ/0001 of 3.0.0.
  void StartFleet() {
    robots_.push_back(Robot({"KIT/0001", "--count", "3", "--vda", "1.1.0"}));
    robots_.push_back(Robot({"ABC/0001", "--count", "2", "--vda", "2.1.0"}));
    robots_.push_back(Robot({"XYZ/0001", "--vda", "3.0.0", "--state-interval", "1s"}));
  }
  // `TARGET STATUS VERSION` of each result; the summary is left out.
  [[nodiscard]] static std::set<std::string> Results(const Finished& run) {
    std::set<std::string> results;
    for (const std::string& line : Lines(run.output)) {
      const auto report = Json(line);
      if (report.HasMember("summary")) continue;
      results.insert(fmt::format("{} {} {}", report["target"].GetString(),
                                 report["status"].GetString(), report["version"].GetString()));
    }
    return results;
  }
  // The same calls with what a person types after the command.
  [[nodiscard]] Finished WithInput(std::vector<std::string> arguments, std::string input) const {
    Command command = operator_.Prepare(std::move(arguments));
    command.input = std::move(input);
    return fleetpub::testing::Run(std::move(command));
  }

  std::vector<std::unique_ptr<Process>> robots_;
};

TEST_F(Targets, OneCommandReachesAMixedFleetEachInItsOwnVersion) {
  StartFleet();
  const Finished run = Fleetpub({"pause", "--all", "--wait", "-o", "json"});
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  EXPECT_THAT(Results(run), ElementsAre("ABC/0001 FINISHED 2.1.0", "ABC/0002 FINISHED 2.1.0",
                                        "KIT/0001 FINISHED 1.1.0", "KIT/0002 FINISHED 1.1.0",
                                        "KIT/0003 FINISHED 1.1.0", "XYZ/0001 FINISHED 3.0.0"));
  const auto summary = Json(Lines(run.output).back());
  EXPECT_EQ(summary["summary"]["robots"].GetInt(), 6);
  EXPECT_EQ(summary["summary"]["finished"].GetInt(), 6);
  EXPECT_EQ(summary["summary"]["exitCode"].GetInt(), 0);
}

TEST_F(Targets, PatternsExceptionsAndNamesMayStandBesideEachOther) {
  StartFleet();
  const Finished some = Fleetpub({"pause", "*/0001", "KIT/0003", "--except", "ABC/*", "--except",
                                  "XYZ/0001", "--vda", "1.1", "-o", "json"});
  EXPECT_THAT(Results(some), ElementsAre("KIT/0001 SENT 1.1.0", "KIT/0003 SENT 1.1.0"))
      << some.errors;
  // An exception swallows no target behind it.
  const Finished order = Fleetpub({"pause", "--except", "KIT/0002", "KIT/*", "-o", "json"});
  EXPECT_THAT(Results(order), ElementsAre("KIT/0001 SENT 1.1.0", "KIT/0003 SENT 1.1.0"));
  const Finished excluded = Fleetpub({"pause", "KIT/0001", "--except", "KIT/0001"});
  EXPECT_EQ(excluded.exit_code, 2);
  const Finished idle = Send({"pause", "KIT/0001", "--except", "KIT/1", "--vda", "1.1"});
  EXPECT_THAT(idle.errors, HasSubstr("--except KIT/1: it is not among the targets"));
}

TEST_F(Targets, AMisspeltExceptionCommandsNobody) {
  StartFleet();
  const Subscriber subscriber(broker_, "+/+/+/+/instantActions");
  for (const char* misspelt : {"KIT/O002", "KTI/*"}) {
    const Finished run = Fleetpub({"resume", "KIT/*", "--except", misspelt, "--yes"});
    EXPECT_EQ(run.exit_code, 7);
    EXPECT_THAT(run.errors, AllOf(HasSubstr("nothing was sent"), HasSubstr(misspelt),
                                  HasSubstr("matches none of the")));
  }
  EXPECT_THAT(subscriber.SoFar(), IsEmpty());
  for (const char* right : {"KIT/0002", "*/0002"}) {
    const Finished run = Fleetpub({"resume", "KIT/*", "--except", right, "--yes"});
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(run.output, AllOf(HasSubstr("KIT/0001"), ::testing::Not(HasSubstr("KIT/0002"))));
  }
  // To stop one too many is no harm.
  const Finished stop = Fleetpub({"pause", "KIT/*", "--except", "KIT/O002"});
  EXPECT_EQ(stop.exit_code, 0);
  EXPECT_THAT(stop.errors, HasSubstr("matches none of the"));
}

TEST_F(Targets, GroupsAndAliasesCanBeExceptions) {
  StartFleet();
  operator_.home().Write(".config/fleetpub/config.toml",
                         "[robot.\"KIT/0002\"]\nalias = \"two\"\n[group]\nspare = [\"two\", "
                         "\"KIT/0003\"]\n");
  EXPECT_THAT(Results(Fleetpub({"pause", "KIT/*", "--except", "@spare", "-o", "json"})),
              ElementsAre("KIT/0001 SENT 1.1.0"));
  EXPECT_THAT(Results(Fleetpub({"pause", "KIT/*", "--except", "two", "-o", "json"})),
              ElementsAre("KIT/0001 SENT 1.1.0", "KIT/0003 SENT 1.1.0"));
  EXPECT_EQ(Fleetpub({"pause", "KIT/*", "--except", "@spart"}).exit_code, 2);
}

TEST_F(Targets, FiltersLookAtWhatRobotsSay) {
  StartFleet();
  const Finished version = Fleetpub({"pause", "--all", "--where", "version=2.1.0", "-o", "json"});
  EXPECT_THAT(Results(version), ElementsAre("ABC/0001 SENT 2.1.0", "ABC/0002 SENT 2.1.0"));
  const Finished state = Fleetpub({"resume", "XYZ/*", "--where", "operatingMode=AUTOMATIC",
                                   "--where", "/powerSupply/stateOfCharge>20", "-o", "json"});
  EXPECT_EQ(state.exit_code, 0) << state.errors;
  EXPECT_THAT(Results(state), ElementsAre("XYZ/0001 SENT 3.0.0"));
  const Finished none = Fleetpub({"resume", "XYZ/*", "--where", "battery<20"});
  EXPECT_EQ(none.exit_code, 7);
  EXPECT_THAT(none.errors, AllOf(HasSubstr("nothing was sent"), HasSubstr("battery is 80")));
  const Finished shell = Fleetpub({"resume", "XYZ/*", "--where", "/powerSupply/stateOfCharge"});
  EXPECT_EQ(shell.exit_code, 2);
  EXPECT_THAT(shell.errors, AllOf(HasSubstr("--where"), HasSubstr("the shell takes it")));
}

TEST_F(Targets, ARobotWhoseStateIsNotHeardIsNamedAndSpared) {
  const auto silent = Robot({"KIT/0001", "--silent"});
  const Subscriber subscriber(broker_, "+/+/+/+/instantActions");
  const Finished run =
      Fleetpub({"pause", "KIT/*", "--where", "paused=false", "--state-wait", "300ms"});
  EXPECT_EQ(run.exit_code, 7);
  EXPECT_THAT(run.errors, HasSubstr("waiting up to 300 ms"));
  EXPECT_THAT(run.output, AllOf(HasSubstr("KIT/0001"), HasSubstr("REFUSED"), HasSubstr("--where")));
  EXPECT_THAT(subscriber.SoFar(), IsEmpty());
}

TEST_F(Targets, StandardInputNamesOnePerLine) {
  StartFleet();
  const Finished run = WithInput({"pause", "-", "--vda", "auto", "-o", "json"},
                                 "KIT/0001\n\n  ABC/0002\r\nXYZ/0001");
  EXPECT_THAT(Results(run),
              ElementsAre("ABC/0002 SENT 2.1.0", "KIT/0001 SENT 1.1.0", "XYZ/0001 SENT 3.0.0"))
      << run.errors;
  const Finished patterns =
      WithInput({"pause", "-", "--patterns", "-o", "json"}, "KIT/0001\nABC/*\n");
  EXPECT_THAT(Results(patterns), SizeIs(3)) << patterns.errors;
  const Finished bad = WithInput({"pause", "-"}, "KIT/0001\nKIT\n");
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_THAT(bad.errors, HasSubstr("standard input, line 2: "));
  EXPECT_EQ(WithInput({"pause", "-"}, "\n").exit_code, 2);
  EXPECT_EQ(WithInput({"cancel", "-"}, "KIT/0001\nKIT/0002\n").exit_code, 2) << "asks for --yes";
  EXPECT_EQ(WithInput({"pause", "-"}, "@hall\n").exit_code, 2) << "a group takes --patterns";
  EXPECT_EQ(WithInput({"publish", "order", "-", "-f", "-"}, "KIT/0001\n").exit_code, 2);
}

// Robots that are called like a pattern, a group, an option, and like nothing that one sees.
TEST_F(Targets, WhatIsPrintedMeansThatRobotAlone) {
  const std::vector<std::string> words = {"%2A/%2A",       "%2D-all/1", "%40hall/1",
                                          "%5BKIT/0001]",  "KIT/%2A",   "KIT/%E2%80%AE0001",
                                          "KIT/1 %2D-all", "KIT/0001",  "K\u0406T/0001"};
  std::vector<std::string> simulated = words;
  robots_.push_back(Robot(std::move(simulated)));
  const Finished fleet = Fleetpub({"fleet", "-o", "json", "--state-wait", "0"});
  EXPECT_THAT(fleet.errors, AllOf(HasSubstr("warning"), HasSubstr("%2A/%2A (has U+002A)")));
  std::set<std::string> printed;
  for (const std::string& line : Lines(fleet.output)) {
    const auto robot = Json(line);
    const std::string word = robot["target"].GetString();
    printed.insert(word);
    const std::string topic =
        fmt::format("vda5050/v3/{}/{}/instantActions", robot["manufacturer"].GetString(),
                    robot["serialNumber"].GetString());
    const Subscriber subscriber(broker_, "+/+/+/+/instantActions");
    EXPECT_EQ(WithInput({"charge", "-", "--yes"}, word + "\n").exit_code, 0) << word;
    EXPECT_EQ(Fleetpub({"charge", word}).exit_code, 0) << word;
    EXPECT_EQ(WithInput({"charge", "-", "--patterns"}, word + "\n").exit_code, 0) << word;
    EXPECT_THAT(Fleetpub({"history", "--target", word, "-o", "json"}).output, Not(IsEmpty()));
    const auto received = subscriber.Await(3);
    for (const auto& message : received) {  // which the helper cuts at a blank
      EXPECT_EQ(message.topic, topic.substr(0, topic.find(' ')));
    }
    EXPECT_THAT(received, SizeIs(3));
    EXPECT_THAT(subscriber.SoFar(), SizeIs(3));
  }
  EXPECT_EQ(printed, std::set(words.begin(), words.end()));
  const Finished others =
      Fleetpub({"charge", "KIT/*", "--except", "KIT/%2A", "--dry-run", "-o", "json"});
  EXPECT_THAT(Results(others),
              ElementsAre("KIT/%E2%80%AE0001 DRY_RUN 3.0.0", "KIT/0001 DRY_RUN 3.0.0",
                          "KIT/1 %2D-all DRY_RUN 3.0.0"));
}

TEST_F(Targets, AnOldRowsRobotIsShownAsATargetToo) {
  EXPECT_EQ(Send({"pause", "KIT/0001"}).exit_code, 0);
  const std::string change =
      "import sqlite3, sys; ledger = sqlite3.connect(sys.argv[1]); "
      "ledger.execute(\"update messages set target = '*/*'\"); "
      "ledger.commit()";
  const Finished changed = fleetpub::testing::Run(
      {.arguments = {"python3", "-c", change, operator_.LedgerPath().string()}});
  ASSERT_EQ(changed.exit_code, 0) << changed.errors;
  const Finished history = Fleetpub({"history", "-o", "json"});
  EXPECT_STREQ(Json(history.output)["target"].GetString(), "%2A/%2A");
  EXPECT_THAT(Fleetpub({"__complete", "pause", ""}).output, Not(HasSubstr("*")));
}

TEST_F(Targets, ALineIsOneRobotsName) {
  StartFleet();
  const Finished run = WithInput(WithoutLook({"pause", "-", "-o", "json"}), "*/*\n");
  EXPECT_THAT(Results(run), ElementsAre("%2A/%2A SENT 3.0.0"));
  EXPECT_THAT(run.errors, HasSubstr("--patterns"));
}

TEST_F(Targets, AnUnusualNameIsMarkedBeforeItIsAgreedTo) {
  robots_.push_back(Robot({"KIT/0001", "K\u0406T/0001", "KIT/0002"}));
  const Finished run = Fleetpub({"charge", "--all"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("(K\u0406T/0001 (has U+0406), KIT/0001, KIT/0002)"));
}

TEST_F(Targets, WhatNobodyWouldSeeIsEscapedInJsonToo) {
  const std::string name = "KIT/\u202E1\u0085\u00AD";
  for (const std::string format : {"text", "json"}) {
    const Finished run = Send({"action", "b\u200Beep", name, "--dry-run", "-o", format, "-v"});
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(run.output, HasSubstr(R"("serialNumber":"\u202e1\u0085\u00ad")"));
    for (const std::string hidden : {"\u202E", "\u0085", "\u00AD", "\u200B"}) {
      EXPECT_THAT(run.output + run.errors, Not(HasSubstr(hidden)));
    }
  }
}

TEST_F(Targets, MoreThanOneRobotNeedsAWord) {
  StartFleet();
  const Subscriber subscriber(broker_, "+/+/+/+/instantActions");
  const Finished refused = Fleetpub({"cancel", "KIT/*"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, AllOf(HasSubstr("KIT/* means 3 robots at " + broker_.Url() +
                                              " (KIT/0001, KIT/0002, KIT/0003)"),
                                    HasSubstr("--yes")));
  EXPECT_THAT(subscriber.SoFar(), IsEmpty());
  EXPECT_EQ(Fleetpub({"cancel", "XYZ/*"}).exit_code, 0) << "it is one robot";
  EXPECT_EQ(Fleetpub({"cancel", "KIT/*", "--yes"}).exit_code, 0);
  EXPECT_EQ(Fleetpub({"stateRequest", "KIT/*"}).exit_code, 0);
  EXPECT_EQ(Fleetpub({"cancel", "KIT/*", "--dry-run"}).exit_code, 0);
  EXPECT_THAT(subscriber.Await(7), SizeIs(7));
}

TEST_F(Targets, APatternThatMatchesNothingSaysWhatWasHeard) {
  StartFleet();
  const Finished run = Fleetpub({"pause", "KTI/*"});
  EXPECT_EQ(run.exit_code, 7);
  EXPECT_EQ(run.output, "");
  EXPECT_THAT(run.errors, AllOf(HasSubstr("nothing was sent"), HasSubstr("KTI/*"),
                                HasSubstr("6 robots: ABC/0001, ABC/0002, KIT/0001")));
  const Mosquitto empty;
  const Finished nobody = Fleetpub({"pause", "--all", "-b", empty.Url()});
  EXPECT_EQ(nobody.exit_code, 7);
  EXPECT_THAT(nobody.errors, HasSubstr("knows no robot"));
}

TEST_F(Targets, AnUnknownRobotIsOftenAMisspeltOne) {
  const auto robot = Robot({"KIT/0001"});
  EXPECT_EQ(Send({"pause", "DEPOT/Lift-17"}).exit_code, 0);
  const Finished run = Fleetpub({"resume", "KIT/00001", "DEPOT/Lift-71", "SOMETHING/ELSE-1234",
                                 "--wait", "--discover", "60"});
  EXPECT_EQ(run.exit_code, 7);
  const auto lines = Lines(run.output);
  ASSERT_THAT(lines, SizeIs(3));
  EXPECT_THAT(lines[0], HasSubstr("did you mean KIT/0001?"));
  EXPECT_THAT(lines[1], Not(HasSubstr("did you mean"))) << "the ledger knows it, it is not there";
  EXPECT_THAT(lines[2], Not(HasSubstr("did you mean")));
}

TEST_F(Targets, AnActionThatSomeVersionsLackIsRefusedForThose) {
  StartFleet();
  const Finished run = Fleetpub({"factsheetRequest", "--all", "-o", "json"});
  EXPECT_EQ(run.exit_code, 3) << run.errors;
  EXPECT_THAT(Results(run), ElementsAre("ABC/0001 SENT 2.1.0", "ABC/0002 SENT 2.1.0",
                                        "KIT/0001 INVALID 1.1.0", "KIT/0002 INVALID 1.1.0",
                                        "KIT/0003 INVALID 1.1.0", "XYZ/0001 SENT 3.0.0"));
  const Finished all = Fleetpub({"factsheetRequest", "KIT/*"});
  EXPECT_EQ(all.exit_code, 3);
  EXPECT_THAT(all.errors, HasSubstr("nothing was sent"));
}

TEST_F(Targets, AwaitWaitsForEachRobotOfAPattern) {
  const auto one = Robot({"KIT/0001", "--state-interval", "1s", "--vda", "2.1.0"});
  const auto two = Robot({"KIT/0002", "--state-interval", "1s"});
  ASSERT_EQ(Fleetpub({"pause", "KIT/*", "--wait"}).exit_code, 0);
  const Finished both = Fleetpub({"await", "KIT/*", "state", "paused=true", "-o", "json"});
  EXPECT_EQ(both.exit_code, 0) << both.errors;
  EXPECT_THAT(Lines(both.output), ::testing::SizeIs(2));
  ASSERT_EQ(Fleetpub({"resume", "KIT/0002", "--wait"}).exit_code, 0);
  const Finished half = Fleetpub({"await", "KIT/*", "state", "paused=true", "-W", "4s"});
  EXPECT_EQ(half.exit_code, 6);
  EXPECT_THAT(half.errors,
              AllOf(HasSubstr("KIT/0002: condition not met within"), HasSubstr("paused is false")));
  EXPECT_EQ(Fleetpub({"await", "KTI/*", "state", "paused=true"}).exit_code, 7);
}

TEST_F(Targets, SaysWhoOfThoseThatWereCommandedDoesNotAnswer) {
  const auto robot = Robot({"KIT/0001"});
  EXPECT_EQ(Send({"pause", "KIT/0002", "ACME/0001"}).exit_code, 0);
  const Finished run = Fleetpub({"pause", "KIT/*"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, AllOf(HasSubstr("did not answer: KIT/0002"), Not(HasSubstr("ACME"))));
}

TEST_F(Targets, ACommandIsHeldBackUnlessJustSoManyRobotsAreMeant) {
  const auto robots = Robot({"KIT/0001", "KIT/0002"});
  for (const char* count : {"1", "3"}) {
    const Finished run = Fleetpub({"pause", "--all", "--expect", count, "--discover", "60"});
    EXPECT_EQ(run.exit_code, 7) << run.output;
    EXPECT_THAT(run.errors, AllOf(HasSubstr("nothing was sent"), HasSubstr("--expect")));
  }
  EXPECT_EQ(Fleetpub({"pause", "KIT/*", "--expect", "2", "--discover", "60"}).exit_code, 0);
  EXPECT_EQ(Fleetpub({"pause", "KIT/0001", "--expect", "none"}).exit_code, 2);
}

}  // namespace
}  // namespace fleetpub::testing
