// `--report` of validate and batch from the shell: who is a case, and what it takes to be written.
#include <gmock/gmock.h>

#include <csignal>

#include "base/file.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

constexpr const char* kGood =
    R"({"headerId":1,"timestamp":"2026-01-02T03:04:05.678Z","version":"3.0.0",)"
    R"("manufacturer":"KIT","serialNumber":"0001","connectionState":"ONLINE"})";

class ReportFile : public EndToEnd {
 protected:
  [[nodiscard]] std::string Path(const std::string& name) const {
    return (operator_.home().path() / name).string();
  }
  // Words, with every kind of report.
  [[nodiscard]] std::vector<std::string> Reporting(std::vector<std::string> words) const {
    words.insert(words.end(), {"--report", "junit=" + Path("o.xml") + ",tap=" + Path("o.tap"),
                               "--report", "json=" + Path("o.json") + ",html=" + Path("o.html")});
    return words;
  }
  // `VERDICT id says`, as the JSON report has them.
  [[nodiscard]] std::vector<std::string> Cases() const {
    std::vector<std::string> cases;
    const auto report = Json(base::ReadFile(Path("o.json")).value_or("{}"));
    if (!report.HasMember("results")) return cases;
    for (const auto& one : report["results"].GetArray()) {
      cases.push_back(std::string(one["verdict"].GetString()) + " " + one["id"].GetString() + " " +
                      one["says"].GetString());
    }
    return cases;
  }
  // What an XML parser that is not ours finds in the JUnit file.
  [[nodiscard]] std::string ReadJUnit() const {
    return ::fleetpub::testing::Run({{"python3", "-c",
                                      "import sys, xml.etree.ElementTree as e\n"
                                      "s = e.parse(sys.argv[1]).getroot().find('testsuite')\n"
                                      "print(s.get('tests'), s.get('failures'), s.get('skipped'))\n"
                                      "for c in s.iter('failure'): print(c.get('message'))",
                                      Path("o.xml")}})
        .output;
  }
};

TEST_F(ReportFile, OfValidateHasACaseForEachMessage) {
  const auto& home = operator_.home();
  (void)home.Write("good.json", kGood);
  (void)home.Write("two.jsonl", std::string(kGood) + "\n\n{\"version\":\"3.0.0\",\"nodes\":1}\n");
  const Finished run = Fleetpub(
      Reporting({"validate", Path("good.json"), Path("two.jsonl"), Path("not-there.json")}));
  EXPECT_EQ(run.exit_code, 8) << run.errors;
  EXPECT_THAT(Cases(), ElementsAre("PASS " + Path("good.json") + " is valid",
                                   "PASS " + Path("two.jsonl") + ":1 is valid",
                                   "FAIL " + Path("two.jsonl") + ":3 is valid",
                                   "FAIL " + Path("not-there.json") + " is valid"));
  EXPECT_THAT(ReadJUnit(), AllOf(StartsWith("4 2 0\n"), HasSubstr("FAIL: 3:")));
  EXPECT_THAT(*base::ReadFile(Path("o.tap")), HasSubstr("not ok 3 - "));
  EXPECT_THAT(*base::ReadFile(Path("o.html")), HasSubstr("two.jsonl:3"));
}

TEST_F(ReportFile, OfOneFileThatCannotBeReadSaysSo) {
  EXPECT_EQ(Fleetpub(Reporting({"validate", Path("not-there.json")})).exit_code, 8);
  EXPECT_THAT(Cases(), ElementsAre(StartsWith("FAIL ")));
}

TEST_F(ReportFile, OfValidateIsWrittenWhenItIsInterrupted) {
  Command command = operator_.Prepare(Reporting({"validate", "--lines"}));
  command.input = std::nullopt;
  Process validate(std::move(command));
  validate.Write(std::string(kGood) + "\n");
  ASSERT_TRUE(validate.AwaitOutput("valid"));
  validate.Signal(SIGINT);
  EXPECT_EQ(validate.Wait(), 130) << validate.Errors();
  EXPECT_THAT(Cases(), ElementsAre("PASS -:1 is valid"));
  EXPECT_THAT(*base::ReadFile(Path("o.json")), HasSubstr("ended early"));
}

TEST_F(ReportFile, OfValidateLiveHasACaseForEachTopicOfARobot) {
  const auto robot = Robot({"KIT/0001", "--state-interval", "50ms"});
  Say("vda5050/v3/KIT/0002/connection", R"({"version":"3.0.0"})", true);
  const Finished run = Fleetpub(Reporting({"validate", "--live", "--count", "6", "--for", "10s"}));
  EXPECT_EQ(run.exit_code, 3) << run.output << run.errors;
  EXPECT_THAT(Cases(), ::testing::IsSupersetOf({"PASS KIT/0001 connection messages are valid",
                                                "PASS KIT/0001 state messages are valid",
                                                "FAIL KIT/0002 connection messages are valid"}));
  EXPECT_THAT(ReadJUnit(), HasSubstr("1 message, 0 valid, 1 invalid"));
}

