#include "app/order_update.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "base/json.h"

namespace fleetpub::app {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string Node(int i, bool released) {
  return fmt::format(
      R"({{"nodeId":"n{}","sequenceId":{},"released":{},"nodePosition":{{"x":1.50,"y":0,"mapId":"m"}},)"
      R"("actions":[{{"actionId":"a{}","actionType":"beep","blockingType":"NONE"}}]}})",
      i, 2 * i, released, i);
}
std::string Edge(int i, bool released) {
  return fmt::format(R"({{"edgeId":"e{0}","sequenceId":{1},"released":{2},"startNodeId":"n{3}",)"
                     R"("endNodeId":"n{0}","actions":[]}})",
                     i, 2 * i - 1, released, i - 1);
}

// Nodes first … last, of which those before `released` are the base.
SentOrder Sent(std::uint32_t update_id, int first, int last, int released) {
  std::vector<std::string> nodes;
  std::vector<std::string> edges;
  for (int i = first; i <= last; ++i) {
    if (i > first) edges.push_back(Edge(i, i < released));
    nodes.push_back(Node(i, i < released));
  }
  return {.update_id = update_id,
          .by = "ops@host",
          .at = {},
          .message = vda5050::MakeOrder("o-1", update_id, "zones-1", nodes, edges)};
}

vda5050::RobotState Driving(std::uint32_t update_id, std::size_t left = 2) {
  vda5050::RobotState state;
  state.order_id = "o-1";
  state.order_update_id = update_id;
  state.nodes_left = left;
  state.edges_left = left;
  state.last_node_id = "n1";
  state.last_node_sequence_id = 2;
  return state;
}

OrderHistory History(std::vector<SentOrder> sent) {
  OrderHistory history{.order_id = "o-1", .sent = {}};
  for (SentOrder& each : sent) history.sent.push_back(std::move(each));
  return history;
}

std::vector<SentOrder> List(SentOrder a) {
  std::vector<SentOrder> list;
  list.push_back(std::move(a));
  return list;
}

// What an update says: `0+ 2+ 4-`, by sequence id, + for released.
std::string Legs(const base::JsonDocument& order) {
  std::string text;
  for (const char* list : {"nodes", "edges"}) {
    for (const auto& leg : order[list].GetArray()) {
      text +=
          fmt::format("{}{} ", leg["sequenceId"].GetInt(), leg["released"].GetBool() ? "+" : "-");
    }
  }
  return text;
}

TEST(OrderUpdate, BeginsWithTheDecisionPointAndCarriesTheWholeHorizon) {
  const OrderHistory history = History(List(Sent(0, 0, 4, 3)));
  auto order = CurrentOrder::Find(history, Driving(0), "KIT/0001");
  ASSERT_TRUE(order) << order.error().message;
  EXPECT_EQ(order->horizon(), 2U);
  EXPECT_THAT(order->horizon_nodes(), ElementsAre("n3", "n4"));
  const auto update = order->MakeUpdate(1);
  EXPECT_EQ(Legs(update), "4+ 6+ 8- 5+ 7- ");
  EXPECT_EQ(update["orderUpdateId"].GetInt(), 1);
  EXPECT_STREQ(update["orderId"].GetString(), "o-1");
  EXPECT_STREQ(update["zoneSetId"].GetString(), "zones-1");
  // Unchanged, actions and all: a robot may compare.
  EXPECT_EQ(base::ToJson(update["nodes"][0]), base::ToJson(history.sent[0].message["nodes"][2]));
}

TEST(OrderUpdate, WithoutNodesBehindTheDecisionPointDeletesNothingElse) {
  const OrderHistory history = History(List(Sent(0, 0, 2, 3)));
  auto order = CurrentOrder::Find(history, Driving(0), "KIT/0001");
  ASSERT_TRUE(order);
  EXPECT_EQ(order->horizon(), 0U);
  EXPECT_EQ(Legs(order->MakeUpdate(0)), "4+ ");
}

TEST(OrderUpdate, ContinuesTheCountOfSequenceIds) {
  const OrderHistory history = History(List(Sent(0, 0, 2, 3)));
  auto order = CurrentOrder::Find(history, Driving(0), "KIT/0001");
  ASSERT_TRUE(order);
  EXPECT_EQ(order->last_node(), "n2");
  EXPECT_EQ(order->last_sequence_id(), 4U);
  order->Append({Node(3, false), Node(4, false)}, {Edge(3, false), Edge(4, false)});
  EXPECT_EQ(Legs(order->MakeUpdate(2)), "4+ 6+ 8+ 5+ 7+ ");
  EXPECT_EQ(Legs(order->MakeUpdate(0)), "4+ 6- 8- 5- 7- ");
}

// One that was sent and not taken, or recorded and not sent, has used its id.
TEST(OrderUpdate, NeverUsesAnIdTwice) {
  std::vector<SentOrder> sent;
  sent.push_back(Sent(0, 0, 3, 2));
  sent.push_back(Sent(1, 1, 3, 3));
  sent.push_back(Sent(5, 1, 3, 4));
  const OrderHistory history = History(std::move(sent));
  auto order = CurrentOrder::Find(history, Driving(1), "KIT/0001");
  ASSERT_TRUE(order);
  EXPECT_EQ(order->next_update_id(), 6U);
  EXPECT_EQ(Legs(order->MakeUpdate(1)), "4+ 6+ 5+ ");  // of what the robot has: update 1
}

// The newest of that id may be one that the robot did not take, or that went to another robot.
TEST(OrderUpdate, BuildsOnTheMessageWhoseNodesTheRobotShows) {
  std::vector<SentOrder> sent;
  sent.push_back(Sent(0, 0, 4, 2));
  sent.push_back(Sent(0, 0, 2, 2));
  const OrderHistory history = History(std::move(sent));
  vda5050::RobotState state = Driving(0);
  state.nodes = {{.id = "n2", .sequence_id = 4, .released = false},
                 {.id = "n3", .sequence_id = 6, .released = false}};
  auto order = CurrentOrder::Find(history, state, "KIT/0001");
  ASSERT_TRUE(order) << order.error().message;
  EXPECT_THAT(order->horizon_nodes(), ElementsAre("n2", "n3", "n4"));
  state.nodes[1].id = "x9";
  order = CurrentOrder::Find(history, state, "KIT/0001");
  ASSERT_FALSE(order);
  EXPECT_THAT(order.error().message, HasSubstr("other nodes"));
}

TEST(OrderUpdate, NeedsAnOrderThatThisLedgerSent) {
  vda5050::RobotState none;
  auto order = CurrentOrder::Find({}, none, "KIT/0001");
  ASSERT_FALSE(order);
  EXPECT_EQ(order.error().kind, ErrorKind::kPreflight);
  EXPECT_THAT(order.error().message, HasSubstr("has no order"));
  order = CurrentOrder::Find(History(List(Sent(0, 0, 2, 3))), Driving(7), "KIT/0001");
  ASSERT_FALSE(order);
  EXPECT_THAT(order.error().message, HasSubstr("did not send"));
}

TEST(OrderUpdate, MayContinueAnOrderThatIsDoneButNoneThatEndedEarly) {
  const OrderHistory history = History(List(Sent(0, 0, 2, 3)));
  vda5050::RobotState state = Driving(0, 0);
  state.last_node_sequence_id = 4;
  EXPECT_TRUE(CurrentOrder::Find(history, state, "KIT/0001"));
  state.last_node_sequence_id = 2;
  const auto order = CurrentOrder::Find(history, state, "KIT/0001");
  ASSERT_FALSE(order);
  EXPECT_THAT(order.error().message, HasSubstr("cancelled"));
}

TEST(IsUnderWay, IsAnOrderWithAnythingLeftToDo) {
  EXPECT_FALSE(IsUnderWay({}));
  EXPECT_TRUE(IsUnderWay(Driving(0)));
  vda5050::RobotState state = Driving(0, 0);
  EXPECT_FALSE(IsUnderWay(state));
  state.action_states = {{.id = "a", .type = "pick", .status = "RUNNING", .result = ""}};
  EXPECT_FALSE(IsUnderWay(state)) << "up to 2.1 it may be an instant action";
  state.has_instant_action_states = true;
  EXPECT_TRUE(IsUnderWay(state));
}

}  // namespace
}  // namespace fleetpub::app
