// `fleetpub conform` from the shell to a virtual robot: each level, what it leaves, and its reports.
#include <gmock/gmock.h>

#include <csignal>
#include <map>
#include <set>

#include "base/file.h"
#include "layout/layouts.h"
#include "support/document.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAre;

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
  EXPECT_EQ(Fleetpub({"await", "KIT/0001", "paused=false", "-W", "60s"}).exit_code, 0);
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
  EXPECT_THAT(refused.errors, AllOf(HasSubstr("8.0 m"), HasSubstr("load"), HasSubstr("--yes")));
  const Finished light = Test({"--level", "drive", "--skip", "A07"});
  EXPECT_THAT(light.errors, Not(HasSubstr("picks and drops")));
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

// n1 to n3 round a corner, both ways.
class ConformOnALayout : public Conform {
 protected:
  [[nodiscard]] Finished Drive(std::vector<std::string> words) const {
    words.insert(words.begin(), {"--level", "drive", "--yes", "-o", "json"});
    return Test(std::move(words));
  }
  static std::string Node(const char* id, double x, double y) {
    return NodeText(id, x, y, R"({"vehicleTypeId":"T"})", "map-1");
  }
  static std::string Edge(const char* from, const char* to) {
    return EdgeText(from, to, R"("maxSpeed":1)");
  }
  // The ids of the nodes and edges of all orders that were heard.
  static std::set<std::string> Ids(const Subscriber& orders) {
    std::set<std::string> ids;
    for (const auto& heard : orders.SoFar()) {
      const auto order = Json(heard.payload);
      for (const auto& node : order["nodes"].GetArray()) ids.insert(node["nodeId"].GetString());
      for (const auto& edge : order["edges"].GetArray()) ids.insert(edge["edgeId"].GetString());
    }
    return ids;
  }

  std::string hall_ =
      operator_.home()
          .Write(
              "hall.lif.json",
              FileText({Node("n1", 1, 2), Node("n2", 9, 2), Node("n3", 9, 10), Node("n4", 9, 14)},
                       {Edge("n1", "n2"), Edge("n2", "n1"), Edge("n2", "n3"), Edge("n3", "n2")}))
          .string();
};

TEST_F(ConformOnALayout, DrivesThereAndBackAlongItsEdges) {
  const auto robot = QuickRobot();
  const Subscriber orders(broker_, "+/+/KIT/0001/order");
  const Finished driven = Drive({"--nodes", "n1,n2,n3", "--layout", hall_, "--only",
                                 "D01,D02,D03,D08,D15,A02,X01,X02,X05,S04"});
  EXPECT_EQ(driven.exit_code, 0) << driven.output << driven.errors;
  for (const auto& [id, verdict] : Verdicts(driven)) {
    EXPECT_EQ(verdict, id == "D15" ? "SKIPPED" : "PASS") << id << "\n" << driven.output;
  }
  EXPECT_THAT(Ids(orders), IsSupersetOf({"n1", "n2", "n3", "n1-n2", "n2-n3", "n3-n2", "n2-n1"}));
  EXPECT_THAT(Ids(orders), Not(Contains("n4")));
}

TEST_F(ConformOnALayout, DrivesALoopWhoseLastNodeIsItsFirst) {
  const auto robot = QuickRobot();
  const Subscriber orders(broker_, "+/+/KIT/0001/order");
  const Finished driven =
      Drive({"--nodes", "n1,n2,n1", "--layout", hall_, "--only", "D01,D02,X05"});
  EXPECT_EQ(driven.exit_code, 0) << driven.output << driven.errors;
  for (const auto& [id, verdict] : Verdicts(driven)) EXPECT_EQ(verdict, "PASS") << id;
  EXPECT_THAT(Ids(orders), UnorderedElementsAre("n1", "n2", "n1-n2", "n2-n1"));
}

