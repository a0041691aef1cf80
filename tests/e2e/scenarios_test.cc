// `fleetpub test` from the shell: scenarios with virtual robots, their ends, and what is refused.
#include <gmock/gmock.h>

#include <csignal>

#include "base/file.h"
#include "support/document.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

class Scenario : public EndToEnd {
 protected:
  [[nodiscard]] std::string Write(const std::string& text,
                                  const std::string& name = "s.toml") const {
    return operator_.home().Write(name, text).string();
  }
  // One test of these steps.
  [[nodiscard]] std::string WriteSteps(const std::string& steps) const {
    return Write("[[test]]\nname = \"it works\"\nrobot = \"KIT/0001\"\nsteps = [\n" + steps +
                 "]\n");
  }
  [[nodiscard]] Finished Test(const std::string& file, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"test", file});
    return Fleetpub(std::move(more));
  }
  // The objects of the tests, by `VERDICT stepLine`.
  [[nodiscard]] static std::vector<std::string> Verdicts(const Finished& finished) {
    std::vector<std::string> verdicts;
    for (const std::string& line : Lines(finished.output)) {
      const auto object = Json(line);
      if (!object.HasMember("verdict")) continue;
      const auto& step = object["stepLine"];
      verdicts.push_back(std::string(object["verdict"].GetString()) +
                         (step.IsNull() ? "" : " " + std::to_string(step.GetUint())));
    }
    return verdicts;
  }
  [[nodiscard]] std::size_t Sent() const {
    return Lines(Fleetpub({"history", "-o", "json"}).output).size();
  }
};

constexpr const char* kFast = " --state-interval 100ms\" },\n";

TEST_F(Scenario, OfTheManualPasses) {
  const std::string manual = SourceText("docs/manual.md");
  const auto begin = manual.find("```toml\nwithin");
  ASSERT_NE(begin, std::string::npos);
  const auto end = manual.find("```\n", begin + 3);
  const Finished run = Test(Write(manual.substr(begin + 8, end - begin - 8)), {"-o", "json"});
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  EXPECT_THAT(Verdicts(run), ElementsAre("PASS", "PASS"));
}

TEST_F(Scenario, CapturesAValueOnceAndUsesItTwice) {
  const Finished run = Test(
      WriteSteps(std::string("{ simulate = \"KIT/0001 --vda 2.1") + kFast +
                 "{ send = \"pause KIT/0001 --id p-7 --wait\" },\n"
                 "{ await = [\"paused=true\", \"driving=false\"] },\n"
                 "{ capture = \"serialNumber\", as = \"serial\" },\n"
                 "{ expect = \"serialNumber=${serial}\" },\n"
                 "{ send = \"publish instantActions KIT/0001 -f -\", payload = '''{\"actions\":[{"
                 "\"actionType\":\"stateRequest\",\"actionId\":\"of-${serial}\","
                 "\"blockingType\":\"NONE\",\"actionParameters\":[]}]}''' },\n"
                 "{ expect = \"serialNumber=${serial}\", for = \"200ms\" },\n"),
      {"-o", "json"});
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  EXPECT_THAT(Fleetpub({"history", "-o", "json"}).output, HasSubstr("of-0001"));
}

TEST_F(Scenario, HasRobotsOfDifferentVersions) {
  const Finished run = Test(
      WriteSteps(
          std::string("{ simulate = \"KIT/0001 --vda 2.1") + kFast +
          "{ simulate = [\"KIT/0002\", \"--count\", \"2\", \"--state-interval\", \"100ms\"] },\n"
          "{ send = \"pause KIT/0001 KIT/0002 --wait\", outcome = \"FINISHED\" },\n"
          "{ await = \"version=2.1.0\" },\n"
          "{ await = [\"version=3.0.0\", \"paused=true\"], robot = \"KIT/0002\" },\n"
          "{ expect = \"connectionState=ONLINE\", robot = \"KIT/0003\", topic = "
          "\"connection\" },\n"),
      {"-o", "json"});
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  EXPECT_THAT(Verdicts(run), ElementsAre("PASS"));
}

