// The core list: what has to work at every broker, in each of its ways in. The short form belongs to
// every run of the tests; FLEETPUB_CORE_LIST=long is every transport and MQTT version, with a
// thousand robots. What a broker cannot do is asserted too, and stands in docs/brokers.md.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstdlib>
#include <functional>
#include <memory>
#include <ostream>

#include "support/aedes.h"
#include "support/ejabberd.h"
#include "support/operator.h"
#include "support/rabbitmq.h"

namespace fleetpub::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

// RabbitMQ takes 15 s for the subscriptions to a thousand robots, with nothing beside it.
constexpr std::chrono::seconds kPatience = 2 * Process::kPatience;
// For what a broker has to answer. An attempt that a robot gives up publishes its last will, which
// ends a wait: OFFLINE.
constexpr const char* kAcknowledged = "60s";

enum class Kind { kMosquitto, kAedes, kEjabberd, kRabbitMq };

struct Way {
  Kind broker = Kind::kMosquitto;
  std::string scheme;
  std::string version;
};

// For GoogleTest, where a test fails.
void PrintTo(const Way& way, std::ostream* out) { *out << way.scheme << ", MQTT " << way.version; }

bool IsLong() {
  const char* form = std::getenv("FLEETPUB_CORE_LIST");
  return form != nullptr && std::string_view(form) == "long";
}

int FleetSize() { return IsLong() ? 40 : 10; }

std::vector<Way> Ways(Kind broker) {
  const bool has_5 = broker == Kind::kMosquitto || broker == Kind::kEjabberd;
  if (!IsLong()) return {{broker, "mqtt", has_5 ? "5" : "3.1.1"}};
  std::vector<Way> ways = {{broker, "mqtt", "3.1.1"}, {broker, "ws", "3.1.1"}};
  if (has_5) ways.insert(ways.end(), {{broker, "mqtt", "5"}, {broker, "ws", "5"}});
  return ways;
}

constexpr auto kName = [](const ::testing::TestParamInfo<Way>& way) {
  return way.param.scheme + way.param.version.substr(0, 1);
};

// A broker that is running.
struct Running {
  std::function<std::string(const std::string&)> url;
  std::function<void()> restart;
};

template <typename Broker>
Running Use(std::shared_ptr<Broker> broker) {
  return {[broker](const std::string& scheme) { return broker->Url(scheme); },
          [broker] { broker->Restart(); }};
}

// A listener of mosquitto is for WebSockets or not. Over these it drops what is retained beyond
// max_queued_messages, 1,000 by default.
struct Mosquittos {
  [[nodiscard]] std::string Url(const std::string& scheme) const {
    return (scheme == "ws" ? web : plain).Url(scheme);
  }
  void Restart() {
    plain.Restart();
    web.Restart();
  }

  Mosquitto plain;
  Mosquitto web{{"allow_anonymous true", "max_queued_messages 0", "protocol websockets"}};
};

Running Start(Kind broker) {
  switch (broker) {
    case Kind::kMosquitto:
      return Use(std::make_shared<Mosquittos>());
    case Kind::kAedes:
      return Use(std::make_shared<Aedes>());
    case Kind::kEjabberd:
      return Use(std::make_shared<Ejabberd>());
    case Kind::kRabbitMq:
      // It takes ten seconds to start: one for all suites.
      return Use(std::shared_ptr<RabbitMq>(&RabbitMq::Shared(), [](auto*) {}));
  }
  return {};
}

class CoreList : public ::testing::TestWithParam<Way> {
 public:
  static void TearDownTestSuite() { shared_ = {}; }

 protected:
  CoreList() : maker_(fmt::format("M{}", ++makers_)) {
    if (!shared_.url) shared_ = testing::Start(GetParam().broker);
    operator_.UseBroker(shared_.url(GetParam().scheme));
  }

  // Ends the robots in order, so that they leave nothing behind.
  void TearDown() override {
    for (const auto& robots : robots_) robots->Signal();
    for (const auto& robots : robots_) EXPECT_EQ(robots->Wait(), 0) << robots->Errors();
  }

  // RabbitMQ keeps what is retained for exact topics only.
  [[nodiscard]] static bool KeepsForPatterns() { return GetParam().broker != Kind::kRabbitMq; }
  static void RestartBroker() { shared_.restart(); }

