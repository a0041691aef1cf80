// `fleetpub explain`: an order's and an action's way through a recording, and what cannot be known.
#include <gmock/gmock.h>

#include <chrono>
#include <map>
#include <random>

#include "base/file.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::StrNe;

std::string Line(double t, const std::string& topic, const std::string& payload) {
  std::string escaped;
  for (const char c : payload) escaped += c == '"' ? "\\\"" : std::string(1, c);
  return fmt::format(
      R"({{"t":{},"at":"2026-03-04T05:{:02}:{:02}.000Z","topic":"vda5050/v3/KIT/0001/{}","qos":0,"retain":false,"payload":"{}"}})"
      "\n",
      t, static_cast<int>(t) / 60, static_cast<int>(t) % 60, topic, escaped);
}

std::string State(double t, int id, int sequence, const std::string& action,
                  const std::string& errors = "") {
  const bool is_done = sequence == 4;
  return Line(
      t, "state",
      fmt::format(
          R"({{"headerId":{},"orderId":"o1","orderUpdateId":0,"lastNodeId":"n{}","lastNodeSequenceId":{},"nodeStates":[{}],"edgeStates":[],"actionStates":[{{"actionId":"a1","actionType":"pick","actionStatus":"{}"}}],"errors":[{}]}})",
          id, sequence / 2, sequence, is_done ? "" : R"({"nodeId":"n2","sequenceId":4})", action,
          errors));
}

std::string Order(double t) {
  return Line(
      t, "order",
      R"({"headerId":1,"orderId":"o1","orderUpdateId":0,"nodes":[{"nodeId":"n0","sequenceId":0,"released":true,"actions":[]},{"nodeId":"n2","sequenceId":4,"released":true,"actions":[{"actionType":"pick","actionId":"a1"}]}],"edges":[]})");
}

// The verdict of each finding, and the exit code for `exit`.
std::map<std::string, std::string> ReadVerdicts(const Finished& run) {
  std::map<std::string, std::string> verdicts = {{"exit", std::to_string(run.exit_code)}};
  if (run.exit_code != 0) return verdicts;
  const auto told = Json(run.output);
  for (const auto& finding : told["findings"].GetArray()) {
    verdicts[finding["id"].GetString()] = finding["verdict"].GetString();
  }
  return verdicts;
}

class Explain : public ::testing::Test {
 protected:
  std::map<std::string, std::string> Verdicts(const std::string& text,
                                              std::vector<std::string> more = {}) {
    const std::string file = operator_.home().Write("shift.jsonl", text).string();
    more.insert(more.begin(), {"explain", "KIT/0001", "--from", file, "-o", "json"});
    last_ = operator_.Fleetpub(more);
    return ReadVerdicts(last_);
  }
  static std::string Whole() {
    return Order(0) + State(1, 7, 0, "WAITING") + State(5, 8, 2, "WAITING") +
           State(9, 9, 4, "RUNNING") + State(12, 10, 4, "FINISHED");
  }

  Operator operator_;
  Finished last_;
};

TEST_F(Explain, TellsAnOrdersWholeWay) {
  const auto verdicts = Verdicts(Whole());
  for (const auto& [id, verdict] : verdicts) EXPECT_EQ(verdict, id == "exit" ? "0" : "PASS") << id;
  EXPECT_EQ(verdicts.size(), 7U);
  for (const char* text : {"order o1 update 0 was sent", "taken", "node n1 (sequenceId 2)",
                           "pick (a1) is RUNNING", "nothing of the order is left"}) {
    EXPECT_THAT(last_.output, HasSubstr(text));
  }
}

