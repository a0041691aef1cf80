// Each fault shows, and does not show where nobody asked for it.
#include <fstream>
#include <functional>
#include <iterator>
#include <set>

#include "simulator/conversation.h"
#include "simulator/faults.h"
#include "simulator/route.h"

namespace fleetpub::simulator {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using vda5050::Version;

constexpr auto kV3 = Version::k300;

// A robot with these settings, what it is told, and what is seen then.
class Play {
 public:
  explicit Play(const Settings& settings) : version_(settings.version), robot_(settings) {}

  Play& Order(const Route& route) {
    robot_.Hear("order", Write(route, version_));
    return *this;
  }
  Play& Wait(milliseconds time) {
    // In steps, as a runner calls it.
    for (; time.count() > 0; time -= milliseconds(100)) {
      robot_.Wait(std::min(time, milliseconds(100)));
    }
    return *this;
  }
  Play& Do(std::string_view type, std::vector<vda5050::Parameter> parameters = {}) {
    last_ = robot_.Do(type, std::move(parameters));
    return *this;
  }
  [[nodiscard]] std::string At(const char* pointer) const { return robot_.At(pointer); }
  [[nodiscard]] std::string Of(const std::string& id) const { return robot_.Of(id); }
  /// Of the last instant action.
  [[nodiscard]] std::string Done() const { return robot_.Of(last_); }
  [[nodiscard]] bool Has(const char* pointer, const std::string& value) const {
    return robot_.At(pointer) == value;
  }
  [[nodiscard]] std::size_t Errors() const { return robot_.Last("state")["errors"].Size(); }
  /// Whether some state was so.
  [[nodiscard]] bool Ever(const std::function<bool(const base::JsonValue&)>& is_so) const {
    for (const Utterance& one : robot_.said()) {
      if (one.topic == "state" && is_so(*base::ParseJson(one.payload))) return true;
    }
    return false;
  }
  [[nodiscard]] Conversation& robot() { return robot_; }

