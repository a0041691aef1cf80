#include "app/run_batch.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "support/fake_environment.h"
#include "support/fake_observer.h"
#include "support/report_matchers.h"
#include "support/temporary_folder.h"

namespace fleetpub::app {
namespace {

using message::CommandStatus;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::Field;
using testing::Is;
using ::testing::IsEmpty;
using testing::Says;
using ::testing::SizeIs;

/// Reads the results, and may have enough.
class Reader final : public BatchObserver {
 public:
  std::vector<message::Report> reports;
  std::size_t sent = 0;
  bool has_begun = false;
  bool is_stopped = false;
  Status readable;

  void Begin() override { has_begun = true; }
  void Sent() override { ++sent; }
  void Report(const message::Report& report) override { reports.push_back(report); }
  Status Flush() override { return readable; }
  [[nodiscard]] bool IsStopped() const override { return is_stopped; }
  [[nodiscard]] int stop_descriptor() const override { return -1; }
};

class RunningBatches : public ::testing::Test {
 protected:
  static std::string Pause(const std::string& serial, const std::string& more = "") {
    return R"({"target":"KIT/)" + serial + R"(","action":"startPause")" + more + "}\n";
  }

  Result<BatchEnd> Batch(const std::string& lines) {
    auto reader = base::LineReader::Open(folder_.Write("lines", lines));
    return RunBatch(*std::move(reader), request_, world_.Get(), reader_, log_);
  }

  [[nodiscard]] auto Published() const {
    const auto& entries = world_.journal.entries();
    return std::count_if(entries.begin(), entries.end(),
                         [](const std::string& entry) { return entry.starts_with("publish "); });
  }

