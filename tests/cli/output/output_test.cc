#include "cli/output/output.h"

#include <gmock/gmock.h>

#include <chrono>

#include "base/json.h"
#include "support/environment.h"

namespace fleetpub::cli {
namespace {

using namespace std::chrono_literals;
using message::CommandStatus;
using message::Report;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

Report SentReport() {
  return {.target = "KIT/0001",
          .protocol = "vda5050",
          .version = "3.0.0",
          .topic = "vda5050/v3/KIT/0001/instantActions",
          .actions = {{"startPause", "a1"}},
          .header_id = 18,
          .status = CommandStatus::kSent,
          .elapsed = 42ms};
}

Report ErrorReport() {
  Report report = SentReport();
  report.header_id.reset();
  report.status = CommandStatus::kError;
  report.error = ErrorKind::kBroker;
  report.message = "not sent: mqtt://broker:1883: connection lost";
  report.elapsed = 0ms;
  return report;
}

std::string Text(const Report& report, std::size_t width = 0) {
  const testing::EnvironmentVariable no_colour("NO_COLOR", "1");
  return ReportText(report, width, Output({}));
}

std::vector<std::string> NamesIn(const base::JsonValue& object) {
  std::vector<std::string> names;
  for (const auto& member : object.GetObject()) names.emplace_back(member.name.GetString());
  return names;
}

TEST(ReportText, TellsTargetActionStatusAndTime) {
  EXPECT_EQ(Text(SentReport()), "KIT/0001  startPause  SENT  42 ms");
}

TEST(ReportText, AlignsSeveralTargets) {
  EXPECT_EQ(Text(SentReport(), 10), "KIT/0001    startPause  SENT  42 ms");
}

TEST(ReportText, SaysThatAVersionIsAssumed) {
  Report report = SentReport();
  report.version_assumed = true;
  EXPECT_EQ(Text(report), "KIT/0001  startPause  SENT  42 ms  3.0.0 (assumed)");
}

TEST(ReportText, SaysWhyItIsNoSuccess) {
  EXPECT_EQ(Text(ErrorReport()),
            "KIT/0001  startPause  ERROR  not sent: mqtt://broker:1883: connection lost");
}

TEST(ReportText, NamesEveryAction) {
  Report report = SentReport();
  report.actions.push_back({"beep", "a2"});
  EXPECT_THAT(Text(report), HasSubstr("  startPause,beep  "));
}

TEST(ReportText, MovesNoCursor) {
  Report report = SentReport();
  report.target = "KIT/\x1b[2J";
  report.actions = {{"beep\x1b[31m", "a1"}};
  EXPECT_THAT(Text(report), Not(HasSubstr("\x1b")));
}

TEST(ReportJson, HasStableFields) {
  EXPECT_EQ(ReportJson(SentReport()),
            R"({"target":"KIT/0001","protocol":"vda5050","version":"3.0.0",)"
            R"("topic":"vda5050/v3/KIT/0001/instantActions",)"
            R"("actions":[{"type":"startPause","id":"a1"}],"headerId":18,"status":"SENT",)"
            R"("elapsedMs":42.000})");
}

TEST(ReportJson, SaysWhyItIsNoSuccess) {
  const auto object = base::ParseJson(ReportJson(ErrorReport()));
  ASSERT_TRUE(object);
  EXPECT_THAT(NamesIn(*object), ElementsAre("target", "protocol", "version", "topic", "actions",
                                            "status", "elapsedMs", "message"));
  EXPECT_EQ(base::StringMember(*object, "status"), "ERROR");
  EXPECT_EQ(base::StringMember(*object, "message"), ErrorReport().message);
}

TEST(ReportJson, HoldsThePayloadOfADryRunAsAnObject) {
  Report report = SentReport();
  report.status = CommandStatus::kDryRun;
  report.payload = R"({"headerId":18})";
  const auto object = base::ParseJson(ReportJson(report));
  ASSERT_TRUE(object);
  ASSERT_NE(base::FindMember(*object, "payload"), nullptr);
  EXPECT_EQ((*object)["payload"]["headerId"].GetInt(), 18);
}

TEST(ReportJson, HoldsNoPayloadOtherwise) {
  Report report = SentReport();
  report.payload = R"({"headerId":18})";
  EXPECT_THAT(ReportJson(report), Not(HasSubstr("payload")));
}

TEST(ReportJson, MarksAnAssumedVersion) {
  Report report = SentReport();
  EXPECT_THAT(ReportJson(report), Not(HasSubstr("versionAssumed")));
  report.version_assumed = true;
  EXPECT_THAT(ReportJson(report), HasSubstr(R"("versionAssumed":true)"));
}

TEST(ReportJson, ParsesWhateverTheTextsHold) {
  Report report = ErrorReport();
  report.target = "K\"T/\\1";
  report.topic = "t\n";
  report.actions = {{"\"", "\\"}, {"ü", ""}};
  report.message = "line 1\nline 2 \x1b[2J \"quoted\"";
  const auto object = base::ParseJson(ReportJson(report));
  ASSERT_TRUE(object);
  EXPECT_EQ(base::StringMember(*object, "target"), report.target);
  EXPECT_EQ(base::StringMember(*object, "message"), report.message);
  EXPECT_EQ((*object)["actions"].Size(), 2U);
  EXPECT_EQ(ReportJson(report).find('\n'), std::string::npos) << "one object per line";
}

TEST(ReportJson, ParsesForEveryVerdict) {
  for (const CommandStatus status : {CommandStatus::kSent, CommandStatus::kPublished,
                                     CommandStatus::kInvalid, CommandStatus::kError}) {
    Report report = SentReport();
    report.status = status;
    const auto object = base::ParseJson(ReportJson(report));
    ASSERT_TRUE(object);
    EXPECT_EQ(base::StringMember(*object, "status"), message::GetName(status));
  }
}

// What comes out on either stream.
struct Streams {
  std::string out;
  std::string err;
};

Streams Captured(Output::Settings settings) {
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  Output output(settings);
  output.Line("result");
  output.PeopleLine("for people");
  output.Warn("warning");
  output.Debug("note");
  output.PrintError({ErrorKind::kBroker, "sentence",
                     "det\x1b"
                     "ail"});
  return {::testing::internal::GetCapturedStdout(), ::testing::internal::GetCapturedStderr()};
}

TEST(Output, PutsResultsOnStandardOutputAndTheRestOnStandardError) {
  const auto [out, err] = Captured({});
  EXPECT_EQ(out, "result\nfor people\n");
  EXPECT_EQ(err, "fleetpub: warning: warning\nfleetpub: error: sentence\n");
}

TEST(Output, IsQuietButForErrorsWhenAsked) {
  const auto [out, err] = Captured({.quiet = true});
  EXPECT_EQ(out, "result\n");
  EXPECT_EQ(err, "fleetpub: error: sentence\n");
}

TEST(Output, TellsNotesAndDetailsWhenAsked) {
  const auto [out, err] = Captured({.verbose = true});
  EXPECT_EQ(err,
            "fleetpub: warning: warning\nfleetpub: note\nfleetpub: error: sentence\n"
            "fleetpub: detail: det\\x1bail\n");
}

TEST(Output, HasNoColourWhereItIsNotWanted) {
  const testing::EnvironmentVariable no_colour("NO_COLOR", "1");
  EXPECT_EQ(Output({}).Toned(Tone::kBad, "ERROR"), "ERROR");
}

TEST(Output, RemembersThatSomethingWasSent) {
  Output output({});
  EXPECT_FALSE(output.something_was_sent());
  output.SomethingWasSent();
  EXPECT_TRUE(output.something_was_sent());
}

}  // namespace
}  // namespace fleetpub::cli
