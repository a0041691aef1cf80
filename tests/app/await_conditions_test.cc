#include "app/await_conditions.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "support/fake_environment.h"
#include "support/fake_observer.h"

namespace fleetpub::app {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class AwaitingConditions : public ::testing::Test {
 protected:
  AwaitingConditions() {
    request_.target = "KIT/0001";
    request_.topic = "state";
    request_.conditions.push_back(vda5050::ParseCondition("paused=true").value());
    request_.timeout = std::chrono::milliseconds(20);
    world_.on_connect = [this](testing::FakeTransport& broker) {
      broker.retained = retained_;
      broker_ = &broker;
    };
  }

  void Says(const std::string& serial, const std::string& topic, const std::string& payload) {
    retained_[fmt::format("vda5050/v3/KIT/{}/{}", serial, topic)] = payload;
  }

  Status Await() {
    return AwaitConditions(
        request_, world_.Get(),
        [this](const vda5050::RobotAddress& robot, const std::string& line,
               std::chrono::nanoseconds /*elapsed*/) {
          satisfied_.push_back(robot.ToString() + " " + line);
          subscribed_ = broker_->subscribed();
        },
        log_);
  }

  std::map<std::string, std::string> retained_;
  testing::FakeEnvironment world_;
  testing::FakeLog log_;
  AwaitRequest request_;
  testing::FakeTransport* broker_ = nullptr;
  std::vector<std::string> satisfied_;
  std::set<std::string> subscribed_;  // when the last of these was
};

TEST_F(AwaitingConditions, EndsWithTheMessageThatSatisfiesThem) {
  Says("0001", "state", R"({"paused":true})");
  EXPECT_TRUE(Await());
  EXPECT_THAT(satisfied_, ElementsAre(R"(KIT/0001 {"paused":true})"));
  EXPECT_THAT(world_.journal.entries(), Contains("disconnect"));
}

TEST_F(AwaitingConditions, ShowsAMessageOfSeveralLinesAsOne) {
  Says("0001", "state", "{\n  \"paused\": true\n}");
  EXPECT_TRUE(Await());
  EXPECT_THAT(satisfied_, ElementsAre(R"(KIT/0001 {"paused":true})"));
}

TEST_F(AwaitingConditions, SaysWhatWasSaidInstead) {
  Says("0001", "state", R"({"paused":false})");
  const Status awaited = Await();
  ASSERT_FALSE(awaited);
  EXPECT_EQ(awaited.error().kind, ErrorKind::kUnconfirmed);
  EXPECT_THAT(awaited.error().message, AllOf(HasSubstr("KIT/0001"), HasSubstr("paused is false")));
}

TEST_F(AwaitingConditions, SaysThatNothingCame) {
  const Status awaited = Await();
  ASSERT_FALSE(awaited);
  EXPECT_THAT(awaited.error().message, HasSubstr("no state message came"));
}

TEST_F(AwaitingConditions, AwaitsEachRobotOfAPatternOverOneConnection) {
  request_.target = "KIT/*";
  request_.timeout = std::chrono::seconds(10);
  for (const std::string serial : {"0001", "0002"}) {
    Says(serial, "connection", R"({"connectionState":"ONLINE"})");
    Says(serial, "state", R"({"paused":true})");
  }
  EXPECT_TRUE(Await());
  EXPECT_THAT(satisfied_,
              ElementsAre(R"(KIT/0001 {"paused":true})", R"(KIT/0002 {"paused":true})"));
  EXPECT_EQ(world_.connections, 1);
  EXPECT_THAT(subscribed_, Each(EndsWith("/state"))) << "who they are is known";
}

TEST_F(AwaitingConditions, CountsNoMessageOfAnotherTopic) {
  request_.target = "KIT/*";
  Says("0001", "connection", R"({"connectionState":"ONLINE"})");
  world_.on_connect = [this](testing::FakeTransport& broker) {
    broker.retained = retained_;
    broker.arriving = {
        {.topic = "vda5050/v3/KIT/0001/connection", .payload = R"({"paused":true})"}};
    broker.arrives_behind = 2;  // the search for the robots stays subscribed
  };
  EXPECT_FALSE(Await());
  EXPECT_THAT(satisfied_, IsEmpty());
}

TEST_F(AwaitingConditions, NamesThePatternThatFindsNobody) {
  request_.target = "ACME/*";
  Says("0001", "connection", R"({"connectionState":"ONLINE"})");
  const Status awaited = Await();
  ASSERT_FALSE(awaited);
  EXPECT_EQ(awaited.error().kind, ErrorKind::kPreflight);
  EXPECT_THAT(awaited.error().message, HasSubstr("ACME/*"));
}

TEST_F(AwaitingConditions, ConnectsForNoSlipOfThePen) {
  request_.conditions.push_back(vda5050::ParseCondition("pausd=true").value());
  EXPECT_FALSE(Await());
  EXPECT_EQ(world_.connections, 0);
}

TEST_F(AwaitingConditions, WarnsOfATopicThatNearlyIsOne) {
  request_.topic = "stat";
  EXPECT_FALSE(Await());
  EXPECT_THAT(log_.warnings, Contains(HasSubstr("did you mean state")));
  EXPECT_THAT(satisfied_, IsEmpty());
}

}  // namespace
}  // namespace fleetpub::app
