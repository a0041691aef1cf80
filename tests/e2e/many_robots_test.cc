// One command to many robots: each answer accounted for, none lost, nobody else kept waiting.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <map>
#include <set>

#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;
using ::testing::SizeIs;

class ManyRobots : public EndToEnd {
 protected:
  // Robots that were there and are not any more, as their last will says it.
  void LeaveOffline(int count) const {
    for (int i = 1; i <= count; ++i) {
      const std::string payload = fmt::format(
          R"({{"headerId":1,"timestamp":"2026-01-02T03:04:05.000Z","version":"2.1.0",)"
          R"("manufacturer":"OFF","serialNumber":"{:04}","connectionState":"OFFLINE"}})",
          i);
      const Finished done = fleetpub::testing::Run(
          {.arguments = {"mosquitto_pub", "-h", "127.0.0.1", "-p", std::to_string(broker_.port()),
                         "-q", "1", "-r", "-t", fmt::format("uagv/v2/OFF/{:04}/connection", i),
                         "-m", payload}});
      ASSERT_EQ(done.exit_code, 0) << done.errors;
    }
  }
  // Names by status.
  [[nodiscard]] static std::map<std::string, std::set<std::string>> ByStatus(const Finished& run) {
    std::map<std::string, std::set<std::string>> names;
    for (const std::string& line : Lines(run.output)) {
      const auto report = Json(line);
      if (!report.HasMember("summary")) {
        names[report["status"].GetString()].insert(report["target"].GetString());
      }
    }
    return names;
  }
};

std::set<std::string> Names(const char* manufacturer, int count) {
  std::set<std::string> names;
  for (int i = 1; i <= count; ++i) names.insert(fmt::format("{}/{:04}", manufacturer, i));
  return names;
}

TEST_F(ManyRobots, QuietKeepsTheSummaryWhenSomethingWentWrong) {
  const auto robots = Robot({"KIT/0001", "--count", "2"});
  const Finished good = Fleetpub({"pause", "--all", "--wait", "--quiet"});
  EXPECT_EQ(good.output + good.errors, "");
  const auto refusing = Robot({"NO/0001", "--reject", "pause"});
  const Finished bad = Fleetpub({"pause", "--all", "--wait", "--quiet"});
  EXPECT_EQ(bad.exit_code, 5);
  EXPECT_THAT(Lines(bad.output), SizeIs(1)) << "the result of the one that refused";
  EXPECT_THAT(bad.errors, AllOf(HasSubstr("3 robots at "), HasSubstr("2 finished, 1 failed"),
                                HasSubstr("NO/0001")));
}

