// `fleetpub conform` from the shell to a virtual robot: each level, what it leaves, and its reports.
#include <gmock/gmock.h>

#include <map>

#include "base/file.h"
#include "support/document.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class Conform : public EndToEnd {
 protected:
  [[nodiscard]] std::unique_ptr<Process> QuickRobot(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments = {"KIT/0001", "--position",       "1,2,0", "--time-scale",
                                          "8",        "--state-interval", "200ms"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Robot(std::move(arguments));
  }
  [[nodiscard]] Finished Test(std::vector<std::string> words) const {
    words.insert(words.begin(), {"conform", "KIT/0001", "--for", "300ms"});
    return Fleetpub(std::move(words));
  }
  // The verdicts by case.
  static std::map<std::string, std::string> Verdicts(const Finished& finished) {
    std::map<std::string, std::string> verdicts;
    for (const std::string& line : Lines(finished.output)) {
      const auto object = Json(line);
      if (object.HasMember("id"))
        verdicts[object["id"].GetString()] = object["verdict"].GetString();
    }
    return verdicts;
  }
  [[nodiscard]] std::size_t Sent() const {
    return Lines(Fleetpub({"history", "-o", "json"}).output).size();
  }
};

TEST_F(Conform, ListeningSendsNothing) {
  const auto robot = QuickRobot();
  const Finished tested = Test({"-o", "json"});
  EXPECT_EQ(tested.exit_code, 0) << tested.output << tested.errors;
  auto verdicts = Verdicts(tested);
  EXPECT_EQ(verdicts["C01"], "PASS");
  EXPECT_EQ(verdicts["C02"], "PASS");
  EXPECT_EQ(verdicts["F02"], "PASS");
  EXPECT_EQ(verdicts["I01"], "SKIPPED");
  EXPECT_EQ(Sent(), 0U);
}

TEST_F(Conform, ActionsAreSentThroughTheLedgerAndThePauseIsTakenBack) {
  const auto robot = QuickRobot({"--vda", "2.1"});
  const Finished tested = Test({"--level", "actions", "--only", "I", "-o", "json"});
  EXPECT_EQ(tested.exit_code, 0) << tested.output << tested.errors;
  auto verdicts = Verdicts(tested);
  EXPECT_EQ(verdicts["I07"], "PASS");
  EXPECT_EQ(verdicts["I09"], "PASS");
  EXPECT_EQ(verdicts.count("I11"), 0U) << "of 3.0";
  EXPECT_GT(Sent(), 10U);
  EXPECT_EQ(Fleetpub({"await", "KIT/0001", "paused=false", "-W", "5s"}).exit_code, 0);
}

TEST_F(Conform, AFaultIsFoundWithAdviceAndExitCode) {
  const auto robot = QuickRobot({"--fault", "pause-once"});
  const Finished tested = Test({"--level", "actions", "--only", "I07,I08"});
  EXPECT_EQ(tested.exit_code, 5);
  EXPECT_THAT(tested.output, AllOf(HasSubstr("FAIL"), HasSubstr("I07"), HasSubstr("advice:"),
                                   HasSubstr("1 failed"), Not(HasSubstr("certified"))));
}

TEST_F(Conform, DrivesWithConsentOnlyAndLeavesTheRobotIdle) {
  const auto robot = QuickRobot();
  const Finished refused = Test({"--level", "drive", "--distance", "8"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, AllOf(HasSubstr("8.0 m"), HasSubstr("--yes")));
  EXPECT_EQ(Sent(), 0U);

  const std::string recording = (operator_.home().path() / "test.jsonl").string();
  const Finished driven = Test({"--level", "drive", "--yes", "--distance", "8", "--only",
                                "D01,D02,O15,X01,S01,S04", "-o", "json", "--record", recording});
  EXPECT_EQ(driven.exit_code, 0) << driven.output << driven.errors;
  for (const auto& [id, verdict] : Verdicts(driven)) EXPECT_EQ(verdict, "PASS") << id;
  EXPECT_EQ(Verdicts(driven).size(), 6U);
  const Finished told = Fleetpub({"explain", "KIT/0001", "--from", recording});
  EXPECT_EQ(told.exit_code, 0) << told.errors;
  const Finished shown = Fleetpub({"show", "KIT/0001", "-o", "json"});
  EXPECT_THAT(shown.output, HasSubstr(R"("nodesLeft":0)"));
}

TEST_F(Conform, WritesReports) {
  const auto robot = QuickRobot({"--fault", "header-name"});
  const auto path = [&](const char* name) { return (operator_.home().path() / name).string(); };
  const Finished tested =
      Test({"--only", "H", "--report", "junit=" + path("o.xml") + ",tap=" + path("o.tap"),
            "--report", "json=" + path("o.json"), "--report", "html=" + path("o.html")});
  EXPECT_EQ(tested.exit_code, 5);
  EXPECT_THAT(*base::ReadFile(path("o.xml")), HasSubstr(R"(failures="1")"));
  EXPECT_THAT(*base::ReadFile(path("o.tap")), HasSubstr("not ok 2 - H02"));
  EXPECT_EQ(Json(*base::ReadFile(path("o.json")))["failed"].GetUint(), 1U);
  EXPECT_THAT(*base::ReadFile(path("o.html")), HasSubstr("H02"));
}

TEST_F(Conform, ARobotThatIsNotThereIsNotJudged) {
  EXPECT_EQ(Test({}).exit_code, 7);
  EXPECT_EQ(Fleetpub({"conform"}).exit_code, 2);
  EXPECT_EQ(Test({"--only", "Z99"}).exit_code, 2);
  EXPECT_EQ(Test({"--report", "pdf=x"}).exit_code, 2);
  EXPECT_EQ(Test({"--distance", "3"}).exit_code, 2) << "of --level drive";
}

TEST(ConformList, IsOnThePage) {
  const Operator someone;
  const Finished listed = someone.Fleetpub({"conform", "--list"});
  EXPECT_EQ(listed.exit_code, 0);
  EXPECT_THAT(SourceText("docs/conformance.md"), HasSubstr(listed.output))
      << "docs/conformance.md holds what fleetpub conform --list prints";
  EXPECT_EQ(someone.Fleetpub({"conform", "--list", "-o", "json"}).exit_code, 0);
}

}  // namespace
}  // namespace fleetpub::testing
