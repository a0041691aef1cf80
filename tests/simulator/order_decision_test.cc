// Every question of the figure on order updates, and every way in which an order is refused.
#include "simulator/order_decision.h"

#include <functional>

#include "base/text.h"
#include "simulator/conversation.h"
#include "simulator/route.h"

namespace fleetpub::simulator {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;
using ::testing::Not;
using vda5050::Version;

// n1 to n3 released, n4 is horizon.
Route Base() { return {.stops = {{"n1"}, {"n2", true, Act("a", "NONE")}, {"n3"}, {"n4", false}}}; }
Route OtherOrder(const std::string& first = "n1") { return {"o2", 0, {{first}, {"n9"}}}; }
Route Update(std::uint32_t update, const std::string& first, std::uint32_t sequence,
             const std::string& id = "o1") {
  return {id, update, {{first}, {"n8"}}, sequence};
}

enum class Before {
  kNothing,    ///< fresh
  kBusy,       ///< between n1 and n2 of Base()
  kAtBaseEnd,  ///< stands at n3, n4 is horizon
  kDone,       ///< an order from n1 to n2
  kCancelled,  ///< Base(), at n1
};

struct Row {
  std::string name;
  Before before;
  Route message;
  /// `new`, `update`, `discard`, or an errorType; 1.1, 2.0, 2.1, 3.0.
  std::array<std::string, 4> expected;
  std::string references = {};  ///< keys of 3.0 and before, beside topic and headerId
  std::string level_30 = "WARNING";
  std::function<void(Settings&)> settings = {};
};

Route With(Route route, const std::function<void(Route&)>& change) {
  change(route);
  return route;
}

Route Fresh(Stop second, Stop first = {"n1"}) {
  return {"o1", 0, {std::move(first), std::move(second)}};
}

const std::string kOrder = "orderId";
const std::string kUpdate = "orderId orderUpdateId";

std::vector<Row> Figure() {
  const std::string busy = "OTHER_ORDER_ACTIVE";
  return {
      {"first order", Before::kNothing, Base(), {"new", "new", "new", "new"}},
      {"single node", Before::kNothing, {"o1", 0, {{"n1"}}}, {"new", "new", "new", "new"}},
      {"new while busy",
       Before::kBusy,
       OtherOrder(),
       {"orderUpdateError", "orderUpdateError", "orderUpdateError", busy},
       kOrder},
      {"new while it stands at the decision point",
       Before::kAtBaseEnd,
       OtherOrder("n3"),
       {"orderUpdateError", "orderUpdateError", "orderUpdateError", busy},
       kOrder},
      {"new that continues the base",
       Before::kBusy,
       Update(0, "n3", 4, "o2"),
       {"replace", "orderUpdateError", "orderUpdateError", busy},
       kOrder},
      {"new after the last has ended",
       Before::kDone,
       OtherOrder("n2"),
       {"new", "new", "new", "new"}},
      {"new with an update id above 0",
       Before::kDone,
       With(OtherOrder("n2"), [](Route& r) { r.update = 1; }),
       {"new", "new", "new", "VALIDATION_FAILURE"},
       kUpdate},
      {"new from where it is not",
       Before::kDone,
       OtherOrder("n7"),
       {"noRouteError", "noRouteError", "noRouteError", "START_NODE_OUT_OF_RANGE"},
       kOrder + " nodeId"},
      {"new after a cancelled one", Before::kCancelled, OtherOrder(), {"new", "new", "new", "new"}},
      {"update", Before::kBusy, Update(1, "n3", 4), {"update", "update", "update", "update"}},
      {"update with a gap",
       Before::kBusy,
       Update(7, "n3", 4),
       {"update", "update", "update", "update"}},
      {"lower update",
       Before::kBusy,
       Update(0, "n3", 4),
       {"orderUpdateError", "orderUpdateError", "orderUpdateError", "OUTDATED_ORDER_UPDATE"},
       kUpdate,
       "WARNING",
       [](Settings&) {}},
      {"update after a cancel",
       Before::kCancelled,
       Update(1, "n1", 0),
       {"update", "update", "update", "ORDER_UPDATE_FOLLOWING_CANCEL"},
       kUpdate},
      {"the same again", Before::kBusy, Base(), {"discard", "discard", "discard", "discard"}},
      {"the same update id, other content",
       Before::kBusy,
       With(Base(), [](Route& r) { r.stops.pop_back(); }),
       {"discard", "discard", "discard", "SAME_ORDER_UPDATE_ID"},
       kUpdate},
      {"the same after it has ended",
       Before::kDone,
       Fresh({"n2"}),
       {"discard", "discard", "discard", "discard"}},
      {"update from another node",
       Before::kBusy,
       Update(1, "n2", 4),
       {"orderUpdateError", "orderUpdateError", "orderUpdateError", "VALIDATION_FAILURE"},
       kUpdate + " nodeId"},
      {"update from another sequence id",
       Before::kBusy,
       Update(1, "n3", 2),
       {"orderUpdateError", "orderUpdateError", "orderUpdateError", "VALIDATION_FAILURE"},
       kUpdate + " nodeId"},
      {"update from the horizon's end",
       Before::kBusy,
       Update(1, "n4", 6),
       {"orderUpdateError", "orderUpdateError", "orderUpdateError", "VALIDATION_FAILURE"}},
      {"update at the decision point",
       Before::kAtBaseEnd,
       Update(1, "n3", 4),
       {"update", "update", "update", "update"}},
      {"update after completion",
       Before::kDone,
       Update(1, "n2", 2),
       {"update", "update", "update", "update"}},
      {"update after completion from another node",
       Before::kDone,
       Update(1, "n1", 2),
       {"orderUpdateError", "orderUpdateError", "orderUpdateError", "VALIDATION_FAILURE"}},
      {"update after completion from another sequence id",
       Before::kDone,
       Update(1, "n2", 0),
       {"orderUpdateError", "orderUpdateError", "orderUpdateError", "VALIDATION_FAILURE"}},
  };
}

std::array<std::string, 4> Types(const std::string& up_to_21, const std::string& from_30) {
  return {up_to_21, up_to_21, up_to_21, from_30};
}

std::vector<Row> BesideTheFigure() {
  return {
      {"malformed: released behind the horizon",
       Before::kNothing,
       {"o1", 0, {{"n1"}, {"n2", false}, {"n3"}}},
       Types("validationError", "VALIDATION_FAILURE"),
       kUpdate},
      {"malformed: no node released",
       Before::kNothing,
       {"o1", 0, {{"n1", false}}},
       Types("validationError", "VALIDATION_FAILURE"),
       kUpdate},
      {"optional member that it cannot use", Before::kNothing,
       Fresh({"n2", true, "", "", "", R"(,"direction":"left")"}),
       Types("orderError", "UNSUPPORTED_PARAMETER"), kOrder + " parameter", "CRITICAL"},
      {"action that nobody knows", Before::kNothing, Fresh({"n2", true, Act("x", "HARD", "dance")}),
       Types("orderError", "INVALID_ORDER_ACTION"), kUpdate + " actionId"},
      {"action that is none for a node", Before::kNothing,
       Fresh({"n2", true, Act("x", "HARD", "startPause")}),
       Types("orderError", "INVALID_ORDER_ACTION"), kUpdate + " actionId"},
      {"action without its parameters", Before::kNothing,
       Fresh({"n2", true, Act("x", "HARD", "waitForTrigger")}),
       Types("orderError", "INVALID_ORDER_ACTION"), kUpdate + " actionId"},
      {"action that it is told to refuse", Before::kNothing, Fresh({"n2", true, Act("x", "HARD")}),
       Types("orderError", "INVALID_ORDER_ACTION"), kUpdate + " actionId", "WARNING",
       [](Settings& s) { s.reject.insert("detectObject"); }},
      {"two actions of one id", Before::kNothing,
       Fresh({"n2", true, Act("x", "HARD") + "," + Act("x", "NONE")}),
       Types("orderError", "INVALID_ORDER_ACTION"), kUpdate + " actionId"},
      {"action of the base under the same id",
       Before::kBusy,
       {"o1", 1, {{"n3"}, {"n4", true, Act("a", "NONE")}}, 4},
       Types("orderError", "INVALID_ORDER_ACTION"),
       kUpdate + " actionId"},
      {"node that no way leads to", Before::kNothing, Fresh({"n2"}),
       Types("noRouteError", "NO_ROUTE_TO_TARGET"), kOrder + " nodeId", "WARNING",
       [](Settings& s) { s.unreachable.insert("n2"); }},
      {"edge that allows no speed", Before::kNothing,
       Fresh({"n2", true, "", "", "", R"(,"maxSpeed":0,"maximumSpeed":0)"}),
       Types("noRouteError", "NO_ROUTE_TO_TARGET"), kOrder + " edgeId"},
      {"map that is not on board",
       Before::kNothing,
       Fresh({"n2", true, "", At(1, 1, "", "moon")}),
       {"new", "new", "orderError", "UNKNOWN_MAP_ID"},
       kOrder + " mapId"},
      {"mode", Before::kNothing, Fresh({"n2"}), Types("orderError", "MOBILE_ROBOT_NOT_AVAILABLE"),
       kOrder, "WARNING", [](Settings& s) { s.operating_mode = "MANUAL"; }},
      {"too many nodes", Before::kNothing, Fresh({"n2"}),
       Types("orderError", "INSUFFICIENT_MEMORY"), kOrder, "URGENT",
       [](Settings& s) { s.order_limit = 1; }},
      {"other zone set",
       Before::kBusy,
       {"o1", 1, {{"n3"}, {"n4"}}, 4, R"(,"zoneSetId":"z9")"},
       Types("orderError", "update"),
       kUpdate},
      {"first node too far away", Before::kNothing, Fresh({"n2"}, {"n1", true, "", At(3, 4.2)}),
       Types("noRouteError", "START_NODE_OUT_OF_RANGE"), kOrder + " nodeId", "WARNING",
       [](Settings& s) { s.initial.is_placed = true; }},
      {"first node at another angle", Before::kNothing,
       Fresh({"n2"}, {"n1", true, "", At(0, 0, R"(,"theta":1.5)")}),
       Types("noRouteError", "START_NODE_OUT_OF_RANGE"), kOrder + " nodeId", "WARNING",
       [](Settings& s) { s.initial.is_placed = true; }},
  };
}

void Prepare(Conversation& robot, Before before, Version version) {
  if (before == Before::kNothing) return;
  if (before == Before::kDone) {
    robot.Hear("order", Write(Fresh({"n2"}), version));
    robot.Wait(seconds(5));
    ASSERT_EQ(robot.At("/lastNodeId"), R"("n2")");
    return;
  }
  robot.Hear("order", Write(Base(), version));
  if (before == Before::kAtBaseEnd) robot.Wait(seconds(10));
  if (before == Before::kCancelled) robot.Do("cancelOrder");
}

class Decisions : public EachVersion {
 protected:
  [[nodiscard]] std::size_t Index() const { return static_cast<std::size_t>(GetParam()); }

