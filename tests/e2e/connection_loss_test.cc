// Networks and brokers that go away, come back, or are far: one message, and the truth about it.
#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <set>

#include "support/operator.h"
#include "support/relay.h"

namespace fleetpub::testing {
namespace {

using std::chrono::milliseconds;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::Eq;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

class ConnectionLoss : public EndToEnd {
 protected:
  // What the broker got for the robot since it was started.
  [[nodiscard]] std::ptrdiff_t Commands() const {
    const auto lines = Lines(broker_.Log());
    return std::count_if(lines.begin(), lines.end(), [](const std::string& line) {
      return line.find("Received PUBLISH") != std::string::npos &&
             line.find("/instantActions'") != std::string::npos;
    });
  }
  [[nodiscard]] std::vector<std::string> History() const {
    return Lines(Fleetpub({"history", "-o", "json"}).output);
  }
  /// `fleetpub charge KIT/0001 --wait …` over this broker URL, once the robot has the command.
  [[nodiscard]] std::unique_ptr<Process> Charge(Process& robot, const std::string& url,
                                                std::vector<std::string> more) const {
    more.insert(more.begin(), {"charge", "KIT/0001", "--wait", "-b", url});
    auto run = std::make_unique<Process>(operator_.Prepare(std::move(more)));
    EXPECT_TRUE(robot.AwaitErrors("startCharging")) << robot.Errors() << run->Errors();
    return run;
  }
};

TEST_F(ConnectionLoss, WaitsOnWhenTheBrokerIsStartedAgain) {
  const auto robot = Robot({"KIT/0001", "--delay", "1s", "--state-interval", "300ms", "-v"});
  const auto run = Charge(*robot, broker_.Url(), {"-W", "60s"});
  EXPECT_EQ(Commands(), 1);
  broker_.Kill();
  ASSERT_TRUE(run->AwaitErrors("was lost: the broker closed it"));
  broker_.Restart();
  EXPECT_EQ(run->Wait(), 0) << run->Output() << run->Errors();
  EXPECT_THAT(run->Errors(), AllOf(HasSubstr("connecting again"), HasSubstr("connected again")));
  EXPECT_THAT(run->Output(), HasSubstr("FINISHED"));
  EXPECT_EQ(Commands(), 0) << "the broker that was started again got none";
  EXPECT_THAT(History(), SizeIs(1));
}

TEST_F(ConnectionLoss, SaysThatTheBrokerNeverCameBack) {
  const auto robot = Robot({"KIT/0001", "--delay", "30s", "-v"});
  const auto run = Charge(*robot, broker_.Url(), {"-W", "2s"});
  broker_.Kill();
  EXPECT_EQ(run->Wait(), 6) << run->Output();
  EXPECT_THAT(run->Output(), AllOf(HasSubstr("TIMEOUT"), HasSubstr("out of reach at the end")));
  EXPECT_THAT(Lines(run->Errors()), SizeIs(1)) << "it is not told again and again";
  EXPECT_THAT(History(), SizeIs(1));
}

// Nobody hangs up: only the keep-alive can tell.
TEST_F(ConnectionLoss, NoticesThatTheNetworkIsDead) {
  const auto robot = Robot({"KIT/0001", "--delay", "1s", "--state-interval", "300ms", "-v"});
  Relay relay(broker_.port());
  const auto run = Charge(*robot, relay.Url(), {"-W", "60s", "-k", "1", "--connect-timeout", "2s"});
  relay.Die();
  ASSERT_TRUE(run->AwaitErrors("did not answer the keep-alive pings")) << run->Errors();
  relay.Revive();
  EXPECT_EQ(run->Wait(), 0) << run->Output() << run->Errors();
  EXPECT_EQ(Commands(), 1);
  EXPECT_THAT(History(), SizeIs(1));
}

TEST_F(ConnectionLoss, IsWaitedForNoLongerThanTheTimeout) {
  const auto robot = Robot({"KIT/0001", "--delay", "30s", "-v"});
  Relay relay(broker_.port());
  const auto run = Charge(*robot, relay.Url(), {"-W", "1s"});
  relay.Die();
  EXPECT_EQ(run->Wait(), 6);
  const auto waiting = std::make_unique<Process>(
      operator_.Prepare({"await", "KIT/0001", "state", "paused=true", "-W", "500ms",
                         "--connect-timeout", "500ms", "-b", relay.Url()}));
  EXPECT_THAT(waiting->Wait(milliseconds(8000)), AnyOf(Eq(4), Eq(6)));
}

TEST_F(ConnectionLoss, IsNotADistantBroker) {
  const auto robot = Robot({"KIT/0001", "--state-interval", "500ms"});
  const Subscriber subscriber(broker_, "+/+/+/+/instantActions");
  const Relay far(broker_.port(), milliseconds(150));
  operator_.UseBroker(far.Url());
  for (const std::vector<std::string>& call : std::vector<std::vector<std::string>>{
           {"pause", "KIT/0001"},
           {"resume", "KIT/0001", "-q", "1", "-V", "5"},
           {"pause", "KIT/0001", "--wait", "-q", "2"},
           {"resume", "KIT/0001", "--wait", "--vda", "auto", "-W", "60s"},
           {"await", "KIT/0001", "state", "paused=false", "-W", "60s"},
           {"fleet"},
           {"ping"}}) {
    const Finished run = Fleetpub(call);
    EXPECT_EQ(run.exit_code, 0) << call[0] << run.output << run.errors;
  }
  EXPECT_THAT(subscriber.Await(4), SizeIs(4));
  EXPECT_EQ(Commands(), 4);
}

TEST_F(ConnectionLoss, SurvivesThatSomebodyElseTakesTheClientId) {
  const auto robot = Robot({"KIT/0001", "--delay", "1s", "--state-interval", "300ms", "-v"});
  const auto run = Charge(*robot, broker_.Url(), {"-W", "60s", "-i", "hall-1"});
  EXPECT_EQ(Send({"pause", "KIT/0001", "-i", "hall-1"}).exit_code, 0);
  EXPECT_EQ(run->Wait(), 0) << run->Output() << run->Errors();
  EXPECT_THAT(run->Errors(), HasSubstr("does another client use the same client id?"));
  EXPECT_EQ(Commands(), 2);
  EXPECT_THAT(History(), SizeIs(2));
}

// Each throws the other out whenever it connects.
TEST_F(ConnectionLoss, CalmsDownWhenTwoWaitWithOneClientId) {
  const auto robot = Robot({"KIT/0001", "--silent", "-v"});
  const auto first = Charge(*robot, broker_.Url(), {"-W", "4s", "-i", "hall-1"});
  Process second(
      operator_.Prepare({"pause", "KIT/0001", "--wait", "--no-check", "-W", "4s", "-i", "hall-1"}));
  EXPECT_EQ(first->Wait(), 6) << first->Output();
  EXPECT_THAT(second.Wait(), AnyOf(Eq(4), Eq(6))) << second.Output();
  EXPECT_LE(Commands(), 2);
  const auto log = Lines(broker_.Log());
  const auto connects = std::count_if(log.begin(), log.end(), [](const std::string& line) {
    return line.find("as hall-1") != std::string::npos;
  });
  EXPECT_LE(connects, 6) << "without growing pauses it would be more";
}

}  // namespace
}  // namespace fleetpub::testing
