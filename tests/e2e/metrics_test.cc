// `fleet -o openmetrics`, held against what reads it: promtool and Prometheus' own reader.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "base/json.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

const std::vector<std::string> kMetrics = {"fleet", "-o", "openmetrics", "--ask"};

Finished Promtool(std::string metrics) {
  return Run({.arguments = {"promtool", "check", "metrics"}, .input = std::move(metrics)});
}

// As OpenMetrics 1.0 has it, by the reader of Prometheus' client in Python.
Finished ReadStrictly(std::string metrics) {
  const std::string script =
      "import sys\n"
      "from prometheus_client.openmetrics.parser import text_string_to_metric_families as read\n"
      "for family in read(sys.stdin.read()):\n"
      "  print(family.name, family.type, len(family.samples))\n";
  return Run({.arguments = {"/usr/bin/python3", "-c", script}, .input = std::move(metrics)});
}

class Metrics : public EndToEnd {
 protected:
  // A recording of robots that say well-formed and other things.
  [[nodiscard]] std::string Recording(int robots, const std::string& more = "") const {
    const auto file = operator_.home() / "shift.jsonl";
    std::ofstream lines(file);
    for (int i = 0; i < robots; ++i) {
      const std::string name = std::to_string(i);
      Say(lines, "vda5050/v3/KIT/" + name + "/connection", R"({"connectionState":"ONLINE"})", true);
      Say(lines, "vda5050/v3/KIT/" + name + "/state",
          R"({"headerId":1,"timestamp":"2026-01-02T03:04:05Z","version":"3.0.0","manufacturer":"KIT","serialNumber":")" +
              name +
              R"(","orderId":"","operatingMode":"AUTOMATIC","driving":false,"powerSupply":{"stateOfCharge":)" +
              std::to_string(i % 100) +
              R"(,"charging":false},"safetyState":{"activeEmergencyStop":"NONE","fieldViolation":false},"errors":[],"nodeStates":[],"edgeStates":[]})");
    }
    lines << more;
    return file.string();
  }
  static void Say(std::ostream& lines, const std::string& topic, const std::string& payload,
                  bool retain = false) {
    lines << R"({"timestamp":"2026-01-02T03:04:05Z","topic":)" << base::JsonString(topic)
          << ",\"retain\":" << (retain ? "true" : "false") << ",\"payload\":" << payload << "}\n";
  }
};

TEST_F(Metrics, AreTakenByPromtoolAndByOpenMetrics) {
  const auto robots = Robot({"KIT/0001", "KIT/0002", "--battery", "62"});
  ASSERT_EQ(Fleetpub({"pause", "KIT/*", "--wait"}).exit_code, 0);
  const Finished run = Fleetpub(kMetrics);
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(
      run.output,
      AllOf(HasSubstr("fleetpub_robot_battery_charge_ratio{robot=\"KIT/0002\"} 0."),
            HasSubstr("fleetpub_robot_paused{robot=\"KIT/0001\"} 1\n"),
            HasSubstr("fleetpub_robot_connection_state{robot=\"KIT/0001\",state=\"ONLINE\"} "
                      "1\n"),
            ContainsRegex("confirmation_seconds\\{topic=\"instantActions\",quantile=\"0.5\"} "
                          "[0-9.e-]+\n"),
            HasSubstr("confirmation_seconds_count{topic=\"instantActions\"} 2\n"),
            EndsWith("\n# EOF\n")));
  const Finished lint = Promtool(run.output);
  EXPECT_EQ(lint.exit_code, 0) << lint.errors;
  EXPECT_THAT(lint.errors + lint.output, IsEmpty());
  const Finished strict = ReadStrictly(run.output);
  EXPECT_EQ(strict.exit_code, 0) << strict.errors;
  EXPECT_THAT(strict.output, HasSubstr("fleetpub_command_confirmation_seconds summary 5\n"));
  EXPECT_THAT(strict.output, HasSubstr("fleetpub_robot_info gauge 2\n"));
}

TEST_F(Metrics, CountConfirmationsOfTheRobotsShownAtThisBroker) {
  const auto robots = Robot({"KIT/0001", "KIT/0002"});
  ASSERT_EQ(Fleetpub({"pause", "KIT/*", "--wait"}).exit_code, 0);
  const std::string count = "confirmation_seconds_count{topic=\"instantActions\"} ";
  std::vector<std::string> one = kMetrics;
  one.emplace_back("KIT/0001");
  EXPECT_THAT(Fleetpub(one).output, HasSubstr(count + "1\n"));
  const Mosquitto other;
  operator_.UseBroker(other.Url());
  const auto elsewhere = Robot({"KIT/0001"});
  EXPECT_THAT(Fleetpub(kMetrics).output, Not(HasSubstr(count)));
}

