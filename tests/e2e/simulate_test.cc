// `fleetpub simulate`: virtual robots on a real broker, as mosquitto_sub sees them.
#include <gmock/gmock.h>

#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

class Simulate : public EndToEnd {
 protected:
  /// Returns once the robots are online.
  [[nodiscard]] std::unique_ptr<Process> Start(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "simulate");
    auto process = std::make_unique<Process>(operator_.Prepare(std::move(arguments)));
    EXPECT_TRUE(process->AwaitErrors(" online at ")) << process->Errors();
    return process;
  }
  /// What a newcomer gets at once.
  [[nodiscard]] std::string Retained(const std::string& topic) const {
    const Subscriber newcomer(broker_, topic);
    const auto messages = newcomer.Await(1);
    EXPECT_TRUE(!messages.empty() && messages.front().retained) << topic;
    return messages.empty() ? "{}" : messages.front().payload;
  }
  [[nodiscard]] std::string ConnectionState(const std::string& topic) const {
    return Json(Retained(topic))["connectionState"].GetString();
  }
};

TEST_F(Simulate, IsOnlineWithRetainedConnectionAndFactsheet) {
  const auto robot = Start({"KIT/0001"});
  EXPECT_THAT(robot->Errors(), HasSubstr("1 robot online at " + broker_.Url()));
  EXPECT_EQ(ConnectionState("vda5050/v3/KIT/0001/connection"), "ONLINE");
  const auto factsheet = Json(Retained("vda5050/v3/KIT/0001/factsheet"));
  EXPECT_EQ(factsheet["protocolFeatures"]["mobileRobotActions"].Size(), 29U);
}

TEST_F(Simulate, DoesNotTakeThePlaceOfARobotThatIsOnline) {
  const auto robot = Start({"KIT/0006", "--vda", "2.1"});
  for (const char* version : {"2.1", "3.0"}) {
    const Finished run = Fleetpub({"simulate", "KIT/0005", "KIT/0006", "--vda", version});
    EXPECT_EQ(run.exit_code, 7) << run.errors;
    EXPECT_THAT(run.errors, HasSubstr("uagv/v2/KIT/0006/connection"));
  }
  EXPECT_EQ(ConnectionState("uagv/v2/KIT/0006/connection"), "ONLINE");
  const auto forced = Start({"KIT/0006", "--force", "--for", "100ms"});
  EXPECT_EQ(forced->Wait(), 0);
}

TEST_F(Simulate, SpeaksEachVersion) {
  struct Case {
    const char* version;
    const char* prefix;
  };
  for (const auto& [version, prefix] : {Case{"1.1.0", "uagv/v1"}, Case{"2.0.0", "uagv/v2"},
                                        Case{"2.1.0", "uagv/v2"}, Case{"3.0.0", "vda5050/v3"}}) {
    const auto robot = Start({"KIT/0001", "--vda", version});
    const Subscriber states(broker_, std::string(prefix) + "/KIT/0001/state");
    EXPECT_EQ(Fleetpub({"pause", "KIT/0001", "--vda", version}).exit_code, 0);
    const auto received = states.Await(1);
    ASSERT_THAT(received, SizeIs(1)) << version;
    const auto state = Json(received.front().payload);
    EXPECT_STREQ(state["version"].GetString(), version);
    EXPECT_TRUE(state["paused"].GetBool()) << version;
    EXPECT_FALSE(received.front().retained);
  }
}

TEST_F(Simulate, SaysOfflineWhenItIsEnded) {
  for (const int signal : {SIGTERM, SIGINT}) {
    const auto robot = Start({"KIT/0001"});
    const Subscriber connections(broker_, "+/+/+/+/connection", 1);
    robot->Signal(signal);
    EXPECT_EQ(robot->Wait(), 0) << robot->Errors();
    const auto said = connections.Await(3);
    ASSERT_THAT(said, SizeIs(3));
    EXPECT_STREQ(Json(said[1].payload)["connectionState"].GetString(), "OFFLINE");
    EXPECT_EQ(said[2].payload, "") << "nothing is left behind";
  }
}

TEST_F(Simulate, LeavesRetainedMessagesAsItFoundThem) {
  const auto say = [&](const std::string& topic, const std::string& payload) {
    EXPECT_EQ(testing::Run({.arguments = {"mosquitto_pub", "-p", std::to_string(broker_.port()),
                                          "-r", "-q", "1", "-t", topic, "-m", payload}})
                  .exit_code,
              0);
  };
  const std::string earlier = R"({"connectionState":"CONNECTION_BROKEN","version":"3.0.0"})";
  const std::string factsheet = R"({"version":"3.0.0","own":true})";
  say("vda5050/v3/KIT/0002/connection", earlier);
  say("vda5050/v3/KIT/0003/factsheet", factsheet);
  say("uagv/v2/KIT/0001/connection", earlier);
  const auto robots = Start({"KIT/0001", "--count", "3"});
  EXPECT_EQ(ConnectionState("vda5050/v3/KIT/0002/connection"), "ONLINE");
  robots->Signal(SIGTERM);
  EXPECT_EQ(robots->Wait(), 0);
  EXPECT_EQ(Retained("vda5050/v3/KIT/0002/connection"), earlier);
  EXPECT_EQ(Retained("vda5050/v3/KIT/0003/factsheet"), factsheet);
  const Finished left =
      testing::Run({.arguments = {"mosquitto_sub", "-p", std::to_string(broker_.port()), "-t", "#",
                                  "-F", "%t", "--retained-only", "-W", "1"}});
  EXPECT_THAT(Lines(left.output), ::testing::UnorderedElementsAre("vda5050/v3/KIT/0002/connection",
                                                                  "vda5050/v3/KIT/0003/factsheet",
                                                                  "uagv/v2/KIT/0001/connection"));
}

