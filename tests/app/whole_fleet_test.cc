#include "app/whole_fleet.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <set>

#include "support/fake_observer.h"
#include "support/fake_transport.h"

namespace fleetpub::app {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

// Hands out so many retained messages for a filter, as ejabberd.
class StingyBroker : public testing::FakeTransport {
 public:
  StingyBroker(testing::Journal& journal, std::size_t most) : FakeTransport(journal), most_(most) {}

  int asked = 0;

  void Add(std::string_view place, std::string_view manufacturer, int robots) {
    for (int i = 0; i < robots; ++i) {
      topics_.push_back(fmt::format("{}/{}/{:05}/connection", place, manufacturer, i));
    }
  }

  Status Subscribe(std::span<const std::string> filters, mqtt::Qos /*qos*/,
                   mqtt::Deadline /*deadline*/) override {
    ++asked;
    for (const std::string& filter : filters) {
      std::size_t left = most_;
      for (const std::string& topic : topics_) {
        if (left == 0) break;
        if (!delivery::Matches(filter, topic)) continue;
        incoming_.push_back({.topic = topic, .payload = "{}", .retained = true});
        --left;
      }
    }
    return {};
  }

 private:
  std::size_t most_;
  std::vector<std::string> topics_;
};

class WholeFleet : public ::testing::Test {
 protected:
  HandedOut Read() {
    const std::vector<vda5050::TopicScheme> schemes(1);
    const auto handed_out = ReadWholeFleet(
        broker_, {.schemes = schemes, .filters = {"+/+/+/+/connection"}, .expected = expected_}, {},
        [this](const mqtt::Message& message) { found_.insert(message.topic); },
        [this] { return found_.size(); });
    EXPECT_TRUE(handed_out);
    WarnOfLimit(*handed_out, log_);
    return *handed_out;
  }

  testing::Journal journal_;
  StingyBroker broker_{journal_, 1'000};
  std::vector<ExpectedRobot> expected_;
  std::set<std::string> found_;
  testing::FakeLog log_;
};

TEST_F(WholeFleet, IsAskedForOnceWhereNothingIsLeftOut) {
  broker_.Add("vda5050/v3", "KIT", 950);
  EXPECT_TRUE(Read().any);
  EXPECT_THAT(found_, SizeIs(950));
  EXPECT_EQ(broker_.asked, 1);
  EXPECT_THAT(log_.warnings, IsEmpty());
}

TEST_F(WholeFleet, IsAskedForInPartsWhereABrokerHandsOutOnlySoMuch) {
  broker_.Add("site/v2", "KIT", 400);
  broker_.Add("vda5050/v3", "KIT", 700);
  broker_.Add("uagv/v2", "KIT", 300);
  broker_.Add("uagv/v2", "ACME", 600);
  expected_.push_back({.robot = {"ACME", "00001"}, .scheme = {}});
  EXPECT_EQ(Read().limit, 0U);
  EXPECT_THAT(found_, SizeIs(2'000));
  EXPECT_THAT(log_.warnings, IsEmpty());
}

TEST_F(WholeFleet, IsSaidToBePerhapsIncompleteWhereAPartIsAsLargeAsThat) {
  broker_.Add("vda5050/v3", "KIT", 1'200);
  EXPECT_EQ(Read().limit, 1'000U);
  EXPECT_THAT(log_.warnings, SizeIs(1));
}

TEST_F(WholeFleet, IsSaidToBePerhapsIncompleteWhereAQueueWasFull) {
  broker_.Add("vda5050/v3", "KIT", 999);
  EXPECT_EQ(Read().limit, 999U);
  EXPECT_THAT(log_.warnings, SizeIs(1));
}

TEST_F(WholeFleet, MayBeNobody) {
  EXPECT_FALSE(Read().any);
  EXPECT_THAT(log_.warnings, IsEmpty());
}

}  // namespace
}  // namespace fleetpub::app
