// Orders, zone sets and permissions from the shell to a virtual robot and back.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>

#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::MatchesRegex;

constexpr std::string_view kZoneSet = R"({"zoneSet":{"mapId":"map-1","zoneSetId":"hall-1","zones":[
  {"zoneId":"gate","zoneType":"RELEASE","releaseLossBehavior":"STOP","vertices":[
    {"x":0,"y":0},{"x":10,"y":0},{"x":10,"y":10},{"x":0,"y":10}]}]}})";

// From node n1 at -5, 5 to node n2 in the zone.
std::string Order(std::string_view id, std::string_view header = R"("version":"3.0.0")",
                  std::string_view sequence_id = "2") {
  return fmt::format(R"({{{},"orderId":"{}","orderUpdateId":0,"nodes":[
    {{"nodeId":"n1","sequenceId":0,"released":true,"actions":[],
      "nodePosition":{{"x":-5,"y":5,"mapId":"map-1"}}}},
    {{"nodeId":"n2","sequenceId":{},"released":true,"actions":[],
      "nodePosition":{{"x":5,"y":5,"mapId":"map-1"}}}}],
    "edges":[{{"edgeId":"e1","sequenceId":1,"released":true,"startNodeId":"n1","endNodeId":"n2",
      "actions":[]}}]}})",
                     header, id, sequence_id);
}

std::string Header(std::string_view version) {
  return fmt::format(R"("headerId":1,"timestamp":"2026-11-22T20:00:00Z","version":"{}",
    "manufacturer":"KIT","serialNumber":"0001")",
                     version);
}

class Orders : public EndToEnd {
 protected:
  std::string File(std::string_view name, std::string_view content) const {
    return operator_.home().Write(name, content).string();
  }
};

TEST_F(Orders, NeedAPermissionAndAreDoneWithIt) {
  const auto robot = Robot({"KIT/0001", "--order-time", "300ms", "--state-interval", "1s"});
  const Finished zones =
      Fleetpub({"publish", "zoneSet", "KIT/0001", "-f", File("z.json", kZoneSet), "--wait"});
  EXPECT_EQ(zones.exit_code, 0) << zones.output << zones.errors;
  EXPECT_EQ(Fleetpub({"enableZoneSet", "KIT/0001", "--zoneSetId", "hall-1", "--wait"}).exit_code,
            0);

  const std::string order = File("order.json", Order("o-1"));
  const Finished sent = Fleetpub({"publish", "order", "KIT/0001", "-f", order, "--wait"});
  EXPECT_EQ(sent.exit_code, 0) << sent.errors;
  EXPECT_THAT(sent.output, MatchesRegex("KIT/0001  order  ACCEPTED  .*\n"));

  const Finished requests = Fleetpub({"requests", "-o", "json"});
  EXPECT_EQ(requests.output,
            R"({"target":"KIT/0001","requestId":"request-1","requestType":"ACCESS",)"
            R"("requestStatus":"REQUESTED","zoneId":"gate","zoneSetId":"hall-1"})"
            "\n");
  const Finished granted =
      Fleetpub({"respond", "KIT/0001", "request-1", "granted", "--lease-expiry", "1m", "--wait"});
  EXPECT_EQ(granted.exit_code, 0) << granted.output;
  const Finished done = Fleetpub({"await", "KIT/0001", "state", "orderId=o-1", "lastNodeId=n2",
                                  "/nodeStates=[]", "-W", "60s"});
  EXPECT_EQ(done.exit_code, 0) << done.errors;
  EXPECT_THAT(Fleetpub({"requests"}).output, HasSubstr("no robot that sent a state asks"));
}

TEST_F(Orders, CanBeWaitedForUntilTheyAreFinished) {
  for (const char* version : {"1.1.0", "2.0.0", "2.1.0", "3.0.0"}) {
    const auto robot = Robot({"KIT/0001", "--order-time", "200ms", "--vda", version});
    const std::string order = File("order.json", Order(fmt::format("o-{}", version),
                                                       fmt::format(R"("version":"{}")", version)));
    const Finished run =
        Fleetpub({"publish", "order", "KIT/0001", "-f", order, "--wait-for", "finished"});
    EXPECT_EQ(run.exit_code, 0) << version << run.output << run.errors;
    EXPECT_THAT(run.output, HasSubstr("FINISHED"));
  }
}

