#include "app/order_path.h"

#include <gmock/gmock.h>

#include <numbers>

#include "app/path_file.h"

namespace fleetpub::app {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// n1 (0,0) → n2 (3,0) → dock (3,4); a lift at dock is required, a beep is offered.
layout::Site Hall() {
  layout::Site site;
  site.layouts.push_back({.id = "hall"});
  const auto node = [&](const char* id, double x, double y) {
    layout::Node n{.id = id, .name = "", .description = "", .map_id = "m", .x = x, .y = y};
    n.properties.push_back({.vehicle_type = "T", .theta = {}, .actions = {}});
    site.nodes.push_back(n);
  };
  node("n1", 0, 0);
  node("n2", 3, 0);
  node("dock", 3, 4);
  site.nodes[2].properties[0].actions = {
      {.type = "lift", .requirement = layout::Requirement::kRequired, .blocking_type = "HARD"},
      {.type = "beep", .blocking_type = "SOFT", .parameters = {{"tone", "low"}, {"count", "2"}}}};
  const auto edge = [&](const char* id, std::size_t start, std::size_t end) {
    layout::Edge e{.id = id, .name = "", .description = "", .start = start, .end = end};
    e.properties.push_back({.vehicle_type = "T", .max_speed = 1.5});
    site.edges.push_back(e);
  };
  edge("e12", 0, 1);
  edge("e2d", 1, 2);
  site.stations.push_back({.id = "S1", .name = "", .description = "", .nodes = {2}});
  return site;
}

class PlanningAPath : public ::testing::Test {
 protected:
  Result<PlannedPath> Plan(PathRequest request) {
    if (request.vehicle_type.empty()) request.vehicle_type = "T";
    return PlanPath(request, site_ ? &*site_ : nullptr,
                    {.address = {"KIT", "0001"}, .state = &state_, .start = state_.last_node_id});
  }

