// `fleetpub order` from the shell to a virtual robot that drives, and back.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <map>
#include <set>
#include <thread>

#include "base/json.h"
#include "support/free_port.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// n1 (0,0) → n2 (3,0) → n3 (3,4) → n4 (6,4) → n1; the station dock-3 is at n4.
std::string Hall() {
  const std::pair<int, int> places[] = {{0, 0}, {3, 0}, {3, 4}, {6, 4}};
  std::string nodes;
  std::string edges;
  for (int i = 0; i < 4; ++i) {
    nodes += fmt::format(R"({}{{"nodeId":"n{}","mapId":"map-1","nodePosition":{{"x":{},"y":{}}},)"
                         R"("vehicleTypeNodeProperties":[{{"vehicleTypeId":"T"}}]}})",
                         i == 0 ? "" : ",", i + 1, places[i].first, places[i].second);
    edges += fmt::format(
        R"({}{{"edgeId":"e{}","startNodeId":"n{}","endNodeId":"n{}","vehicleTypeEdgeProperties":)"
        R"([{{"vehicleTypeId":"T","rotationAllowed":true}}]}})",
        i == 0 ? "" : ",", i + 1, i + 1, (i + 1) % 4 + 1);
  }
  return fmt::format(
      R"({{"metaInformation":{{"projectIdentification":"p","creator":"c",)"
      R"("exportTimestamp":"2026-01-01T00:00:00Z","lifVersion":"1.0.0"}},"layouts":[{{)"
      R"("layoutId":"hall","layoutVersion":"1","nodes":[{}],"edges":[{}],"stations":[)"
      R"({{"stationId":"dock-3","interactionNodeIds":["n4"]}}]}}]}})",
      nodes, edges);
}

class OrderCommand : public EndToEnd {
 protected:
  [[nodiscard]] std::unique_ptr<Process> DrivingRobot(std::vector<std::string> more = {},
                                                      const char* time_scale = "20") const {
    std::vector<std::string> arguments = {"KIT/0001", "--at", "n1", "--time-scale", time_scale};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Robot(std::move(arguments));
  }

  [[nodiscard]] Finished Order(std::vector<std::string> words) const {
    words.insert(words.begin(), "order");
    return Fleetpub(std::move(words));
  }

  // The orders that were sent, oldest first.
  [[nodiscard]] std::vector<base::JsonDocument> SentOrders() const {
    std::vector<base::JsonDocument> orders;
    const Finished history =
        Fleetpub({"history", "KIT/0001", "--action", "order", "--limit", "0", "-o", "json"});
    for (const std::string& line : Lines(history.output)) {
      orders.push_back(Json(base::ToJson(Json(line)["payload"])));
    }
    return orders;
  }

  std::string layout_ = operator_.home().Write("hall.lif.json", Hall()).string();
};

// `n1+ n2+ n3-`: + is released.
std::string Nodes(const base::JsonDocument& order) {
  std::string text;
  for (const auto& node : order["nodes"].GetArray()) {
    text += fmt::format("{}{}{}", text.empty() ? "" : " ", node["nodeId"].GetString(),
                        node["released"].GetBool() ? '+' : '-');
  }
  return text;
}

class OrderInEachVersion : public OrderCommand,
                           public ::testing::WithParamInterface<const char*> {};

INSTANTIATE_TEST_SUITE_P(Versions, OrderInEachVersion,
                         ::testing::Values("1.1.0", "2.0.0", "2.1.0", "3.0.0"),
                         [](const auto& version) { return "V" + std::to_string(version.index); });

TEST_P(OrderInEachVersion, DrivesARobotToAStation) {
  const auto robot = DrivingRobot({"--vda", GetParam()});
  const Finished run = Order({"KIT/0001", "--to", "dock-3", "--layout", layout_, "--wait"});
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  EXPECT_THAT(run.output, HasSubstr("KIT/0001  order  FINISHED"));
  EXPECT_THAT(run.errors, HasSubstr("n1 → n2 → n3 → n4, 10.0 m"));
  EXPECT_THAT(run.errors, HasSubstr("KIT/0001  n4 (4 of 4)"));
  const Finished state = Fleetpub({"show", "KIT/0001", "-o", "json"});
  EXPECT_STREQ(Json(state.output)["state"]["lastNodeId"].GetString(), "n4");
}

