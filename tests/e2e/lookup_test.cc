// A robot that is named is looked up before it is commanded: version, interface, topic, and whether
// it is there at all.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::StartsWith;

constexpr const char* kCommands = "+/+/+/+/instantActions";

std::string Header(std::string_view version, std::string_view serial) {
  return fmt::format(R"("headerId":1,"timestamp":"2026-01-02T03:04:05.000Z","version":"{}",
      "manufacturer":"KIT","serialNumber":"{}")",
                     version, serial);
}

class Lookup : public EndToEnd {
 protected:
  void Connect(const std::string& place, std::string_view version, const std::string& serial,
               std::string_view state) const {
    Say(place + "/KIT/" + serial + "/connection",
        fmt::format(R"({{{},"connectionState":"{}"}})", Header(version, serial), state), true);
  }
  /// Sends states as long as it lives, fifty a second; the first has come when this returns.
  [[nodiscard]] std::unique_ptr<Process> Speak(const std::string& place, std::string_view version,
                                               const std::string& serial) {
    const std::string topic = place + "/KIT/" + serial + "/state";
    const std::string state = fmt::format(R"({{{},"operatingMode":"AUTOMATIC","paused":false}})",
                                          Header(version, serial));
    auto robot = std::make_unique<Process>(Command{
        .arguments = {"mosquitto_pub", "-h", "127.0.0.1", "-p", std::to_string(broker_.port()),
                      "-t", topic, "-m", state, "--repeat", "1000000", "--repeat-delay", "0.02"}});
    EXPECT_TRUE(broker_.AwaitLog("'" + topic + "'"));
    return robot;
  }
  /// The one result.
  [[nodiscard]] base::JsonDocument Result(std::vector<std::string> arguments, int exit_code) const {
    arguments.insert(arguments.end(), {"-o", "json"});
    const Finished run = Fleetpub(std::move(arguments));
    EXPECT_EQ(run.exit_code, exit_code) << run.output << run.errors;
    const auto lines = Lines(run.output);
    EXPECT_THAT(lines, Not(IsEmpty()));
    return Json(lines.empty() ? "{}" : lines.front());
  }
};

TEST_F(Lookup, SpeaksToARobotInItsOwnVersionAtItsOwnTopics) {
  const auto old = Robot({"KIT/0001", "--vda", "2.1"});
  const auto apart = Robot({"KIT/0002", "--vda", "1.1", "--interface", "hall"});
  const Subscriber subscriber(broker_, kCommands);
  const auto pause = Result({"pause", "KIT/0001"}, 0);
  EXPECT_STREQ(pause["version"].GetString(), "2.1.0");
  EXPECT_FALSE(pause.HasMember("versionAssumed"));
  EXPECT_STREQ(Result({"resume", "KIT/0002", "--wait"}, 0)["status"].GetString(), "FINISHED");
  const auto messages = subscriber.Await(2);
  ASSERT_THAT(messages, SizeIs(2));
  EXPECT_EQ(messages[0].topic, "uagv/v2/KIT/0001/instantActions");
  EXPECT_STREQ(Json(messages[0].payload)["version"].GetString(), "2.1.0");
  EXPECT_EQ(messages[1].topic, "hall/v1/KIT/0002/instantActions");
}

TEST_F(Lookup, HoldsThoseThatAreFoundAtAStatedInterfaceAgainstTheirFactsheets) {
  const auto robot = Robot({"KIT/0001", "--interface", "hall"});
  for (const char* words : {"KIT/0001", "KIT/*"}) {
    const auto polish = Result({"action", "polish", words, "--interface", "hall"}, 7);
    EXPECT_THAT(polish["message"].GetString(), HasSubstr("factsheet does not list polish"));
  }
}

TEST_F(Lookup, HoldsAStatedVersionAgainstTheRobots) {
  const auto robot = Robot({"KIT/0001", "--vda", "2.1"});
  const auto other = Result({"resume", "KIT/0001", "--vda", "3"}, 7);
  EXPECT_THAT(other["message"].GetString(), HasSubstr("speaks 2.1.0"));
  EXPECT_STREQ(Result({"resume", "KIT/0001", "--vda", "3", "--no-check"}, 0)["topic"].GetString(),
               "vda5050/v3/KIT/0001/instantActions");
  EXPECT_STREQ(Result({"resume", "KIT/0001", "--no-check"}, 0)["version"].GetString(), "2.1.0")
      << "the version is looked up nevertheless";
}