TEST_F(ConformOnALayout, SendsNothingAlongAWayThatIsNone) {
  const auto robot = QuickRobot();
  const auto drive = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"--level", "drive", "--layout", hall_, "--nodes"});
    return Test(std::move(words));
  };
  EXPECT_EQ(drive({"n1,n2", "--yes"}).exit_code, 2);
  EXPECT_EQ(drive({"n1,n2,n3", "--yes", "--vehicle-type", "none"}).exit_code, 2);
  const Finished off = drive({"n1,n2,n4"});
  EXPECT_EQ(off.exit_code, 2) << "nobody has agreed";
  EXPECT_THAT(off.errors, AllOf(HasSubstr("no edge from n2 to n4"), HasSubstr("no edge from n4")));
  EXPECT_EQ(Drive({"--nodes", "n1,n2,n3", "--layout", "no.lif.json"}).exit_code, 8);
  EXPECT_EQ(Sent(), 0U);
}

// Ended while the robot drives.
class InterruptedConform : public Conform {
 protected:
  // Returns once it is under way.
  [[nodiscard]] std::unique_ptr<Process> Drive(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = {"conform", "KIT/0001", "--for",          "300ms",
                                      "--level", "drive",    "--yes",          "--only",
                                      "D01,D02", "-o",       "json",           "--distance",
                                      "60",      "--report", "json=" + report_};
    words.insert(words.end(), more.begin(), more.end());
    auto process = std::make_unique<Process>(operator_.Prepare(std::move(words)));
    EXPECT_EQ(Fleetpub({"await", "KIT/0001", "driving=true", "-W", "60s"}).exit_code, 0)
        << process->Errors();
    return process;
  }

  std::string report_ = (operator_.home().path() / "o.json").string();
};

TEST_F(InterruptedConform, CancelsTheOrderAndSaysThatNotAllWasTested) {
  const auto robot = Robot({"KIT/0001", "--position", "1,2,0", "--state-interval", "200ms"});
  const Subscriber orders(broker_, "+/+/KIT/0001/order");
  for (const auto& [signal, code] : {std::pair(SIGINT, 130), {SIGTERM, 143}}) {
    const auto test = Drive();
    const std::size_t sent = orders.SoFar().size();
    test->Signal(signal);
    EXPECT_EQ(test->Wait(), code) << test->Errors();
    EXPECT_THAT(orders.SoFar(), SizeIs(sent)) << "another order was sent";
    const auto last = Json(Lines(test->Output()).back());
    EXPECT_FALSE(last["summary"]["complete"].GetBool());
    EXPECT_EQ(last["summary"]["exitCode"].GetInt(), code);
    EXPECT_THAT(*base::ReadFile(report_), HasSubstr(R"("ended early":"interrupted")"));
    EXPECT_THAT(Fleetpub({"show", "KIT/0001", "-o", "json"}).output,
                AllOf(HasSubstr(R"("nodesLeft":0)"), HasSubstr(R"("driving":false)")));
  }
}

TEST_F(InterruptedConform, EndsAtOnceTheSecondTime) {
  const auto robot =
      Robot({"KIT/0001", "--position", "1,2,0", "--state-interval", "200ms", "--delay", "60s"});
  const Subscriber actions(broker_, "+/+/KIT/0001/instantActions");
  const auto test = Drive();
  const std::size_t sent = actions.SoFar().size();
  test->Signal(SIGINT);
  EXPECT_THAT(actions.Await(sent + 1), SizeIs(sent + 1)) << "it asks how the robot was left";
  test->Signal(SIGINT);
  EXPECT_EQ(test->Wait(std::chrono::seconds(5)), 130);
  EXPECT_THAT(test->Errors(), HasSubstr("ended at once"));
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
  EXPECT_EQ(Test({"--only", "C01", "--skip", "C01"}).exit_code, 2);
  EXPECT_EQ(Test({"--only", "I"}).exit_code, 2) << "of --level actions";
  EXPECT_EQ(Test({"--report", "pdf=x"}).exit_code, 2);
  EXPECT_EQ(Test({"--distance", "3"}).exit_code, 2) << "of --level drive";
}

TEST_F(Conform, OfCasesOfAnotherVersionIsRefused) {
  const auto robot = QuickRobot({"--vda", "2.1"});
  EXPECT_EQ(Test({"--level", "actions", "--only", "I11"}).exit_code, 2);
  EXPECT_EQ(Sent(), 0U);
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
