// `fleetpub validate --live`: a conformance check of whatever is published.
#include <gmock/gmock.h>

#include <algorithm>

#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

class ValidateLive : public EndToEnd {
 protected:
  std::unique_ptr<Process> Start(std::vector<std::string> arguments) const {
    return std::make_unique<Process>(operator_.Prepare(std::move(arguments)));
  }
  void Publish(const std::string& topic, const std::string& payload, bool retained = false) const {
    Command command{{"mosquitto_pub", "-h", "127.0.0.1", "-p", std::to_string(broker_.port()), "-t",
                     topic, "-m", payload}};
    if (retained) command.arguments.emplace_back("-r");
    EXPECT_EQ(::fleetpub::testing::Run(std::move(command)).exit_code, 0);
  }
  static std::string Connection(const std::string& state, const std::string& serial = "0001") {
    return R"({"headerId":17,"timestamp":"2026-01-02T03:04:05.678Z","version":"3.0.0",)"
           R"("manufacturer":"KIT","serialNumber":")" +
           serial + R"(","connectionState":")" + state + "\"}";
  }
};

TEST_F(ValidateLive, FindsNoFaultInVirtualRobots) {
  const auto robots = Start({"simulate", "KIT/0001", "--count", "3", "--state-interval", "100ms"});
  ASSERT_TRUE(robots->AwaitErrors("online at"));
  const Finished run = Fleetpub({"validate", "--live", "--count", "30", "--for", "15s"});
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  EXPECT_THAT(run.output, AllOf(HasSubstr("state  "), HasSubstr("all             30 messages, 30 "
                                                                "valid, 0 invalid\n")));
}

TEST_F(ValidateLive, FindsTheConnectionMessageAtAStatedInterface) {
  const auto robot =
      Start({"simulate", "KIT/0001", "--interface", "hall", "--state-interval", "100ms"});
  ASSERT_TRUE(robot->AwaitErrors("online at"));
  const Finished run =
      Fleetpub({"validate", "--live", "--interface", "hall", "--strict", "--for", "700ms"});
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
}

TEST_F(ValidateLive, ListensToTheTopicsOfTheConfiguration) {
  const auto robot = Robot({"KIT/0001", "--topic-template", "plant/{manufacturer}-{serial}/{topic}",
                            "--vda", "2.1", "--state-interval", "100ms"});
  operator_.home().Write(".config/fleetpub/config.toml",
                         "topic_template = \"plant/{manufacturer}-{serial}/{topic}\"\n");
  const Finished run = Fleetpub({"validate", "--live", "--strict", "--count", "5", "--for", "15s"});
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  EXPECT_THAT(run.output, HasSubstr("5 messages, 5 valid"));
}

TEST_F(ValidateLive, TellsEachViolationAndEndsWithThree) {
  Publish("vda5050/v3/KIT/0001/connection", Connection("AWAY"), true);
  Publish("vda5050/v3/KIT/0002/connection", Connection("ONLINE", "0002"), true);
  Publish("vda5050/v3/ABC/0003/connection", "{", true);
  const Finished run = Fleetpub({"validate", "--live", "KIT/*", "--for", "300ms"});
  EXPECT_EQ(run.exit_code, 3) << run.errors;
  EXPECT_THAT(
      run.output,
      AllOf(HasSubstr("KIT/0001 connection headerId 17 (retained): /connectionState: "),
            HasSubstr("connection      2 messages, 1 valid, 1 invalid\n"), Not(HasSubstr("ABC"))));
}

