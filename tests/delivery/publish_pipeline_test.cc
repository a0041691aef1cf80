#include "delivery/publish_pipeline.h"

#include <gmock/gmock.h>

#include "support/fake_ledger.h"
#include "support/fake_transport.h"

namespace fleetpub::delivery {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

// A broker at a distance: its acknowledgements come when they are waited for.
class AtADistance : public ::testing::Test {
 protected:
  AtADistance() { transport_.is_distant = true; }

  static std::vector<message::Command> To(const std::vector<std::string>& targets) {
    std::vector<message::Command> commands;
    for (const std::string& target : targets) {
      message::Command& command = commands.emplace_back();
      command.target = target;
      command.topic = "t/" + target;
      command.payload = {"{", ",", "}"};
    }
    return commands;
  }

  [[nodiscard]] Status Send(const std::vector<std::string>& targets) {
    return pipeline_.Send(transport_, To(targets), next_key_++);
  }

  void Done(PublishPipeline::Key key, const BatchResult& result) {
    for (const message::Report& report : result.reports) {
      done_.push_back(std::to_string(key) + " " + report.target + " " +
                      std::string(GetName(report.status)) + " " + report.message);
    }
    if (result.broken) broken_.push_back(result.broken->message);
  }

  testing::Journal journal_;
  testing::FakeLedger ledger_{journal_};
  testing::FakeTransport transport_{journal_};
  SendOptions options_{.qos = mqtt::Qos::kAtLeastOnce};
  std::vector<std::string> done_;
  std::vector<std::string> broken_;
  PublishPipeline::Key next_key_ = 0;
  PublishPipeline pipeline_{
      ledger_, options_, {}, [this](PublishPipeline::Key key, const BatchResult& result) {
        Done(key, result);
      }};
};

TEST_F(AtADistance, TheNextBracketLeavesBeforeTheFirstIsAcknowledged) {
  EXPECT_TRUE(Send({"a", "b"}));
  EXPECT_TRUE(Send({"c"}));
  EXPECT_THAT(done_, IsEmpty());
  pipeline_.Await(transport_, 0);
  EXPECT_THAT(journal_.entries(),
              ElementsAre("lock t/a t/b", "reserve 2", "publish t/a", "publish t/b", "lock t/c",
                          "reserve 1", "publish t/c", "await", "unlock", "await", "unlock"));
  EXPECT_THAT(done_, ElementsAre("0 a PUBLISHED ", "0 b PUBLISHED ", "1 c PUBLISHED "));
}

TEST_F(AtADistance, WaitsForTheOldestAlone) {
  EXPECT_TRUE(Send({"a"}));
  EXPECT_TRUE(Send({"b"}));
  EXPECT_TRUE(Send({"c"}));
  pipeline_.Await(transport_, 2);
  EXPECT_THAT(done_, ElementsAre("0 a PUBLISHED "));
  EXPECT_EQ(transport_.in_flight(), 2);
}

TEST_F(AtADistance, KeepsEachTopicUntilItsOwnAcknowledgement) {
  EXPECT_TRUE(Send({"a"}));
  EXPECT_TRUE(Send({"a"}));
  EXPECT_THAT(journal_.entries(), ElementsAre("lock t/a", "reserve 1", "publish t/a", "await",
                                              "unlock", "lock t/a", "reserve 1", "publish t/a"));
}

TEST_F(AtADistance, WaitsForNobodyWhileItHoldsTopics) {
  EXPECT_TRUE(Send({"a"}));
  ledger_.lock_error = Error{ErrorKind::kLedger, "somebody else holds t/b"};
  EXPECT_FALSE(Send({"b"}));
  // The one that waits comes when the first has been let go.
  EXPECT_THAT(done_, ElementsAre("0 a PUBLISHED "));
  EXPECT_GT(ledger_.last_deadline(), std::chrono::steady_clock::now());
}

TEST_F(AtADistance, TakesAcknowledgementsInAnyOrder) {
  EXPECT_TRUE(Send({"a"}));
  EXPECT_TRUE(Send({"b"}));
  int asked = 0;
  transport_.acknowledge = [&asked](int token) -> std::optional<mqtt::Acknowledgement> {
    if (++asked == 1) return std::nullopt;  // the second comes first
    return mqtt::Acknowledgement{.token = token};
  };
  pipeline_.Await(transport_, 0);
  EXPECT_THAT(done_, ElementsAre("0 a PUBLISHED ", "1 b PUBLISHED "));
}

TEST_F(AtADistance, SaysOfEachBracketThatTheConnectionWasLost) {
  EXPECT_TRUE(Send({"a"}));
  EXPECT_TRUE(Send({"b"}));
  transport_.await_error = Error{ErrorKind::kBroker, "broker: connection lost"};
  pipeline_.Await(transport_, PublishPipeline::kMostUnderWay);
  EXPECT_THAT(done_, IsEmpty());
  pipeline_.Await(transport_, 0);
  EXPECT_THAT(done_, ElementsAre(StartsWith("0 a ERROR sent, but not acknowledged: broker"),
                                 StartsWith("1 b ERROR sent, but not acknowledged: broker")));
  EXPECT_THAT(broken_, SizeIs(2));
}

TEST_F(AtADistance, GivesUpOnABrokerThatStaysSilent) {
  options_.acknowledge_timeout = std::chrono::milliseconds(10);
  PublishPipeline pipeline(
      ledger_, options_, {},
      [this](PublishPipeline::Key key, const BatchResult& result) { Done(key, result); });
  transport_.acknowledge = [](int) { return std::nullopt; };
  EXPECT_TRUE(pipeline.Send(transport_, To({"a"}), 0));
  EXPECT_TRUE(pipeline.Send(transport_, To({"b"}), 1));
  pipeline.Await(transport_, 0);
  EXPECT_THAT(done_, ElementsAre(HasSubstr("did not acknowledge within 10 ms"),
                                 HasSubstr("did not acknowledge within 10 ms")));
}

}  // namespace
}  // namespace fleetpub::delivery
