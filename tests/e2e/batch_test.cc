// `fleetpub batch`: lines in, lines out, with a real broker and virtual robots.
#include <gmock/gmock.h>

#include <algorithm>

#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::StartsWith;

class Batching : public EndToEnd {
 protected:
  Finished Batch(std::string input, std::vector<std::string> options = {}) const {
    options.insert(options.begin(), "batch");
    Command command = operator_.Prepare(std::move(options));
    command.input = std::move(input);
    return ::fleetpub::testing::Run(std::move(command));
  }
  // A co-process, to be written to.
  std::unique_ptr<Process> Start(std::vector<std::string> arguments) const {
    Command command = operator_.Prepare(std::move(arguments));
    command.input = std::nullopt;
    return std::make_unique<Process>(std::move(command));
  }
  std::unique_ptr<Process> Simulate(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "simulate");
    auto robots = std::make_unique<Process>(operator_.Prepare(std::move(arguments)));
    EXPECT_TRUE(robots->AwaitErrors("online at")) << robots->Errors();
    return robots;
  }
  static std::string Pause(const std::string& target, const std::string& more = "") {
    return R"({"target":")" + target + R"(","action":"startPause")" + more + "}\n";
  }
};

TEST_F(Batching, AnswersEachLineWithItsNumberAndId) {
  const Subscriber subscriber(broker_);
  const Finished run =
      Batch(Pause("KIT/0001", R"(,"id":"a")") + "\n" + Pause("KIT/0002", R"(,"id":7,"vda":"2.1")"));
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  const auto lines = Lines(run.output);
  ASSERT_THAT(lines, SizeIs(2));
  EXPECT_THAT(lines[0], StartsWith(R"({"line":1,"id":"a","exitCode":0,"target":"KIT/0001",)"));
  const auto second = Json(lines[1]);
  EXPECT_EQ(second["line"].GetInt(), 3);
  EXPECT_EQ(second["id"].GetInt(), 7);
  EXPECT_STREQ(second["status"].GetString(), "SENT");
  EXPECT_STREQ(second["topic"].GetString(), "uagv/v2/KIT/0002/instantActions");
  EXPECT_THAT(subscriber.Await(2), SizeIs(2));
}

