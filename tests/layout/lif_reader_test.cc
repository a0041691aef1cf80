// Files of both major versions, and what is no layout at all.
#include <gmock/gmock.h>

#include <filesystem>

#include "layout/layout.h"
#include "layout/layouts.h"
#include "layout/route.h"

namespace fleetpub::layout {
namespace {

using ::testing::ElementsAre;
using ::testing::Eq;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Optional;
using ::testing::SizeIs;

TEST(LifReader, RefusesWhatIsNoLayout) {
  const std::pair<std::string, std::string_view> cases[] = {
      {"", "nothing is there"},
      {"[]", "array"},
      {"null", "null"},
      {"{}", "neither"},
      {R"({"layouts":[]})", "no layout"},
      {R"({"layouts":[],"origins":[]})", "layouts and origins"},
      {R"({"layouts":{}})", "no layout"},
      {R"({"layouts":[7]})", "no layout"},
      {"\xff\xfe", "JSON"},
      {R"({"layouts":[NaN]})", "JSON"},
      {R"({"layouts":[1e999]})", "JSON"},
      {R"({"layouts":[],"layouts":[]})", "twice"},
      {std::string(100'000, '['), "nested"},
  };
  for (const auto& [text, fact] : cases) {
    const auto read = ReadLayout(text);
    ASSERT_FALSE(read) << text.substr(0, 80);
    EXPECT_EQ(read.error().kind, ErrorKind::kInvalid);
    EXPECT_THAT(read.error().message, HasSubstr(fact));
  }
  EXPECT_EQ(ReadLayoutFile("/there/is/none").error().kind, ErrorKind::kLedger);
}

TEST(LifReader, LeavesOutWhatIsFaultyAndGoesOn) {
  const auto read = testing::Read(testing::FileText(
      {testing::NodeText("a", 0, 0), testing::NodeText("a", 1, 1), "5",
       R"({"nodeId":"b","mapId":"m","vehicleTypeNodeProperties":[{"vehicleTypeId":"T"}]})",
       testing::NodeText("c", 2, 0)},
      {testing::EdgeText("a", "x"),
       testing::EdgeText("a", "c", R"("rotationAtEndNodeAllowed":"UP")")}));
  EXPECT_THAT(read.site.nodes, SizeIs(3));
  EXPECT_THAT(read.site.nodes[1].properties, IsEmpty()) << "it has no place";
  ASSERT_THAT(read.site.edges, SizeIs(1));
  EXPECT_THAT(read.site.edges[0].properties, IsEmpty()) << "how it turns is not understood";
}

TEST(LifReader, ReadsVersion2) {
  const auto read = testing::Read(R"({"metaInformation":{"lifId":"id","creator":"c",
    "exportTimestamp":"2026-04-15T11:40:03Z","lifVersion":"2.0.0"},"origins":[{"originId":"o1","layouts":[
    {"layoutId":"l","layoutVersion":"1","nodes":[
      {"nodeId":"a","mapId":"m","nodePosition":{"x":0,"y":0},"mobileRobotTypeNodeProperties":[
        {"mobileRobotTypes":[{"manufacturer":"M","seriesName":"S"},{"manufacturer":"M","seriesName":"R"}],
         "requiredActions":[{"actionType":"beep","blockingType":"SINGLE","actionParameters":[{"key":"n","value":[1,2]}]}],
         "feasibleActions":[{"actionType":"pick","blockingType":"HARD"}],"forbiddenActionTypes":["drop"],
         "allowedDeviationXY":{"aMinimum":0.1,"aMaximum":0.5,"bMinimum":0.1,"bMaximum":0.5,"theta":0},
         "loadRestriction":{"loaded":true,"unloaded":true,"loadSetNames":["EPAL"]}}]},
      {"nodeId":"b","mapId":"m","nodePosition":{"x":4,"y":0},"mobileRobotTypeNodeProperties":[
        {"mobileRobotTypes":[{"manufacturer":"M","seriesName":"S"}],"theta":3.14159}]}],
     "edges":[{"edgeId":"e","startNodeId":"a","endNodeId":"b","mobileRobotTypeEdgeProperties":[
        {"mobileRobotTypes":[{"manufacturer":"M","seriesName":"S"}],"mobileRobotOrientations":[0,3.14159],
         "rotationAtEndNodeAllowed":"NONE","maximumSpeed":2,"corridor":{"maximumLeftWidth":1,"maximumRightWidth":0.5},
         "physicalLineGuidedProperty":{"direction":"left","length":4.5}}]}],
     "stations":[{"stationId":"s","interactionNodeIds":["b"],"stationType":"rack"}]}]}]})");
  EXPECT_THAT(read.findings, IsEmpty());
  const Site& site = read.site;
  EXPECT_THAT(site.VehicleTypes(), ElementsAre("M.S", "M.R"));
  const NodeProperties& node = *site.nodes[0].Find("M.R");
  ASSERT_THAT(node.actions, SizeIs(2));
  EXPECT_EQ(node.actions[0].requirement, Requirement::kRequired);
  EXPECT_EQ(node.actions[1].requirement, Requirement::kOptional);
  EXPECT_EQ(node.actions[0].parameters[0].value, "[1,2]");
  EXPECT_TRUE(node.actions[0].parameters[0].is_json);
  EXPECT_THAT(node.forbidden_actions, ElementsAre("drop"));
  EXPECT_TRUE(node.deviation);
  const EdgeProperties& edge = *site.edges[0].Find("M.S");
  EXPECT_FALSE(edge.rotation_allowed) << "the orientation is reached before, if nothing is said";
  EXPECT_THAT(edge.max_speed, Optional(2.0));
  EXPECT_TRUE(edge.corridor);
  EXPECT_FALSE(site.stations[0].height) << "not said is not known";
  // b is reached backwards only: of the two orientations the second one.
  const auto route = FindRoute(site, {.vehicle_type = "M.S", .from = 0, .stops = {{1}}});
  ASSERT_TRUE(route) << route.error().message;
  EXPECT_DOUBLE_EQ(route->length, 4.5);
  EXPECT_THAT(route->edges[0].orientation, Optional(3.14159));
  EXPECT_FALSE(FindRoute(
      site, {.vehicle_type = "M.S", .loaded = true, .load_set = "GB", .from = 0, .stops = {{1}}}));
}

TEST(LifReader, KeepsOriginsApart) {
  const std::string layout =
      R"({{"layoutId":"{0}","layoutVersion":"1","nodes":[{{"nodeId":"n{0}","mapId":"m",)"
      R"("nodePosition":{{"x":{1},"y":0}},"mobileRobotTypeNodeProperties":[{{"mobileRobotTypes":)"
      R"([{{"manufacturer":"M","seriesName":"S"}}]}}]}}],"edges":[{2}]}})";
  const std::string edge =
      R"({"edgeId":"e","startNodeId":"n1","endNodeId":"n2","mobileRobotTypeEdgeProperties":)"
      R"([{"mobileRobotTypes":[{"manufacturer":"M","seriesName":"S"}]}]})";
  const auto read = testing::Read(fmt::format(
      R"({{"origins":[{{"originId":"o1","layouts":[{}]}},{{"originId":"o2","layouts":[{}]}}]}})",
      fmt::format(fmt::runtime(layout), 1, 0, edge), fmt::format(fmt::runtime(layout), 2, 50, "")));
  const auto route = FindRoute(read.site, {.vehicle_type = "M.S", .from = 0, .stops = {{1}}});
  ASSERT_TRUE(route) << route.error().message;
  EXPECT_EQ(route->length, 0);
}

// They are published beside the schema, and satisfy it nowhere: stationHeight is a text.
TEST(LifReader, ReadsThePublishedExamples) {
  const std::filesystem::path folder =
      std::filesystem::path(FLEETPUB_SOURCE_DIR) / "../shared/reference/lif/1.0.0/examples";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "the published examples are not at hand";
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const auto read = ReadLayoutFile(entry.path().string());
    ASSERT_TRUE(read) << entry.path() << read.error().message;
    ++count;
    for (const auto& finding : read->findings) {
      EXPECT_EQ(finding.level, LayoutFinding::Level::kWarning) << entry.path() << finding.text;
    }
    const Site& site = read->site;
    for (const Edge& edge : site.edges) {  // each can be driven by those whom it is for
      const auto& properties = edge.properties.front();
      const auto& load = properties.load;
      const RouteRequest request{.vehicle_type = properties.vehicle_type,
                                 .loaded = !load.unloaded,
                                 .load_set = load.load_sets.empty() ? "" : load.load_sets.front(),
                                 .from = edge.start,
                                 .stops = {{edge.end}}};
      EXPECT_TRUE(FindRoute(site, request)) << entry.path() << edge.id;
    }
  }
  EXPECT_EQ(count, 18U);
}

}  // namespace
}  // namespace fleetpub::layout