TEST_F(Explain, FindsWhatTheRobotDidWrong) {
  EXPECT_EQ(Verdicts(Order(0) + State(1, 7, 0, "WAITING") + State(9, 8, 4, "FINISHED"))["nodes"],
            "FAIL");
  EXPECT_EQ(Verdicts(Whole() + State(13, 10, 4, "FINISHED"))["headerIds"], "FAIL");
  EXPECT_EQ(Verdicts(Whole() + State(60, 11, 4, "FINISHED"))["states"], "FAIL");
  std::string other;
  for (int i = 0; i < 5; ++i) {
    other += Line(i * 10, "state", fmt::format(R"({{"headerId":{},"orderId":""}})", i + 1));
  }
  EXPECT_EQ(Verdicts(Order(0) + other)["taken"], "FAIL");
}

TEST_F(Explain, TellsARefusal) {
  auto verdicts = Verdicts(
      Order(0) +
      Line(
          1, "state",
          R"({"headerId":1,"orderId":"","errors":[{"errorType":"orderError","errorLevel":"WARNING","errorReferences":[{"referenceKey":"orderId","referenceValue":"o1"}]}]})"));
  EXPECT_EQ(verdicts["taken"], "PASS");
  EXPECT_THAT(last_.output, HasSubstr("refused"));
}

TEST_F(Explain, SaysWhatTheRecordingCannotShow) {
  const std::string gap = R"({"t":6,"at":"2026-03-04T05:00:06.000Z","event":"gap","seconds":2.5})"
                          "\n";
  auto verdicts = Verdicts(Order(0) + State(1, 7, 0, "WAITING") + gap + State(9, 8, 4, "RUNNING"));
  EXPECT_EQ(verdicts["nodes"], "INCONCLUSIVE");
  EXPECT_EQ(verdicts["end"], "INCONCLUSIVE");
  EXPECT_EQ(Verdicts(Order(0))["taken"], "INCONCLUSIVE");
}

TEST_F(Explain, GivesNoFalseVerdictWhereMessagesAreMissing) {
  const auto lines = Lines(Whole());
  std::mt19937 random(7);
  for (int run = 0; run < 30; ++run) {
    std::string text;
    for (const std::string& line : lines) {
      if (random() % 3 != 0) text += line + "\n";
    }
    for (const auto& [id, verdict] : Verdicts(text)) {
      EXPECT_THAT(verdict, StrNe("FAIL")) << id << "\n" << text;
    }
  }
}

TEST_F(Explain, ExplainsAnActionThatTheLedgerKnows) {
  const Mosquitto broker;
  operator_.UseBroker(broker.Url());
  Process robot(operator_.Prepare({"simulate", "KIT/0001", "--state-interval", "200ms"}));
  ASSERT_TRUE(robot.AwaitErrors("online at"));
  const std::string file = (operator_.home() / "a.jsonl").string();
  Process recorder(operator_.Prepare({"record", "-f", file}));
  ASSERT_TRUE(recorder.AwaitErrors("recording mqtt"));
  EXPECT_EQ(operator_.Fleetpub({"pause", "KIT/0001", "--id", "p-1", "--wait"}).exit_code, 0);
  recorder.Signal();
  EXPECT_EQ(recorder.Wait(), 0);
  const Finished told =
      operator_.Fleetpub({"explain", "KIT/0001", "--action", "p-1", "--from", file});
  EXPECT_EQ(told.exit_code, 0) << told.errors;
  for (const char* text :
       {"fleetpub history show 1", "startPause (p-1) was sent", "is FINISHED", "PASS"}) {
    EXPECT_THAT(told.output, HasSubstr(text));
  }
}

TEST_F(Explain, RefusesWhatItCannotExplain) {
  EXPECT_EQ(Verdicts(Whole(), {"--order", "other"})["exit"], "6");
  EXPECT_EQ(Verdicts("")["exit"], "6");
  EXPECT_EQ(Verdicts("text\n")["exit"], "3");
  EXPECT_EQ(operator_.Fleetpub({"explain"}).exit_code, 2);
  EXPECT_EQ(Verdicts(Whole(), {"--for", "1s"})["exit"], "2");
  EXPECT_EQ(operator_.Fleetpub({"explain", "KIT/0001", "--from", "-"}).exit_code, 2);
  EXPECT_EQ(operator_.Fleetpub({"explain", "KIT/0001", "--from", "none"}).exit_code, 8);
}