TEST_F(Batching, KeepsTheOrderOfATopicOverManyBatches) {
  std::string input;
  for (int i = 0; i < 1'200; ++i) input += Pause("KIT/0001");
  const Subscriber subscriber(broker_);
  const Finished run = Batch(input);
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(Lines(run.output), SizeIs(1'200));
  const auto messages = subscriber.Await(1'200);
  ASSERT_THAT(messages, SizeIs(1'200));
  for (int i = 0; i < 1'200; ++i) {
    EXPECT_EQ(Json(messages[static_cast<std::size_t>(i)].payload)["headerId"].GetInt(), i);
  }
}

TEST_F(Batching, ReportsABadLineAndGoesOn) {
  const Subscriber subscriber(broker_);
  const std::string hostile = "nonsense\n{\"a\":\"\xff\"}\n" + std::string(1, '\0') + "\n" +
                              std::string(200, '[') + "\n" + std::string(17'000'000, 'x') + "\n";
  const Finished run =
      Batch(Pause("KIT/0001") + hostile + R"({"target":"KIT/0002","action":"startPause"})");
  EXPECT_EQ(run.exit_code, 3);
  const auto lines = Lines(run.output);
  ASSERT_THAT(lines, SizeIs(7));
  std::vector<int> bad;
  for (const std::string& line : lines) {
    const auto result = Json(line);
    if (result["exitCode"].GetInt() == 0) continue;
    bad.push_back(result["line"].GetInt());
    EXPECT_STREQ(result["status"].GetString(), "INVALID");
  }
  EXPECT_THAT(bad, ::testing::ElementsAre(2, 3, 4, 5, 6));
  EXPECT_THAT(run.output, HasSubstr("has a line of more than 16777216 bytes"));
  EXPECT_THAT(subscriber.Await(2), SizeIs(2));
}

TEST_F(Batching, HasNothingToDoWithoutLines) {
  const Finished run = Batch("");
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, IsEmpty());
}

TEST_F(Batching, WaitsForRobotsAndTellsTheWorst) {
  const auto robots = Simulate({"KIT/0001", "--count", "3", "--fail", "logReport"});
  const Finished run =
      Batch(Pause("KIT/0001") + Pause("KIT/0002", R"(,"wait":"accepted")") +
                R"({"target":"KIT/0003","action":"logReport","parameters":{"reason":"x"}})" + "\n",
            {"--wait"});
  EXPECT_EQ(run.exit_code, 5) << run.errors;
  EXPECT_THAT(run.output, AllOf(HasSubstr("FINISHED"), HasSubstr("ACCEPTED"), HasSubstr("FAILED")));
}

TEST_F(Batching, LeavesOutWhoIsOfflineWithoutFailing) {
  const auto robots = Simulate({"KIT/0001"});
  Say("vda5050/v3/KIT/0002/connection",
      R"({"headerId":1,"timestamp":"2026-01-02T03:04:05.000Z","version":"3.0.0",)"
      R"("manufacturer":"KIT","serialNumber":"0002","connectionState":"OFFLINE"})",
      true);
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{}, std::vector<std::string>{"--no-check", "--vda", "3"}}) {
    std::vector<std::string> options = {"--online", "--discover", "50"};
    options.insert(options.end(), more.begin(), more.end());
    const Finished run = Batch(Pause("KIT/0002") + Pause("KIT/0001"), options);
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    const auto lines = Lines(run.output);
    ASSERT_THAT(lines, SizeIs(2)) << run.output;
    for (const std::string& line : lines) {
      const auto result = Json(line);
      EXPECT_EQ(result["exitCode"].GetInt(), 0);
      const bool is_away = result["line"].GetInt() == 1;
      EXPECT_STREQ(result["status"].GetString(), is_away ? "OFFLINE" : "SENT");
    }
    const Finished unknown = Batch(Pause("KIT/0009"), options);
    EXPECT_EQ(unknown.exit_code, 7) << unknown.output;
    EXPECT_THAT(unknown.output, HasSubstr("REFUSED"));
  }
  EXPECT_EQ(Batch("", {"--online", "--dry-run", "--offline"}).exit_code, 2);
}

TEST_F(Batching, EndsWhatIsNotConfirmedInTime) {
  const Finished run = Batch(Pause("KIT/0001", R"(,"wait":true)"), {"-W", "200ms"});
  EXPECT_EQ(run.exit_code, 6) << run.errors;
  EXPECT_THAT(run.output, HasSubstr("TIMEOUT"));
}

TEST_F(Batching, AnswersALoneLineAtOnceAsACoProcess) {
  const auto robots = Simulate({"KIT/0001"});
  const auto batch = Start({"batch", "--wait"});
  for (int i = 1; i <= 3; ++i) {
    batch->Write(Pause("KIT/0001"));
    ASSERT_TRUE(batch->AwaitOutput("{\"line\":" + std::to_string(i) + ","));
  }
  EXPECT_TRUE(batch->Running());
  batch->CloseInput();
  EXPECT_EQ(batch->Wait(), 0) << batch->Errors();
}

TEST_F(Batching, BringsToAnEndWhatIsInFlightWhenInterrupted) {
  const auto robots = Simulate({"KIT/0001", "--delay", "1s"});
  const auto batch = Start({"batch", "--wait"});
  batch->Write(Pause("KIT/0001"));
  ASSERT_TRUE(broker_.AwaitLog("'vda5050/v3/KIT/0001/instantActions'"));
  batch->Signal(SIGINT);
  batch->Write(Pause("KIT/0001"));
  EXPECT_EQ(batch->Wait(), 130);
  EXPECT_THAT(Lines(batch->Output()), SizeIs(1));
  EXPECT_THAT(batch->Output(), HasSubstr("FINISHED"));
  EXPECT_THAT(batch->Errors(), HasSubstr("interrupted: 1 message was sent; nothing was sent from "
                                         "line 2 on"));
}

TEST_F(Batching, EndsAtOnceWhenInterruptedTwice) {
  const auto batch = Start({"batch", "--wait"});
  batch->Write(Pause("KIT/0001"));
  ASSERT_TRUE(broker_.AwaitLog("'vda5050/v3/KIT/0001/instantActions'"));
  batch->Signal(SIGTERM);
  EXPECT_FALSE(batch->Wait(std::chrono::milliseconds(300)));
  batch->Signal(SIGTERM);
  EXPECT_EQ(batch->Wait(), 143);
  EXPECT_THAT(batch->Errors(), HasSubstr("ended at once"));
}

TEST_F(Batching, StopsAtTheFirstError) {
  const Subscriber subscriber(broker_);
  const Finished run = Batch(Pause("KIT/0001") + "bad\n" + Pause("KIT/0002"), {"--stop-on-error"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(Lines(run.output), SizeIs(2));
  EXPECT_THAT(run.errors, HasSubstr("stopped at the first error: 1 message was sent; nothing was "
                                    "sent from line 3 on"));
  EXPECT_THAT(subscriber.Await(1), SizeIs(1));
}

TEST_F(Batching, KeepsToARate) {
  std::string input;
  for (int i = 0; i < 6; ++i) input += Pause("KIT/0001");
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(Batch(input, {"--rate", "10"}).exit_code, 0);
  EXPECT_GE(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(490));
  EXPECT_EQ(Batch(input, {"--rate", "fast"}).exit_code, 2);
}

// With a reader that goes away, a full disk, no standard output at all.
TEST_F(Batching, FailsWhenLinesAreNotSentBecauseNobodyReads) {
  std::string input;
  for (int i = 0; i < 4'000; ++i) input += Pause("KIT/0001", R"(,"vda":"2.1")");
  const std::string file = operator_.home().Write("lines", input);
  const std::string one = operator_.home().Write("one", Pause("KIT/0001", R"(,"vda":"2.1")"));
  const auto in_shell = [&](const std::string& rest) {
    Command command = operator_.Prepare({"batch"});
    command.arguments = {"bash", "-c",
                         "set -o pipefail; " + Binary() + " batch --no-check " + rest};
    return ::fleetpub::testing::Run(std::move(command));
  };
  for (const char* output : {"> /dev/full", ">&-", "| head -2"}) {
    const Finished run = in_shell("--rate 500 " + file + " " + output);
    EXPECT_EQ(run.exit_code, 8) << output;
    EXPECT_THAT(run.errors, HasSubstr("nothing was sent from line")) << output;
  }
  for (const char* rate : {"", "--rate 1 "}) {
    const Finished all = in_shell(rate + one + " > /dev/full");
    EXPECT_EQ(all.exit_code, 0) << "everything was sent";
    EXPECT_THAT(all.errors, AllOf(HasSubstr("could not be written"), Not(HasSubstr("line 2"))));
  }
}

TEST_F(Batching, OutlivesARestartOfTheBroker) {
  const auto batch = Start({"batch"});
  batch->Write(Pause("KIT/0001"));
  ASSERT_TRUE(batch->AwaitOutput("SENT"));
  broker_.Kill();
  ASSERT_TRUE(batch->AwaitErrors("connecting again"));
  broker_.Restart();
  ASSERT_TRUE(batch->AwaitErrors("connected again")) << batch->Errors();
  const Subscriber subscriber(broker_);
  batch->Write(Pause("KIT/0001"));
  ASSERT_TRUE(batch->AwaitOutput("\"line\":2"));
  batch->CloseInput();
  EXPECT_EQ(batch->Wait(), 0) << batch->Output();
  const auto messages = subscriber.Await(1);
  ASSERT_THAT(messages, SizeIs(1));
  EXPECT_EQ(Json(messages[0].payload)["headerId"].GetInt(), 1);
}

TEST_F(Batching, GivesUpWhenTheBrokerStaysAway) {
  const auto batch = Start({"batch", "--wait", "--reconnect", "500ms"});
  batch->Write(Pause("KIT/0001"));
  ASSERT_TRUE(broker_.AwaitLog("'vda5050/v3/KIT/0001/instantActions'"));
  broker_.Kill();
  EXPECT_EQ(batch->Wait(), 4) << batch->Errors();
  EXPECT_THAT(batch->Output(), HasSubstr("sent, but the connection was lost before the robot "
                                         "answered"));
  EXPECT_THAT(batch->Errors(), HasSubstr("nothing was sent from line 2 on"));
}

TEST_F(Batching, EndsADryRunAtOnceWhenInterrupted) {
  const auto batch = Start({"batch", "--dry-run"});
  batch->Write(Pause("KIT/0001"));
  ASSERT_TRUE(batch->AwaitOutput("startPause"));
  batch->Signal(SIGINT);
  EXPECT_EQ(batch->Wait(), 130);
}

TEST_F(Batching, ShowsInADryRunWhatWouldBeNext) {
  const Finished run = Batch(Pause("KIT/0001") + Pause("KIT/0001"), {"--dry-run"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  const auto lines = Lines(run.output);
  ASSERT_THAT(lines, SizeIs(2));
  EXPECT_EQ(Json(lines[1])["payload"]["headerId"].GetInt(), 1);
  EXPECT_THAT(lines, Each(HasSubstr("DRY_RUN")));
}

}  // namespace
}  // namespace fleetpub::testing