TEST_P(OrderInEachVersion, ReleasesExtendsAndIsFollowed) {
  const auto robot = DrivingRobot({"--vda", GetParam()});
  const auto accepted = [&](std::vector<std::string> words) {
    words.insert(words.end(), {"--layout", layout_, "--wait-for", "accepted"});
    const Finished run = Order(std::move(words));
    EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  };
  accepted({"KIT/0001", "n1", "n2", "n3", "--release", "1"});
  accepted({"extend", "KIT/0001", "n4"});
  EXPECT_EQ(Order({"release", "KIT/0001", "2", "--wait-for", "accepted"}).exit_code, 0);
  EXPECT_EQ(Order({"release", "KIT/0001", "all"}).exit_code, 0);
  const Finished follow = Order({"follow", "KIT/0001", "-W", "60s"});
  EXPECT_EQ(follow.exit_code, 0) << follow.errors;
  EXPECT_THAT(follow.output, HasSubstr("FINISHED"));
  accepted({"extend", "KIT/0001", "n1"});  // after the end

  const auto orders = SentOrders();
  std::vector<std::string> nodes;
  for (std::size_t i = 0; i < orders.size(); ++i) {
    nodes.push_back(Nodes(orders[i]));
    EXPECT_EQ(orders[i]["orderUpdateId"].GetUint(), i);
    EXPECT_STREQ(orders[i]["orderId"].GetString(), orders[0]["orderId"].GetString());
  }
  EXPECT_THAT(nodes, ::testing::ElementsAre("n1+ n2- n3-", "n1+ n2- n3- n4-", "n1+ n2+ n3+ n4-",
                                            "n3+ n4+", "n4+ n1+"));
  // Unchanged and at its sequenceId: it is where the robot stitches.
  EXPECT_EQ(base::ToJson(orders[3]["nodes"][0]), base::ToJson(orders[2]["nodes"][2]));
  EXPECT_EQ(orders[4]["nodes"][0]["sequenceId"].GetInt(), 6);
}

TEST_F(OrderCommand, KeepsNodesReleasedAheadOfTheRobot) {
  const auto robot = DrivingRobot();
  const Finished run = Order({"KIT/0001", "n1", "n2", "n3", "n4", "n1", "n2", "--layout", layout_,
                              "--release", "2", "--auto-release", "--wait"});
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  EXPECT_THAT(run.output, AllOf(HasSubstr("ACCEPTED"), HasSubstr("FINISHED")));
  EXPECT_EQ(Nodes(SentOrders().front()), "n1+ n2+ n3- n4- n1- n2-");
  const Finished ended = Fleetpub({"history", "KIT/0001", "--status", "FINISHED", "-o", "json"});
  EXPECT_THAT(ended.output, HasSubstr(R"("type":"order")"));
  std::set<unsigned> ids;
  for (const auto& order : SentOrders()) ids.insert(order["orderUpdateId"].GetUint());
  EXPECT_EQ(ids.size(), SentOrders().size());
  EXPECT_GT(ids.size(), 2U);
}

// At another broker the robot of that name is another one.
TEST_F(OrderCommand, BuildsOnWhatWentOverItsOwnBroker) {
  const Mosquitto rehearsal;
  const auto robot = DrivingRobot();
  const auto other = Robot({"KIT/0001", "--at", "n1", "-b", rehearsal.Url()});
  const auto send = [&](std::vector<std::string> words) {
    words.insert(words.end(), {"--release", "2", "--order-id", "t1", "--wait-for", "accepted"});
    const Finished run = Order(std::move(words));
    EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  };
  send({"KIT/0001", "n1", "n2", "n3"});
  send({"KIT/0001", "n1", "n2", "n9", "-b", rehearsal.Url()});
  const Finished run = Order({"release", "KIT/0001", "--wait-for", "accepted"});
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  EXPECT_EQ(Nodes(SentOrders().back()), "n2+ n3+");
  const Finished shown = Fleetpub({"show", "KIT/0001"});
  EXPECT_THAT(shown.output, HasSubstr("over " + rehearsal.Url()));
}