TEST_F(Simulate, SaysWhenTheBrokerRefusesWhatItSays) {
  const Mosquitto broker({"allow_anonymous true", "acl_file {}/acl"}, {{"acl", "topic read #\n"}});
  const Finished known = Fleetpub({"simulate", "KIT/0001", "-b", broker.Url(), "-V", "5"});
  EXPECT_EQ(known.exit_code, 4) << known.errors;
  EXPECT_THAT(known.errors, HasSubstr("vda5050/v3/KIT/0001/connection"));
  EXPECT_THAT(known.errors, Not(HasSubstr("online")));
  Process unknown(operator_.Prepare({"simulate", "KIT/0001", "-b", broker.Url()}));
  EXPECT_TRUE(unknown.AwaitErrors(" online at "));
  EXPECT_THAT(unknown.Errors(), HasSubstr("-V 5")) << "MQTT 3.1.1 has no word for no";
}

TEST_F(Simulate, LeavesItsLastWillWhenItIsKilled) {
  const Subscriber connections(broker_, "+/+/+/+/connection", 1);
  const auto robots = Start({"KIT/0001", "--count", "3"});
  robots->Signal(SIGKILL);
  std::vector<std::string> broken;
  for (const auto& message : connections.Await(6)) {
    if (message.payload.find("CONNECTION_BROKEN") != std::string::npos) {
      broken.push_back(message.topic);
    }
  }
  EXPECT_THAT(broken, SizeIs(3));
  EXPECT_EQ(ConnectionState("vda5050/v3/KIT/0003/connection"), "CONNECTION_BROKEN");
}

TEST_F(Simulate, EndsByItself) {
  const auto robot = Start({"KIT/0001", "--for", "100ms"});
  EXPECT_EQ(robot->Wait(), 0);
  const auto other = Start({"KIT/0001", "KIT/0002"});
  EXPECT_EQ(Fleetpub({"shutdown", "KIT/0001", "KIT/0002", "--vda", "3"}).exit_code, 0);
  EXPECT_EQ(other->Wait(), 0) << "all have shut down";
}

TEST_F(Simulate, AThousandRobotsEachAnswer) {
  constexpr int kRobots = 1000;
  const auto robots = Start({"KIT/0001", "--count", std::to_string(kRobots)});
  const Subscriber states(broker_, "vda5050/v3/KIT/+/state");
  std::vector<std::string> arguments = {"pause", "--quiet", "--vda", "3"};
  for (int i = 1; i <= kRobots; ++i) {
    const std::string number = std::to_string(i);
    arguments.push_back("KIT/" + std::string(4 - number.size(), '0') + number);
  }
  EXPECT_EQ(Fleetpub(arguments).exit_code, 0);
  EXPECT_THAT(states.Await(kRobots), SizeIs(kRobots));
}

TEST_F(Simulate, ComesBackWhenTheBrokerDoes) {
  const auto robot = Start({"KIT/0001"});
  broker_.Restart();
  EXPECT_TRUE(robot->AwaitErrors("connecting again"));
  const Subscriber connections(broker_, "+/+/+/+/connection", 1);
  const auto messages = connections.Await(1);
  ASSERT_THAT(messages, SizeIs(1));
  EXPECT_THAT(messages.front().payload, HasSubstr("ONLINE"));
}

TEST_F(Simulate, ReportsWhatBreaksTheSpecification) {
  const auto robot = Start({"KIT/0001", "-v"});
  EXPECT_EQ(
      testing::Run({.arguments = {"mosquitto_pub", "-p", std::to_string(broker_.port()), "-r", "-t",
                                  "vda5050/v3/KIT/0001/instantActions", "-m", "{\"headerId\":9}"}})
          .exit_code,
      0);
  EXPECT_TRUE(robot->AwaitErrors("headerId 9"));
  EXPECT_THAT(robot->Errors(), HasSubstr("required but missing"));
  EXPECT_EQ(Fleetpub({"pause", "KIT/0001", "--id", "abc"}).exit_code, 0);
  EXPECT_TRUE(robot->AwaitErrors("KIT/0001: instantActions headerId 0: startPause abc"));
}

struct Refused {
  std::vector<std::string> arguments;
  const char* why;
};

TEST_F(Simulate, RefusesWhatMakesNoSense) {
  const std::vector<Refused> cases = {
      {{}, "manufacturer/serialNumber"},
      {{"KIT/robot", "--count", "2"}, "--count"},
      {{"KIT/1", "--count", "0"}, "--count"},
      {{"KIT/1", "--vda", "2.1", "--retriable", "charge"}, "--retriable"},
      {{"KIT/1", "--vda", "2.1", "--mode", "STARTUP"}, "--mode"},
      {{"KIT/1", "--drop", "101"}, "--drop"},
      {{"KIT/1", "--reject-style", "loud"}, "--reject-style"},
      {{"KIT/1", "--vda", "auto"}, "--vda"},
      {{"KIT/0001", "KIT/0002", "--count", "2"}, "KIT/0002"},
  };
  for (const auto& [arguments, why] : cases) {
    std::vector<std::string> all = {"simulate"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const Finished run = Fleetpub(all);
    EXPECT_EQ(run.exit_code, 2) << why;
    EXPECT_THAT(run.errors, HasSubstr(why));
  }
  operator_.UseBroker("mqtt://127.0.0.1:1");
  EXPECT_EQ(Fleetpub({"simulate", "KIT/1", "--connect-timeout", "200ms"}).exit_code, 4);
}

}  // namespace
}  // namespace fleetpub::testing