TEST_F(Scenario, FailsWithTheStepAndWhatTheRobotSaid) {
  const std::string file = Write(
      "[[test]]\nname = \"fails\"\nrobot = \"KIT/0001\"\nsteps = [\n"
      "{ simulate = \"KIT/0001 --state-interval 100ms\" },\n"
      "{ await = \"paused=true\", within = \"300ms\" },\n"
      "{ send = \"pause KIT/0001\" },\n]\n"
      "[[test]]\nname = \"refused\"\nsteps = [\n"
      "{ simulate = \"KIT/0001 --vda 2.1 --reject startPause\" },\n"
      "{ send = \"pause KIT/0001 --wait\" } ]\n"
      "[[test]]\nname = \"left out\"\nskip = \"no charger\"\nsteps = [{ send = \"charge KIT/0001\" "
      "}]\n"
      "[[test]]\nname = \"too long\"\nsteps = [\n"
      "{ simulate = \"KIT/0001 --silent\" },\n"
      "{ send = \"pause KIT/0001 --wait\", within = \"700ms\" } ]\n");
  const std::string junit = (operator_.home().path() / "o.xml").string();
  const Finished run = Test(file, {"-o", "json", "--report", "junit=" + junit});
  EXPECT_EQ(run.exit_code, 5) << run.output << run.errors;
  EXPECT_THAT(Verdicts(run), ElementsAre("FAIL 6", "FAIL 13", "SKIPPED", "FAIL 22"));
  EXPECT_THAT(run.output, AllOf(HasSubstr("paused is false"), HasSubstr("KIT/0001 state headerId"),
                                HasSubstr("REJECTED"), HasSubstr("no charger")));
  const Finished read =
      ::fleetpub::testing::Run({{"python3", "-c",
                                 "import sys, xml.etree.ElementTree as e\n"
                                 "s = e.parse(sys.argv[1]).getroot().find('testsuite')\n"
                                 "print(s.get('tests'), s.get('failures'), s.get('skipped'))\n"
                                 "print([c.get('name') for c in s.findall('testcase')])",
                                 junit}});
  EXPECT_EQ(read.output, "4 3 1\n['fails', 'refused', 'left out', 'too long']\n");
}

TEST_F(Scenario, OfNoVirtualRobotIsInconclusive) {
  const auto real = Robot({"KIT/0001"});
  const Finished run = Test(
      WriteSteps("{ simulate = \"KIT/0001\" },\n{ send = \"pause KIT/0001\" },\n"), {"-o", "json"});
  EXPECT_EQ(run.exit_code, 6) << run.output;
  EXPECT_THAT(Verdicts(run), ElementsAre("INCONCLUSIVE 5"));
  EXPECT_EQ(Sent(), 0U);
}

TEST_F(Scenario, CommandsRealRobotsWithConsentOnly) {
  const auto real = Robot({"KIT/0001", "--state-interval", "100ms"});
  const std::string moves = WriteSteps("{ send = \"uncharge KIT/0001 --wait\" },\n");
  const Finished refused = Test(moves);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, AllOf(HasSubstr("KIT/0001"), HasSubstr("--yes")));
  EXPECT_EQ(Sent(), 0U);
  EXPECT_EQ(Test(moves, {"--yes"}).exit_code, 0);
  EXPECT_EQ(Sent(), 1U);
  // What stops it needs none.
  EXPECT_EQ(Test(WriteSteps("{ send = \"pause KIT/0001 --wait\" },\n"
                            "{ expect = \"paused=true\" },\n"))
                .exit_code,
            0);
}

TEST_F(Scenario, OfSeveralFilesSendsNothingWhenOneIsWrong) {
  const std::string good =
      WriteSteps("{ simulate = \"KIT/0001\" },\n{ send = \"pause KIT/0001\" },\n");
  struct Wrong {
    const char* text;
    const char* says;
  };
  const std::string head = "[[test]]\nname = \"x\"\nrobot = \"KIT/0001\"\nsteps = [ ";
  for (const auto& [text, says] : std::initializer_list<Wrong>{
           {"", "w.toml:1:1: "},
           {"test = 3", "w.toml:1:1: "},
           {"[[test]]\nname = \"x\"\nstep = []", "w.toml:3:1: step"},
           {"{ sned = \"pause KIT/0001\" }]", "w.toml:4:11: "},
           {"{ send = \"paus KIT/0001\" }]", "did you mean pause?"},
           {"{ send = \"pause KIT/0001\", within = 3 }]", "within"},
           {"{ send = \"pause KIT/0001 -b mqtt://127.0.0.1:1\" }]", "--broker"},
           {"{ send = \"simulate KIT/0001\" }]", "simulate"},
           {"{ send = \"test w.toml\" }]", "test"},
           {"{ send = \"pause ${who}\" }]", "${who}"},
           {"{ send = \"pause\" }]", "whom?"},
           {"{ send = \"pause KIT\" }]", "KIT"},
           {"{ simulate = \"KIT\" }]", "KIT"},
           {"{ simulate = \"KIT/a --count 2\" }]", "KIT/a"},
           {"{ capture = \"orderId\", as = \"../o\" }]", "as"},
           {"{ capture = \"${o}\", as = \"o\" }]", "${o}"},
           {"{ await = \"pausd=true\" }]", "paused"},
           {"{ await = true }]", "await"},
       }) {
    const bool is_step = std::string_view(text).starts_with('{');
    const std::string wrong = Write((is_step ? head : "") + text, "w.toml");
    const Finished run = Test(good, {wrong});
    EXPECT_EQ(run.exit_code, 2) << text << run.output;
    EXPECT_THAT(run.errors, AllOf(HasSubstr(wrong + ":"), HasSubstr(says)));
    EXPECT_EQ(run.output, "");
  }
  EXPECT_EQ(Test(good, {Write(std::string(2'000'000, 'a'), "w.toml")}).exit_code, 8);
  EXPECT_EQ(Test(good, {"not-there.toml"}).exit_code, 8);
  EXPECT_EQ(Test(good, {"--ask-password"}).exit_code, 2);
  EXPECT_EQ(Sent(), 0U);
}

