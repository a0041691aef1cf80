#include "app/scenario/player.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

namespace fleetpub::app::scenario {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const vda5050::RobotAddress kRobot{"KIT", "0001"};

/// Virtual time; messages that come at times, and commands that take theirs.
class FakeStage final : public Stage {
 public:
  struct Script {
    milliseconds takes{10};
    CommandEnd end = {};
    bool is_online = false;
  };
  std::map<std::string, Script> commands;  // by their first word
  std::vector<std::string> started;
  std::vector<std::string> inputs;
  int running = 0;
  std::size_t lost = 0;
  std::optional<milliseconds> stop_at;

  /// A state with this member, headed by the next id or that one.
  void Say(milliseconds at, const std::string& member, std::optional<int> id = {},
           const std::string& topic = "state") {
    id_ = id.value_or(id_ + 1);
    said_.emplace(TimePoint() + at,
                  std::pair(topic, fmt::format(R"({{"headerId":{},{}}})", id_, member)));
  }

  Result<std::unique_ptr<RunningCommand>> Start(const std::vector<std::string>& words,
                                                const std::string& input) override {
    started.push_back(fmt::format("{}", fmt::join(words, " ")));
    inputs.push_back(input);
    return std::make_unique<Running>(*this, commands[words.front()]);
  }
  std::optional<Said> Next(TimePoint until) override {
    const auto next = said_.begin();
    if (next == said_.end() || next->first > until) {
      now_ = until;
      return std::nullopt;
    }
    now_ = std::max(now_, next->first);
    auto [topic, payload] = next->second;
    said_.erase(next);
    return Said{kRobot,
                conformance::MakeHeard(topic, {.topic = topic, .payload = payload}, now_, {})};
  }
  TimePoint Now() const override { return now_; }
  std::size_t losses() const override { return now_ > TimePoint() ? lost : 0; }
  bool IsStopped() const override { return stop_at && now_ >= TimePoint() + *stop_at; }

 private:
  class Running final : public RunningCommand {
   public:
    Running(FakeStage& stage, Script script)
        : stage_(stage), script_(std::move(script)), start_(stage.Now()) {
      ++stage_.running;
    }
    ~Running() override { --stage_.running; }
    bool IsOnline() const override { return script_.is_online; }
    std::optional<CommandEnd> Poll() override {
      if (stage_.Now() < start_ + script_.takes) return std::nullopt;
      return script_.end;
    }
    void Terminate() override {}

   private:
    FakeStage& stage_;
    Script script_;
    TimePoint start_;
  };