  void Check(const Row& row) {
    SCOPED_TRACE(row.name);
    Settings settings = Plain();
    if (row.settings) row.settings(settings);
    Conversation robot(settings);
    // Lower needs something to be lower than.
    Prepare(robot, row.before, GetParam());
    if (row.name == "lower update") robot.Hear("order", Write(Update(2, "n3", 4), GetParam()));
    const Facts before = Read(robot);
    const auto states = robot.Times("state");
    robot.Hear("order", Write(row.message, GetParam()));
    const std::string& expected = row.expected.at(Index());
    const Facts after = Read(robot);
    if (expected == "discard") {
      EXPECT_EQ(after, before);
      EXPECT_EQ(robot.At("/errors"), "[]");
    } else if (expected == "new" || expected == "update" || expected == "replace") {
      EXPECT_EQ(robot.At("/errors"), "[]");
      EXPECT_EQ(robot.At("/orderId"), '"' + row.message.id + '"');
      EXPECT_EQ(robot.At("/orderUpdateId"), std::to_string(row.message.update));
      EXPECT_EQ(robot.Times("state"), states + 1);
    } else {
      EXPECT_EQ(after, before) << "nothing else changes";
      EXPECT_EQ(robot.Times("state"), states + 1);
      CheckRefusal(robot, row, expected);
    }
  }