TEST_F(Orders, ThatTheRobotRefusesAreRejected) {
  const auto robot = Robot({"KIT/0001", "--with-order"});
  const Finished run =
      Fleetpub({"publish", "order", "KIT/0001", "-f", File("order.json", Order("o-2")), "--wait"});
  EXPECT_EQ(run.exit_code, 5) << run.output;
  EXPECT_THAT(run.output, AllOf(HasSubstr("REJECTED"), HasSubstr("still active")));
}

TEST_F(Orders, ComeThroughAPipe) {
  const Subscriber subscriber(broker_, "#");
  Command command =
      operator_.Prepare(WithoutLook({"publish", "order", "KIT/0001", "-f", "-", "--vda", "2.1"}));
  command.input = Order("o-3", R"("version":"2.1.0","manufacturer":"KIT")");
  const Finished run = testing::Run(command);
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  const auto received = subscriber.Await(1);
  ASSERT_EQ(received.size(), 1U);
  EXPECT_EQ(received[0].topic, "uagv/v2/KIT/0001/order");
  const auto message = Json(received[0].payload);
  EXPECT_STREQ(message["orderId"].GetString(), "o-3");
  EXPECT_STREQ(message["serialNumber"].GetString(), "0001");
  EXPECT_EQ(message["headerId"].GetInt(), 0);
}