TEST_F(Metrics, AreLeftOutWhereTheLedgerCannotBeRead) {
  const auto robots = Robot({"KIT/0001"});
  operator_.UseLedger(operator_.home().Write("no-ledger", "this is no database").string());
  const Finished run = Fleetpub({"fleet", "-o", "openmetrics", "--state-wait", "100ms"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.errors, HasSubstr("the times to confirm are left out"));
  EXPECT_THAT(run.output, AllOf(HasSubstr("fleetpub_robot_info{"), Not(HasSubstr("confirmation"))));
}

// Whoever writes them into a file must see that by the exit code, and have no half of one.
TEST_F(Metrics, AreNotPrintedWhereThereAreNone) {
  const Finished nobody = Fleetpub({"fleet", "-o", "openmetrics", "--state-wait", "100ms"});
  EXPECT_EQ(nobody.exit_code, 7);
  EXPECT_THAT(nobody.output, IsEmpty());
  const Finished nowhere = Fleetpub({"fleet", "-o", "openmetrics", "-b", "mqtt://127.0.0.1:1"});
  EXPECT_EQ(nowhere.exit_code, 4);
  EXPECT_THAT(nowhere.output, IsEmpty());
}

TEST_F(Metrics, AreOfFleetAlone) {
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"pause", "KIT/0001"}, {"watch"}, {"config", "show"}, {"history"}}) {
    std::vector<std::string> call = words;
    call.insert(call.end(), {"-o", "openmetrics"});
    const Finished run = Fleetpub(call);
    EXPECT_EQ(run.exit_code, 2) << words.front();
    EXPECT_THAT(run.errors, HasSubstr("try: fleetpub fleet -o openmetrics"));
    EXPECT_THAT(run.output, IsEmpty());
  }
  const Finished fields = Fleetpub({"fleet", "-o", "openmetrics", "--fields", "target"});
  EXPECT_EQ(fields.exit_code, 2);
  EXPECT_THAT(fields.errors, HasSubstr("--fields needs"));
}

TEST_F(Metrics, StayRightForPromtoolWhateverRobotsSay) {
  std::ostringstream more;
  Say(more, "vda5050/v3/K\"I\\T/{\"} 1/state",
      R"({"operatingMode":"A\"} 1\nevil 1","powerSupply":{"stateOfCharge":1e308},"errors":[{"errorLevel":"\u0000\n","errorType":"x"}],"timestamp":"0001-01-01T00:00:00Z"})");
  Say(more, "vda5050/v3/KIT/\xe2\x80\xae\xf0\x9f\xa4\x96/state",
      R"({"batteryState":{"batteryCharge":-0.0},"timestamp":17,"driving":"true"})");
  const Finished run = Fleetpub({"fleet", "-o", "openmetrics", "--from", Recording(1, more.str())});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, Not(HasSubstr("\nevil")));
  const Finished lint = Promtool(run.output);
  EXPECT_EQ(lint.exit_code, 0) << lint.errors << run.output;
  const Finished strict = ReadStrictly(run.output);
  EXPECT_EQ(strict.exit_code, 0) << strict.errors;
  EXPECT_THAT(strict.output, HasSubstr("fleetpub_robot_info gauge 3\n"));
}

TEST_F(Metrics, OfManyRobotsTakeNoMemoryOfTheirOwn) {
  const std::string recording = Recording(1'000);
  const Finished json = Fleetpub({"fleet", "-o", "json", "--from", recording});
  const Finished run = Fleetpub({"fleet", "-o", "openmetrics", "--from", recording});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
#ifdef FLEETPUB_SLOW
  constexpr int kMoreMib = 64;  // a sanitizer keeps what was given back
#else
  constexpr int kMoreMib = 1;
#endif
  EXPECT_LE(run.peak_mib, json.peak_mib + kMoreMib);
  EXPECT_THAT(run.output, HasSubstr("charge_ratio{robot=\"KIT/999\"} 0.99\n"));
}

}  // namespace
}  // namespace fleetpub::testing