 private:
  using Facts = std::vector<std::string>;
  static Facts Read(const Conversation& robot) {
    Facts facts;
    for (const char* pointer : {"/orderId", "/orderUpdateId", "/nodeStates", "/edgeStates",
                                "/actionStates", "/lastNodeId", "/lastNodeSequenceId"}) {
      facts.push_back(robot.At(pointer));
    }
    return facts;
  }
  void CheckRefusal(Conversation& robot, const Row& row, const std::string& type) const {
    EXPECT_EQ(robot.At("/errors/0/errorType"), '"' + type + '"');
    EXPECT_EQ(robot.At("/errors/1"), "");
    EXPECT_EQ(robot.At("/errors/0/errorLevel"), Is30() ? '"' + row.level_30 + '"' : R"("WARNING")");
    const std::string references = robot.At("/errors/0/errorReferences");
    for (const std::string& key : base::Split(row.references, ' ')) {
      if (key.empty()) continue;
      EXPECT_THAT(references, HasSubstr("\"referenceKey\":\"" + std::string(key) + '"'));
    }
    EXPECT_THAT(references, HasSubstr('"' + row.message.id + '"'));
    robot.Do("stateRequest");
    robot.Wait(seconds(31));
    EXPECT_EQ(robot.At("/errors/0/errorType"), '"' + type + '"') << "it stays";
  }
};

INSTANTIATE_TEST_SUITE_P(Versions, Decisions, ::testing::ValuesIn(vda5050::kVersions), VersionName);

TEST_P(Decisions, FollowTheFigure) {
  for (const Row& row : Figure()) Check(row);
}

TEST_P(Decisions, AskFurtherQuestions) {
  for (const Row& row : BesideTheFigure()) Check(row);
}

TEST_P(Decisions, ForgetARefusalWithTheNextOrderThatIsTaken) {
  Conversation robot(Plain());
  robot.Hear("order", Write(Fresh({"n2", true, Act("x", "HARD", "dance")}), GetParam()));
  EXPECT_NE(robot.At("/errors"), "[]");
  robot.Hear("order", Write(Fresh({"n2", true, Act("x", "HARD", "dance")}), GetParam()));
  EXPECT_NE(robot.At("/errors"), "[]") << "it was refused, too";
  robot.Hear("order", Write(Fresh({"n2"}), GetParam()));
  EXPECT_EQ(robot.At("/errors"), "[]");
}

TEST_P(Decisions, ForgetARefusalForTheModeWithTheMode) {
  Settings settings = Plain();
  settings.operating_mode = "MANUAL";
  settings.mode_changes = {{seconds(5), "AUTOMATIC"}};
  Conversation robot(settings);
  robot.Hear("order", Write(Fresh({"n2"}), GetParam()));
  EXPECT_NE(robot.At("/errors"), "[]");
  robot.Wait(seconds(5));
  EXPECT_EQ(robot.At("/operatingMode"), R"("AUTOMATIC")");
  EXPECT_EQ(robot.At("/errors"), "[]");
}

// Unsupported members and actions do not turn a harmless message into an error.
TEST_P(Decisions, AskAboutContentOnlyOfWhatWouldBeTaken) {
  const Route odd = Fresh({"n2", true, Act("x", "HARD", "dance")});
  Settings settings = Plain();
  settings.faults.Add(Fault::kTakeUnknownActions);
  Conversation lenient(settings);
  lenient.Hear("order", Write(odd, GetParam()));
  lenient.Hear("order", Write(odd, GetParam()));
  EXPECT_EQ(lenient.At("/errors"), "[]");
  Conversation busy(Plain());
  busy.Hear("order", Write(Base(), GetParam()));
  busy.Hear("order", Write(With(odd, [](Route& r) { r.id = "o2"; }), GetParam()));
  EXPECT_THAT(busy.At("/errors/0/errorType"), Not(HasSubstr("ACTION")));
  EXPECT_THAT(busy.At("/errors/0/errorDescription"), HasSubstr("still active"));
}

TEST_P(Decisions, TakeAStartWithinItsDeviation) {
  const std::string deviation =
      Is30() ? R"(,"allowedDeviationXY":{"a":5,"b":0.5,"theta":0})" : R"(,"allowedDeviationXY":5)";
  Settings settings = Plain();
  settings.initial.is_placed = true;
  const auto type = [&](double x, double y) {
    Conversation robot(settings);
    robot.Hear("order", Write(Fresh({"n2"}, {"n1", true, "", At(x, y, deviation)}), GetParam()));
    return robot.At("/errors/0/errorType");
  };
  EXPECT_EQ(type(4.9, 0), "");
  EXPECT_EQ(type(0, 4.9).empty(), !Is30()) << "from 3.0 it is an ellipse";
  EXPECT_NE(type(5.5, 0), "");
}

// After nodes without places its states go on telling the last place that it knew.
TEST_P(Decisions, TakeAStartWhereTheStateSaysItIs) {
  Settings settings = Plain();
  settings.initial.is_placed = false;
  settings.initial.last_node_id = "n9";
  const auto type = [&](const std::string& id, double x, double y) {
    Conversation robot(settings);
    robot.Hear("order", Write(Fresh({"n2"}, {id, true, "", At(x, y)}), GetParam()));
    return robot.At("/errors/0/errorType");
  };
  EXPECT_EQ(type("n1", 0, 0), "");
  EXPECT_EQ(type("n9", 7, 7), "") << "by its name";
  EXPECT_NE(type("n1", 7, 7), "");
}

// Up to 2.1 the text counts every action in actionStates.
TEST_P(Decisions, CountInstantActionsAsWorkUpTo21) {
  Settings settings = Plain();
  settings.delay = seconds(5);
  Conversation robot(settings);
  robot.Do("startPause");
  robot.Hear("order", Write(Base(), GetParam()));
  EXPECT_EQ(robot.At("/orderId"), Is30() ? R"("o1")" : R"("")");
}

TEST_P(Decisions, RefuseUpdatesWhileTheOrderIsBeingCancelled) {
  Settings settings = Plain();
  settings.delay = seconds(5);
  Conversation robot(settings);
  robot.Hear("order", Write({"o1",
                             0,
                             {{"n1", true, Act("p", "HARD", "pick", R"(,"actionParameters":[
                 {"key":"loadType","value":"EPAL"},{"key":"stationType","value":"floor"}])")},
                              {"n2"}}},
                            GetParam()));
  EXPECT_EQ(robot.Of("p"), "RUNNING") << robot.At("/errors");
  robot.Do("cancelOrder");
  robot.Wait(seconds(1));
  robot.Hear("order", Write(Update(1, "n2", 2), GetParam()));
  EXPECT_NE(robot.At("/errors"), "[]");
}

}  // namespace
}  // namespace fleetpub::simulator
