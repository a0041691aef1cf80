#include <fmt/format.h>
#include <gmock/gmock.h>

#include <functional>

#include "base/json.h"
#include "vda5050/rules/text_rules.h"

namespace fleetpub::vda5050 {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

using Findings = std::vector<message::TextFinding>;

std::vector<std::string> ListLines(const Findings& findings) {
  std::vector<std::string> lines;
  for (const auto& [violation, is_error] : findings) {
    lines.push_back(fmt::format("{} {}: {}", is_error ? "error" : "warning", violation.path,
                                violation.message));
  }
  return lines;
}

base::JsonDocument Parsed(const std::string& text) {
  auto document = base::ParseJson(text);
  if (!document) throw std::runtime_error(document.error().message);
  return std::move(*document);
}

// Three nodes, the last of them in the horizon; each part can be given otherwise.
struct Parts {
  std::string id = "o-1";
  std::string sequence[5] = {"0", "1", "2", "3", "4"};
  bool released[5] = {true, true, true, false, false};
  std::string ends = R"("startNodeId":"n1","endNodeId":"n2")";
  std::string node_actions;
  std::string edge_actions;
};

std::string MakeOrder(const Parts& p) {
  return fmt::format(
      R"({{"orderId":"{}","nodes":[
        {{"nodeId":"n1","sequenceId":{},"released":{},"actions":[{}]}},
        {{"nodeId":"n2","sequenceId":{},"released":{},"actions":[]}},
        {{"nodeId":"n3","sequenceId":{},"released":{},"actions":[]}}],
      "edges":[
        {{"edgeId":"e1","sequenceId":{},"released":{},{},"actions":[{}]}},
        {{"edgeId":"e2","sequenceId":{},"released":{},"startNodeId":"n2","endNodeId":"n3","actions":[]}}]}})",
      p.id, p.sequence[0], p.released[0], p.node_actions, p.sequence[2], p.released[2],
      p.sequence[4], p.released[4], p.sequence[1], p.released[1], p.ends, p.edge_actions,
      p.sequence[3], p.released[3]);
}

std::vector<std::string> Check(const Parts& parts, Version version = Version::k300) {
  return ListLines(CheckOrder(Parsed(MakeOrder(parts)), version));
}

TEST(OrderRules, HaveNothingAgainstAnOrderWithBaseAndHorizon) {
  for (const Version version : kVersions) EXPECT_THAT(Check({}, version), IsEmpty());
}

TEST(OrderRules, WantOneSequenceOverNodesAndEdges) {
  Parts parts;
  parts.sequence[2] = "3";
  EXPECT_THAT(Check(parts), ElementsAre(StartsWith("error /nodes/1/sequenceId: sequenceId must be "
                                                   "2")));
}

TEST(OrderRules, LetASequenceBeginAnywhere) {
  Parts parts;
  for (int i = 0; i < 5; ++i) parts.sequence[i] = std::to_string(100 + i);
  EXPECT_THAT(Check(parts), IsEmpty());
}

TEST(OrderRules, WantTheFirstNodeReleased) {
  Parts parts;
  for (bool& released : parts.released) released = false;
  EXPECT_THAT(Check(parts), ElementsAre(StartsWith("error /nodes/0/released")));
}

TEST(OrderRules, WantTheBaseBeforeTheHorizon) {
  Parts parts;
  parts.released[1] = parts.released[2] = false;
  parts.released[3] = parts.released[4] = true;
  EXPECT_THAT(Check(parts), Contains(StartsWith("error /edges/1/released: released behind")));
}

TEST(OrderRules, WantTheBaseToEndWithANode) {
  Parts parts;
  parts.released[3] = true;
  EXPECT_THAT(Check(parts), ElementsAre(HasSubstr("the base ends with a node")));
}

TEST(OrderRules, WantEachEdgeBetweenItsNodes) {
  Parts parts;
  parts.ends = R"("startNodeId":"n1","endNodeId":"n9")";
  EXPECT_THAT(Check(parts), ElementsAre(StartsWith("error /edges/0/endNodeId: endNodeId is 'n9'")));
}

TEST(OrderRules, WantOneEdgeFewerThanNodes) {
  const auto order = Parsed(R"({"orderId":"o","nodes":[{"nodeId":"n1","sequenceId":0,
      "released":true,"actions":[]}],"edges":[{"edgeId":"e"}]})");
  EXPECT_THAT(ListLines(CheckOrder(order, Version::k210)),
              ElementsAre("error /edges: 1 node are joined by 0 edges, not by 1"));
}

TEST(OrderRules, WantANodeAndAnId) {
  const auto order = Parsed(R"({"orderId":"","nodes":[],"edges":[]})");
  EXPECT_THAT(ListLines(CheckOrder(order, Version::k210)),
              ElementsAre(StartsWith("error /orderId"), StartsWith("error /nodes")));
}

