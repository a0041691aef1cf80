// Each finding that `layout check` makes (but for the actions of versions and factsheets, see app).
#include "layout/check.h"

#include <gmock/gmock.h>

#include "layout/layouts.h"

namespace fleetpub::layout {
namespace {

using testing::EdgeText;
using testing::FileText;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::LayoutText;
using testing::NodeText;
using Level = LayoutFinding::Level;

std::vector<LayoutFinding> Check(const std::string& text) {
  ReadSite read = testing::Read(text);
  CheckElements(read.site, read.findings);
  CheckWays(read.site, read.findings);
  return read.findings;
}

// Two nodes with edges there and back.
std::string Pair(std::string_view there = "", std::string_view node = R"({"vehicleTypeId":"T"})",
                 std::string_view stations = "") {
  return FileText({NodeText("a", 0, 0, node), NodeText("b", 5, 0)},
                  {EdgeText("a", "b", there), EdgeText("b", "a")}, stations);
}

std::string Curve(std::string_view knots, std::string_view points, std::string_view degree = "1") {
  return fmt::format(R"("trajectory":{{"degree":{},"knotVector":[{}],"controlPoints":[{}]}})",
                     degree, knots, points);
}
constexpr std::string_view kTwoPoints = R"({"x":0,"y":0},{"x":5,"y":0})";
constexpr std::string_view kThreePoints = R"({"x":0,"y":0},{"x":2,"y":1},{"x":5,"y":0})";

std::string WithActions(std::string_view actions) {
  return fmt::format(R"({{"vehicleTypeId":"T","actions":[{}]}})", actions);
}

TEST(LayoutCheck, FindsNothingInWhatIsRight) { EXPECT_THAT(Check(Pair()), IsEmpty()); }

struct Case {
  std::string_view name;
  std::string text;
  Level level;
  std::string_view place;
  std::string_view fact;  ///< a part of the text
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class LayoutFindingIs : public ::testing::TestWithParam<Case> {};

TEST_P(LayoutFindingIs, Told) {
  const Case& c = GetParam();
  std::string all;
  bool is_told = false;
  for (const auto& [level, place, text] : Check(c.text)) {
    all += place + ": " + text + "\n";
    is_told =
        is_told || (level == c.level && place == c.place && text.find(c.fact) != std::string::npos);
  }
  EXPECT_TRUE(is_told) << c.name << "\n" << all;
}

const std::string kEdge = "/layouts/0/edges/0";
const std::string kProperty = kEdge + "/vehicleTypeEdgeProperties/0";
const std::string kNodeProperty = "/layouts/0/nodes/0/vehicleTypeNodeProperties/0";
const std::string kKnots = kProperty + "/trajectory/knotVector";
const std::string kStation = R"({"stationId":"s","interactionNodeIds":["a"]})";

std::string Replaced(std::string text, std::string_view from, std::string_view to) {
  const auto at = text.find(from);
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

std::vector<Case> Errors() {
  const auto error = [](std::string_view name, std::string text, std::string_view place,
                        std::string_view fact) {
    return Case{name, std::move(text), Level::kError, place, fact};
  };
  static const std::string two_layouts =
      FileText({LayoutText({NodeText("a", 0, 0)}, {}), LayoutText({NodeText("b", 0, 0)}, {})});
  static const std::string foreign_start =
      FileText({LayoutText({NodeText("a", 0, 0)}, {EdgeText("b", "a")}),
                LayoutText({NodeText("b", 1, 0)}, {}, "", "other")});
  static const std::string point = kProperty + "/trajectory/controlPoints/1/weight";
  static const std::string start = kEdge + "/startNodeId";
  static const std::string end = kEdge + "/endNodeId";
  static const std::string theta = kNodeProperty + "/theta";
  static const std::string orientation = kProperty + "/vehicleOrientation";
  static const std::string degree = kProperty + "/trajectory/degree";
  static const std::string points = kProperty + "/trajectory/controlPoints";
  static const std::string speed = kProperty + "/maxSpeed";
  static const std::string action = kNodeProperty + "/actions/0";
  static const std::string key = action + "/actionParameters/1/key";
  return {
      error("layoutId twice", two_layouts, "/layouts/1/layoutId", "hall"),
      error("nodeId twice", FileText({NodeText("a", 0, 0), NodeText("a", 1, 0)}, {}),
            "/layouts/0/nodes/1/nodeId", "another"),
      error("edgeId twice",
            FileText({NodeText("a", 0, 0), NodeText("b", 1, 0)},
                     {EdgeText("a", "b"), EdgeText("a", "b")}),
            "/layouts/0/edges/1/edgeId", "another"),
      error("stationId twice", Pair("", R"({"vehicleTypeId":"T"})", kStation + "," + kStation),
            "/layouts/0/stations/1/stationId", "another"),
      error("start in another layout", foreign_start, start, "another layout"),
      error("unknown end", FileText({NodeText("a", 0, 0)}, {EdgeText("a", "x")}), end, "'x'"),
      error("unknown interaction node",
            Pair("", R"({"vehicleTypeId":"T"})", R"({"stationId":"s","interactionNodeIds":["x"]})"),
            "/layouts/0/stations/0/interactionNodeIds", "'x'"),
      error("no interaction node",
            Pair("", R"({"vehicleTypeId":"T"})", R"({"stationId":"s","interactionNodeIds":[]})"),
            "/layouts/0/stations/0/interactionNodeIds", "empty"),
      error("no properties", Pair("", ""), "/layouts/0/nodes/0/vehicleTypeNodeProperties", "empty"),
      error("type twice", Pair("", R"({"vehicleTypeId":"T"},{"vehicleTypeId":"T"})"),
            "/layouts/0/nodes/0/vehicleTypeNodeProperties/1", "second"),
      error("no mapId", Replaced(Pair(), R"("mapId":"m",)", ""), "/layouts/0/nodes/0", "mapId"),
      error("theta in degrees", Pair("", R"({"vehicleTypeId":"T","theta":90})"), theta, "radians"),
      error("orientation", Pair(R"("vehicleOrientation":3.2)"), orientation, "π"),
      error("too few knots", Pair(Curve("0,0,1", kTwoPoints)), kKnots, "3 knots"),
      error("falling knots",
            Pair(Curve("0,0,0.6,0.5,1,1", R"({"x":0,"y":0},{"x":1,"y":0},)"
                                          R"({"x":2,"y":0},{"x":5,"y":0})")),
            kKnots, "fall"),
      error("knots beyond 1", Pair(Curve("0,0,2,2", kTwoPoints)), kKnots, "within"),
      error("not clamped", Pair(Curve("0,0.2,1,1", kTwoPoints)), kKnots, "clamped"),
      error("too many knots alike",
            Pair(Curve("0,0,0.5,0.5,1,1", R"({"x":0,"y":0},{"x":1,"y":0},)"
                                          R"({"x":2,"y":0},{"x":5,"y":0})")),
            kKnots, "more than"),
      error("too few points", Pair(Curve("0,0,0,1,1,1", kTwoPoints, "2")), points, "needs 3"),
      error("degree 1.5", Pair(Curve("0,0,1,1", kTwoPoints, "1.5")), degree, "whole"),
      error("degree 0", Pair(Curve("0,1", kTwoPoints, "0")), degree, "whole"),
      error("weight 0", Pair(Curve("0,0,1,1", R"({"x":0,"y":0},{"x":5,"y":0,"weight":0})")), point,
            "weight"),
      error("parameter twice",
            Pair("", WithActions(R"({"actionType":"beep","blockingType":"NONE",)"
                                 R"("requirementType":"OPTIONAL","actionParameters":)"
                                 R"([{"key":"k","value":"1"},{"key":"k","value":"2"}]})")),
            key, "twice"),
      error("no requirementType",
            Pair("", WithActions(R"({"actionType":"beep","blockingType":"NONE"})")), action,
            "requirementType"),
      error("unknown requirementType",
            Pair("", WithActions(R"({"actionType":"beep","blockingType":"NONE",)"
                                 R"("requirementType":"MAYBE"})")),
            "/layouts/0/nodes/0/vehicleTypeNodeProperties/0/actions/0/requirementType", "MAYBE"),
      error("negative speed", Pair(R"("maxSpeed":-1)"), speed, "negative"),
      error("huge number", Replaced(Pair(), R"("x":5)", R"("x":1e300)"),
            "/layouts/0/nodes/1/nodePosition/x", "too large"),
  };
}

std::vector<Case> Warnings() {
  const auto warning = [](std::string_view name, std::string text, std::string_view place,
                          std::string_view fact) {
    return Case{name, std::move(text), Level::kWarning, place, fact};
  };
  static const std::string load = kProperty + "/loadRestriction";
  static const std::string sets = load + "/loadSetNames";
  static const std::string actions = kNodeProperty + "/actions";
  static const std::string speed = kProperty + "/maxSpeed";
  const auto nodes = [](double x) { return std::vector{NodeText("a", 0, 0), NodeText("b", x, 0)}; };
  static const std::string fixed =
      R"("vehicleOrientation":0,"rotationAtStartNodeAllowed":"NONE","rotationAtEndNodeAllowed":"NONE")";
  const std::string required =
      R"({"actionType":"beep","blockingType":"NONE","requirementType":"REQUIRED"})";
  return {
      warning("node is not for the type", Pair("", R"({"vehicleTypeId":"U"})"), kEdge, "node a"),
      warning("no load flag", Pair(R"("loadRestriction":{"loaded":false,"unloaded":false})"), load,
              "neither"),
      warning("load sets unloaded",
              Pair(R"("loadRestriction":{"loaded":false,"unloaded":true,"loadSetNames":["x"]})"),
              sets, "nothing"),
      warning("several REQUIRED", Pair("", WithActions(required + "," + required)), actions,
              "2 actions"),
      warning("trajectory off", Pair(Curve("0,0,1,1", R"({"x":0,"y":0},{"x":5,"y":0.1})")), kEdge,
              "0.10 m off node b"),
      warning("start is end", FileText(nodes(5), {EdgeText("a", "a")}), kEdge, "starts and ends"),
      warning("no length", FileText(nodes(0), {EdgeText("a", "b")}), kEdge, "no length"),
      warning("one place", FileText(nodes(0), {EdgeText("a", "b")}), "/layouts/0/nodes/1",
              "node a"),
      warning(
          "two maps",
          FileText({NodeText("a", 0, 0), NodeText("b", 1, 0, R"({"vehicleTypeId":"T"})", "n")}, {}),
          "/layouts/0", "m, n"),
      warning("alike edges", FileText(nodes(5), {EdgeText("a", "b"), EdgeText("a", "b", "", "2")}),
              "/layouts/0/edges/1", "a-b"),
      warning("never left", FileText(nodes(5), {EdgeText("a", "b")}), "/layouts/0/nodes/1",
              "leave"),
      warning("never entered", FileText(nodes(5), {EdgeText("a", "b")}), "/layouts/0/nodes/0",
              "come"),
      warning("parts", FileText(nodes(5), {EdgeText("a", "b")}), "", "2 parts"),
      warning("parts of a load", Pair(R"("loadRestriction":{"loaded":true,"unloaded":false})"), "",
              "unloaded"),
      warning("no edge can follow",
              FileText(nodes(5), {EdgeText("a", "b", fixed), EdgeText("b", "a", fixed)}), kEdge,
              "no edge can follow"),
      warning(
          "cannot turn as the node wants it",
          FileText({NodeText("a", 0, 0), NodeText("b", 5, 0, R"({"vehicleTypeId":"T","theta":1})")},
                   {EdgeText("a", "b", fixed), EdgeText("b", "a")}),
          kEdge, "as the node wants"),
      warning("station without actions", Pair("", R"({"vehicleTypeId":"T"})", kStation),
              "/layouts/0/stations/0", "no node"),
      warning("station elsewhere",
              FileText({LayoutText({NodeText("a", 0, 0)}, {}),
                        LayoutText({NodeText("b", 1, 0)}, {}, kStation, "other")}),
              "/layouts/1/stations/0", "another layout"),
      warning("speed 0", Pair(R"("maxSpeed":0)"), speed, "0"),
      warning("odd id", FileText({NodeText("a b", 0, 0)}, {}), "/layouts/0/nodes/0/nodeId", "a b"),
      warning("timestamp", Replaced(Pair(), "2026-04-15T", "15.4.2026 "),
              "/metaInformation/exportTimestamp", "15.4.2026"),
      warning("height as text",
              Pair("", R"({"vehicleTypeId":"T"})",
                   R"({"stationId":"s","interactionNodeIds":["a"],"stationHeight":"0.5"})"),
              "/layouts/0/stations/0/stationHeight", "quotation"),
      warning("unknown member", Pair(R"("colour":"red")"),
              "/layouts/0/edges/0/vehicleTypeEdgeProperties/0/colour", "colour"),
      warning("parameter as number",
              Pair("", WithActions(R"({"actionType":"beep","blockingType":"NONE",)"
                                   R"("requirementType":"OPTIONAL","actionParameters":)"
                                   R"([{"key":"k","value":1}]})")),
              "/layouts/0/nodes/0/vehicleTypeNodeProperties/0/actions/0/actionParameters/0/value",
              "number"),
      warning("other version", Replaced(Pair(), "1.0.0", "7.0.0"), "/metaInformation/lifVersion",
              "7.0.0"),
  };
}

INSTANTIATE_TEST_SUITE_P(Errors, LayoutFindingIs, ::testing::ValuesIn(Errors()));
INSTANTIATE_TEST_SUITE_P(Warnings, LayoutFindingIs, ::testing::ValuesIn(Warnings()));

TEST(LayoutCheck, TellsAnUnknownMemberOnceWithItsCount) {
  const auto findings =
      Check(FileText({NodeText("a", 0, 0), NodeText("b", 5, 0)},
                     {EdgeText("a", "b", R"("x":1)"), EdgeText("b", "a", R"("x":1)")}));
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_THAT(findings.front().text, HasSubstr("1 more"));
}

}  // namespace
}  // namespace fleetpub::layout