// A mistyped serial number, another letter case, and KIT/* that the shell made a file of.
TEST_F(Lookup, RefusesWhomTheBrokerDoesNotKnow) {
  const auto robot = Robot({"KIT/0017"});
  Connect("uagv/v2", "2.1.0", "0071", "OFFLINE");
  operator_.home().Write(".config/fleetpub/config.toml",
                         "[profile.north]\nbroker = \"" + broker_.Url() + "\"\n");
  const Subscriber subscriber(broker_, kCommands);
  const Finished run = Fleetpub({"resume", "KIT/00177", "kit/0017", "KIT/0072", "KIT/report.txt",
                                 "--profile", "north", "--discover", "60", "-o", "json"});
  EXPECT_EQ(run.exit_code, 7) << run.errors;
  const auto lines = Lines(run.output);
  ASSERT_THAT(lines, SizeIs(4));
  EXPECT_THAT(lines, Each(AllOf(HasSubstr(R"("status":"REFUSED")"), HasSubstr("not sent"),
                                HasSubstr(broker_.Url() + " (profile north)"),
                                HasSubstr("--no-check sends it anyway"))));
  EXPECT_THAT(lines[0], HasSubstr("did you mean KIT/0017?"));
  EXPECT_THAT(lines[1], HasSubstr("did you mean KIT/0017?"));
  EXPECT_THAT(lines[2], Not(HasSubstr("KIT/0071"))) << "it is not there itself";
  EXPECT_THAT(lines[3], Not(HasSubstr("did you mean")));
  EXPECT_THAT(subscriber.SoFar(), IsEmpty());
}