TEST_F(ReportFile, OfBatchHasACaseForEachCommandInTheOrderOfTheLines) {
  const auto robot = Robot({"KIT/0001", "--fail", "stopPause"});
  Command command = operator_.Prepare(Reporting({"batch", "--wait", "--online"}));
  command.input =
      "{\"id\":\"a\",\"target\":\"KIT/0001\",\"action\":\"stopPause\"}\n"
      "{\"target\":\"KIT/0001\",\"action\":\"startPause\"}\n"
      "nonsense\n";
  const Finished run = ::fleetpub::testing::Run(std::move(command));
  EXPECT_EQ(run.exit_code, 5) << run.output << run.errors;
  EXPECT_THAT(Cases(), ElementsAre("FAIL line 1 KIT/0001 stopPause",
                                   "PASS line 2 KIT/0001 startPause", StartsWith("FAIL line 3")));
  EXPECT_THAT(ReadJUnit(), AllOf(StartsWith("3 2 0\n"), HasSubstr("FAILED")));
}

TEST_F(ReportFile, OfBatchIsWrittenWhenItIsInterrupted) {
  const auto robot = Robot({"KIT/0001"});
  Command command = operator_.Prepare(Reporting({"batch", "--wait"}));
  command.input = std::nullopt;
  Process batch(std::move(command));
  batch.Write("{\"target\":\"KIT/0001\",\"action\":\"startPause\"}\n");
  ASSERT_TRUE(batch.AwaitOutput("FINISHED"));
  batch.Signal(SIGINT);
  EXPECT_EQ(batch.Wait(), 130);
  EXPECT_THAT(Cases(), ElementsAre("PASS line 1 KIT/0001 startPause"));
  EXPECT_THAT(*base::ReadFile(Path("o.json")), HasSubstr("ended early"));
}

TEST_F(ReportFile, ThatCannotBeWrittenIsRefusedBeforeAnythingIsSent) {
  const auto robot = Robot({"KIT/0001"});
  const Subscriber subscriber(broker_, "+/+/+/+/instantActions");
  const std::vector<std::string> report = {"--report", "tap=/no/such/folder/o.tap"};
  for (std::vector<std::string> words : {std::vector<std::string>{"batch"},
                                         {"validate"},
                                         {"validate", "--live"},
                                         {"conform", "KIT/0001", "--level", "actions"}}) {
    words.insert(words.end(), report.begin(), report.end());
    Command command = operator_.Prepare(std::move(words));
    command.input = "{\"target\":\"KIT/0001\",\"action\":\"startPause\"}\n";
    const Finished run = ::fleetpub::testing::Run(std::move(command));
    EXPECT_EQ(run.exit_code, 8) << run.output;
    EXPECT_THAT(run.errors, HasSubstr("/no/such/folder/o.tap"));
  }
  EXPECT_THAT(subscriber.SoFar(), IsEmpty());
}

// A report is what tests are run for; a batch has done its work.
TEST_F(ReportFile, ThatCannotBeWrittenAtTheEndFailsTestsAndNoBatch) {
  const auto robot = Robot({"KIT/0001"});
  const auto reporting = [&](std::vector<std::string> words, const std::string& input) {
    words.insert(words.end(), {"--report", "json=/dev/full"});
    Command command = operator_.Prepare(std::move(words));
    command.input = input;
    const Finished run = ::fleetpub::testing::Run(std::move(command));
    EXPECT_THAT(run.errors, HasSubstr("/dev/full cannot be written"));
    return run.exit_code;
  };
  const std::string pause = "{\"target\":\"KIT/0001\",\"action\":\"startPause\"}\n";
  const std::string scenario = operator_.home().Write(
      "a.toml",
      "[[test]]\nname = \"a\"\nrobot = \"KIT/0001\"\nsteps = [{ await = \"headerId>0\" }]\n");
  EXPECT_EQ(reporting({"batch", "--wait"}, pause), 0);
  EXPECT_EQ(reporting({"batch", "--wait"}, pause + "nonsense\n"), 3) << "as without a report";
  EXPECT_EQ(reporting({"batch", "--dry-run"}, pause), 8) << "nothing was sent";
  EXPECT_EQ(reporting({"conform", "KIT/0001", "--only", "H01", "--for", "1s"}, ""), 8);
  EXPECT_EQ(reporting({"test", scenario, "--yes"}, ""), 8);
  EXPECT_EQ(reporting({"validate"}, kGood), 8);
}

}  // namespace
}  // namespace fleetpub::testing