TEST_F(OrderCommand, BuildsOnWhatWentOverAnyBrokerOfItsSite) {
  const std::string port = std::to_string(FreePort());
  const Mosquitto cluster({"allow_anonymous true", "listener " + port + " 127.0.0.1"});
  const std::string first = cluster.Url();
  const std::string second = "mqtt://127.0.0.1:" + port;
  operator_.UseBroker(first);
  const auto robot = DrivingRobot();
  const auto send = [&](std::vector<std::string> words, const std::vector<std::string>& brokers) {
    words.insert(words.end(), {"--wait-for", "accepted"});
    for (const std::string& broker : brokers) words.insert(words.end(), {"-b", broker});
    return Order(std::move(words));
  };
  EXPECT_EQ(send({"KIT/0001", "n1", "n2", "n3", "--release", "1"}, {first, second}).exit_code, 0);
  const Finished alone = send({"release", "KIT/0001"}, {second});
  EXPECT_EQ(alone.exit_code, 7);
  EXPECT_THAT(alone.output, HasSubstr("did not send over " + second));
  const Finished failed_over = send({"release", "KIT/0001"}, {second, first});
  EXPECT_EQ(failed_over.exit_code, 0) << failed_over.output << failed_over.errors;
  const Finished explained =
      Fleetpub({"explain", "KIT/0001", "--for", "1s", "-b", second, "-b", first});
  EXPECT_THAT(explained.output, HasSubstr("sent by"));
}

TEST_F(OrderCommand, TellsTheSecondWhoseOrderIsActive) {
  const auto robot = DrivingRobot({}, "1");
  EXPECT_EQ(Order({"KIT/0001", "n1", "n2", "--wait-for", "accepted"}).exit_code, 0);
  const Finished second = Order({"KIT/0001", "n1", "n3"});
  EXPECT_EQ(second.exit_code, 7);
  EXPECT_THAT(second.output,
              AllOf(HasSubstr("REFUSED"), HasSubstr("sent by"), HasSubstr("order replace")));
  EXPECT_EQ(SentOrders().size(), 1U);
}

TEST_F(OrderCommand, IsReplacedOnceTheRobotHasCancelledIt) {
  const auto robot = DrivingRobot({}, "2");
  EXPECT_EQ(Order({"KIT/0001", "n1", "n2", "n3", "--layout", layout_, "--wait-for", "accepted"})
                .exit_code,
            0);
  const Finished run = Order({"replace", "KIT/0001", "--to", "n2", "--layout", layout_, "--wait"});
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  EXPECT_THAT(run.output, AllOf(HasSubstr("cancelOrder  FINISHED"), HasSubstr("order  FINISHED")));
  const Finished idle = Order({"replace", "KIT/0001", "n2", "n3", "--layout", layout_});
  EXPECT_EQ(idle.exit_code, 0) << idle.output << idle.errors;
}

TEST_F(OrderCommand, IsNotCancelledForAnotherOneThatCannotBeMade) {
  const auto robot = DrivingRobot({}, "1");
  ASSERT_EQ(Order({"KIT/0001", "n1", "n2", "--order-id", "t1", "--layout", layout_, "--wait-for",
                   "accepted"})
                .exit_code,
            0);
  const std::pair<int, std::vector<std::string>> wrong[] = {
      {2, {"--to", "n7"}},
      {2, {"--to", "n3", "--auto-release"}},
      {2, {"--to", "n3", "--header-id", "0"}},
      {7, {"--to", "n3", "--order-id", "t1"}},
      {2, {"--to", "n3", "--action", "pick@n4"}},
  };
  for (const auto& [exit_code, words] : wrong) {
    std::vector<std::string> arguments = {"replace", "KIT/0001", "--layout", layout_};
    arguments.insert(arguments.end(), words.begin(), words.end());
    const Finished run = Order(arguments);
    EXPECT_EQ(run.exit_code, exit_code) << words[2] << run.output << run.errors;
    EXPECT_THAT(run.output, Not(HasSubstr("cancelOrder")));
  }
  EXPECT_THAT(Fleetpub({"history", "--action", "cancelOrder", "-o", "json"}).output, IsEmpty());
  const Finished dry =
      Order({"replace", "KIT/0001", "--to", "n3", "--from", "n1", "--layout", layout_, "-n"});
  EXPECT_EQ(dry.exit_code, 0) << dry.output << dry.errors;
  EXPECT_THAT(dry.output, HasSubstr(R"("nodeId":"n3")"));
}

// Standard input is there once.
TEST_F(OrderCommand, IsReplacedByTheRowsOfStandardInput) {
  const auto robot = DrivingRobot();
  Command command = operator_.Prepare({"order", "replace", "KIT/0001", "--route", "-", "--wait"});
  command.input = "node,x,y,map\nn1,0,0,map-1\nn2,3,0,map-1\n";
  const Finished run = fleetpub::testing::Run(command);
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  EXPECT_EQ(Nodes(SentOrders().back()), "n1+ n2+");
}

