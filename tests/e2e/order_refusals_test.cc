// What a robot refuses of an order, in the words of its version, as the shell is told of it: the
// questions and refusals of VDA 5050 1.1–2.1 §6.6.4 and 3.0 §6.1.4, seen from fleet control.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

struct Place {
  std::string id;
  int x = 0;
  bool released = true;
  std::string more = "";  ///< members of the node
  std::string map = "map-1";
};

struct OrderText {
  std::string id = "o-1";
  int update = 0;
  int sequence = 0;  ///< of the first node
  std::vector<Place> places;
  std::string edge_more = "";

  [[nodiscard]] std::string Write(std::string_view version) const {
    std::string nodes;
    std::string edges;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Place& place = places[i];
      const int own = sequence + 2 * static_cast<int>(i);
      nodes += fmt::format(
          R"({}{{"nodeId":"{}","sequenceId":{},"released":{},"nodePosition":{{"x":{},"y":0,)"
          R"("mapId":"{}"}}{}}})",
          i == 0 ? "" : ",", place.id, own, place.released, place.x, place.map,
          place.more.empty() ? R"(,"actions":[])" : place.more);
      if (i == 0) continue;
      const std::string ends =
          version == "3.0.0"
              ? ""
              : fmt::format(R"(,"startNodeId":"{}","endNodeId":"{}")", places[i - 1].id, place.id);
      edges += fmt::format(R"({}{{"edgeId":"e{}","sequenceId":{},"released":{},"actions":[]{}{}}})",
                           i == 1 ? "" : ",", own - 1, own - 1, place.released, ends, edge_more);
    }
    return fmt::format(
        R"({{"version":"{}","orderId":"{}","orderUpdateId":{},"nodes":[{}],"edges":[{}]}})",
        version, id, update, nodes, edges);
  }
};

// Two places: the robot drives for minutes. With a horizon, it stands at n1 and waits.
const OrderText kLong{.places = {{"n1"}, {"n2", 500}}};
const OrderText kWaiting{.places = {{"n1"}, {"n2", 500, false}}};
const OrderText kShort{.places = {{"n1"}}};

struct Case {
  std::string name;
  std::vector<OrderText> before;        ///< taken, one after the other
  bool cancelled = false;               ///< then
  OrderText order;                      ///< refused
  std::vector<std::string> robot = {};  ///< options
  /// errorType in 1.1, 2.0, 2.1 and 3.0; "": it is not refused there.
  std::array<std::string, 4> errors;
};

std::vector<Case> Cases() {
  const std::string beep =
      R"(,"actions":[{"actionId":"a","actionType":"levitate","blockingType":"NONE"}])";
  return {
      {"OtherOrderActive",
       {kLong},
       false,
       {.id = "o-2", .places = {{"n1"}, {"n3", 5}}},
       {},
       {"orderUpdateError", "orderUpdateError", "orderUpdateError", "OTHER_ORDER_ACTIVE"}},
      {"LowerUpdateId",
       {{.update = 3, .places = {{"n1"}, {"n2", 500}}}},
       false,
       {.update = 2, .places = {{"n1"}, {"n2", 500}}},
       {},
       {"orderUpdateError", "orderUpdateError", "orderUpdateError", ""}},
      {"LowerUpdateIdOf30",
       {kWaiting, {.update = 3, .places = {{"n1"}, {"n2", 500}}}},
       false,
       {.update = 2, .places = {{"n1"}, {"n2", 500}}},
       {},
       {"orderUpdateError", "orderUpdateError", "orderUpdateError", "OUTDATED_ORDER_UPDATE"}},
      {"NewOrderAboveUpdateZero",
       {},
       false,
       {.update = 4, .places = {{"n1"}}},
       {},
       {"", "", "", "VALIDATION_FAILURE"}},
      {"OtherContentUnderTheSameId",
       {kLong},
       false,
       {.places = {{"n1"}, {"n3", 600}}},
       {},
       {"", "", "", "SAME_ORDER_UPDATE_ID"}},
      {"StartOutOfRange",
       {},
       false,
       {.places = {{"far", 900}, {"n2", 901}}},
       {"--position", "0,0,0,map-1", "--at", "n1"},
       {"noRouteError", "noRouteError", "noRouteError", "START_NODE_OUT_OF_RANGE"}},
      {"WrongStitch",
       {kWaiting},
       false,
       {.update = 1, .sequence = 2, .places = {{"n2", 500}, {"n3", 501}}},
       {},
       {"orderUpdateError", "orderUpdateError", "orderUpdateError", "VALIDATION_FAILURE"}},
      {"WrongContinuationOfAnOrderThatIsDone",
       {kShort},
       false,
       {.update = 1, .sequence = 4, .places = {{"n9"}, {"n3", 3}}},
       {},
       {"orderUpdateError", "orderUpdateError", "orderUpdateError", "VALIDATION_FAILURE"}},
      {"UpdateAfterCancel",
       {kLong},
       true,
       {.update = 1, .places = {{"n1"}, {"n2", 500}}},
       {},
       {"", "", "", "ORDER_UPDATE_FOLLOWING_CANCEL"}},
      {"UnknownAction",
       {},
       false,
       {.places = {{"n1", 0, true, beep}}},
       {},
       {"orderError", "orderError", "orderError", "INVALID_ORDER_ACTION"}},
      {"UnsupportedMember",
       {},
       false,
       {.places = {{"n1"}, {"n2", 5}}, .edge_more = R"(,"direction":"left")"},
       {},
       {"orderError", "orderError", "orderError", "UNSUPPORTED_PARAMETER"}},
      {"UnknownMap",
       {},
       false,
       {.places = {{"n1", 0, true, "", "moon"}}},
       {"--at", "n1"},
       {"", "", "orderError", "UNKNOWN_MAP_ID"}},
      {"ModeThatTakesNone",
       {},
       false,
       kShort,
       {"--mode", "MANUAL"},
       {"orderError", "orderError", "orderError", "MOBILE_ROBOT_NOT_AVAILABLE"}},
      {"MoreNodesThanFit",
       {},
       false,
       kLong,
       {"--order-limit", "1"},
       {"orderError", "orderError", "orderError", "INSUFFICIENT_MEMORY"}},
      {"NoWay",
       {},
       false,
       kLong,
       {"--unreachable", "n2"},
       {"noRouteError", "noRouteError", "noRouteError", "NO_ROUTE_TO_TARGET"}},
  };
}