TEST_F(Lookup, LetsAPauseLeaveForAnybody) {
  const Subscriber subscriber(broker_, kCommands);
  const Finished run = Fleetpub({"pause", "KIT/0001", "--discover", "60"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, AllOf(HasSubstr("SENT"), HasSubstr("3.0.0 (assumed)")));
  EXPECT_THAT(run.errors, AllOf(HasSubstr("warning: KIT/0001 is unknown to " + broker_.Url()),
                                HasSubstr("sent anyway")));
  EXPECT_EQ(Fleetpub({"resume", "KIT/0001", "--discover", "60"}).exit_code, 7);
  EXPECT_THAT(subscriber.Await(1),
              ElementsAre(::testing::Field(&Subscriber::Received::topic,
                                           "vda5050/v3/KIT/0001/instantActions")));
}

TEST_F(Lookup, IsSparedWhoStatesTheVersionAndWantsNoCheck) {
  operator_.home().Write(".config/fleetpub/config.toml", "[robot.\"KIT/0002\"]\nvda = \"2.1\"\n");
  const Finished flag = Fleetpub({"resume", "KIT/0001", "--vda", "2.1", "--no-check"});
  EXPECT_EQ(flag.exit_code, 0);
  EXPECT_EQ(flag.errors, "");
  EXPECT_EQ(Fleetpub({"resume", "KIT/0002", "--no-check"}).exit_code, 0);
  EXPECT_TRUE(broker_.AwaitLog("uagv/v2/KIT/0002/instantActions"));
  EXPECT_THAT(broker_.Log(), Not(HasSubstr("SUBSCRIBE")));
  EXPECT_EQ(Fleetpub({"pause", "KIT/0001", "--vda", "2.1", "--discover", "60"}).exit_code, 0);
  EXPECT_THAT(broker_.Log(), HasSubstr("Received SUBSCRIBE"));
}

// ── robots that do not say that they are there, but speak ──

TEST_F(Lookup, TakesStatesForASignOfLife) {
  Connect("uagv/v2", "2.0.0", "0002", "CONNECTIONBROKEN");
  const auto silent_about_it = Speak("uagv/v2", "2.0.0", "0001");
  const auto left_its_will = Speak("uagv/v2", "2.0.0", "0002");
  const std::vector<std::vector<std::string>> ways = {
      {"KIT/0001", "KIT/0002"}, {"KIT/*"}, {"KIT/*", "--where", "paused=false"}};
  for (const auto& way : ways) {
    std::vector<std::string> call = {"resume", "--yes", "-o", "json", "--discover", "300"};
    call.insert(call.end(), way.begin(), way.end());
    const Finished run = Fleetpub(call);
    EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
    const auto lines = Lines(run.output);
    ASSERT_THAT(lines, SizeIs(::testing::Ge(2U)));
    for (std::size_t i = 0; i < 2; ++i) {
      const auto result = Json(lines.at(i));
      EXPECT_STREQ(result["status"].GetString(), "SENT");
      EXPECT_STREQ(result["version"].GetString(), "2.0.0");
    }
    EXPECT_THAT(run.errors, AllOf(HasSubstr("warning: KIT/0001 has left no connection message"),
                                  HasSubstr("KIT/0002 as CONNECTION_BROKEN"),
                                  HasSubstr("but it sends states")));
  }
}

// The connection messages say the same, and the clock of the one that lives is wrong.
TEST_F(Lookup, FindsThePlaceWhereARobotLives) {
  Connect("uagv/v2", "2.1.0", "0001", "ONLINE");
  Say("vda5050/v3/KIT/0001/connection",
      R"({"headerId":1,"timestamp":"1970-01-01T00:00:07.000Z","version":"3.0.0",)"
      R"("manufacturer":"KIT","serialNumber":"0001","connectionState":"ONLINE"})",
      true);
  const Finished unclear = Fleetpub({"resume", "KIT/0001", "--discover", "60"});
  EXPECT_EQ(unclear.exit_code, 0);
  EXPECT_THAT(unclear.errors,
              AllOf(HasSubstr("uagv/v2/KIT/0001"), HasSubstr("vda5050/v3/KIT/0001")))
      << "nobody can tell";
  const auto living = Speak("vda5050/v3", "3.0.0", "0001");
  for (const char* target : {"KIT/0001", "KIT/*"}) {
    const Finished run = Fleetpub({"resume", target, "--discover", "300", "-o", "json"});
    EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
    EXPECT_STREQ(Json(Lines(run.output).front())["topic"].GetString(),
                 "vda5050/v3/KIT/0001/instantActions");
  }
}

// ── dry runs ──

TEST_F(Lookup, OfADryRunShowsWhatWouldBeSent) {
  const auto robot = Robot({"KIT/0001", "--vda", "2.1"});
  const Subscriber subscriber(broker_, kCommands);
  const auto expect = [](const Finished& run, const std::string& topic, const std::string& why) {
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(run.errors, AllOf(HasSubstr(topic), HasSubstr(why)));
    EXPECT_THAT(Lines(run.output), ElementsAre(StartsWith(R"({"headerId":0,)")));
  };
  const std::string v2 = "uagv/v2/KIT/0001/instantActions";
  const std::string v3 = "vda5050/v3/KIT/0001/instantActions";
  expect(Fleetpub({"resume", "KIT/0001", "-n"}), v2 + " in 2.1.0", "the robot itself");
  expect(Fleetpub({"resume", "KIT/0001", "-n", "--vda", "2.1"}), v2 + " in 2.1.0", "stated");
  expect(Fleetpub({"resume", "KIT/0001", "-n", "--offline"}), v3 + " in 3.0.0", "assumed");
  const Finished unknown = Fleetpub({"resume", "KIT/0009", "-n", "--discover", "60"});
  EXPECT_EQ(unknown.exit_code, 7);
  EXPECT_THAT(unknown.errors, AllOf(HasSubstr("REFUSED"), HasSubstr("unknown")));
  EXPECT_THAT(unknown.output, IsEmpty()) << "nothing but payloads";
  operator_.UseBroker("");
  expect(Fleetpub({"resume", "KIT/0001", "-n"}), v3 + " in 3.0.0", "no broker was asked");
  EXPECT_THAT(subscriber.SoFar(), IsEmpty());
}

TEST_F(Lookup, OfADryRunIsLeftOutOnlyWhereThatCanBe) {
  EXPECT_EQ(Fleetpub({"resume", "KIT/0001", "--offline"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"resume", "KIT/*", "-n", "--offline"}).exit_code, 2);
  operator_.UseBroker("mqtt://127.0.0.1:1");
  EXPECT_EQ(Fleetpub({"resume", "KIT/0001", "-n"}).exit_code, 4) << "it was to be asked";
}

// ── brokers that keep nothing ──

TEST_F(Lookup, SaysThatABrokerKeepsNothingRetained) {
  const Mosquitto forgetful({"allow_anonymous true", "retain_available false"});
  operator_.UseBroker(forgetful.Url());
  const std::tuple<std::vector<std::string>, int> calls[] = {
      {{"pause", "KIT/0001", "--wait", "-W", "100ms"}, 6},
      {{"resume", "KIT/0001"}, 7},
      {{"pause", "KIT/*"}, 7},
      {{"fleet", "--state-wait", "0"}, 7}};
  for (const auto& [words, exit_code] : calls) {
    std::vector<std::string> call = words;
    call.insert(call.end(), {"-V", "5", "--discover", "60"});
    const Finished run = Fleetpub(call);
    EXPECT_EQ(run.exit_code, exit_code) << words[0] << run.output << run.errors;
    EXPECT_THAT(run.output + run.errors,
                AllOf(HasSubstr("keeps no retained messages"), HasSubstr(forgetful.Url())));
  }
  EXPECT_THAT(Fleetpub({"fleet", "--state-wait", "0", "--discover", "60"}).errors,
              Not(HasSubstr("retained messages")))
      << "over MQTT 3.1.1 it does not say so";
}

}  // namespace
}  // namespace fleetpub::testing