TEST_F(ValidateLive, WarnsOfWhatNoSchemaStatesUnlessItIsStrict) {
  Publish("vda5050/v3/KIT/0002/connection", Connection("ONLINE"), true);
  std::string offset = Connection("ONLINE");
  offset.replace(offset.find("678Z"), 4, "678+02:00");
  Publish("vda5050/v3/KIT/0001/connection", offset, true);
  Finished run = Fleetpub({"validate", "--live", "--for", "300ms"});
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_THAT(run.errors, AllOf(HasSubstr("KIT/0002 connection headerId 17 (retained): "
                                          "/serialNumber: "),
                                HasSubstr("KIT/0001 connection headerId 17 (retained): "
                                          "/timestamp: ")));
  run = Fleetpub({"validate", "--live", "--strict", "--for", "300ms"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.output, AllOf(HasSubstr("/serialNumber: "), HasSubstr("/timestamp: "),
                                HasSubstr("2 messages, 0 valid, 2 invalid")));
  Command file = operator_.Prepare({"validate"});
  file.input = offset;
  EXPECT_EQ(::fleetpub::testing::Run(file).exit_code, 0);
  file.arguments.emplace_back("--strict");
  EXPECT_EQ(::fleetpub::testing::Run(file).exit_code, 3);
}

TEST_F(ValidateLive, ReportsARobotThatHasLeftNoConnectionMessage) {
  Publish("vda5050/v3/KIT/0002/connection", Connection("ONLINE", "0002"), true);
  const auto live = Start({"validate", "--live", "--strict", "--for", "10s", "-o", "json"});
  ASSERT_TRUE(broker_.AwaitSubscription("+/+/+/+/responses (QoS 0)"));
  Publish("vda5050/v3/KIT/0001/connection", "", true);
  Publish("vda5050/v3/KIT/0001/state", "{}");
  Publish("vda5050/v3/KIT/0002/state", "{}");
  ASSERT_TRUE(live->AwaitOutput("none is retained")) << live->Output();
  live->Signal(SIGTERM);
  EXPECT_EQ(live->Wait(), 3);
  const auto lines = Lines(live->Output());
  const auto missing = std::count_if(lines.begin(), lines.end(), [](const std::string& line) {
    return line.find("none is retained") != std::string::npos &&
           line.find("KIT/0001/connection") != std::string::npos;
  });
  EXPECT_EQ(missing, 1) << live->Output();
  EXPECT_EQ(Json(lines.back())["withoutConnection"].GetInt(), 1);
}

TEST_F(ValidateLive, WarnsOfANameThatMeansSomethingElse) {
  Publish("vda5050/v3/KIT/@hall/connection", Connection("ONLINE", "@hall"), true);
  Publish("vda5050/v3/KIT/?/connection", Connection("ONLINE", "?"), true);
  const Finished run = Fleetpub({"validate", "--live", "--for", "500ms"});
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_THAT(run.errors, HasSubstr("KIT/%3F"));
  EXPECT_THAT(run.errors, Not(HasSubstr("@hall (")));
}

TEST_F(ValidateLive, TellsAScriptInJson) {
  const auto live = Start({"validate", "--live", "--count", "1", "-o", "json"});
  ASSERT_TRUE(broker_.AwaitSubscription("+/+/+/+/responses (QoS 0)"));
  Publish("vda5050/v3/KIT/0001/connection", Connection("AWAY"));
  EXPECT_EQ(live->Wait(), 3) << live->Errors();
  const auto lines = Lines(live->Output());
  ASSERT_THAT(lines, SizeIs(2));
  const auto violation = Json(lines[0]);
  EXPECT_STREQ(violation["target"].GetString(), "KIT/0001");
  EXPECT_STREQ(violation["topic"].GetString(), "vda5050/v3/KIT/0001/connection");
  EXPECT_EQ(violation["headerId"].GetInt(), 17);
  EXPECT_STREQ(violation["path"].GetString(), "/connectionState");
  EXPECT_FALSE(violation["retained"].GetBool());
  EXPECT_EQ(Json(lines[1])["topics"]["connection"]["invalid"].GetInt(), 1);
}

TEST_F(ValidateLive, SumsUpWhenInterruptedAndOutlivesTheBroker) {
  const auto live = Start({"validate", "--live"});
  ASSERT_TRUE(broker_.AwaitSubscription("+/+/+/+/responses (QoS 0)"));
  broker_.Kill();
  ASSERT_TRUE(live->AwaitErrors("connecting again"));
  broker_.Restart();
  ASSERT_TRUE(live->AwaitErrors("connected again"));
  Publish("vda5050/v3/KIT/0001/connection", Connection("AWAY"));
  ASSERT_TRUE(live->AwaitOutput("/connectionState"));
  live->Signal(SIGINT);
  EXPECT_EQ(live->Wait(), 3);
  EXPECT_THAT(live->Output(), HasSubstr("1 message, 0 valid, 1 invalid"));
}

TEST_F(ValidateLive, SaysThatNothingCame) {
  const Finished run = Fleetpub({"validate", "--live", "--for", "200ms"});
  EXPECT_EQ(run.exit_code, 6);
  EXPECT_THAT(run.errors, HasSubstr("no message came"));
}

TEST_F(ValidateLive, RefusesWhatDoesNotGoTogether) {
  EXPECT_EQ(Fleetpub({"validate", "--live", "--lines"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"validate", "--count", "3"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"validate", "--live", "--topic", "status"}).exit_code, 2);
  EXPECT_THAT(Fleetpub({"validate", "--live", "KIT"}).errors, HasSubstr("'KIT'"));
  for (const char* option : {"--online", "--all"}) {
    EXPECT_EQ(Fleetpub({"validate", option}).exit_code, 2) << "without --live";
  }
}

TEST_F(ValidateLive, ListensToTheRobotsThatAreMeant) {
  Publish("vda5050/v3/KIT/0001/connection", Connection("AWAY"), true);
  Publish("vda5050/v3/KIT/0002/connection", Connection("AWAY"), true);
  const auto targets = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"validate", "--live", "--for", "300ms", "-o", "json"});
    std::string serials;
    for (const std::string& line : Lines(Fleetpub(words).output)) {
      const auto found = Json(line);
      const bool is_violation = found.HasMember("path");
      if (is_violation && std::string_view(found["path"].GetString()) == "/connectionState") {
        serials += found["target"].GetString()[7];
      }
    }
    return serials;
  };
  EXPECT_EQ(targets({"KIT/0001", "KIT/0002"}), "12");
  EXPECT_EQ(targets({"--except", "KIT/0001"}), "2");
  EXPECT_EQ(targets({"KIT/0002", "--where", "connectionState=AWAY"}), "2");
  EXPECT_EQ(targets({"--online"}), "");
}

}  // namespace
}  // namespace fleetpub::testing
