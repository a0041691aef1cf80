#include "cli/output/fleet_summary.h"

#include <gmock/gmock.h>

#include "base/json.h"

namespace fleetpub::cli {
namespace {

using message::CommandStatus;
using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

void Add(FleetSummary& summary, const char* target, CommandStatus status, milliseconds elapsed) {
  message::Report report;
  report.target = target;
  report.status = status;
  report.elapsed = elapsed;
  summary.Add(report);
}

TEST(FleetSummary, NamesThoseThatAPersonHasToLookAfter) {
  FleetSummary summary;
  Add(summary, "KIT/1", CommandStatus::kFinished, milliseconds(5));
  Add(summary, "KIT/4", CommandStatus::kRejected, milliseconds(5));
  Add(summary, "KIT/2", CommandStatus::kFailed, milliseconds(5));
  Add(summary, "KIT/3", CommandStatus::kTimeout, milliseconds(5));
  Add(summary, "KIT/5", CommandStatus::kOffline, milliseconds(0));
  EXPECT_THAT(
      summary.Lines(milliseconds(42), "mqtt://north"),
      ElementsAre("5 robots at mqtt://north: 1 finished, 2 failed, 1 unconfirmed, 1 offline  42 ms",
                  "  failed      KIT/2, KIT/4", "  unconfirmed KIT/3", "  offline     KIT/5"));
}

TEST(FleetSummary, GroupsByReasonOfWhomNothingWasTold) {
  FleetSummary summary;
  const auto add = [&](const char* target, CommandStatus status, const char* why) {
    message::Report report;
    report.target = target;
    report.status = status;
    report.message = why;
    summary.Add(report);
  };
  add("KIT/1", CommandStatus::kFinished, "");
  add("KIT/4", CommandStatus::kFailed, "no load");
  add("KIT/3", CommandStatus::kFailed, "battery low");
  add("KIT/2", CommandStatus::kFailed, "no load");
  add("KIT/5", CommandStatus::kTimeout, "");
  const auto lines = summary.Lines(milliseconds(1), "mqtt://north", FleetSummary::Names::kByReason);
  EXPECT_THAT(lines, ElementsAre(HasSubstr("1 finished, 3 failed, 1 unconfirmed"),
                                 "  FAILED      KIT/3  battery low",
                                 "  FAILED      KIT/2, KIT/4  no load", "  TIMEOUT     KIT/5"));
}

TEST(FleetSummary, GoesOnGroupingByReasonsThatItKnows) {
  FleetSummary summary;
  message::Report report;
  report.status = CommandStatus::kFailed;
  for (int i = 0; i < 150; ++i) {
    report.target = "KIT/" + std::to_string(i);
    report.message = "reason " + std::to_string(i);
    summary.Add(report);
  }
  report.target = "KIT/999";
  report.message = "reason 7";
  summary.Add(report);
  const auto lines = summary.Lines(milliseconds(1), "mqtt://north", FleetSummary::Names::kByReason);
  EXPECT_THAT(lines, SizeIs(102)) << "a hundred reasons, and one line for the rest";
  EXPECT_THAT(lines, ::testing::Contains("  FAILED      KIT/7, KIT/999  reason 7"));
}

TEST(FleetSummary, CountsEveryStatusUnderOneWord) {
  FleetSummary summary;
  for (std::size_t i = 0; i < message::kCommandStatuses.size(); ++i) {
    Add(summary, "KIT/1", static_cast<CommandStatus>(i), milliseconds(1));
  }
  EXPECT_EQ(summary.Counts(),
            "2 finished, 3 sent, 1 no order, 2 failed, 4 unconfirmed, 1 offline, 2 refused, "
            "1 errors");
  const auto json =
      base::ParseJson(summary.Json(milliseconds(7), ExitCode::kBroker, "mqtt://north"));
  EXPECT_EQ((*json)["summary"]["noOrder"].GetInt(), 1);
}

TEST(FleetSummary, NamesTheSlowOnesAmongTheFinished) {
  FleetSummary summary;
  for (int i = 0; i < 9; ++i) Add(summary, "KIT/1", CommandStatus::kFinished, milliseconds(400));
  Add(summary, "KIT/2", CommandStatus::kFinished, milliseconds(1'100));
  EXPECT_THAT(summary.Lines(milliseconds(1), "mqtt://north"), SizeIs(1))
      << "not three times the median";
  Add(summary, "KIT/3", CommandStatus::kFinished, milliseconds(1'300));
  EXPECT_EQ(summary.Lines(milliseconds(1), "mqtt://north").back(), "  slow        KIT/3 1.3 s");
}

TEST(FleetSummary, BoundsItsLists) {
  FleetSummary summary;
  for (int i = 0; i < 60; ++i) Add(summary, "KIT/1", CommandStatus::kTimeout, milliseconds(1));
  EXPECT_THAT(summary.Lines(milliseconds(1), "mqtt://north").back(), HasSubstr(" and 10 more"));
}

TEST(FleetSummary, IsAnObjectForScripts) {
  FleetSummary summary;
  Add(summary, "KIT/1", CommandStatus::kPublished, milliseconds(2));
  Add(summary, "KIT/2", CommandStatus::kRefused, milliseconds(0));
  Add(summary, "KIT/3", CommandStatus::kError, milliseconds(0));
  const auto json =
      base::ParseJson(summary.Json(milliseconds(7), ExitCode::kBroker, "mqtt://north"));
  ASSERT_TRUE(json.has_value());
  const auto& members = (*json)["summary"];
  EXPECT_STREQ(members["site"].GetString(), "mqtt://north");
  EXPECT_EQ(members["robots"].GetInt(), 3);
  EXPECT_EQ(members["sent"].GetInt(), 1);
  EXPECT_EQ(members["refused"].GetInt(), 1);
  EXPECT_EQ(members["errors"].GetInt(), 1);
  EXPECT_EQ(members["exitCode"].GetInt(), 4);
  EXPECT_TRUE(members["slow"].IsArray());
}

}  // namespace
}  // namespace fleetpub::cli