TEST_F(ManyRobots, TheReportOnAThousandNamesExactlyThoseThatAreNotPaused) {
  const auto first = Robot({"A/0001", "--count", "250", "--vda", "1.1.0"});
  const auto second = Robot({"B/0001", "--count", "250", "--vda", "2.0.0"});
  const auto third = Robot({"C/0001", "--count", "250", "--vda", "2.1.0"});
  const auto fourth = Robot({"D/0001", "--count", "215", "--vda", "3.0.0"});
  const auto refusing = Robot({"NO/0001", "--count", "10", "--vda", "3.0.0", "--reject", "pause"});
  const auto silent = Robot({"MUTE/0001", "--count", "5", "--vda", "2.0.0", "--silent"});
  LeaveOffline(20);
  const Finished run = Fleetpub({"pause", "--all", "--wait", "--timeout", "8s", "-o", "json"});
  EXPECT_EQ(run.exit_code, 5) << run.errors;
  auto names = ByStatus(run);
  EXPECT_THAT(names["FINISHED"], SizeIs(965));
  EXPECT_EQ(names["OFFLINE"], Names("OFF", 20));
  EXPECT_EQ(names["FAILED"], Names("NO", 10));
  EXPECT_EQ(names["TIMEOUT"], Names("MUTE", 5));
  EXPECT_THAT(names, SizeIs(4));
  const auto lines = Lines(run.output);
  ASSERT_THAT(lines, SizeIs(1'001));
  EXPECT_THAT(
      lines.back(),
      HasSubstr(R"("robots":1000,"finished":965,"sent":0,"noOrder":0,"failed":10,"unconfirmed":5,)"
                R"("offline":20,"refused":0,"errors":0)"));
}

TEST_F(ManyRobots, APersonReadsASummary) {
  const auto robots = Robot({"KIT/0001", "--count", "3"});
  const auto refusing = Robot({"NO/0001", "--reject", "pause"});
  LeaveOffline(1);
  const Finished run = Fleetpub({"pause", "--all", "--wait"});
  EXPECT_EQ(run.exit_code, 5);
  const auto lines = Lines(run.output);
  ASSERT_THAT(lines, SizeIs(8));
  EXPECT_THAT(lines[5], MatchesRegex("5 robots at " + broker_.Url() +
                                     ": 3 finished, 1 failed, 1 offline  [0-9.]+ m?s"));
  EXPECT_EQ(lines[6], "  failed      NO/0001");
  EXPECT_EQ(lines[7], "  offline     OFF/0001");
  EXPECT_EQ(run.errors, "");
  const auto rows = Lines(Fleetpub({"history", "--status", "OFFLINE", "-o", "json"}).output);
  EXPECT_THAT(rows, SizeIs(1));
}

TEST_F(ManyRobots, WhatIsNotSentToARobotThatIsOfflineIsListedToo) {
  const auto robots = Robot({"KIT/0001", "--count", "2"});
  LeaveOffline(2);
  const Subscriber subscriber(broker_, "+/+/OFF/+/instantActions");
  const Finished run = Fleetpub({"resume", "--all", "--wait", "--yes", "-o", "json"});
  EXPECT_EQ(run.exit_code, 7);
  auto names = ByStatus(run);
  EXPECT_EQ(names["OFFLINE"], Names("OFF", 2));
  EXPECT_EQ(names["FINISHED"], Names("KIT", 2));
  EXPECT_THAT(subscriber.SoFar(), ::testing::IsEmpty());
}

TEST_F(ManyRobots, TheSlowOnesAreNamed) {
  const auto quick = Robot({"KIT/0001", "--count", "3"});
  const auto slow = Robot({"SLOW/0001", "--delay", "1200ms"});
  const Finished run = Fleetpub({"charge", "--all", "--wait", "--yes"});
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_THAT(run.output, HasSubstr("4 robots at " + broker_.Url() + ": 4 finished"));
  EXPECT_THAT(Lines(run.output).back(), HasSubstr("slow        SLOW/0001 1."));
}

TEST_F(ManyRobots, AtQosZeroAndOneNoneIsLost) {
  const auto robots = Robot({"KIT/0001", "--count", "1500"});
  for (const char* qos : {"0", "1"}) {
    const Finished run = Fleetpub({"pause", "KIT/*", "--wait", "-q", qos, "-o", "json"});
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(ByStatus(run)["FINISHED"], SizeIs(1'500));
  }
}

TEST_F(ManyRobots, ABulkJobKeepsNobodyWaiting) {
  const auto robots = Robot({"KIT/0001", "--count", "40"});
  Process bulk(operator_.Prepare({"resume", "KIT/*", "--yes", "--rate", "4", "-q", "1"}));
  ASSERT_TRUE(bulk.AwaitOutput("PUBLISHED"));
  const Finished own = Fleetpub({"pause", "KIT/0040", "--wait"});
  EXPECT_EQ(own.exit_code, 0) << own.output;
  EXPECT_TRUE(bulk.Running()) << "40 messages at 4 a second take ten";
  bulk.Signal(SIGINT);
  EXPECT_EQ(bulk.Wait(), 130);
  EXPECT_THAT(bulk.Output(), AllOf(HasSubstr("not sent: interrupted"), HasSubstr("40 robots at ")));
}

TEST_F(ManyRobots, ATerminalShowsHowFarItHasCome) {
  const auto robots = Robot({"KIT/0001", "--count", "3", "--delay", "3s"});
  Command command = operator_.Prepare({"charge", "KIT/*", "--wait", "--yes"});
  command.arguments = {"script", "-qec", command.arguments[0] + " charge 'KIT/*' --wait --yes",
                       "/dev/null"};
  const Finished shown = fleetpub::testing::Run(std::move(command));
  EXPECT_EQ(shown.exit_code, 0) << shown.output;
  EXPECT_THAT(shown.output, AllOf(HasSubstr("0 of 3"),
                                  HasSubstr("3 robots at " + broker_.Url() + ": 3 finished")));
  const Finished piped = Fleetpub({"charge", "KIT/*", "--wait", "--yes"});
  EXPECT_EQ(piped.errors, "");
  EXPECT_THAT(piped.output, Not(HasSubstr("of 3 ")));
}

}  // namespace
}  // namespace fleetpub::testing
