// Zone sets, requests and responses, with a virtual robot of 3.0.
#include "simulator/permissions.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "simulator/conversation.h"

namespace fleetpub::simulator {
namespace {

using ::testing::HasSubstr;

using std::chrono::milliseconds;

constexpr std::string_view kHeader =
    R"("headerId":1,"timestamp":"2026-11-22T20:00:00.000Z","version":"3.0.0","manufacturer":"KIT",)"
    R"("serialNumber":"0001")";

constexpr std::string_view kSquare =
    R"([{"x":0,"y":0},{"x":10,"y":0},{"x":10,"y":10},{"x":0,"y":10}])";

class Permissions : public ::testing::Test {
 protected:
  void Hear(std::string_view topic, std::string_view members) {
    robot_.Hear(topic, fmt::format("{{{},{}}}", kHeader, members));
  }
  void HearZoneSet() {
    Hear("zoneSet", fmt::format(R"("zoneSet":{{"mapId":"map-1","zoneSetId":"zs","zones":[
        {{"zoneId":"z","zoneType":"RELEASE","releaseLossBehavior":"STOP","vertices":{}}}]}})",
                                kSquare));
  }
  void EnableZoneSet() { robot_.Do("enableZoneSet", {{"zoneSetId", R"("zs")"}}); }
  // From outside the zone to x, y.
  void HearOrder(double x, double y, std::string_view edge = "") {
    Hear("order", fmt::format(R"("orderId":"o-{}","orderUpdateId":0,"nodes":[
        {{"nodeId":"n1","sequenceId":0,"released":true,"actions":[],
          "nodePosition":{{"x":-5,"y":5,"mapId":"map-1"}}}},
        {{"nodeId":"n2","sequenceId":2,"released":true,"actions":[],
          "nodePosition":{{"x":{},"y":{},"mapId":"map-1"}}}}],
        "edges":[{{"edgeId":"e1","sequenceId":1,"released":true,"startNodeId":"n1",
          "endNodeId":"n2","actions":[]{}}}])",
                              ++orders_, x, y, edge));
  }
  void Answer(std::string_view id, std::string_view grant, std::string_view further = "") {
    Hear("responses", fmt::format(R"("responses":[{{"requestId":"{}","grantType":"{}"{}}}])", id,
                                  grant, further));
  }
  [[nodiscard]] std::string Status(const char* list = "zoneRequests") const {
    return robot_.At(fmt::format("/{}/0/requestStatus", list).c_str());
  }
  [[nodiscard]] bool IsUnderWay() const { return robot_.At("/nodeStates") != "[]"; }

  Conversation robot_{Settings{.order_time = milliseconds(1000)}};
  int orders_ = 0;
};

TEST_F(Permissions, AreAskedForZonesThatTheOrderLeadsInto) {
  HearZoneSet();
  EnableZoneSet();
  HearOrder(5, 5);
  EXPECT_EQ(robot_.At("/zoneRequests"),
            R"([{"requestId":"request-1","requestType":"ACCESS","zoneId":"z","zoneSetId":"zs",)"
            R"("requestStatus":"REQUESTED"}])");
  EXPECT_EQ(robot_.At("/driving"), "false");
}

TEST_F(Permissions, AreNotAskedForZonesBesideTheWayOrSetsThatAreNotEnabled) {
  HearZoneSet();
  HearOrder(5, 5);
  EXPECT_EQ(robot_.At("/zoneRequests"), "[]") << "not enabled";
  robot_.Wait(milliseconds(1000));
  EnableZoneSet();
  HearOrder(5, 15);
  EXPECT_EQ(robot_.At("/zoneRequests"), "[]") << "outside";
}

TEST_F(Permissions, AreAskedForCorridors) {
  HearOrder(5, 5, R"(,"corridor":{"leftWidth":1,"rightWidth":1,"releaseRequired":true,
      "releaseLossBehavior":"STOP"})");
  EXPECT_EQ(robot_.At("/edgeRequests/0/requestType"), R"("CORRIDOR")");
  EXPECT_EQ(robot_.At("/edgeRequests/0/edgeId"), R"("e1")");
  EXPECT_EQ(robot_.At("/edgeRequests/0/sequenceId"), "1");
}

TEST_F(Permissions, HoldTheOrderUntilTheyAreGranted) {
  HearZoneSet();
  EnableZoneSet();
  HearOrder(5, 5);
  robot_.Wait(milliseconds(5000));
  EXPECT_TRUE(IsUnderWay());
  Answer("request-1", "QUEUED");
  EXPECT_EQ(Status(), R"("REQUESTED")");
  Answer("request-1", "GRANTED");
  EXPECT_EQ(Status(), R"("GRANTED")");
  EXPECT_EQ(robot_.At("/driving"), "true");
  robot_.Wait(milliseconds(1000));
  EXPECT_FALSE(IsUnderWay());
  EXPECT_EQ(robot_.At("/zoneRequests"), "[]") << "they end with the order";
}

TEST_F(Permissions, CanBeRevoked) {
  HearZoneSet();
  EnableZoneSet();
  HearOrder(5, 5);
  Answer("request-1", "GRANTED");
  Answer("request-1", "REVOKED");
  EXPECT_EQ(Status(), R"("REVOKED")");
  robot_.Wait(milliseconds(5000));
  EXPECT_TRUE(IsUnderWay());
}

TEST_F(Permissions, ExpireWithTheirLease) {
  HearZoneSet();
  EnableZoneSet();
  HearOrder(5, 5);
  const auto expiry = base::WallTime::clock::now() + std::chrono::hours(1);
  Answer("request-1", "GRANTED",
         fmt::format(R"(,"leaseExpiry":"{}")", base::FormatTimestamp(expiry)));
  EXPECT_EQ(Status(), R"("GRANTED")");
  EXPECT_NE(robot_.robot().Due(), std::chrono::steady_clock::time_point::max());
}

TEST_F(Permissions, ThatNobodyAskedForAreAnError) {
  Answer("request-9", "GRANTED");
  EXPECT_THAT(robot_.At("/errors/0/errorDescription"), HasSubstr("no request request-9"));
  EXPECT_EQ(robot_.At("/errors/0/errorReferences/0"),
            R"({"referenceKey":"requestId","referenceValue":"request-9"})");
}

TEST_F(Permissions, TakeAZoneSetOnce) {
  HearZoneSet();
  EXPECT_EQ(robot_.At("/zoneSets"),
            R"([{"zoneSetId":"zs","mapId":"map-1","zoneSetStatus":"DISABLED"}])");
  HearZoneSet();
  EXPECT_EQ(robot_.At("/errors/0/errorType"), R"("DUPLICATE_ZONE_SET")");
}

TEST(ExpireLeases, EndsThoseWhoseTimeIsUp) {
  RobotState state;
  const base::WallTime now = *base::ParseDateTime("2026-11-22T20:00:00Z");
  const auto granted = [&](const char* id, std::chrono::seconds left) {
    state.requests.push_back(
        {.id = id, .type = "ACCESS", .status = "GRANTED", .lease_expiry = now + left});
  };
  granted("a", std::chrono::seconds(0));
  granted("b", std::chrono::seconds(1));
  EXPECT_EQ(NextExpiry(state), now);
  EXPECT_TRUE(ExpireLeases(state, now));
  EXPECT_EQ(state.requests[0].status, "EXPIRED");
  EXPECT_EQ(state.requests[1].status, "GRANTED");
  EXPECT_FALSE(state.MayDrive());
  EXPECT_FALSE(ExpireLeases(state, now));
}

}  // namespace
}  // namespace fleetpub::simulator
