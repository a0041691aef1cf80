// SoAR over the kind of broker that its backbone is: RabbitMQ, whose clients speak AMQP.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "base/json.h"
#include "support/operator.h"
#include "support/rabbitmq.h"

namespace fleetpub::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

TEST(SoarBackbone, CarriesOurMessagesToAmqpAndItsAcknowledgementsBack) {
  const RabbitMq& backbone = RabbitMq::Shared();
  Operator someone;
  someone.UseBroker(backbone.Url());
  const AmqpConsumer consumer(backbone, "soar.#");

  Process waiting(someone.Prepare(
      {"soar", "mission-plan", "soar.planet-ocean.ecosub.eco1", "--plan-id", "3", "--platform-id",
       "1", "--waypoint", "lat=50.3707,lon=-4.1872,depth=15,action=move", "--wait", "-q", "1"}));
  const auto received = consumer.Await(1);
  ASSERT_THAT(received, SizeIs(1)) << waiting.Errors();
  const auto message = Json(received[0]);
  EXPECT_STREQ(message["header"]["destination"].GetString(),
               "soar.planet-ocean.ecosub.eco1.to_platform.mission_plan");

  for (const char* level : {"c2_received", "operator_approved_and_sent", "executed"}) {
    PublishOverAmqp(
        backbone, "soar.planet-ocean.ecosub.eco1.from_platform.acknowledgement",
        fmt::format(R"({{"header":{{"source":"planet-ocean"}},"payload":{{"message_type":)"
                    R"("acknowledgement","acknowledged_message_ID":"{}","status":"{}"}}}})",
                    message["header"]["message_ID"].GetString(), level));
    EXPECT_TRUE(waiting.AwaitErrors(level)) << level;
  }
  EXPECT_EQ(waiting.Wait(), 0) << waiting.Errors();
  EXPECT_THAT(waiting.Output(), HasSubstr("FINISHED"));

  // Byte for byte what the ledger says that was sent.
  const auto row = Json(someone.Fleetpub({"history", "-o", "json"}).output);
  EXPECT_EQ(received[0], base::ToJson(row["payload"]));

  EXPECT_EQ(
      someone.Fleetpub({"soar", "observation", "--broadcast", "--platform-id", "2"}).exit_code, 0);
  EXPECT_THAT(consumer.Await(5).back(), HasSubstr(R"("delivery_type":"broadcast")"));
}

}  // namespace
}  // namespace fleetpub::testing