TEST_F(Orders, ThatAreWrongAreNotSent) {
  const Subscriber subscriber(broker_, "#");
  const auto publish = [&](std::string_view content, std::vector<std::string> more = {}) {
    std::vector<std::string> arguments = {"publish", "order", "KIT/0001", "-f",
                                          File("order.json", content)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Fleetpub(arguments);
  };
  const Finished gap = publish(Order("o", R"("version":"3.0.0")", "3"));
  EXPECT_EQ(gap.exit_code, 3);
  EXPECT_THAT(gap.errors, AllOf(HasSubstr("nothing was sent"), HasSubstr("sequenceId must be 2")));
  const Finished other = publish(Order("o", R"("serialNumber":"0002")"));
  EXPECT_EQ(other.exit_code, 3);
  EXPECT_THAT(other.errors, AllOf(HasSubstr("\"0002\""), HasSubstr("--restamp")));
  EXPECT_EQ(publish(Order("o", R"("serialNumber":"0002")"), {"--restamp", "--dry-run", "--offline"})
                .exit_code,
            0);
  const Finished schema = publish(R"({"orderId":"o","nodes":[],"edges":[]})");
  EXPECT_EQ(schema.exit_code, 3);
  EXPECT_THAT(schema.errors, HasSubstr("orderUpdateId"));
  EXPECT_EQ(publish("{").exit_code, 3);
  EXPECT_EQ(publish("").exit_code, 3);
  EXPECT_EQ(publish("[]").exit_code, 3);
  EXPECT_EQ(publish("\xff").exit_code, 3);
  EXPECT_EQ(Fleetpub({"publish", "order", "KIT/0001", "-f", "/nowhere/order.json"}).exit_code, 8);
  EXPECT_EQ(Fleetpub({"publish", "order", "KIT/0001"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"publish", "state", "KIT/0001", "-f", "-"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"publish"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"respond", "KIT/0001", "r"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"respond", "KIT/0001", "r", "MAYBE"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"respond", "KIT/0001", "r", "QUEUED", "--wait"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"respond", "KIT/0001", "r", "QUEUED", "--lease-expiry", "9s"}).exit_code, 3);
  EXPECT_EQ(Fleetpub({"respond", "KIT/0001", "r", "GRANTED", "--lease-expiry", "x"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"respond", "KIT/0001", "r", "GRANTED", "--vda", "2.1"}).exit_code, 2);
  EXPECT_THAT(subscriber.SoFar(), IsEmpty());
}

TEST_F(Orders, AreCheckedBeforehandLikeActions) {
  const Finished run =
      Fleetpub({"publish", "order", "KIT/0009", "-f", File("order.json", Order("o")), "--wait"});
  EXPECT_EQ(run.exit_code, 7);
  EXPECT_THAT(run.output, AllOf(HasSubstr("REFUSED"), HasSubstr("unknown")));
}

TEST_F(Orders, StandInTheHistory) {
  EXPECT_EQ(
      Send({"publish", "order", "KIT/0001", "-f", File("order.json", Order("o-7"))}).exit_code, 0);
  const auto rows = Lines(Fleetpub({"history", "-o", "json"}).output);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_THAT(rows[0], AllOf(HasSubstr("\"order\""), HasSubstr("\"o-7\"")));
}

TEST_F(Orders, AreReadInOneWayByPublishValidateAndBatch) {
  const auto robot = Robot({"KIT/0001", "--vda", "2.0"});
  const std::string order = Order("o", Header("2.0.0+rig"));
  const std::string file = File("order.json", order);
  std::string line = fmt::format(R"({{"target":"KIT/0001","topic":"order","payload":{}}})", order);
  std::replace(line.begin(), line.end(), '\n', ' ');
  for (const Finished& run :
       {Fleetpub({"publish", "order", "KIT/0001", "-f", file, "--dry-run"}),
        Fleetpub({"publish", "order", "KIT/0001", "-f", file, "--dry-run", "--restamp"}),
        Fleetpub({"validate", file}), Fleetpub({"batch", File("lines", line + "\n")})}) {
    EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
    EXPECT_THAT(run.errors, AllOf(HasSubstr("2.0.0+rig"), HasSubstr("taken as 2.0.0")));
  }
  EXPECT_EQ(Fleetpub({"validate", file, "--strict"}).exit_code, 3);
  EXPECT_EQ(Fleetpub({"publish", "order", "KIT/0001", "-f", file, "--vda", "3"}).exit_code, 3);
  EXPECT_THAT(Fleetpub({"publish", "order", "KIT/0001", "-n", "--offline", "-f",
                        File("plain.json", Order("o", R"("headerId":1)"))})
                  .errors,
              HasSubstr("3.0.0 is assumed"));
}

TEST_F(Orders, WithAMisspeltMemberAreWarnedOf) {
  const auto robot = Robot({"KIT/0001"});
  std::string order = Order("o", Header("3.0.0"));
  const auto at = order.find("nodePosition");
  order.replace(at, 12, "node_position");
  const std::string file = File("order.json", order);
  std::string line = fmt::format(R"({{"target":"KIT/0001","topic":"order","payload":{}}})", order);
  std::replace(line.begin(), line.end(), '\n', ' ');
  for (const Finished& run :
       {Fleetpub({"publish", "order", "KIT/0001", "-f", file, "--dry-run"}),
        Fleetpub({"validate", file}), Fleetpub({"batch", File("lines", line + "\n")})}) {
    EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
    EXPECT_THAT(run.errors, AllOf(HasSubstr("node_position"), HasSubstr("nodePosition")));
  }
}

TEST_F(Orders, OfActionsUnderTheOtherNameAreMetWithTheOption) {
  const std::string file = File("actions.json", R"({"version":"2.0.3","instantActions":[
      {"actionType":"stopPause","actionId":"a-1","blockingType":"HARD"}]})");
  const std::vector<std::string> publish = {"publish", "instantActions", "KIT/0001", "-f",
                                            file,      "--dry-run",      "--offline"};
  const Finished run = Fleetpub(publish);
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.errors, HasSubstr("--actions-key instantActions"));
  auto renamed = publish;
  renamed.insert(renamed.end(), {"--actions-key", "instantActions"});
  EXPECT_EQ(Fleetpub(renamed).exit_code, 0);
}

TEST_F(Orders, WithSeveralActionsAreWaitedForWhole) {
  const auto robot = Robot({"KIT/0001"});
  const std::string file = File("actions.json",
                                R"({"actions":[
      {"actionType":"startPause","actionId":"a-1","blockingType":"NONE"},
      {"actionType":"stopPause","actionId":"a-2","blockingType":"NONE"}]})");
  const Finished run = Fleetpub({"publish", "instantActions", "KIT/0001", "-f", file, "--wait"});
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
}

}  // namespace
}  // namespace fleetpub::testing
