#include "vda5050/messages/order.h"

#include <gmock/gmock.h>

#include <numbers>

#include "delivery/validate.h"
#include "schema/schema.h"
#include "vda5050/messages/user_message.h"

namespace fleetpub::vda5050 {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

OrderNode Dock() {
  return {.id = "dock-3",
          .description = "by the gate",
          .position = OrderPosition{.x = 1.5,
                                    .y = -2,
                                    .theta = 3.5,
                                    .map_id = "hall",
                                    .deviation_xy = 0.25,
                                    .deviation_theta = 0.5},
          .actions = {{.type = "pick",
                       .id = "a-1",
                       .descriptor = "",
                       .blocking_type = "HARD",
                       .parameters = {{"loadType", R"("EPAL")"}, {"stationType", R"("rack")"}}}}};
}

OrderEdge Way() {
  return {.id = "e1",
          .description = "the aisle",
          .max_speed = 1.2,
          .max_rotation_speed = 0.4,
          .max_height = 2.1,
          .min_height = 0.1,
          .orientation = std::numbers::pi,
          .rotation_allowed = false,
          .length = 4.5,
          .heading = std::numbers::pi / 2,
          .trajectory = {},
          .actions = {}};
}

std::string Node(Version version, const Factsheet* factsheet = nullptr) {
  return OrderWriter(version, factsheet).WriteNode(Dock(), 4, true);
}

std::string Edge(Version version, const Factsheet* factsheet = nullptr) {
  return OrderWriter(version, factsheet).WriteEdge(Way(), 3, false, "n1", "dock-3");
}

TEST(OrderWriter, WritesNodesInTheMembersOfEachVersion) {
  EXPECT_EQ(
      Node(Version::k110),
      R"({"nodeId":"dock-3","sequenceId":4,"released":true,"nodeDescription":"by the gate",)"
      R"("nodePosition":{"x":1.5,"y":-2,"theta":-2.7831853071795862,"allowedDeviationXy":0.25,)"
      R"("allowedDeviationTheta":0.5,"mapId":"hall"},"actions":[{"actionType":"pick",)"
      R"("actionId":"a-1","blockingType":"HARD","actionParameters":[{"key":"loadType",)"
      R"("value":"EPAL"},{"key":"stationType","value":"rack"}]}]})");
  EXPECT_THAT(Node(Version::k210), HasSubstr(R"("allowedDeviationXY":0.25,)"));
  EXPECT_THAT(Node(Version::k300), HasSubstr(R"("nodeDescriptor":"by the gate",)"));
  EXPECT_THAT(Node(Version::k300),
              HasSubstr(R"("allowedDeviationXY":{"a":0.25,"b":0.25,"theta":0})"));
}

TEST(OrderWriter, WritesEdgesInTheMembersOfEachVersion) {
  EXPECT_EQ(Edge(Version::k110),
            R"({"edgeId":"e1","sequenceId":3,"released":false,"startNodeId":"n1",)"
            R"("endNodeId":"dock-3","edgeDescription":"the aisle","maxSpeed":1.2,"maxHeight":2.1,)"
            R"("minHeight":0.1,"orientation":-1.5707963267948966,"rotationAllowed":false,)"
            R"("maxRotationSpeed":0.4,"distance":4.5,"actions":[]})");
  EXPECT_EQ(Edge(Version::k210),
            R"({"edgeId":"e1","sequenceId":3,"released":false,"startNodeId":"n1",)"
            R"("endNodeId":"dock-3","edgeDescription":"the aisle","maxSpeed":1.2,"maxHeight":2.1,)"
            R"("minHeight":0.1,"orientation":3.141592653589793,"orientationType":"TANGENTIAL",)"
            R"("rotationAllowed":false,"maxRotationSpeed":0.4,"length":4.5,"actions":[]})");
  EXPECT_EQ(Edge(Version::k300),
            R"({"edgeId":"e1","sequenceId":3,"released":false,"edgeDescriptor":"the aisle",)"
            R"("maximumSpeed":1.2,"maximumMobileRobotHeight":2.1,)"
            R"("minimumLoadHandlingDeviceHeight":0.1,"orientation":3.141592653589793,)"
            R"("orientationType":"TANGENTIAL","maximumRotationSpeed":0.4,"length":4.5,)"
            R"("actions":[]})");
}

TEST(OrderWriter, SatisfiesTheSchemaAndTheTextOfEachVersion) {
  schema::Registry registry("");
  for (const Version version : kVersions) {
    OrderWriter writer(version, nullptr);
    OrderNode start{.id = "n1", .description = "", .position = {}, .actions = {}};
    OrderEdge way = Way();
    if (version >= Version::k200) {
      way.trajectory =
          OrderTrajectory{.degree = 1, .knots = {0, 0, 1, 1}, .points = {{0, 0}, {3, 4}}};
    }
    const std::vector<std::string> nodes = {writer.WriteNode(start, 0, true),
                                            writer.WriteNode(Dock(), 2, false)};
    const std::vector<std::string> edges = {writer.WriteEdge(way, 1, false, "n1", "dock-3")};
    const auto order = MakeOrder("o-1", 0, "", nodes, edges);
    const auto command = BuildUserMessage({"KIT", "0001"}, {.version = version, .topics = {}},
                                          "order", order, HeaderMismatch::kReplace);
    ASSERT_TRUE(command);
    const auto findings = delivery::Validate(*command, registry);
    ASSERT_TRUE(findings);
    EXPECT_THAT(findings->errors, IsEmpty())
        << GetFacts(version).name << delivery::Describe(*findings);
    EXPECT_THAT(writer.refusals(), IsEmpty());
  }
}

TEST(OrderWriter, LeavesOutWhatTheFactsheetDoesNotList) {
  Factsheet factsheet;
  factsheet.has_optional_parameters = true;
  factsheet.optional_parameters = {{"order.nodes.nodePosition.theta", false}};
  OrderWriter writer(Version::k210, &factsheet);
  const std::string node = writer.WriteNode(Dock(), 0, true);
  EXPECT_THAT(node, HasSubstr(R"("theta":)"));
  EXPECT_THAT(node, HasSubstr(R"("mapId":"hall")"));
  EXPECT_THAT(node, Not(HasSubstr("allowedDeviation")));
  EXPECT_THAT(writer.left_out(), ElementsAre("order.nodes.nodeDescription",
                                             "order.nodes.nodePosition.allowedDeviationTheta",
                                             "order.nodes.nodePosition.allowedDeviationXY"));
  EXPECT_THAT(writer.refusals(), IsEmpty());
}

TEST(OrderWriter, RefusesToLeaveOutWhatWouldMakeItAnotherOrder) {
  Factsheet factsheet;
  factsheet.has_optional_parameters = true;
  OrderWriter writer(Version::k300, &factsheet);
  const std::string edge = writer.WriteEdge(Way(), 1, true, "n1", "n2");
  EXPECT_THAT(edge, Not(HasSubstr("maximumSpeed")));
  EXPECT_THAT(writer.refusals(), ::testing::Contains(HasSubstr("--without maximumSpeed")));
  OrderWriter without(
      Version::k300, &factsheet,
      {"maxSpeed", "maxRotationSpeed", "maxHeight", "minHeight", "orientation", "orientationType"});
  EXPECT_THAT(without.WriteEdge(Way(), 1, true, "n1", "n2"), Not(HasSubstr("maximum")));
  EXPECT_THAT(without.refusals(), IsEmpty());
}

TEST(OrderWriter, RefusesWhatTheRobotRequiresAndNobodyKnows) {
  Factsheet factsheet;
  factsheet.has_optional_parameters = true;
  factsheet.optional_parameters = {{"order.nodes.nodePosition", true},
                                   {"order.edges.length", true}};
  OrderWriter writer(Version::k210, &factsheet);
  static_cast<void>(writer.WriteNode({.id = "n1"}, 0, true));
  EXPECT_THAT(writer.refusals(), ElementsAre(HasSubstr("order.nodes.nodePosition")));
  static_cast<void>(writer.WriteEdge({.id = "e"}, 1, true, "n1", "n2"));
  EXPECT_THAT(writer.refusals(), ElementsAre(HasSubstr("nodePosition"), HasSubstr("length")));
}

TEST(OrderWriter, TurnsBeforeAnEdgeOnlyWhereTheRobotDrivesInAnyDirection) {
  Factsheet factsheet;
  factsheet.specification.kinematics = "OMNIDIRECTIONAL";
  EXPECT_THAT(Edge(Version::k300, &factsheet),
              HasSubstr(R"("reachOrientationBeforeEntering":true)"));
  factsheet.specification.kinematics = "DIFFERENTIAL";
  EXPECT_THAT(Edge(Version::k300, &factsheet), Not(HasSubstr("reachOrientation")));
}

TEST(OrderWriter, GlobalOrientationsAreForRobotsThatDriveInAnyDirection) {
  Factsheet factsheet;
  factsheet.specification.kinematics = "THREEWHEEL";
  OrderEdge edge = Way();
  edge.is_tangential = false;
  OrderWriter three(Version::k300, &factsheet);
  static_cast<void>(three.WriteEdge(edge, 1, true, "a", "b"));
  EXPECT_THAT(three.refusals(), ElementsAre(HasSubstr("omnidirectional")));
  OrderWriter two(Version::k210, &factsheet);
  EXPECT_THAT(two.WriteEdge(edge, 1, true, "a", "b"), HasSubstr(R"("orientationType":"GLOBAL")"));
  EXPECT_THAT(two.refusals(), IsEmpty());
}

TEST(OrderWriter, RefusesActionsThatTheRobotDoesNotDoThere) {
  Factsheet factsheet;
  factsheet.actions = {{.type = "pick", .scopes = {"INSTANT"}, .blocking_types = {"HARD"}},
                       {.type = "drop", .scopes = {"NODE"}, .blocking_types = {"SOFT"}}};
  const auto refusals = [&](std::string type) {
    OrderNode node{.id = "n", .description = "", .position = {}, .actions = {}};
    node.actions = {
        {.type = std::move(type), .id = "a", .descriptor = "", .blocking_type = "HARD"}};
    OrderWriter writer(Version::k210, &factsheet);
    static_cast<void>(writer.WriteNode(node, 0, true));
    return writer.refusals();
  };
  EXPECT_THAT(refusals("pick"), ElementsAre(HasSubstr("INSTANT, not on a node")));
  EXPECT_THAT(refusals("drop"), ElementsAre(HasSubstr("blockingType SOFT")));
  EXPECT_THAT(refusals("beep"), ElementsAre(HasSubstr("no action beep")));
}

TEST(OrderWriter, KeepsToTheRobotsLimits) {
  Factsheet factsheet;
  factsheet.limits = {.id_length = 3, .node_actions = 0};
  OrderWriter writer(Version::k210, &factsheet);
  static_cast<void>(writer.WriteNode({.id = "long"}, 0, true));
  EXPECT_THAT(writer.refusals(), ElementsAre(HasSubstr("4 characters")));
  factsheet.limits = {.order_nodes = 5, .order_edges = 9, .base_nodes = 3};
  EXPECT_EQ(CheckOrderLimits(factsheet, 5, 4, 3), "");
  EXPECT_THAT(CheckOrderLimits(factsheet, 6, 5, 3), HasSubstr("6 nodes"));
  EXPECT_THAT(CheckOrderLimits(factsheet, 5, 10, 3), HasSubstr("10 edges"));
  EXPECT_THAT(CheckOrderLimits(factsheet, 5, 4, 4), HasSubstr("--release 3"));
}

TEST(ToParameterValue, IsOfTheTypeThatTheFactsheetSays) {
  Factsheet factsheet;
  factsheet.actions = {{.type = "lift",
                        .scopes = {},
                        .parameters = {{"height", "NUMBER"},
                                       {"slow", "BOOL"},
                                       {"slots", "ARRAY"},
                                       {"name", "STRING"}},
                        .blocking_types = {}}};
  const auto value = [&](std::string_view key, std::string_view text) {
    return ToParameterValue(&factsheet, "lift", key, text);
  };
  EXPECT_EQ(value("height", "1.50"), "1.5");
  EXPECT_EQ(value("slow", "true"), "true");
  EXPECT_EQ(value("slots", "[1,2]"), "[1,2]");
  EXPECT_EQ(value("name", "7"), R"("7")");
  EXPECT_EQ(value("height", "high"), R"("high")");
  EXPECT_EQ(value("else", "7"), R"("7")");
  EXPECT_EQ(ToParameterValue(nullptr, "lift", "height", "7"), R"("7")");
}

}  // namespace
}  // namespace fleetpub::vda5050