  TimePoint now_;
  int id_ = 0;
  std::multimap<TimePoint, std::pair<std::string, std::string>> said_;
};

class PlayingScenarios : public ::testing::Test {
 protected:
  static Step Look(StepKind kind, std::vector<std::string> conditions) {
    return {.kind = kind,
            .within = milliseconds(1'000),
            .robot = kRobot,
            .conditions = std::move(conditions)};
  }
  static Step Await(std::string condition) {
    return Look(StepKind::kAwait, {std::move(condition)});
  }
  static Step Expect(std::string condition, milliseconds hold = {}) {
    Step step = Look(StepKind::kExpect, {std::move(condition)});
    step.hold = hold;
    return step;
  }
  static Step Capture(std::string path, std::string name) {
    Step step = Look(StepKind::kCapture, {});
    step.path = std::move(path);
    step.name = std::move(name);
    return step;
  }
  static Step Send(std::vector<std::string> words, std::string outcome = "") {
    return {.kind = StepKind::kSend,
            .within = milliseconds(1'000),
            .words = std::move(words),
            .outcome = std::move(outcome)};
  }
  TestEnd Play(std::vector<Step> steps) {
    test_ = {.name = "x", .steps = std::move(steps)};
    return player_.Play(test_);
  }
  // Which step decided it, from 0.
  std::ptrdiff_t Decider(const TestEnd& end) const {
    return end.step == nullptr ? -1 : end.step - test_.steps.data();
  }

  FakeStage stage_;
  Player player_{stage_};
  scenario::Test test_;
};

TEST_F(PlayingScenarios, AwaitsInTimeOrNamesWhatWasSaidInstead) {
  stage_.Say(milliseconds(400), R"("paused":false)");
  stage_.Say(milliseconds(900), R"("paused":true)");
  EXPECT_EQ(Play({Await("paused=true")}).finding.verdict, Verdict::kPass);
  stage_.Say(milliseconds(1'000), R"("paused":false)", 3);
  const TestEnd late = Play({Await("paused=true")});
  EXPECT_EQ(late.finding.verdict, Verdict::kFail);
  EXPECT_THAT(late.finding.why, HasSubstr("paused is false"));
  EXPECT_THAT(late.finding.evidence, ElementsAre("KIT/0001 state headerId 3"));
  const TestEnd silent = Play({Await("paused=true")});
  EXPECT_EQ(silent.finding.verdict, Verdict::kFail);
  EXPECT_THAT(silent.finding.why, HasSubstr("no state came"));
}

TEST_F(PlayingScenarios, AwaitsInTheOrderOfTheSteps) {
  stage_.Say(milliseconds(10), R"("driving":false)");
  stage_.Say(milliseconds(20), R"("driving":true)");
  const TestEnd end = Play({Await("driving=true"), Await("driving=false")});
  EXPECT_EQ(Decider(end), 1) << "the false was before the true";
}

TEST_F(PlayingScenarios, AwaitsWhatCameSinceTheCommand) {
  stage_.commands["pause"].takes = milliseconds(100);
  stage_.Say(milliseconds(10), R"("paused":true)");  // before
  stage_.Say(milliseconds(150), R"("paused":false)");
  const TestEnd end = Play({Expect("paused=true"), Send({"pause"}), Await("paused=true")});
  EXPECT_EQ(Decider(end), 2) << end.finding.why;
}

TEST_F(PlayingScenarios, TakesWhatTheBrokerKeepsAsItIs) {
  stage_.Say(milliseconds(0), R"("connectionState":"ONLINE")", 1, "connection");
  Step step = Await("connectionState=ONLINE");
  step.topic = "connection";
  EXPECT_EQ(Play({step, Send({"pause"}), step}).finding.verdict, Verdict::kPass);
  EXPECT_EQ(Play({step}).finding.verdict, Verdict::kPass) << "also in the next test";
}

TEST_F(PlayingScenarios, ExpectsForATime) {
  stage_.Say(milliseconds(10), R"("paused":true)");
  stage_.Say(milliseconds(300), R"("paused":true)");
  EXPECT_EQ(Play({Expect("paused=true", milliseconds(500))}).finding.verdict, Verdict::kPass);
  stage_.Say(milliseconds(600), R"("paused":true)");
  stage_.Say(milliseconds(700), R"("paused":false)");
  stage_.Say(milliseconds(800), R"("paused":true)");
  EXPECT_EQ(Play({Expect("paused=true", milliseconds(500))}).finding.verdict, Verdict::kFail);
}

TEST_F(PlayingScenarios, DoesNotJudgeWhatMayBeMissing) {
  stage_.Say(milliseconds(10), R"("paused":true)", 1);
  stage_.Say(milliseconds(20), R"("paused":true)", 3);
  EXPECT_EQ(Play({Expect("paused=true", milliseconds(100))}).finding.verdict,
            Verdict::kInconclusive);
  stage_.Say(milliseconds(200), R"("paused":false)", 5);
  stage_.Say(milliseconds(210), R"("paused":false)", 8);
  EXPECT_EQ(Play({Await("paused=true")}).finding.verdict, Verdict::kInconclusive);
}

TEST_F(PlayingScenarios, DoesNotJudgeBesideALostConnection) {
  stage_.lost = 1;
  EXPECT_EQ(Play({Await("paused=true")}).finding.verdict, Verdict::kInconclusive);
}

TEST_F(PlayingScenarios, HoldsACommandToItsOutcomeAndTime) {
  using enum CommandEnd::Kind;
  stage_.commands["pause"].end = {
      .kind = kFailed, .outcomes = {"REJECTED"}, .why = "no", .evidence = {}};
  EXPECT_EQ(Play({Send({"pause"})}).finding.verdict, Verdict::kFail);
  EXPECT_EQ(Play({Send({"pause"}, "REJECTED")}).finding.verdict, Verdict::kPass);
  EXPECT_EQ(Play({Send({"pause"}, "FAILED")}).finding.verdict, Verdict::kFail);
  stage_.commands["pause"].end.kind = kTrouble;
  EXPECT_EQ(Play({Send({"pause"}, "REJECTED")}).finding.verdict, Verdict::kInconclusive);
  stage_.commands["pause"].takes = milliseconds(2'000);
  const TestEnd late = Play({Send({"pause"}), Send({"resume"})});
  EXPECT_EQ(late.finding.verdict, Verdict::kFail);
  EXPECT_EQ(Decider(late), 0);
  EXPECT_EQ(stage_.running, 0);
}

TEST_F(PlayingScenarios, KeepsVirtualRobotsUntilTheTestEnds) {
  stage_.commands["simulate"] = {.takes = milliseconds(100'000), .is_online = true};
  Step simulate = Send({"simulate", "KIT/0001"});
  simulate.kind = StepKind::kSimulate;
  EXPECT_EQ(Play({simulate, Await("paused=true")}).finding.verdict, Verdict::kFail);
  EXPECT_EQ(stage_.running, 0);
  stage_.commands["simulate"] = {
      .end = {.kind = CommandEnd::Kind::kFailed, .why = "ONLINE already"}};
  const TestEnd refused = Play({simulate, Send({"pause"})});
  EXPECT_EQ(refused.finding.verdict, Verdict::kInconclusive);
  EXPECT_THAT(refused.finding.why, HasSubstr("ONLINE already"));
}

TEST_F(PlayingScenarios, PutsWhatWasCapturedIntoWordsPayloadsAndConditions) {
  stage_.Say(milliseconds(0), R"("orderId":"o \"1\"","n":-5,"list":[])");
  Step send = Send({"publish", "x=${id}"});
  send.payload = R"({"id":"${id}","n":${n}})";
  EXPECT_EQ(Play({Capture("orderId", "id"), Capture("/n", "n"), send, Expect("orderId=${id}")})
                .finding.why,
            "4 steps");
  EXPECT_THAT(stage_.started, ElementsAre("publish x=o \"1\""));
  EXPECT_THAT(stage_.inputs, ElementsAre(R"({"id":"o \"1\"","n":-5})"));
  stage_.Say(milliseconds(0), R"("list":[])");
  EXPECT_EQ(Play({Capture("list", "l")}).finding.verdict, Verdict::kFail);
  stage_.Say(milliseconds(0), R"("list":[])");
  EXPECT_EQ(Play({Capture("other", "o")}).finding.verdict, Verdict::kFail);
}

TEST_F(PlayingScenarios, LetsNoRobotChooseAnOptionOrAFile) {
  for (const char* value : {"--yes", "-b", "@/etc/passwd", "a\\nb"}) {
    stage_.Say(milliseconds(0), fmt::format(R"("orderId":"{}")", value));
    const TestEnd end = Play({Capture("orderId", "id"), Send({"action", "${id}"})});
    EXPECT_EQ(end.finding.verdict, Verdict::kInconclusive) << value;
  }
  stage_.Say(milliseconds(0), R"("orderId":"@/etc/passwd")");
  EXPECT_EQ(Play({Capture("orderId", "id"), Send({"action", "area:=${id}"})}).finding.verdict,
            Verdict::kInconclusive);
  EXPECT_THAT(stage_.started, IsEmpty());
}

TEST_F(PlayingScenarios, EndsAtOnceWhenItIsStopped) {
  stage_.commands["pause"].takes = milliseconds(900);
  stage_.stop_at = milliseconds(200);
  const TestEnd end = Play({Send({"pause"}), Send({"resume"})});
  EXPECT_EQ(end.finding.verdict, Verdict::kInconclusive);
  EXPECT_THAT(end.finding.why, HasSubstr("interrupted"));
  EXPECT_EQ(stage_.running, 0);
  EXPECT_THAT(stage_.started, ElementsAre("pause"));
}

}  // namespace
}  // namespace fleetpub::app::scenario