 private:
  Version version_;
  Conversation robot_;
  std::string last_;
};

const std::vector<Stop> kWay = {
    {"n1", true, "", At(0, 0)}, {"n2", true, "", At(4, 0)}, {"n3", true, "", At(8, 0)}};
const std::vector<Stop> kWithHorizon = {{"n1"}, {"n2"}, {"n3", false, Act("h", "HARD")}};

Play Way(const Settings& s, milliseconds time) {
  Play play(s);
  play.Order({.stops = kWay}).Wait(time);
  return play;
}
Play Horizon(const Settings& s, milliseconds time) {
  Play play(s);
  play.Order({.stops = kWithHorizon}).Wait(time);
  return play;
}
// Takes what a conforming robot would refuse.
bool Takes(Play play, const Route& route) {
  play.Order(route);
  return play.Has("/orderId", '"' + route.id + '"') &&
         play.Has("/orderUpdateId", std::to_string(route.update));
}
bool Takes(const Settings& s, const Route& route) { return Takes(Play(s), route); }
Play AtNode(const Settings& s, const std::string& actions) {
  Play play(s);
  play.Order({.stops = {{"n1", true, actions}, {"n2"}}});
  return play;
}
// Before anything moves.
Play Refused(const Settings& s) {
  Play play(s);
  play.Order({.stops = {{"n1", true, Act("x", "HARD", "dance")}}});
  return play;
}
Settings Manual(Settings s) {
  s.operating_mode = "MANUAL";
  return s;
}
Settings Failing(Settings s) {
  s.fail.insert("detectObject");
  return s;
}
Settings Showing(Settings s) {
  s.visualization_interval = seconds(1);
  return s;
}
bool IsRetained(const Settings& s, std::string_view topic) {
  Play play(s);
  for (const Utterance& one : play.robot().said()) {
    if (one.topic == topic) return one.retained;
  }
  return false;
}

struct FaultCase {
  Fault fault;
  Version version;
  std::function<bool(const Settings&)> shows;
};

// clang-format off
std::vector<FaultCase> DrivingFaults() {
  const std::string turned = R"(,"theta":3)";
  const std::string slow = R"(,"maxSpeed":0.1,"maximumSpeed":0.1)";
  return {
      {Fault::kStuck, kV3, [](const Settings& s) {
         return Way(s, seconds(60)).Has("/mobileRobotPosition/x", "2.0"); }},
      {Fault::kDeviation, kV3, [](const Settings& s) {
         return Way(s, seconds(60)).Has("/mobileRobotPosition/y", "2.0"); }},
      {Fault::kWrongLastNode, kV3, [](const Settings& s) {
         return Way(s, seconds(60)).Has("/lastNodeId", R"("n1")"); }},
      {Fault::kEnterHorizon, kV3, [](const Settings& s) {
         return Horizon(s, seconds(60)).Has("/lastNodeId", R"("n3")"); }},
      {Fault::kSkipTheta, kV3, [turned](const Settings& s) {
         Play play(s);
         play.Order({.stops = {{"n1", true, "", At(0, 0)}, {"n2", true, "", At(1, 0, turned)}}});
         return play.Wait(seconds(9)).Has("/mobileRobotPosition/theta", "0.0"); }},
      {Fault::kIgnoreSpeedLimit, kV3, [slow](const Settings& s) {
         Play play(s);
         play.Order({.stops = {{"n1", true, "", At(0, 0)}, {"n2", true, "", At(1, 0), "", slow}}});
         return play.Wait(seconds(2)).Has("/nodeStates", "[]"); }},
      {Fault::kStopAtNodes, kV3, [](const Settings& s) {
         return Way(s, milliseconds(4100)).Has("/driving", "false"); }},
      {Fault::kNeverDriving, kV3, [](const Settings& s) {
         return Way(s, seconds(1)).Has("/driving", "false"); }},
      {Fault::kNodeBeforeEdge, kV3, [](const Settings& s) {
         return Way(s, seconds(60)).Ever([](const auto& state) {
           return state["nodeStates"].Size() < state["edgeStates"].Size(); }); }},
      {Fault::kListFirstNode, kV3, [](const Settings& s) {
         return Way(s, seconds(60)).Ever([](const auto& state) {
           return state["nodeStates"].Size() == 3; }); }},
  };
}

std::vector<FaultCase> OrderFaults() {
  const Route update = {"o1", 1, {{"n2"}, {"m3"}}, 2};
  return {
      {Fault::kIgnoreUpdates, kV3, [=](const Settings& s) {
         return !Takes(Horizon(s, seconds(0)), update); }},
      {Fault::kAppendHorizon, kV3, [=](const Settings& s) {
         Play play = Horizon(s, seconds(0));
         return play.Order(update).Has("/nodeStates/1/nodeId", R"("n3")"); }},
      {Fault::kDropHorizon, kV3, [](const Settings& s) {
         return Horizon(s, seconds(9)).Has("/nodeStates", "[]"); }},
      {Fault::kOmitHorizonActions, kV3, [](const Settings& s) {
         return Horizon(s, seconds(0)).Of("h").empty(); }},
      {Fault::kRerunStitched, kV3, [](const Settings& s) {
         Play play = AtNode(s, Act("a", "HARD"));
         play.Wait(seconds(5)).Order({"o1", 1, {{"n2", true, Act("b", "HARD")}}, 2});
         return !play.Of("b").empty(); }},
      {Fault::kTakeAnyStitch, kV3, [](const Settings& s) {
         return Takes(Horizon(s, seconds(0)), {"o1", 1, {{"n7"}, {"n8"}}, 2}); }},
      {Fault::kTakeAnyStart, kV3, [](const Settings& s) {
         return Takes(Way(s, seconds(60)), {"o2", 0, {{"n7"}, {"n8"}}}); }},
      {Fault::kExactStart, kV3, [](const Settings& s) {
         return !Takes(Way(s, seconds(60)), {"o2", 0, {{"n9", true, "", At(6, 0,
             R"(,"allowedDeviationXY":{"a":3,"b":3,"theta":0})")}}}); }},
      {Fault::kTakeWhileBusy, kV3, [](const Settings& s) {
         return Takes(Way(s, seconds(0)), {"o2", 0, {{"n1"}, {"n8"}}}); }},
      {Fault::kTakeAnyUpdateId, kV3, [](const Settings& s) {
         return Takes(s, {"o2", 5, {{"n1"}, {"n8"}}}); }},
      {Fault::kTakeUnsupported, kV3, [](const Settings& s) {
         return Takes(s, {"o2", 0, {{"n1"}, {"n8", true, "", "", "", R"(,"direction":"left")"}}}); }},
      {Fault::kTakeUnknownActions, kV3, [](const Settings& s) {
         return Takes(s, {"o2", 0, {{"n1", true, Act("x", "HARD", "dance")}}}); }},
      {Fault::kTakeUnknownMaps, kV3, [](const Settings& s) {
         return Takes(s, {"o2", 0, {{"n1", true, "", At(0, 0, "", "moon")}}}); }},
      {Fault::kTakeAfterCancel, kV3, [](const Settings& s) {
         Play play = Horizon(s, seconds(0));
         play.Do("cancelOrder");
         return Takes(std::move(play), {"o1", 1, {{"n1"}, {"m3"}}}); }},
      {Fault::kTakeInAnyMode, kV3, [](const Settings& s) {
         return Takes(Manual(s), {"o2", 0, {{"n1"}}}); }},
      {Fault::kTakeMalformed, kV3, [](const Settings& s) {
         return Takes(s, {"o2", 0, {{"n1"}, {"n2", false}, {"n3"}}}); }},
      {Fault::kTakeBaseBehindHorizon, kV3, [](const Settings& s) {
         return Takes(s, {"o2", 0, {{"n1"}, {"n2", false}, {"n3"}}}); }},
      {Fault::kTakeSequenceGaps, kV3, [](const Settings& s) {
         Play play(s);
         std::string order = Write({"o2", 0, {{"n1"}, {"n2"}}}, kV3);
         order.replace(order.find(R"("sequenceId":2)"), 14, R"("sequenceId":6)");
         play.robot().Hear("order", order);
         return play.Has("/orderId", R"("o2")"); }},
      {Fault::kRefuseResend, Version::k210, [](const Settings& s) {
         return Way(s, seconds(0)).Order({.stops = kWay}).Errors() > 0; }},
      {Fault::kRefuseResend, kV3, [](const Settings& s) {
         return Way(s, seconds(0)).Order({.stops = kWay}).Errors() > 0; }},
      {Fault::kSilentRejection, kV3, [](const Settings& s) { return Refused(s).Errors() == 0; }},
      {Fault::kBriefRejection, kV3, [](const Settings& s) {
         return Refused(s).Do("stateRequest").Errors() == 0; }},
      {Fault::kOrderErrorForAll, kV3, [](const Settings& s) {
         return Refused(s).Has("/errors/0/errorType", R"("orderError")"); }},
      {Fault::kNoReferences, kV3, [](const Settings& s) {
         return Refused(s).Has("/errors/0/errorReferences", "[]"); }},
      {Fault::kWipeOrderAtEnd, kV3, [](const Settings& s) {
         return Way(s, seconds(60)).Has("/orderId", R"("")"); }},
      {Fault::kNoEmptyOrder, kV3, [](const Settings& s) { return !Takes(s, {"o2", 0, {{"n1"}}}); }},
  };
}

std::vector<FaultCase> ActionFaults() {
  const std::string retriable = R"(,"retriable":true)";
  return {
      {Fault::kHardInParallel, kV3, [](const Settings& s) {
         return AtNode(s, Act("a", "NONE") + "," + Act("b", "HARD")).Of("b") == "RUNNING"; }},
      {Fault::kHardFirst, kV3, [](const Settings& s) {
         return AtNode(s, Act("a", "NONE") + "," + Act("b", "HARD")).Of("a") == "WAITING"; }},
      {Fault::kSingleInParallel, kV3, [](const Settings& s) {
         return AtNode(s, Act("a", "NONE") + "," + Act("b", "SINGLE")).Of("b") == "RUNNING"; }},
      {Fault::kActionsNeverStop, kV3, [](const Settings& s) {
         return AtNode(s, Act("a", "HARD")).Has("/driving", "true"); }},
      {Fault::kSoftOneByOne, kV3, [](const Settings& s) {
         return AtNode(s, Act("a", "SOFT") + "," + Act("b", "SOFT")).Of("b") == "WAITING"; }},
      {Fault::kNoneStops, kV3, [](const Settings& s) {
         return AtNode(s, Act("a", "NONE")).Has("/driving", "false"); }},
      {Fault::kSingleStops, kV3, [](const Settings& s) {
         return AtNode(s, Act("a", "SINGLE")).Has("/driving", "false"); }},
      {Fault::kEdgeActionsRunOn, kV3, [](Settings s) {
         s.delay = seconds(5);
         Play play(s);
         play.Order({.stops = {{"n1"}, {"n2", true, "", "", Act("e", "NONE")}}});
         return play.Wait(seconds(3)).Of("e") == "RUNNING"; }},
      {Fault::kEdgeActionsEarly, kV3, [](const Settings& s) {
         Play play(s);
         play.Order({.stops = {{"n1", true, Act("a", "HARD")},
                               {"n2", true, "", "", Act("e", "NONE")}}});
         return play.Of("e") == "RUNNING"; }},
      {Fault::kNoLoads, kV3, [](const Settings& s) {
         return AtNode(s, Act("a", "HARD", "pick")).Wait(seconds(1)).Has("/loads", "[]"); }},
      {Fault::kFailureWipesOrder, kV3, [](const Settings& s) {
         return AtNode(Failing(s), Act("a", "HARD")).Wait(seconds(1)).Has("/nodeStates", "[]"); }},
      {Fault::kNeverRetriable, kV3, [=](const Settings& s) {
         return AtNode(Failing(s), Act("a", "HARD", "detectObject", retriable))
             .Wait(seconds(1)).Of("a").substr(0, 6) == "FAILED"; }},
      {Fault::kCancelWipesOrderId, kV3, [](const Settings& s) {
         return Way(s, seconds(1)).Do("cancelOrder").Has("/orderId", R"("")"); }},
      {Fault::kCancelFinishedFirst, kV3, [](const Settings& s) {
         return Way(s, seconds(1)).Do("cancelOrder").Ever([](const auto& state) {
           return state["driving"].GetBool() && !state["instantActionStates"].Empty(); }); }},
      {Fault::kCancelDropsActions, kV3, [](const Settings& s) {
         return Horizon(s, seconds(1)).Do("cancelOrder").Has("/actionStates", "[]"); }},
      {Fault::kCancelAnyOrder, kV3, [](const Settings& s) {
         return Way(s, seconds(1)).Do("cancelOrder", {{"orderId", R"("o9")"}}).Done() == "FINISHED"; }},
      {Fault::kNoCancelError, kV3, [](const Settings& s) {
         return Play(s).Do("cancelOrder").Done() == "FINISHED"; }},
      {Fault::kPauseDrives, kV3, [](const Settings& s) {
         return Way(s, seconds(1)).Do("startPause").Has("/driving", "true"); }},
      {Fault::kPauseLosesOrder, kV3, [](const Settings& s) {
         return Way(s, seconds(1)).Do("startPause").Has("/nodeStates", "[]"); }},
      {Fault::kPauseOnce, kV3, [](const Settings& s) {
         return Play(s).Do("startPause").Do("startPause").Done() != "FINISHED"; }},
  };
}

std::vector<FaultCase> StateFaults() {
  return {
      {Fault::kLoseStates, kV3, [](const Settings& s) {
         Play play(s);
         for (int i = 0; i < 3; ++i) play.Do("stateRequest");
         return play.robot().Times("state") == 3; }},
      {Fault::kNoStateOnStatus, kV3, [](const Settings& s) {
         return AtNode(s, Act("a", "NONE")).Wait(milliseconds(500)).Of("a") == "RUNNING"; }},
      {Fault::kNoStateOnChange, kV3, [](const Settings& s) {
         return Play(s).Do("startPause").Has("/paused", "false"); }},
      {Fault::kNoStateOnRequest, kV3, [](const Settings& s) {
         return Play(s).Do("stateRequest").robot().Times("state") == 1; }},
      {Fault::kNewBaseNever, kV3, [](const Settings& s) {
         return Horizon(s, seconds(9)).Has("/newBaseRequest", "false"); }},
      {Fault::kNewBaseStuck, kV3, [](const Settings& s) {
         return Horizon(s, seconds(9)).Order({"o1", 1, {{"n2"}, {"n3"}}, 2})
             .Has("/newBaseRequest", "true"); }},
      {Fault::kLowerCase, Version::k110, [](const Settings& s) {
         return AtNode(s, Act("a", "HARD")).Of("a") == "running"; }},
      {Fault::kDegrees, kV3, [](Settings s) {
         s.initial.position.theta = 3;
         return Play(s).At("/mobileRobotPosition/theta").substr(0, 3) == "171"; }},
      {Fault::kInstantInActionStates, kV3, [](const Settings& s) {
         return Play(s).Do("startPause").Has("/instantActionStates", "[]"); }},
      {Fault::kForgetInstantActions, kV3, [](const Settings& s) {
         return Play(s).Do("startPause").Do("stopPause").Has("/instantActionStates/1", ""); }},
      {Fault::kInstantActionsOverOrder, kV3, [](const Settings& s) {
         return Play(s).Do("stopPause").Order({.stops = kWay}).Has("/instantActionStates", "[]"); }},
      {Fault::kInstantActionsOverOrder, Version::k210, [](const Settings& s) {
         return !Play(s).Do("stopPause").Order({.stops = kWay}).Done().empty(); }},
      {Fault::kHeaderIdRestart, kV3, [](const Settings& s) {
         Play play(s);
         for (int i = 0; i < 10; ++i) play.Do("stateRequest");
         return play.Has("/headerId", "0"); }},
      {Fault::kHeaderIdZero, kV3, [](const Settings& s) {
         return Play(s).Do("stateRequest").Has("/headerId", "0"); }},
      {Fault::kHeaderIdShared, kV3, [](const Settings& s) { return !Play(s).Has("/headerId", "0"); }},
      {Fault::kHeaderVersion, kV3, [](const Settings& s) {
         return Play(s).Has("/version", R"("v3")"); }},
      {Fault::kHeaderName, kV3, [](const Settings& s) {
         return Play(s).Has("/serialNumber", R"("")"); }},
      {Fault::kLocalTime, kV3, [](const Settings& s) {
         return Play(s).At("/timestamp").find('Z') == std::string::npos; }},
  };
}

std::vector<FaultCase> ConnectionFaults() {
  return {
      {Fault::kNoOnline, kV3, [](const Settings& s) {
         Play play(s);
         play.robot().Reconnect(seconds(1));
         return play.robot().Connections() == "ONLINE"; }},
      {Fault::kNoOffline, kV3, [](const Settings& s) {
         Play play(s);
         play.robot().End();
         return play.robot().Connections() == "ONLINE"; }},
      {Fault::kConnectionNotRetained, kV3, [](const Settings& s) {
         return !IsRetained(s, "connection"); }},
      {Fault::kConnectionQos0, kV3, [](const Settings& s) {
         return Play(s).robot().said().front().qos == mqtt::Qos::kAtMostOnce; }},
      {Fault::kOldBroken, kV3, [](const Settings& s) {
         return Play(s).robot().will().find("CONNECTIONBROKEN") != std::string::npos; }},
      {Fault::kFactsheetNotRetained, kV3, [](const Settings& s) {
         return !IsRetained(s, "factsheet"); }},
      {Fault::kFactsheetNotLive, kV3, [](const Settings& s) {
         return Play(s).Do("factsheetRequest").robot().Times("factsheet") == 1; }},
      {Fault::kFactsheetWithoutActions, kV3, [](const Settings& s) {
         const auto sheet = Play(s).robot().Last("factsheet");
         return sheet["protocolFeatures"]["mobileRobotActions"].Empty(); }},
      {Fault::kNoVisualization, kV3, [](const Settings& s) {
         return Play(Showing(s)).Wait(seconds(3)).robot().Times("visualization") == 0; }},
      {Fault::kVisualizationWithoutReference, kV3, [](const Settings& s) {
         const auto message = Play(Showing(s)).Wait(seconds(3)).robot().Last("visualization");
         return !message.IsObject() || !message.HasMember("referenceStateHeaderId"); }},
  };
}
// clang-format on

std::vector<FaultCase> AllCases() {
  std::vector<FaultCase> all;
  for (const auto& part :
       {DrivingFaults(), OrderFaults(), ActionFaults(), StateFaults(), ConnectionFaults()}) {
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

TEST(DrivingFaults, ShowOnDemandOnly) {
  for (const FaultCase& one : AllCases()) {
    SCOPED_TRACE(ListFaults()[static_cast<std::size_t>(one.fault)].name);
    Settings settings{.version = one.version};
    EXPECT_FALSE(one.shows(settings));
    settings.faults.Add(one.fault);
    EXPECT_TRUE(one.shows(settings));
  }
}

// The last wills are the runner's; tests/e2e/driving_test.cc has them.
TEST(DrivingFaults, AllHaveACase) {
  std::set<Fault> missing;
  for (const FaultFacts& one : ListFaults()) missing.insert(one.fault);
  for (const FaultCase& one : AllCases()) missing.erase(one.fault);
  EXPECT_EQ(missing, (std::set{Fault::kNoWill, Fault::kLateWill}));
}

TEST(DrivingFaults, HaveNamesOfTheirOwn) {
  for (const FaultFacts& one : ListFaults()) EXPECT_EQ(FindFault(one.name), one.fault);
  EXPECT_FALSE(FindFault("bad-temper"));
}

TEST(DrivingFaults, StandInTheManual) {
  std::ifstream file(FLEETPUB_SOURCE_DIR "/docs/manual.md");
  const std::string manual{std::istreambuf_iterator<char>(file), {}};
  for (const FaultFacts& one : ListFaults()) {
    EXPECT_THAT(manual, ::testing::HasSubstr(fmt::format("- `{}`: {}", one.name, one.does)));
  }
}

TEST(DrivingFaults, LetActionsHangOrFail) {
  Settings settings{.version = kV3, .hang = {"detectObject"}};
  EXPECT_EQ(AtNode(settings, Act("a", "HARD")).Wait(seconds(60)).Of("a"), "RUNNING");
  EXPECT_EQ(
      AtNode(Failing({.version = kV3}), Act("a", "HARD")).Wait(seconds(60)).Of("a").substr(0, 6),
      "FAILED");
}

}  // namespace
}  // namespace fleetpub::simulator