// ---- Without a recording ----

class ExplainNow : public EndToEnd {
 protected:
  std::map<std::string, std::string> Verdicts(std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"explain", "KIT/0001", "-o", "json"});
    last_ = Fleetpub(more);
    return ReadVerdicts(last_);
  }
  [[nodiscard]] std::unique_ptr<Process> QuickRobot() const {
    return Robot({"KIT/0001", "--at", "n1", "--time-scale", "20", "--state-interval", "200ms"});
  }

  Finished last_;
};

TEST_F(ExplainNow, PutsTogetherWhatTheLedgerAndTheRobotKnow) {
  const auto robot = QuickRobot();
  EXPECT_EQ(Fleetpub({"order", "KIT/0001", "n1", "n2", "n3", "--wait"}).exit_code, 0);
  const auto verdicts = Verdicts();
  EXPECT_EQ(verdicts.at("exit"), "0") << last_.errors;
  EXPECT_EQ(verdicts.at("taken"), "PASS");
  EXPECT_EQ(verdicts.at("end"), "PASS");
  EXPECT_EQ(verdicts.at("nodes"), "INCONCLUSIVE") << "nobody saw it drive";
  for (const auto& [id, verdict] : verdicts) EXPECT_THAT(verdict, StrNe("FAIL")) << id;
  for (const char* text : {"update 0 was sent: 3 nodes", "fleetpub history show",
                           "nobody listened before", "node n3 (sequenceId 4)"}) {
    EXPECT_THAT(last_.output, HasSubstr(text));
  }
}

TEST_F(ExplainNow, FollowsAnOrderForAsLongAsSomebodyWants) {
  const auto robot = Robot({"KIT/0001", "--at", "n1", "--edge-time", "3s"});
  EXPECT_EQ(Fleetpub({"order", "KIT/0001", "n1", "n2", "n3", "--wait-for", "accepted"}).exit_code,
            0);
  const auto verdicts = Verdicts({"--for", "8s"});
  EXPECT_EQ(verdicts.at("end"), "PASS") << last_.output;
  EXPECT_EQ(verdicts.at("nodes"), "PASS") << last_.output;
}

TEST_F(ExplainNow, KnowsAnActionByWhatTheRobotSaidThen) {
  const auto robot = QuickRobot();
  EXPECT_EQ(Fleetpub({"pause", "KIT/0001", "--id", "p-1", "--wait"}).exit_code, 0);
  EXPECT_EQ(Verdicts({"--action", "p-1"}).at("end"), "PASS") << last_.output;
  EXPECT_THAT(last_.output, HasSubstr("startPause (p-1) was sent"));
}

TEST_F(ExplainNow, JudgesNothingOfARobotThatIsGone) {
  Say("vda5050/v3/KIT/0001/connection", R"({"connectionState":"OFFLINE"})", true);
  EXPECT_EQ(Send({"order", "KIT/0001", "n1", "n2"}).exit_code, 0);
  const auto start = std::chrono::steady_clock::now();
  const auto verdicts = Verdicts();
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5) * kSlowness);
  EXPECT_EQ(verdicts.at("exit"), "0") << last_.errors;
  for (const auto& [id, verdict] : verdicts) {
    EXPECT_EQ(verdict, id == "exit" ? "0" : "INCONCLUSIVE") << id;
  }
  EXPECT_THAT(last_.output, HasSubstr("connection OFFLINE"));
}

TEST_F(ExplainNow, SaysThatNothingIsKnown) {
  EXPECT_EQ(Verdicts({"--for", "200ms"}).at("exit"), "6");
  EXPECT_THAT(last_.errors, HasSubstr("--from"));
  broker_.Kill();
  EXPECT_EQ(Verdicts().at("exit"), "4");
}

}  // namespace
}  // namespace fleetpub::testing