constexpr std::array<const char*, 4> kVersions = {"1.1.0", "2.0.0", "2.1.0", "3.0.0"};

class OrderRefusals : public EndToEnd, public ::testing::WithParamInterface<std::size_t> {
 protected:
  [[nodiscard]] Finished Publish(const OrderText& order, const char* version,
                                 const char* wait_for) const {
    const std::string file = operator_.home().Write("order.json", order.Write(version)).string();
    return Fleetpub({"publish", "order", "KIT/0001", "-f", file, "--wait-for", wait_for, "-W",
                     "60s", "--no-check"});
  }
};

INSTANTIATE_TEST_SUITE_P(Versions, OrderRefusals, ::testing::Range<std::size_t>(0, 4));

TEST_P(OrderRefusals, AreToldInTheRobotsWords) {
  const char* version = kVersions.at(GetParam());
  for (const Case& each : Cases()) {
    SCOPED_TRACE(each.name);
    const std::string& error = each.errors.at(GetParam());
    if (error.empty()) continue;
    std::vector<std::string> options = {"KIT/0001", "--vda", version};
    options.insert(options.end(), each.robot.begin(), each.robot.end());
    const auto robot = Robot(options);
    for (const OrderText& order : each.before) {
      const Finished taken = Publish(order, version, "accepted");
      EXPECT_EQ(taken.exit_code, 0) << taken.output << taken.errors;
    }
    if (each.cancelled) {
      EXPECT_EQ(Fleetpub({"cancel", "KIT/0001", "--wait"}).exit_code, 0);
    }
    const Finished refused = Publish(each.order, version, "finished");
    EXPECT_EQ(refused.exit_code, 5) << refused.output << refused.errors;
    EXPECT_THAT(refused.output, AllOf(HasSubstr("order  REJECTED"), HasSubstr(error)));
  }
}

TEST_P(OrderRefusals, AreNoneOfTheSameMessageSentAgain) {
  const char* version = kVersions.at(GetParam());
  const auto robot = Robot({"KIT/0001", "--vda", version, "--state-interval", "1s"});
  EXPECT_EQ(Publish(kLong, version, "accepted").exit_code, 0);
  const Finished again = Publish(kLong, version, "accepted");
  EXPECT_EQ(again.exit_code, 0) << again.output;
  EXPECT_THAT(again.output, AllOf(HasSubstr("ACCEPTED"), Not(HasSubstr("REJECTED"))));
}

}  // namespace
}  // namespace fleetpub::testing