  [[nodiscard]] Command Prepare(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(),
                     {"-V", GetParam().version, "--connect-timeout", kAcknowledged});
    Command command = operator_.Prepare(std::move(arguments));
    // ejabberd lets nobody in without one, whichever it is.
    if (GetParam().broker == Kind::kEjabberd)
      command.environment.emplace_back("FLEETPUB_PASSWORD", "p");
    return command;
  }
  [[nodiscard]] Finished Fleetpub(std::vector<std::string> arguments,
                                  const std::string& input = {}) const {
    Command command = Prepare(std::move(arguments));
    command.input = input;
    return testing::Run(std::move(command), kPatience);
  }
  // `fleetpub simulate ARGUMENTS…`, online when this returns; ends with the test.
  Process& Simulate(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "simulate");
    robots_.push_back(std::make_unique<Process>(Prepare(std::move(arguments))));
    EXPECT_TRUE(robots_.back()->AwaitErrors(" online at ", kPatience)) << robots_.back()->Errors();
    return *robots_.back();
  }
  // Gives the robots up to the test.
  std::unique_ptr<Process> Release() {
    auto last = std::move(robots_.back());
    robots_.pop_back();
    return last;
  }
  Process& Fleet(int count) { return Simulate({Robot(), "--count", std::to_string(count)}); }

  [[nodiscard]] std::string Robot(int number = 1) const {
    return fmt::format("{}/{:04}", maker_, number);
  }
  [[nodiscard]] std::string Everyone() const { return maker_ + "/*"; }
  [[nodiscard]] std::string Names(int count) const {
    std::string names;
    for (int i = 1; i <= count; ++i) names += Robot(i) + '\n';
    return names;
  }

  void ExpectEnd(const std::vector<std::string>& arguments, int exit_code,
                 const std::string& words) const {
    const Finished run = Fleetpub(arguments);
    EXPECT_EQ(run.exit_code, exit_code) << run.output << run.errors;
    EXPECT_THAT(run.output + run.errors, HasSubstr(words));
  }
  // Of so many robots, each has done it.
  static void ExpectDone(const Finished& run, int count) {
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    const auto lines = Lines(run.output);
    ASSERT_EQ(lines.size(), static_cast<std::size_t>(count) + 1);
    EXPECT_THAT(lines.back(), HasSubstr(fmt::format(R"("robots":{0},"finished":{0},)", count)));
  }

  std::string maker_;

 private:
  static inline Running shared_;
  static inline int makers_ = 0;
  Operator operator_;
  std::vector<std::unique_ptr<Process>> robots_;
};

INSTANTIATE_TEST_SUITE_P(Mosquitto, CoreList, ::testing::ValuesIn(Ways(Kind::kMosquitto)), kName);
INSTANTIATE_TEST_SUITE_P(Aedes, CoreList, ::testing::ValuesIn(Ways(Kind::kAedes)), kName);
INSTANTIATE_TEST_SUITE_P(Ejabberd, CoreList, ::testing::ValuesIn(Ways(Kind::kEjabberd)), kName);
INSTANTIATE_TEST_SUITE_P(RabbitMq, CoreList, ::testing::ValuesIn(Ways(Kind::kRabbitMq)), kName);

TEST_P(CoreList, Ping) { ExpectEnd({"ping"}, 0, "reachable"); }

TEST_P(CoreList, EachRobotPausesAtEachQos) {
  const int count = FleetSize();
  Fleet(count);
  for (const char* qos : {"0", "1", "2"}) {
    const char* action = *qos == '1' ? "resume" : "pause";
    ExpectDone(Fleetpub({action, "-", "--yes", "--wait", "-q", qos, "-o", "json"}, Names(count)),
               count);
  }
}

TEST_P(CoreList, ThePatternReachesAllOrSaysThatItFindsNobody) {
  const int count = FleetSize();
  Fleet(count);
  if (KeepsForPatterns()) {
    ExpectDone(Fleetpub({"pause", Everyone(), "--yes", "--wait", "-o", "json"}), count);
  } else {
    ExpectEnd({"pause", Everyone(), "--yes", "--wait"}, 7, maker_);
  }
}

TEST_P(CoreList, TheFleetIsShown) {
  const int count = FleetSize();
  Simulate({Robot(), "--count", std::to_string(count), "--state-interval", "300ms"});
  if (KeepsForPatterns()) {
    const auto rows = Lines(Fleetpub({"fleet", Everyone(), "-o", "json"}).output);
    EXPECT_THAT(rows, SizeIs(count));
    EXPECT_THAT(rows, ::testing::Each(HasSubstr(R"("connectionState":"ONLINE")")));
  } else {
    ExpectEnd({"fleet", Robot(), "--state-wait", "5s"}, 0, Robot());
  }
}