TEST_F(Scenario, IsReadWithoutABrokerByCheck) {
  const std::string file = WriteSteps("{ send = \"charge KIT/0001\" },\n");
  operator_.UseBroker("mqtt://127.0.0.1:1");
  const Finished run = Test(file, {"--check", "-o", "json"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_EQ(Json(run.output)["steps"].GetUint(), 1U);
}

TEST_F(Scenario, IsChosenByItsName) {
  const std::string file = Write(
      "[[test]]\nname = \"pause one\"\nsteps = [{ simulate = \"KIT/0001\" }]\n"
      "[[test]]\nname = \"pause two\"\nsteps = [{ simulate = \"KIT/0002\" }]\n"
      "[[test]]\nname = \"charge\"\nsteps = [{ simulate = \"KIT/0003\" }]\n");
  const Finished run = Test(file, {"--only", "PAUSE", "--skip", "two", "-o", "json"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(Verdicts(run), ElementsAre("PASS"));
  EXPECT_THAT(run.output, HasSubstr("pause one"));
  EXPECT_EQ(Test(file, {"--only", "nothing"}).exit_code, 2);
}

class InterruptedScenario : public Scenario {
 protected:
  // Plays one that waits for long; its robot is there when this returns.
  [[nodiscard]] std::unique_ptr<Process> Start(const std::vector<std::string>& more = {}) {
    std::vector<std::string> words = {
        "test", Write("[[test]]\nname = \"first\"\nrobot = \"KIT/0001\"\nsteps = [\n"
                      "{ simulate = \"KIT/0001 --state-interval 50ms\" },\n"
                      "{ await = \"paused=true\", within = \"60s\" } ]\n"
                      "[[test]]\nname = \"second\"\nsteps = [{ simulate = \"KIT/0001\" }]\n")};
    words.insert(words.end(), more.begin(), more.end());
    auto process = std::make_unique<Process>(operator_.Prepare(std::move(words)));
    EXPECT_THAT(states_.Await(1), Not(IsEmpty()));
    return process;
  }
  Subscriber states_{broker_, "vda5050/v3/KIT/0001/state"};
};

TEST_F(InterruptedScenario, TellsWhatIsKnownAndLeavesNoRobot) {
  const Subscriber connections(broker_, "vda5050/v3/KIT/0001/connection");
  const std::string report = (operator_.home().path() / "o.tap").string();
  const auto test = Start({"-o", "json", "--report", "tap=" + report});
  test->Signal(SIGINT);
  EXPECT_EQ(test->Wait(), 130) << test->Errors();
  EXPECT_THAT(Verdicts({0, test->Output(), ""}),
              ElementsAre(StartsWith("INCONCLUSIVE "), "SKIPPED"));
  EXPECT_THAT(*base::ReadFile(report), HasSubstr("# SKIP INCONCLUSIVE"));
  const auto said = connections.SoFar();
  ASSERT_THAT(said, Not(IsEmpty()));
  EXPECT_NE(Fleetpub({"await", "KIT/0001", "connection", "connectionState=ONLINE", "-W", "200ms"})
                .exit_code,
            0);
}

// Where it may read nothing, a virtual robot listens for its own words before it is ready.
TEST_F(Scenario, InterruptedWhileARobotStartsLeavesNothingOfIt) {
  Mosquitto deaf({"allow_anonymous true", "acl_file {}/acl"},
                 {{"acl", "topic write #\nuser reader\ntopic read #\n"}});
  Process test(operator_.Prepare(
      {"test", WriteSteps("{ simulate = \"KIT/0001\" },\n"), "-o", "json", "-b", deaf.Url()}));
  ASSERT_TRUE(deaf.AwaitLog(", 'vda5050/v3/KIT/0001/connection'")) << "a PUBLISH";
  test.Signal(SIGINT);
  EXPECT_EQ(test.Wait(), 130) << test.Errors();
  const auto last = Json(Lines(test.Output()).back());
  EXPECT_FALSE(last["summary"]["complete"].GetBool());
  EXPECT_EQ(last["summary"]["exitCode"].GetInt(), 130);
  const Finished left = ::fleetpub::testing::Run(
      {.arguments = {"mosquitto_sub", "-p", std::to_string(deaf.port()), "-u", "reader", "-t", "#",
                     "-v", "--retained-only", "-W", "1"}});
  EXPECT_EQ(left.output, "");
}

TEST_F(InterruptedScenario, OutlivedByNothingWhenItIsKilled) {
  const Subscriber connections(broker_, "vda5050/v3/KIT/0001/connection");
  const auto test = Start();
  test->Signal(SIGKILL);
  EXPECT_EQ(test->Wait(), 128 + SIGKILL);
  const auto said = connections.Await(2);  // ONLINE, and what its end leaves
  ASSERT_GE(said.size(), 2U);
  EXPECT_THAT(said.back().payload, Not(HasSubstr("\"ONLINE\"")));
}

}  // namespace
}  // namespace fleetpub::testing