  std::optional<layout::Site> site_;
  vda5050::RobotState state_;
};

TEST_F(PlanningAPath, JoinsNodesByEdgesOfTheirNames) {
  const auto planned = Plan({.nodes = {"a", "b", "a"}});
  ASSERT_TRUE(planned);
  ASSERT_THAT(planned->path.nodes, SizeIs(3));
  EXPECT_EQ(planned->path.edges[0].id, "a-b");
  EXPECT_EQ(planned->path.edges[1].id, "b-a");
  EXPECT_FALSE(planned->length);
  EXPECT_EQ(DescribePath(*planned), "a → b → a");
}

TEST_F(PlanningAPath, TakesPositionsAndEdgesFromALayout) {
  site_ = Hall();
  const auto planned = Plan({.nodes = {"n1", "n2", "S1"}});
  ASSERT_TRUE(planned) << planned.error().message;
  EXPECT_EQ(DescribePath(*planned), "n1 → n2 → dock, 7.0 m, 1 action");
  EXPECT_EQ(planned->path.edges[1].id, "e2d");
  EXPECT_EQ(planned->path.edges[1].max_speed, 1.5);
  EXPECT_NEAR(*planned->path.edges[1].heading, std::numbers::pi / 2, 1e-12);
  EXPECT_EQ(planned->path.nodes[2].actions[0].type, "lift");
  EXPECT_THAT(planned->warnings, IsEmpty());
}

TEST_F(PlanningAPath, WarnsOfWhatTheLayoutDoesNotHave) {
  site_ = Hall();
  const auto planned = Plan({.nodes = {"n2", "n1", "elsewhere"}});
  ASSERT_TRUE(planned);
  EXPECT_THAT(planned->warnings,
              ElementsAre(HasSubstr("no node elsewhere"), HasSubstr("no edge from n2 to n1")));
}

TEST_F(PlanningAPath, PutsActionsWhereTheyAreWanted) {
  site_ = Hall();
  const auto planned = Plan({.nodes = {"n1", "n2", "dock"},
                             .actions = {*ParsePlacedAction("beep@S1", {"count:=3"}),
                                         *ParsePlacedAction("pick@n1", {"loadType=EPAL"}),
                                         *ParsePlacedAction("blink@e12", {})}});
  ASSERT_TRUE(planned);
  const auto& dock = planned->path.nodes[2].actions;
  ASSERT_THAT(dock, SizeIs(2));
  EXPECT_EQ(dock[1].type, "beep");
  EXPECT_EQ(dock[1].blocking_type, "SOFT");
  EXPECT_EQ(dock[1].parameters[0].json, R"("low")");
  EXPECT_EQ(dock[1].parameters[1].json, "3");
  EXPECT_EQ(planned->path.nodes[0].actions[0].blocking_type, "HARD");
  EXPECT_EQ(planned->path.edges[0].actions[0].type, "blink");
  EXPECT_NE(dock[0].id, dock[1].id);
}

TEST_F(PlanningAPath, AnActionAtAPlaceOfALoopIsForItsLastPass) {
  const auto planned =
      Plan({.nodes = {"a", "b", "a"}, .actions = {*ParsePlacedAction("drop@a", {})}});
  ASSERT_TRUE(planned);
  EXPECT_THAT(planned->path.nodes[0].actions, IsEmpty());
  EXPECT_THAT(planned->path.nodes[2].actions, SizeIs(1));
}

TEST_F(PlanningAPath, RefusesAnActionThatIsNotOnTheWay) {
  const auto planned = Plan({.nodes = {"a", "b"}, .actions = {*ParsePlacedAction("drop@c", {})}});
  ASSERT_FALSE(planned);
  EXPECT_EQ(planned.error().kind, ErrorKind::kUsage);
  EXPECT_THAT(planned.error().message, HasSubstr("a → b"));
}

TEST_F(PlanningAPath, BeginsWhereTheRobotIs) {
  state_.last_node_id = "x";
  const auto planned = Plan({.nodes = {"a", "b"}});
  ASSERT_FALSE(planned);
  EXPECT_EQ(planned.error().kind, ErrorKind::kPreflight);
  EXPECT_THAT(planned.error().message, HasSubstr("name x first"));
}

TEST_F(PlanningAPath, WidensTheFirstNodeForARobotThatIsALittleOff) {
  site_ = Hall();
  site_->nodes[0].properties[0].theta = 1;
  state_.last_node_id = "n1";
  state_.position = vda5050::RobotPosition{.x = 0.3, .y = 0.4, .theta = 0, .map_id = "m"};
  const auto planned = Plan({.nodes = {"n1", "n2"}, .deviation_xy = 0.1});
  ASSERT_TRUE(planned);
  EXPECT_DOUBLE_EQ(*planned->path.nodes[0].position->deviation_xy, 0.51);
  EXPECT_DOUBLE_EQ(*planned->path.nodes[0].position->deviation_theta, std::numbers::pi);
  EXPECT_DOUBLE_EQ(*planned->path.nodes[1].position->deviation_xy, 0.1);
}

// It would be done before the robot moved.
TEST_F(PlanningAPath, RefusesTheOneNodeThatTheRobotIsNotAt) {
  site_ = Hall();
  state_.last_node_id = "n1";
  state_.position = vda5050::RobotPosition{.x = 0.3, .y = 0.4, .theta = 0, .map_id = "m"};
  for (const char* from : {"", "n1"}) {
    const auto planned = Plan({.stops = {"n1"}, .from = from});
    ASSERT_FALSE(planned);
    EXPECT_EQ(planned.error().kind, ErrorKind::kPreflight);
    EXPECT_THAT(planned.error().message, HasSubstr("0.5 m from n1"));
  }
  EXPECT_TRUE(Plan({.nodes = {"n1"}, .deviation_xy = 0.6}));
  state_.position->y = 0;
  EXPECT_TRUE(Plan({.nodes = {"n1"}, .deviation_xy = 0.3})) << "it is on it";
}

TEST_F(PlanningAPath, RefusesAStartBesideWhoseWayTheRobotIs) {
  site_ = Hall();
  state_.last_node_id = "n1";
  state_.position = vda5050::RobotPosition{.x = 70, .y = 0, .theta = 0, .map_id = "m"};
  const auto planned = Plan({.nodes = {"n1", "n2"}});
  ASSERT_FALSE(planned);
  EXPECT_THAT(planned.error().message, HasSubstr("70.0 m from n1"));
}

TEST_F(PlanningAPath, DoesNotWidenItForARobotOnAnotherMap) {
  site_ = Hall();
  state_.position = vda5050::RobotPosition{.x = 3, .y = 4, .theta = 0, .map_id = "other"};
  const auto planned = Plan({.nodes = {"n1", "n2"}});
  ASSERT_TRUE(planned);
  EXPECT_FALSE(planned->path.nodes[0].position->deviation_xy);
}

TEST_F(PlanningAPath, ARouteNeedsALayoutAndAStart) {
  auto planned = Plan({.stops = {"dock"}});
  ASSERT_FALSE(planned);
  EXPECT_EQ(planned.error().kind, ErrorKind::kUsage);
  site_ = Hall();
  planned = Plan({.stops = {"dock"}});
  ASSERT_FALSE(planned);
  EXPECT_THAT(planned.error().message, HasSubstr("--from NODE"));
}

TEST_F(PlanningAPath, FindsARouteFromWhereTheRobotIs) {
  site_ = Hall();
  state_.last_node_id = "n1";
  const auto planned = Plan({.stops = {"S1"}});
  ASSERT_TRUE(planned) << planned.error().message;
  EXPECT_EQ(DescribePath(*planned), "n1 → n2 → dock, 7.0 m, 1 action");
}

TEST(ParsePlacedAction, TypesWhatThePredefinedActionsHave) {
  const auto action = ParsePlacedAction("pick@n7", {"height=50cm", "loadType=EPAL", "x:=[1]"});
  ASSERT_TRUE(action);
  EXPECT_EQ(action->parameters[0].json, "0.5");
  EXPECT_EQ(action->parameters[1].json, R"("EPAL")");
  EXPECT_EQ(action->parameters[2].json, "[1]");
  for (const char* word : {"pick", "@n1", "pick@", ""}) {
    const auto none = ParsePlacedAction(word, {});
    ASSERT_FALSE(none) << word;
    EXPECT_EQ(none.error().kind, ErrorKind::kUsage);
  }
}

TEST(ParsePlacedAction, RefusesAParameterThatIsThereTwice) {
  const auto action = ParsePlacedAction("pick@n7", {"loadType=EPAL", "height=1", "loadType:=1"});
  ASSERT_FALSE(action);
  EXPECT_EQ(action.error().kind, ErrorKind::kUsage);
  EXPECT_THAT(action.error().message, HasSubstr("'loadType' is given twice"));
}

TEST(ParsePathFile, ReadsRowsWithWhatTheyHave) {
  const auto points = ParsePathFile(
      "node,x,y,theta,map,actions\n"
      "n1,0,0,,hall,\n"
      "n2, 1.5 ,2,0.5,hall,pick loadType=EPAL; beep\n");
  ASSERT_TRUE(points) << points.error().message;
  EXPECT_FALSE((*points)[0].position->theta);
  EXPECT_DOUBLE_EQ((*points)[1].position->x, 1.5);
  EXPECT_DOUBLE_EQ(*(*points)[1].position->theta, 0.5);
  ASSERT_THAT((*points)[1].actions, SizeIs(2));
  EXPECT_EQ((*points)[1].actions[1].type, "beep");
  const auto bare = ParsePathFile("node\nn1\nn2\n");
  ASSERT_TRUE(bare);
  EXPECT_FALSE((*bare)[0].position);
}

TEST(ParsePathFile, SaysWhereAFileIsWrong) {
  const std::pair<const char*, const char*> cases[] = {
      {"", "names no node"},
      {"node\n", "names no node"},
      {"x,y\n1,2\n", "column node is missing"},
      {"node,speed\nn1,2\n", "column 'speed'"},
      {"node,node\nn1,n1\n", "twice"},
      {"node,x,y,map\nn1,0,0,m\nn2,one,0,m\n", "line 3: x must be a number"},
      {"node,x,y,map\nn1,0,,m\n", "line 2: y must be a number"},
      {"node,x,y\nn1,0,0\n", "line 2: a node with x and y needs a map"},
      {"node,x,y,theta,map\nn1,0,0,90,m\n", "radians"},
      {"node,x\n,1\n", "has no name"},
      {"node,actions\nn1,pick loadType\n", "line 2: "},
      {"node,actions\nn1,\nn2,beep a=1 a=2\n", "line 3: parameter 'a' is given twice"},
      {"node,actions\nn1,@pick\n", "line 2: "},
  };
  for (const auto& [text, part] : cases) {
    const auto points = ParsePathFile(text);
    ASSERT_FALSE(points) << text;
    EXPECT_THAT(points.error().message, HasSubstr(part)) << text;
  }
}

}  // namespace
}  // namespace fleetpub::app
