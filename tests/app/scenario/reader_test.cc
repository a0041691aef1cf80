#include <fmt/format.h>
#include <gmock/gmock.h>

#include "app/scenario/scenario.h"

namespace fleetpub::app::scenario {
namespace {

using std::chrono::milliseconds;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

class ReadingScenarios : public ::testing::Test {
 protected:
  Suite Read(std::string_view text) {
    mistakes_.clear();
    return ReadSuite(text, "s.toml", config_, check_, mistakes_);
  }
  // Of one step, in line 4.
  Step ReadStep(const std::string& step) {
    const Suite suite =
        Read("[[test]]\nname = \"x\"\nrobot = \"KIT/0001\"\nsteps = [" + step + "]");
    const bool is_one = suite.tests.size() == 1 && suite.tests[0].steps.size() == 1;
    return is_one ? suite.tests[0].steps[0] : Step{};
  }
  // The only mistake.
  std::string Mistake(const std::string& step) {
    (void)ReadStep(step);
    return mistakes_.size() == 1 ? mistakes_[0].message : fmt::format("{}", mistakes_.size());
  }

  config::Config config_;
  config::Mistakes mistakes_;
  CommandCheck check_ = [](Step& step) -> Status {
    if (step.words.front() == "wrong") return Fail(ErrorKind::kUsage, "no such command");
    step.targets = {step.words.back()};
    return {};
  };
};

TEST_F(ReadingScenarios, TakesLimitsOfStepFileAndNobody) {
  constexpr const char* kSteps =
      "[[test]]\nname = \"x\"\nsteps = [{ send = \"pause KIT/0001\" }, { send = \"pause "
      "KIT/0001\", "
      "within = \"700ms\" }]\n";
  EXPECT_EQ(Read(kSteps).tests[0].steps[0].within, milliseconds(10'000));
  const Suite suite = Read(std::string("within = \"2s\"\n") + kSteps);
  EXPECT_THAT(mistakes_, IsEmpty());
  EXPECT_EQ(suite.tests[0].steps[0].within, milliseconds(2'000));
  EXPECT_EQ(suite.tests[0].steps[1].within, milliseconds(700));
}

TEST_F(ReadingScenarios, TakesWordsAsATextOrAList) {
  EXPECT_THAT(ReadStep(R"({ send = " pause  KIT/0001 --wait" })").words,
              ElementsAre("pause", "KIT/0001", "--wait"));
  EXPECT_THAT(ReadStep("{ send = \"\"\"\npause\n\tKIT/0001\"\"\" }").words,
              ElementsAre("pause", "KIT/0001"));
  EXPECT_THAT(ReadStep(R"({ send = "fleetpub pause KIT/0001" })").words,
              ElementsAre("pause", "KIT/0001"));
  EXPECT_THAT(ReadStep(R"({ send = ["action", "say", "text=two words"] })").words,
              ElementsAre("action", "say", "text=two words"));
  EXPECT_THAT(ReadStep(R"({ simulate = "KIT/0001" })").words, ElementsAre("simulate", "KIT/0001"));
  EXPECT_THAT(Mistake(R"({ send = "action say 'text=two words'" })"), HasSubstr("a list"));
}

TEST_F(ReadingScenarios, LooksAtTheTestsRobotUnlessAStepSaysAnother) {
  EXPECT_EQ(ReadStep(R"({ await = "paused=true" })").robot.ToString(), "KIT/0001");
  const Step step = ReadStep(
      R"({ expect = "connectionState=ONLINE", robot = "KIT/2", topic = "connection", for = "2s" })");
  EXPECT_EQ(step.robot.ToString(), "KIT/2");
  EXPECT_EQ(step.topic, "connection");
  EXPECT_EQ(step.hold, milliseconds(2'000));
  (void)Read("[[test]]\nname = \"x\"\nsteps = [{ await = \"paused=true\" }]");
  ASSERT_THAT(mistakes_, SizeIs(1));
  EXPECT_THAT(mistakes_[0].message, HasSubstr("whose message?"));
}

TEST_F(ReadingScenarios, RefusesWithPlaceAndWhatToWrite) {
  struct Wrong {
    const char* step;
    const char* says;
  };
  for (const auto& [step, says] : std::initializer_list<Wrong>{
           {R"({ send = "wrong" })", "send: no such command"},
           {R"({ within = "2s" })", "one of simulate, send, expect, await, capture"},
           {R"({ sned = "pause KIT/0001" })", "sned: there is no such step: did you mean send?"},
           {R"({ send = "pause x", await = "paused=true" })", "write two steps"},
           {R"({ send = "pause x", robot = "KIT/1" })", "robot: there is no such key"},
           {R"({ send = 5 })", "send takes a text"},
           {R"({ send = ["a", 5] })", "send takes a text"},
           {R"({ send = [] })", "send takes a text"},
           {R"({ send = "" })", "send takes a text"},
           {R"({ send = " " })", "send takes a text"},
           {R"({ send = "pause x", outcome = "DONE" })", "FINISHED"},
           {R"({ send = "pause x", within = "soon" })", "within takes a time"},
           {R"({ await = "paused" })", "it has no operator"},
           {R"({ await = "pausd=true" })", "paused"},
           {R"({ await = "paused=true", topic = "stat" })", "topic is one of"},
           {R"({ await = "paused=true", robot = "KIT" })", "robot: "},
           {R"({ await = "orderId=${o}" })", "as = \"o\""},
           {R"({ await = "orderId=${" })", "${name}"},
           {R"({ capture = "orderId" })", "as = "},
           {R"({ capture = "orderId", as = "../x" })", "letters"},
           {R"({ capture = "a.b", as = "x" })", "capture takes one member"},
           {R"({ capture = "${x}", as = "x" })", "as = \"x\""},
           {R"("pause")", "one of simulate"},
       }) {
    EXPECT_THAT(Mistake(step), AllOf(StartsWith("s.toml:4:"), HasSubstr(says))) << step;
  }
}

TEST_F(ReadingScenarios, TellsAllMistakesOfAFile) {
  (void)Read(
      "limit = \"5s\"\n[[test]]\nname = \"x\"\nsteps = [{ send = \"wrong\" }, { await = \"x\" }]\n"
      "[[test]]\nname = \"x\"\n[[test]]\nsteps = 5\n");
  EXPECT_THAT(mistakes_, SizeIs(7)) << "key, two steps, no steps, name twice, no name, no steps";
  for (const char* text : {"", "x", "test = []", "test = 5", "[test]", "\xff"}) {
    (void)Read(text);
    EXPECT_THAT(mistakes_, SizeIs(1)) << text;
  }
}

TEST_F(ReadingScenarios, KnowsWhomItCommandsThoughNobodySimulatesIt) {
  const Suite suite = Read(
      "[[test]]\nname = \"x\"\nsteps = [{ send = \"pause a\" }, { simulate = \"a\" }, { simulate = "
      "\"b\" }, { send = \"pause b\" }, { send = \"pause c\" }, { send = \"pause c\" }]");
  EXPECT_THAT(suite.tests.at(0).ListReal(), ElementsAre("a", "c"));
}

TEST(Variables, AreExpandedOnce) {
  Variables variables;
  variables["t"].SetString("say \"${n}\"", variables["t"].GetAllocator());
  variables["n"].SetInt(-5);
  EXPECT_EQ(Expand("x=${n} ${t}.", variables, Into::kText), "x=-5 say \"${n}\".");
  EXPECT_EQ(Expand(R"({"a":"${t}","b":${n}})", variables, Into::kJson),
            R"({"a":"say \"${n}\"","b":-5})");
  EXPECT_THAT(*FindVariables("${a} $b ${c}"), ElementsAre("a", "c"));
  for (const char* text : {"${", "${}", "${a b}", "x ${a"})
    EXPECT_FALSE(FindVariables(text)) << text;
}

}  // namespace
}  // namespace fleetpub::app::scenario
