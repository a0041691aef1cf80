// Which way is the cheapest, and why there is none.
#include "layout/route.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "layout/layouts.h"

namespace fleetpub::layout {
namespace {

using testing::EdgeText;
using ::testing::ElementsAre;
using testing::FileText;
using ::testing::HasSubstr;
using testing::LayoutText;
using testing::NodeText;

struct Asked {
  std::string_view from = "a";
  std::vector<std::string_view> stops = {"c"};
  std::string type = "T";
  bool loaded = false;
  std::string set;
  RouteCost cost = RouteCost::kLength;
  std::optional<double> heading;
  std::optional<double> speed;
};

Result<Route> Find(const Site& site, const Asked& asked) {
  RouteRequest request{.vehicle_type = asked.type,
                       .loaded = asked.loaded,
                       .load_set = asked.set,
                       .cost = asked.cost,
                       .vehicle_speed = asked.speed,
                       .from = site.FindNode(asked.from).value(),
                       .heading = asked.heading};
  for (const auto word : asked.stops) request.stops.push_back(ResolvePlace(site, word).value());
  return FindRoute(site, request);
}

std::string Way(const std::string& text, const Asked& asked = {}) {
  const Site site = testing::Read(text).site;
  const auto route = Find(site, asked);
  if (!route) return route.error().message;
  std::string way;
  for (const auto& edge : route->edges) way += (way.empty() ? "" : " ") + site.edges[edge.edge].id;
  return way;
}

std::string U(std::string_view id, double x, double y) {
  return NodeText(id, x, y, R"({"vehicleTypeId":"U"})");
}

// a, b, c in a line, and d aside.
std::vector<std::string> Nodes() {
  return {NodeText("a", 0, 0), NodeText("b", 5, 0), NodeText("c", 10, 0), NodeText("d", 5, 9)};
}
const std::string kAside = EdgeText("a", "d") + "," + EdgeText("d", "c");

std::string Heading(double orientation, std::string_view at_start, std::string_view at_end,
                    std::string_view more = "") {
  return fmt::format(R"("vehicleOrientation":{},"rotationAtStartNodeAllowed":"{}",)"
                     R"("rotationAtEndNodeAllowed":"{}"{})",
                     orientation, at_start, at_end, more);
}

TEST(Route, IsTheShortest) {
  EXPECT_EQ(Way(FileText(Nodes(), {EdgeText("a", "b"), EdgeText("b", "c"), kAside})), "a-b b-c");
}

TEST(Route, IsDirected) {
  EXPECT_EQ(Way(FileText(Nodes(), {EdgeText("b", "a"), EdgeText("b", "c"), kAside})), "a-d d-c");
}

TEST(Route, AsksEdgeAndBothNodesForTheType) {
  auto nodes = Nodes();
  nodes[1] = U("b", 5, 0);
  EXPECT_EQ(Way(FileText(nodes, {EdgeText("a", "b"), EdgeText("b", "c"), kAside})), "a-d d-c");
  EXPECT_THAT(Way(FileText(nodes, {EdgeText("a", "b"), EdgeText("b", "c")})),
              HasSubstr("b is not for vehicles of type T, only of U"));
}

TEST(Route, HeedsTheLoad) {
  const auto text = [](std::string_view load) {
    return FileText(Nodes(), {EdgeText("a", "b", fmt::format(R"("loadRestriction":{})", load)),
                              EdgeText("b", "c"), kAside});
  };
  const std::string loaded = text(R"({"loaded":true,"unloaded":false})");
  EXPECT_EQ(Way(loaded), "a-d d-c");
  EXPECT_EQ(Way(loaded, {.loaded = true}), "a-b b-c");
  const std::string set = text(R"({"loaded":true,"unloaded":true,"loadSetNames":["EPAL"]})");
  EXPECT_EQ(Way(set), "a-b b-c");
  EXPECT_EQ(Way(set, {.loaded = true, .set = "EPAL"}), "a-b b-c");
  EXPECT_EQ(Way(set, {.loaded = true, .set = "GB"}), "a-d d-c");
  EXPECT_EQ(Way(set, {.loaded = true}), "a-d d-c");
}

TEST(Route, TurnsAtANodeOnlyAsBothEdgesAllow) {
  const auto way = [](std::string_view at_end, std::string_view at_start, double orientation = 3) {
    return Way(
        FileText(Nodes(), {EdgeText("a", "b", Heading(0, "BOTH", at_end)),
                           EdgeText("b", "c", Heading(orientation, at_start, "BOTH")), kAside}));
  };
  EXPECT_EQ(way("BOTH", "BOTH"), "a-b b-c");
  EXPECT_EQ(way("CW", "BOTH"), "a-b b-c");
  EXPECT_EQ(way("CCW", "CCW"), "a-b b-c");
  EXPECT_EQ(way("CW", "CCW"), "a-d d-c");
  EXPECT_EQ(way("NONE", "BOTH"), "a-d d-c");
  EXPECT_EQ(way("BOTH", "NONE"), "a-d d-c");
  EXPECT_EQ(way("NONE", "NONE", 0.01), "a-b b-c") << "alike within 2°";
  EXPECT_EQ(way("NONE", "NONE", 0.1), "a-d d-c");
}

TEST(Route, TurnsAlongAnEdgeThatAllowsIt) {
  std::string second = EdgeText("b", "c", Heading(3, "NONE", "NONE"));
  second.replace(second.find(":false"), 6, ":true");
  EXPECT_EQ(Way(FileText(Nodes(), {EdgeText("a", "b", Heading(0, "NONE", "NONE")), second})),
            "a-b b-c");
}

TEST(Route, MayComeToANodeTwiceToLeaveItTheRightWay) {
  // b can be left for c only with the heading that the loop over d brings.
  const double back = std::numbers::pi;
  const std::string text = FileText(
      Nodes(), {EdgeText("a", "b", Heading(0, "BOTH", "NONE")),
                EdgeText("b", "d", Heading(0, "BOTH", "BOTH", R"(,"orientationType":"GLOBAL")")),
                EdgeText("d", "b", Heading(back, "BOTH", "NONE", R"(,"orientationType":"GLOBAL")")),
                EdgeText("b", "c", Heading(back, "NONE", "BOTH"))});
  EXPECT_EQ(Way(text), "a-b b-d d-b b-c");
}

TEST(Route, KnowsHeadingsFromTrajectories) {
  // A curve that ends upwards, and an edge that needs the heading to the right.
  const auto curved = [](std::string_view last) {
    return fmt::format(R"("trajectory":{{"degree":2,"knotVector":[0,0,0,1,1,1],"controlPoints":)"
                       R"([{{"x":0,"y":0}},{},{{"x":5,"y":0}}]}},"vehicleOrientation":0,)"
                       R"("rotationAtEndNodeAllowed":"NONE")",
                       last);
  };
  const auto way = [&](std::string_view last) {
    return Way(FileText(Nodes(), {EdgeText("a", "b", curved(last)),
                                  EdgeText("b", "c", Heading(0, "NONE", "NONE")), kAside}));
  };
  EXPECT_EQ(way(R"({"x":2,"y":0})"), "a-b b-c");
  EXPECT_EQ(way(R"({"x":5,"y":-2})"), "a-d d-c");
}

TEST(Route, StandsOnANodeAsItsThetaSays) {
  auto nodes = Nodes();
  nodes[1] = NodeText("b", 5, 0, R"({"vehicleTypeId":"T","theta":3.14})");
  const auto way = [&](std::string_view at_end) {
    return Way(FileText(nodes, {EdgeText("a", "b", Heading(0, "BOTH", at_end)),
                                EdgeText("b", "c", Heading(3.14159, "NONE", "BOTH"))}));
  };
  EXPECT_THAT(way("NONE"), HasSubstr("turn"));
  EXPECT_THAT(way("BOTH"), HasSubstr("turn")) << "one of the two forbids it";
  nodes[1] = NodeText("b", 5, 0, R"({"vehicleTypeId":"T","theta":0})");
  EXPECT_THAT(way("NONE"), HasSubstr("turn"));
}

TEST(Route, BeginsWithTheVehiclesHeading) {
  const std::string text = FileText(
      Nodes(), {EdgeText("a", "b", Heading(0, "NONE", "BOTH")), EdgeText("b", "c"), kAside});
  EXPECT_EQ(Way(text), "a-b b-c");
  EXPECT_EQ(Way(text, {.heading = 0}), "a-b b-c");
  EXPECT_EQ(Way(text, {.heading = 1.5}), "a-d d-c");
}

TEST(Route, IsTheFastestWhenTimeCounts) {
  const std::string text =
      FileText(Nodes(), {EdgeText("a", "b", R"("maxSpeed":0.1)"), EdgeText("b", "c"), kAside});
  EXPECT_EQ(Way(text), "a-b b-c");
  EXPECT_EQ(Way(text, {.cost = RouteCost::kTime}), "a-d d-c");
  EXPECT_EQ(Way(text, {.cost = RouteCost::kTime, .speed = 0.05}), "a-b b-c");
}

TEST(Route, PassesStopsAndTakesTheNearestNodeOfAStation) {
  const Site site = testing::Read(FileText(Nodes(),
                                           {EdgeText("a", "b"), EdgeText("b", "c"),
                                            EdgeText("b", "d"), EdgeText("d", "b")},
                                           R"({"stationId":"s","stationName":"Dock 3",)"
                                           R"("interactionNodeIds":["c","d","b"]})"))
                        .site;
  const auto to_station = Find(site, {.stops = {"Dock 3"}});
  ASSERT_TRUE(to_station);
  EXPECT_THAT(to_station->nodes, ElementsAre(0U, 1U));
  const auto over = Find(site, {.stops = {"a", "d", "c"}});
  ASSERT_TRUE(over) << over.error().message;
  EXPECT_THAT(over->nodes, ElementsAre(0U, 1U, 3U, 1U, 2U));
  EXPECT_THAT(over->stops, ElementsAre(0U, 2U, 4U));
  EXPECT_DOUBLE_EQ(over->length, 5 + 9 + 9 + 5);
  const auto nowhere = Find(site, {.from = "c", .stops = {"s"}});
  ASSERT_TRUE(nowhere);
  EXPECT_THAT(nowhere->nodes, ElementsAre(2U));
}

TEST(Route, CountsNothingBetweenMaps) {
  const Site site =
      testing::Read(FileText({LayoutText({NodeText("a", 0, 0), NodeText("b", 3, 4)},
                                         {EdgeText("a", "b"), EdgeText("b", "c")}),
                              LayoutText({NodeText("c", 90, 0, R"({"vehicleTypeId":"T"})", "up")},
                                         {}, "", "upper")}))
          .site;
  const auto route = Find(site, {});
  ASSERT_TRUE(route) << route.error().message;
  EXPECT_DOUBLE_EQ(route->length, 5);
  EXPECT_FALSE(route->edges.back().has_heading);
}

TEST(Route, MeasuresTrajectories) {
  // A quarter of a circle, exactly: a rational curve of degree 2.
  const Site site =
      testing::Read(
          FileText({NodeText("a", 1, 0), NodeText("c", 0, 1)},
                   {EdgeText("a", "c",
                             R"("trajectory":{"degree":2,"knotVector":[0,0,0,1,1,1],)"
                             R"("controlPoints":[{"x":1,"y":0},{"x":1,"y":1,"weight":)"
                             R"(0.7071067811865476},{"x":0,"y":1}]},"vehicleOrientation":0)")}))
          .site;
  const auto route = Find(site, {});
  ASSERT_TRUE(route);
  EXPECT_NEAR(route->length, std::numbers::pi / 2, 1e-6);
  EXPECT_NEAR(std::abs(route->edges.front().heading), std::numbers::pi, 1e-9);
}

struct Refused {
  std::string_view name;
  std::vector<std::string> edges;
  std::string_view fact;
};

TEST(Route, TellsTheNearestReasonWhenThereIsNone) {
  const std::string ab = EdgeText("a", "b");
  const std::vector<Refused> cases = {
      {"island", {ab}, "no edge leads to c"},
      {"parts", {ab, EdgeText("d", "c")}, "no edge joins"},
      {"one-way", {ab, EdgeText("c", "b")}, "edge c-b leads only from c to b"},
      {"load",
       {ab, EdgeText("b", "c", R"("loadRestriction":{"loaded":true,"unloaded":false})")},
       "edge b-c is only for loaded vehicles"},
      {"speed", {ab, EdgeText("b", "c", R"("maxSpeed":0)")}, "speed on edge b-c"},
      {"turning",
       {EdgeText("a", "b", Heading(0, "NONE", "NONE")),
        EdgeText("b", "c", Heading(2, "NONE", "NONE"))},
       "may not turn there for edge b-c"},
      {"faulty", {ab, EdgeText("b", "c", R"("maxSpeed":-1)")}, "edge b-c is not for vehicles"},
  };
  for (const auto& [name, edges, fact] : cases) {
    EXPECT_THAT(Way(FileText(Nodes(), edges)), HasSubstr(fact)) << name;
  }
}

TEST(Route, RefusesPlacesAndTypesThatAreNotThere) {
  const Site site = testing::Read(FileText({NodeText("dock-1", 0, 0), U("dock-2", 1, 0)}, {})).site;
  const auto place = ResolvePlace(site, "dock1");
  ASSERT_FALSE(place);
  EXPECT_EQ(place.error().kind, ErrorKind::kUsage);
  EXPECT_THAT(place.error().message, HasSubstr("dock-1"));
  EXPECT_EQ(ChooseVehicleType(site, "", "U").value(), "U");
  EXPECT_EQ(ChooseVehicleType(site, "T", "U").value(), "T");
  for (const auto& refused :
       {ChooseVehicleType(site, "", "X"), ChooseVehicleType(site, "X", "T")}) {
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().message, HasSubstr("T, U"));
  }
}

}  // namespace
}  // namespace fleetpub::layout
