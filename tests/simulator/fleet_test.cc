// Many robots: whom a message reaches, and when it is whose turn.
#include "simulator/fleet.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "base/json.h"
#include "vda5050/messages/instant_actions.h"

namespace fleetpub::simulator {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;
using vda5050::RobotAddress;

class Fleets : public ::testing::Test {
 protected:
  std::unique_ptr<Fleet> Make(Settings settings, std::size_t count) {
    auto fleet = Fleet::Make(std::move(settings), *CountUp({"KIT", "0001"}, count), registry_,
                             [this](std::string_view robot, const Event& event) {
                               remarks_.push_back(fmt::format("{} {}", robot, event.text));
                             });
    return std::move(*fleet);
  }
  [[nodiscard]] static mqtt::Message Pause(const std::string& serial, bool retained = false) {
    const vda5050::InstantAction action{"startPause", "a-" + serial, "", "", {}};
    const auto command = vda5050::BuildInstantActions({"KIT", serial}, {}, {&action, 1});
    return {command->topic, command->payload.Render(0, base::WallTime::clock::now()),
            mqtt::Qos::kAtMostOnce, retained};
  }

  schema::Registry registry_;
  std::vector<std::string> remarks_;
  Moment now_{std::chrono::steady_clock::time_point(std::chrono::hours(1)), base::WallTime()};
  std::vector<Outgoing> out_;
};

std::string Describe(const Outgoing& outgoing) {
  return fmt::format("{} q{}{}", outgoing.message.topic, static_cast<int>(outgoing.message.qos),
                     outgoing.retain ? " retained" : "");
}

TEST_F(Fleets, GreetWithRetainedConnectionAndFactsheet) {
  const auto fleet = Make({}, 1);
  fleet->Start(now_, out_);
  std::vector<std::string> sent;
  for (const Outgoing& one : out_) sent.push_back(Describe(one));
  EXPECT_THAT(sent, ElementsAre("vda5050/v3/KIT/0001/connection q1 retained",
                                "vda5050/v3/KIT/0001/factsheet q0 retained",
                                "vda5050/v3/KIT/0001/state q0"));
  const mqtt::Will will = fleet->MakeWill(0, now_);
  EXPECT_EQ(will.topic, "vda5050/v3/KIT/0001/connection");
  EXPECT_TRUE(will.retain);
  EXPECT_THAT(will.payload, HasSubstr("CONNECTION_BROKEN"));
}

TEST_F(Fleets, DeliverToTheRobotThatIsMeant) {
  const auto fleet = Make({}, 3);
  fleet->Receive(Pause("0002"), now_, out_);
  ASSERT_THAT(out_, SizeIs(1));
  EXPECT_EQ(out_.front().message.topic, "vda5050/v3/KIT/0002/state");
  EXPECT_THAT(remarks_, ElementsAre(HasSubstr("KIT/0002 instantActions headerId 0: startPause")));
  fleet->Receive(Pause("0009"), now_, out_);
  EXPECT_THAT(out_, SizeIs(1));
  EXPECT_THAT(fleet->Subscriptions(),
              AllOf(SizeIs(12), Contains("vda5050/v3/KIT/0003/instantActions"),
                    Contains("vda5050/v3/KIT/0003/responses")));
}

TEST_F(Fleets, RemarkOnARetainedCommand) {
  const auto fleet = Make({}, 1);
  fleet->Receive(Pause("0001", true), now_, out_);
  EXPECT_THAT(remarks_, Contains(HasSubstr("must not be retained")));
}

TEST_F(Fleets, DropTheirShareRepeatably) {
  const auto count = [&](unsigned seed) {
    out_.clear();
    Settings settings;
    settings.drop = 0.3;
    settings.drop_seed = seed;
    const auto fleet = Make(settings, 1000);
    const auto robots = CountUp({"KIT", "0001"}, 1000);
    for (const RobotAddress& robot : *robots) {
      fleet->Receive(Pause(robot.serial_number), now_, out_);
    }
    return out_.size();
  };
  const auto first = count(1);
  EXPECT_GT(first, 600U);
  EXPECT_LT(first, 800U);
  EXPECT_EQ(count(1), first);
}

TEST_F(Fleets, TakeTurnsWhenTheyAreDue) {
  Settings settings;
  settings.delay = std::chrono::seconds(1);
  const auto fleet = Make(settings, 100);
  fleet->Start(now_, out_);
  out_.clear();
  fleet->Receive(Pause("0007"), now_, out_);
  ASSERT_THAT(out_, SizeIs(1));
  EXPECT_EQ(fleet->Due(), now_.steady + std::chrono::seconds(1));
  now_.steady += std::chrono::seconds(1);
  fleet->Tick(now_, out_);
  ASSERT_THAT(out_, SizeIs(2));
  EXPECT_THAT(out_.back().message.payload, HasSubstr("FINISHED"));
  EXPECT_EQ(fleet->Due(), now_.steady + std::chrono::seconds(29)) << "the others' next states";
}

TEST_F(Fleets, SayGoodbye) {
  const auto fleet = Make({}, 2);
  fleet->End(now_, out_);
  ASSERT_THAT(out_, SizeIs(2));
  EXPECT_THAT(out_.back().message.payload, HasSubstr("OFFLINE"));
  EXPECT_EQ(fleet->present(), 0U);
}

struct Counted {
  const char* first;
  std::size_t count;
  const char* last;
};

constexpr Counted kCounted[] = {
    {"0001", 10, "0010"},
    {"9998", 3, "10000"},
    {"agv-7", 4, "agv-10"},
    {"robot", 1, "robot"},
};

TEST(CountUp, KeepsTheWidth) {
  for (const auto& [first, count, last] : kCounted) {
    const auto robots = CountUp({"KIT", first}, count);
    ASSERT_TRUE(robots) << first;
    EXPECT_EQ(robots->size(), count);
    EXPECT_EQ(robots->back().serial_number, last);
  }
}

TEST(CountUp, RefusesASerialNumberWithoutANumber) {
  const auto robots = CountUp({"KIT", "robot"}, 2);
  ASSERT_FALSE(robots);
  EXPECT_EQ(robots.error().kind, ErrorKind::kUsage);
}

TEST_F(Fleets, RefuseToShareTopics) {
  const auto fleet = Fleet::Make({}, {{"KIT", "1"}, {"KIT", "1"}}, registry_, {});
  ASSERT_FALSE(fleet);
  EXPECT_THAT(fleet.error().message, HasSubstr("KIT/1"));
}

}  // namespace
}  // namespace fleetpub::simulator