  testing::TemporaryFolder folder_;
  testing::FakeEnvironment world_;
  testing::FakeLog log_;
  Reader reader_;
  BatchRequest request_;
};

TEST_F(RunningBatches, SendsEachLineAndReportsOnIt) {
  const auto end = Batch(Pause("0001", R"(,"id":"a")") + "\n" + Pause("0002"));
  ASSERT_TRUE(end) << end.error().message;
  EXPECT_EQ(end->reason, BatchStop::kEndOfInput);
  EXPECT_TRUE(end->all_read);
  EXPECT_EQ(end->sent, 2U);
  EXPECT_EQ(reader_.sent, 2U);
  EXPECT_THAT(reader_.reports,
              ElementsAre(AllOf(Is(CommandStatus::kSent),
                                Field(&message::Report::reference, R"("line":1,"id":"a")")),
                          AllOf(Is(CommandStatus::kSent),
                                Field(&message::Report::reference, R"("line":3)"))));
  EXPECT_EQ(world_.connections, 1);
  EXPECT_THAT(world_.journal.entries(), Contains("disconnect"));
}

TEST_F(RunningBatches, GoesOnBehindABadLine) {
  const auto end = Batch("nonsense\n" + Pause("0002"));
  ASSERT_TRUE(end);
  EXPECT_THAT(reader_.reports, ElementsAre(Is(CommandStatus::kInvalid), Is(CommandStatus::kSent)));
}

TEST_F(RunningBatches, StopsAtTheFirstErrorWhenTold) {
  request_.stop_on_error = true;
  const auto end = Batch(Pause("0001") + "nonsense\n" + Pause("0003"));
  ASSERT_TRUE(end);
  EXPECT_EQ(end->reason, BatchStop::kFirstError);
  EXPECT_FALSE(end->all_read);
  EXPECT_EQ(end->last_line, 2U);
  EXPECT_EQ(Published(), 1);
}

TEST_F(RunningBatches, ReadsNothingOnceStopped) {
  reader_.is_stopped = true;
  const auto end = Batch(Pause("0001"));
  ASSERT_TRUE(end);
  EXPECT_EQ(end->reason, BatchStop::kStopped);
  EXPECT_EQ(end->last_line, 0U);
  EXPECT_EQ(Published(), 0);
}

TEST_F(RunningBatches, StopsWhenNobodyReadsTheResults) {
  reader_.readable = Fail(ErrorKind::kLedger, "closed");
  request_.settings.rate = delivery::RateLimiter(1);
  const auto end = Batch(Pause("0001") + Pause("0002"));
  ASSERT_TRUE(end);
  EXPECT_EQ(end->reason, BatchStop::kUnread);
  EXPECT_EQ(end->sent, 1U);
}

TEST_F(RunningBatches, GivesUpWhenTheConnectionStaysLost) {
  world_.on_connect = [this](testing::FakeTransport& broker) {
    broker.publish_fails_at = 1;
    world_.connect_error = Error{ErrorKind::kBroker, "broker: refused"};
  };
  request_.reconnect = std::chrono::milliseconds(1);
  request_.settings.rate = delivery::RateLimiter(1000);
  std::string lines;
  for (int i = 0; i < 200; ++i) lines += Pause("0001");
  const auto end = Batch(lines);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->reason, BatchStop::kNoConnection);
  EXPECT_FALSE(end->all_read);
  EXPECT_THAT(reader_.reports, Contains(Says("perhaps sent")));
}

TEST_F(RunningBatches, SendsNothingWithoutAConnection) {
  world_.connect_error = Error{ErrorKind::kBroker, "broker: refused"};
  const auto end = Batch(Pause("0001"));
  ASSERT_FALSE(end);
  EXPECT_EQ(end.error().kind, ErrorKind::kBroker);
  EXPECT_THAT(reader_.reports, IsEmpty());
  EXPECT_FALSE(reader_.has_begun);
}

TEST_F(RunningBatches, ShowsWhatWouldBeSentInADryRun) {
  request_.settings.dry_run = true;
  const auto end = Batch(Pause("0001") + "nonsense\n" + Pause("0001"));
  ASSERT_TRUE(end);
  EXPECT_THAT(reader_.reports, SizeIs(3));
  EXPECT_THAT(reader_.reports, Contains(Is(CommandStatus::kDryRun)).Times(2));
  EXPECT_EQ(world_.connections, 0);
}

class LookingUpTheRobotsOfABatch : public RunningBatches {
 protected:
  LookingUpTheRobotsOfABatch() {
    const config::Config& config = world_.config;
    const auto resolver = DialectResolver::Make({}, config).value();
    request_.defaults.address = [resolver](std::string_view word) {
      return resolver.Resolve(vda5050::ParseRobotAddress(word).value());
    };
    request_.defaults.check = true;
    request_.discover.quiet = std::chrono::milliseconds(50);
    world_.on_connect = [](testing::FakeTransport& broker) {
      broker.retained["uagv/v2/KIT/1/connection"] =
          R"({"headerId":1,"timestamp":"2026-01-02T03:04:05.678Z","version":"2.1.0",)"
          R"("manufacturer":"KIT","serialNumber":"1","connectionState":"ONLINE"})";
    };
  }
};

TEST_F(LookingUpTheRobotsOfABatch, SpeaksToEachInItsOwnVersion) {
  ASSERT_TRUE(Batch(Pause("1") + Pause("1", R"(,"vda":"3.0.0")")));
  EXPECT_THAT(reader_.reports,
              ElementsAre(AllOf(Is(CommandStatus::kRefused), Says("speaks 2.1.0")),
                          AllOf(Is(CommandStatus::kSent),
                                Field(&message::Report::topic, "uagv/v2/KIT/1/instantActions"))))
      << "what is refused is told before anything leaves";
}

TEST_F(LookingUpTheRobotsOfABatch, RefusesWhomNobodyKnowsUnlessItIsToStop) {
  ASSERT_TRUE(Batch(R"({"target":"KIT/2","action":"stopPause","id":"a"})"
                    "\n" +
                    Pause("2")));
  ASSERT_THAT(reader_.reports, SizeIs(2));
  EXPECT_THAT(reader_.reports[0], AllOf(Is(CommandStatus::kRefused), Says("mqtt://broker")));
  EXPECT_EQ(reader_.reports[0].reference, R"("line":1,"id":"a")");
  EXPECT_THAT(reader_.reports[1], Is(CommandStatus::kSent));
  EXPECT_EQ(Published(), 1);
}

// Whose topics, by this template, are those by which they are looked up.
TEST_F(LookingUpTheRobotsOfABatch, GoesOnListeningToThoseItWaitsFor) {
  constexpr int kRobots = 500;  // a batch
  const auto resolver =
      DialectResolver::Make({.topic_template = "site/{manufacturer}/{serial}/{topic}"},
                            world_.config)
          .value();
  request_.defaults.address = [&](std::string_view word) {
    return resolver.Resolve(vda5050::ParseRobotAddress(word).value());
  };
  request_.settings.qos = mqtt::Qos::kAtLeastOnce;
  request_.wait.total = std::chrono::milliseconds(3'000);
  const auto connection = [](std::string_view state) {
    return fmt::format(R"({{"version":"3.0.0","connectionState":"{}"}})", state);
  };
  std::string lines;
  for (int i = 0; i < kRobots; ++i) {
    lines += fmt::format(R"({{"target":"KIT/{}","action":"startCharging","wait":true}})"
                         "\n",
                         i);
  }
  world_.on_connect = [&](testing::FakeTransport& broker) {
    for (int i = 0; i < kRobots; ++i) {
      broker.retained[fmt::format("site/KIT/{}/connection", i)] = connection("ONLINE");
    }
    broker.answers = [&, sent = 0](const mqtt::Message& command) mutable {
      std::vector<mqtt::Message> answers;
      const std::string place = command.topic.substr(0, command.topic.rfind('/'));
      if (++sent > kRobots) {
        answers.push_back({.topic = place + "/connection", .payload = connection("OFFLINE")});
      }
      return answers;
    };
  };
  ASSERT_TRUE(Batch(lines + lines));
  EXPECT_THAT(reader_.reports, SizeIs(2 * kRobots));
  EXPECT_THAT(reader_.reports, Each(Is(CommandStatus::kOffline)));
}

TEST_F(LookingUpTheRobotsOfABatch, SendsNothingBehindALineThatIsRefused) {
  request_.stop_on_error = true;
  const auto end = Batch(R"({"target":"KIT/2","action":"stopPause"})"
                         "\n" +
                         Pause("1"));
  ASSERT_TRUE(end);
  EXPECT_EQ(end->reason, BatchStop::kFirstError);
  EXPECT_EQ(Published(), 0);
}

TEST_F(LookingUpTheRobotsOfABatch, HoldsBackNoPauseForARefusedLook) {
  world_.on_connect = [](testing::FakeTransport& broker) {
    broker.forbidden = "+/+/KIT/1/connection";
  };
  ASSERT_TRUE(Batch(Pause("1") + R"({"target":"KIT/2","action":"stopPause"})" + "\n"));
  EXPECT_THAT(reader_.reports, ElementsAre(AllOf(Is(CommandStatus::kError), Says("refuses")),
                                           Is(CommandStatus::kSent)));
  EXPECT_EQ(Published(), 1);
}

TEST_F(LookingUpTheRobotsOfABatch, ShowsInADryRunWhatWouldBeSent) {
  request_.settings.dry_run = true;
  world_.names_broker = true;
  ASSERT_TRUE(Batch(Pause("1")));
  ASSERT_THAT(reader_.reports, ElementsAre(Is(CommandStatus::kDryRun)));
  EXPECT_EQ(reader_.reports[0].version, "2.1.0");
  request_.settings.offline = true;
  ASSERT_TRUE(Batch(Pause("1")));
  EXPECT_EQ(reader_.reports[1].version, "3.0.0");
  EXPECT_EQ(world_.connections, 1);
}

}  // namespace
}  // namespace fleetpub::app