TEST(OrderRules, WarnOfUnusualCharactersInEveryId) {
  EXPECT_THAT(Check({.id = "o 1"}), ElementsAre(StartsWith("warning /orderId: ")));
  const auto order =
      Parsed(R"({"orderId":"1","nodes":[{"nodeId":"Süd","sequenceId":0,"released":true},
      {"nodeId":"n2","sequenceId":2,"released":true}],"edges":[{"edgeId":"a/b","sequenceId":1,
      "released":true,"startNodeId":"Süd","endNodeId":"n2"}]})");
  EXPECT_THAT(ListLines(CheckOrder(order, Version::k210)),
              ElementsAre(StartsWith("warning /nodes/0/nodeId: "),
                          StartsWith("warning /edges/0/edgeId: ")));
  const auto zones = Parsed(R"({"zoneSet":{"zoneSetId":"z+","zones":[{"zoneId":"zone 1",
      "vertices":[{"x":0,"y":0},{"x":1,"y":0},{"x":0,"y":1}]
}]
}
})");
  EXPECT_THAT(ListLines(CheckZoneSet(zones)),
              ElementsAre(StartsWith("warning /zoneSet/zoneSetId: "),
                          StartsWith("warning /zoneSet/zones/0/zoneId: ")));
}

TEST(OrderRules, WantActionIdsOnceInTheWholeOrder) {
  Parts parts;
  parts.node_actions = parts.edge_actions =
      R"({"actionId":"a","actionType":"beep","blockingType":"NONE"})";
  EXPECT_THAT(Check(parts), ElementsAre(HasSubstr("actionId 'a' is used by two actions")));
}

TEST(OrderRules, KnowWhereAnActionMayStand) {
  Parts parts;
  parts.edge_actions = R"({"actionId":"a","actionType":"startCharging","blockingType":"HARD"})";
  EXPECT_THAT(Check(parts), ElementsAre(HasSubstr("startCharging is not an action for an edge")));
  parts.edge_actions = "";
  parts.node_actions = R"({"actionId":"a","actionType":"cancelOrder","blockingType":"HARD"})";
  EXPECT_THAT(Check(parts), ElementsAre(HasSubstr("cancelOrder is not an action for a node")));
}

TEST(OrderRules, CheckTheParametersOfActions) {
  Parts parts;
  parts.node_actions = R"({"actionId":"a","actionType":"pick","blockingType":"HARD"})";
  EXPECT_THAT(Check(parts, Version::k210), ElementsAre(HasSubstr("pick needs the parameters")));
  EXPECT_THAT(Check(parts, Version::k300), IsEmpty()) << "from 3.0 they are optional";
}

// ── zone sets ──

std::vector<std::string> CheckZones(const std::string& zones) {
  return ListLines(CheckZoneSet(
      Parsed(fmt::format(R"({{"zoneSet":{{"mapId":"m","zoneSetId":"z","zones":[{}]}}}})", zones))));
}

constexpr std::string_view kTriangle =
    R"({{"zoneId":"{}","vertices":[{{"x":0,"y":0}},{{"x":1,"y":0}},{{"x":{},"y":0.5}}]}})";

TEST(ZoneRules, WantPolygonsAndUniqueIds) {
  EXPECT_THAT(CheckZones(fmt::format(kTriangle, "a", 0.5)), IsEmpty());
  EXPECT_THAT(CheckZones(fmt::format(kTriangle, "a", 0.5) + "," + fmt::format(kTriangle, "a", 2)),
              ElementsAre(StartsWith("error /zoneSet/zones/1/zoneId: zoneId 'a' is used by two")));
  EXPECT_THAT(
      CheckZones(R"({"zoneId":"a","vertices":[{"x":0,"y":0},{"x":1,"y":0},{"x":1,"y":0}]})"),
      ElementsAre(HasSubstr("at least three vertices")));
}

// ── responses ──

std::vector<std::string> CheckAnswers(const std::string& responses) {
  const auto now = *base::ParseDateTime("2026-11-22T20:00:00Z");
  return ListLines(CheckResponses(Parsed(fmt::format(R"({{"responses":[{}]}})", responses)), now));
}

TEST(ResponseRules, AllowALeaseOnlyWithGranted) {
  EXPECT_THAT(CheckAnswers(R"({"requestId":"r","grantType":"GRANTED",
      "leaseExpiry":"2026-11-22T20:00:30Z"})"),
              IsEmpty());
  EXPECT_THAT(CheckAnswers(R"({"requestId":"r","grantType":"QUEUED",
      "leaseExpiry":"2026-11-22T20:00:30Z"})"),
              ElementsAre(HasSubstr("leaseExpiry belongs to GRANTED only, not to QUEUED")));
}

TEST(ResponseRules, WantALeaseThatLiesAhead) {
  EXPECT_THAT(CheckAnswers(R"({"requestId":"r","grantType":"GRANTED",
      "leaseExpiry":"2026-11-22T19:59:59Z"})"),
              ElementsAre(HasSubstr("has passed")));
  EXPECT_THAT(CheckAnswers(R"({"requestId":"r","grantType":"GRANTED","leaseExpiry":"soon"})"),
              ElementsAre(HasSubstr("must be a time")));
}

TEST(ResponseRules, WantEachRequestOnce) {
  EXPECT_THAT(CheckAnswers(""), ElementsAre(HasSubstr("at least one response")));
  EXPECT_THAT(CheckAnswers(R"({"requestId":"r","grantType":"QUEUED"},
      {"requestId":"r","grantType":"GRANTED"})"),
              ElementsAre(HasSubstr("answered twice")));
  EXPECT_THAT(CheckAnswers(R"({"requestId":"","grantType":"QUEUED"})"),
              ElementsAre(HasSubstr("requestId must not be empty")));
}

}  // namespace
}  // namespace fleetpub::vda5050