TEST_P(CoreList, AwaitHearsTheRobot) {
  Simulate({Robot(), "--count", "3", "--state-interval", "300ms"});
  ExpectEnd({"await", Robot(), "connection", "connectionState=ONLINE"}, 0, "ONLINE");
  Process waiting(Prepare({"await", Robot(2), "state", "paused=true"}));
  ExpectEnd({"pause", Robot(2), "--wait"}, 0, "FINISHED");
  EXPECT_EQ(waiting.Wait(), 0) << waiting.Errors();
  if (KeepsForPatterns()) {
    ExpectEnd({"await", Everyone(), "state", "driving=false"}, 0, Robot(3));
  }
}

TEST_P(CoreList, AnOrderIsTaken) {
  Simulate(
      {Robot(), "--vda", "2.1.0", "--edge-time", "60s"});  // it does not end before it is cancelled
  const std::string order = R"({"orderId":"o-1","orderUpdateId":0,"nodes":[
    {"nodeId":"n1","sequenceId":0,"released":true,"actions":[]},
    {"nodeId":"n2","sequenceId":2,"released":true,"actions":[]}],"edges":[
    {"edgeId":"e1","sequenceId":1,"released":true,"startNodeId":"n1","endNodeId":"n2","actions":[]}]})";
  const Finished sent = Fleetpub({"publish", "order", Robot(), "-f", "-", "--wait"}, order);
  EXPECT_EQ(sent.exit_code, 0) << sent.output << sent.errors;
  EXPECT_THAT(sent.output, HasSubstr("ACCEPTED"));
  ExpectEnd({"cancel", Robot(), "--wait"}, 0, "FINISHED");
}

TEST_P(CoreList, BatchEndsEachOfItsLines) {
  const int count = FleetSize();
  Fleet(count);
  std::string lines;
  for (int i = 1; i <= count; ++i) {
    lines += fmt::format(R"({{"id":{},"target":"{}","action":"pause"}})"
                         "\n",
                         i, Robot(i));
  }
  const Finished run = Fleetpub({"batch", "--wait", "-q", "1"}, lines);
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  const auto results = Lines(run.output);
  EXPECT_THAT(results, SizeIs(count));
  EXPECT_THAT(results, ::testing::Each(HasSubstr(R"("status":"FINISHED")")));
}

TEST_P(CoreList, TheLastWillIsSeen) {
  Simulate({Robot(), "--delay", "30s", "-v"});
  const auto robot = Release();
  Process run(Prepare({"charge", Robot(), "--wait"}));
  ASSERT_TRUE(robot->AwaitErrors("startCharging")) << robot->Errors() << run.Errors();
  robot->Signal(SIGKILL);
  EXPECT_EQ(run.Wait(), 6) << run.Output() << run.Errors();
  EXPECT_THAT(run.Output(), HasSubstr("OFFLINE"));
  ExpectEnd({"await", Robot(), "connection", "connectionState=CONNECTION_BROKEN"}, 0, maker_);
}

TEST_P(CoreList, TheWaitOutlivesTheBroker) {
  Process& robot = Simulate({Robot(), "--delay", "1s", "--state-interval", "300ms", "-v"});
  Process run(Prepare({"charge", Robot(), "--wait", "-W", "180s"}));
  ASSERT_TRUE(robot.AwaitErrors("startCharging")) << robot.Errors() << run.Errors();
  RestartBroker();  // it may take two minutes, with tests beside it
  EXPECT_EQ(run.Wait(2 * kPatience), 0) << run.Output() << run.Errors() << robot.Errors();
  EXPECT_THAT(run.Output(), HasSubstr("FINISHED"));
}

TEST_P(CoreList, ALargeFleetPauses) {
  const int count = IsLong() ? 1'000 : 100;
  Simulate({Robot(), "--count", std::to_string(count)});
  const auto all = [&](const std::string& action, const std::string& robots) {
    // With tests beside it aedes pauses for longer than 300 ms between what is retained.
    return Fleetpub({action, robots, "--yes", "--wait", "-W", "90s", "--discover",
                     IsLong() ? "2000" : "300", "-o", "json"},
                    Names(count));
  };
  ExpectDone(all("pause", "-"), count);
  if (KeepsForPatterns()) {
    ExpectDone(all("resume", Everyone()), count);
  }
}

TEST_P(CoreList, APlatformExecutesItsPlan) {
  const std::string platform = fmt::format("soar.{}.ecosub.eco1", maker_);
  Simulate({"--protocol", "soar", platform});
  ExpectEnd({"soar", "mission-plan", platform, "--plan-id", "3", "--platform-id", "1", "--waypoint",
             "lat=50.37,lon=-4.19", "--wait"},
            0, "FINISHED");
}

}  // namespace
}  // namespace fleetpub::testing