TEST_F(OrderCommand, BeginsWhereTheRobotStands) {
  const auto robot = DrivingRobot();
  const Finished elsewhere = Order({"KIT/0001", "n3", "n4"});
  EXPECT_EQ(elsewhere.exit_code, 7);
  EXPECT_THAT(elsewhere.output, HasSubstr("is at node n1"));
  const Finished no_way = Order({"KIT/0001", "--to", "nowhere", "--layout", layout_});
  EXPECT_EQ(no_way.exit_code, 2) << no_way.output << no_way.errors;
  EXPECT_THAT(SentOrders(), IsEmpty());
}

TEST_F(OrderCommand, ComesFromTheRowsOfAFile) {
  const auto robot = DrivingRobot({"--vda", "2.1"});
  const std::string file = operator_.home()
                               .Write("tour.csv",
                                      "node,x,y,map,actions\n"
                                      "n1,0,0,map-1,\n"
                                      "n2,2,0,map-1,\n"
                                      "n3,2,1,map-1,drop loadType=EPAL stationType=floor\n")
                               .string();
  const Finished run = Order({"KIT/0001", "--route", file, "--dry-run"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("n1 → n2 → n3, 3.0 m, 1 action"));
  const auto order = Json(run.output);
  EXPECT_STREQ(order["nodes"][2]["actions"][0]["actionType"].GetString(), "drop");
  const Finished wrong =
      Order({"KIT/0001", "--route", operator_.home().Write("bad.csv", "node,x\nn1,0\n").string()});
  EXPECT_EQ(wrong.exit_code, 3);
  EXPECT_THAT(wrong.errors, HasSubstr("bad.csv: line 2"));
}

TEST_F(OrderCommand, RefusesWhatItCannotMean) {
  const std::vector<std::vector<std::string>> wrong = {
      {},
      {"KIT/0001"},
      {"KIT/0001", "n1", "--to", "n2"},
      {"KIT/0001", "n1", "--via", "n2"},
      {"KIT/0001", "--to", "n2"},
      {"KIT/0001", "n1", "--auto-release"},
      {"KIT/0001", "n1", "--release", "0"},
      {"KIT/0001", "n1", "--action", "pick"},
      {"KIT/0001", "--action", "pick@n1", "n1", "n2"},
      {"KIT/0001", "n1", "--without", "wheels"},
      {"KIT/0001", "n1", "--deviation-xy", "-1"},
      {"KIT/0001", "n1", ""},
      {"KIT/0001", "n1", "--to", ""},
      {"KIT/0001", "--to", "n2", "--via", "", "--layout", layout_},
      {"KIT/0001", "--to", "n2", "--from", "", "--layout", layout_},
      {"KIT/0001", "n1", "--route", ""},
      {"KIT/0001", "n1", "--order-id", ""},
      {"KIT/0001", "n1", "--action", "pick@n1", "loadType=EPAL", "loadType=X"},
      {"KIT/0001", "n1", "--dry-run", "-o", "csv", "--fields", "target,nope"},
      {"KIT/0001", "n1", "--dry-run", "-o", "template={nope} {status}"},
      {"follow", "KIT/0001", "-o", "csv", "--fields", "nope"},
      {"KIT/*", "n1", "n2"},
      {"release", "KIT/0001", "some"},
      {"follow"},
  };
  for (const auto& words : wrong) {
    const Finished run = Order(words);
    EXPECT_EQ(run.exit_code, 2) << ::testing::PrintToString(words) << run.output << run.errors;
    EXPECT_THAT(run.output, IsEmpty());
  }
  EXPECT_THAT(SentOrders(), IsEmpty());
}

TEST_F(OrderCommand, GoesToARobotThatIsNotAskedWhenSomebodySaysSo) {
  const Subscriber subscriber(broker_, "uagv/v2/KIT/0001/order");
  const Finished run =
      Order({"KIT/0001", "a", "b", "--vda", "2.1", "--no-check", "--order-id", "tour-1"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  const auto messages = subscriber.Await(1);
  ASSERT_EQ(messages.size(), 1U);
  const auto order = Json(messages[0].payload);
  EXPECT_EQ(Nodes(order), "a+ b+");
  EXPECT_STREQ(order["orderId"].GetString(), "tour-1");
  EXPECT_STREQ(order["edges"][0]["startNodeId"].GetString(), "a");
  const Finished again =
      Order({"KIT/0001", "a", "b", "--vda", "2.1", "--no-check", "--order-id", "tour-1"});
  EXPECT_EQ(again.exit_code, 7);
  EXPECT_THAT(again.output, HasSubstr("ids are used once"));
}

// Between counting and sending a process may end at any moment.
TEST_F(OrderCommand, NeverRepeatsAnUpdateIdWhateverIsKilled) {
  const auto robot = DrivingRobot({}, "1");
  ASSERT_EQ(Order({"KIT/0001", "n1", "n2", "--release", "1", "--wait-for", "accepted"}).exit_code,
            0);
  for (int i = 0; i < 12; ++i) {
    Process process(operator_.Prepare({"order", "extend", "KIT/0001", fmt::format("x{}", i)}));
    std::this_thread::sleep_for(std::chrono::milliseconds(3 * i));
    process.Signal(SIGKILL);
    static_cast<void>(process.Wait());
  }
  std::vector<std::unique_ptr<Process>> both;
  for (const char* node : {"y1", "y2"}) {
    both.push_back(
        std::make_unique<Process>(operator_.Prepare({"order", "extend", "KIT/0001", node})));
  }
  for (const auto& process : both) static_cast<void>(process->Wait());
  Finished last = Order({"extend", "KIT/0001", "z"});
  for (int i = 0; i < 20 && last.exit_code == 7; ++i) {  // while another may be on its way
    EXPECT_THAT(last.output, HasSubstr("does not show it yet: try again"));
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    last = Order({"extend", "KIT/0001", "z"});
  }
  EXPECT_EQ(last.exit_code, 0) << last.output;
  std::set<unsigned> ids;
  const auto orders = SentOrders();
  for (const auto& order : orders) {
    EXPECT_TRUE(ids.insert(order["orderUpdateId"].GetUint()).second) << base::ToJson(order);
  }
  EXPECT_GT(orders.size(), 2U);
}

// Up to 2.1 instant actions stand in the same list.
TEST_F(OrderCommand, DoesNotFailForAnInstantActionThatDid) {
  const std::string base = "uagv/v2/KIT/0001/";
  Say(base + "connection",
      R"({"headerId":1,"timestamp":"2026-01-01T00:00:00Z","version":"2.1.0","manufacturer":"KIT",)"
      R"("serialNumber":"0001","connectionState":"ONLINE"})",
      true);
  const auto state = [&](int id, const char* nodes, const char* last) {
    Say(base + "state",
        fmt::format(
            R"({{"headerId":{},"timestamp":"2026-01-01T00:00:0{}Z","version":"2.1.0",)"
            R"("manufacturer":"KIT","serialNumber":"0001","orderId":"o9","orderUpdateId":0,)"
            R"("lastNodeId":"{}","lastNodeSequenceId":{},"nodeStates":[{}],"edgeStates":[],)"
            R"("driving":false,"actionStates":[{{"actionId":"i1","actionType":"startPause",)"
            R"("actionStatus":"FAILED"}},{{"actionId":"p1","actionType":"pick",)"
            R"("actionStatus":"{}"}}],"batteryState":{{"batteryCharge":80,"charging":false}},)"
            R"("operatingMode":"AUTOMATIC","errors":[],)"
            R"("safetyState":{{"eStop":"NONE","fieldViolation":false}}}})",
            id, id, last, 2 * (id - 1), nodes, *nodes == '\0' ? "FINISHED" : "RUNNING"),
        false);
  };
  const Subscriber asked(broker_, base + "instantActions");
  const auto follow = std::make_unique<Process>(
      operator_.Prepare({"order", "follow", "KIT/0001", "--vda", "2.1", "-W", "60s"}));
  ASSERT_EQ(asked.Await(1).size(), 1U);
  state(1, R"({"nodeId":"n2","sequenceId":2,"released":true})", "n1");
  ASSERT_TRUE(follow->AwaitErrors("order o9"));
  state(2, "", "n2");
  EXPECT_EQ(follow->Wait(), 0) << follow->Output() << follow->Errors();
}

TEST_F(OrderCommand, EndsOnlyOnWhatTheRobotSays) {
  const auto robot = DrivingRobot({"--fault", "stuck"});
  const Finished run = Order({"KIT/0001", "n1", "n2", "--layout", layout_, "--wait", "-W", "1s"});
  EXPECT_EQ(run.exit_code, 6) << run.output << run.errors;
  EXPECT_THAT(run.output, HasSubstr("TIMEOUT"));
  const Finished follow = Order({"follow", "KIT/0001", "-W", "1s"});
  EXPECT_EQ(follow.exit_code, 6) << follow.output << follow.errors;
}

}  // namespace
}  // namespace fleetpub::testing
