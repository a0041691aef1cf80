// A robot that we did not write: the virtual AGV of vda-5050-lib (tests/peers/virtual_agv.mjs).
#include <gmock/gmock.h>

#include <set>
#include <string_view>

#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::HasSubstr;

struct Dialect {
  const char* version;
  /// This release of the library expects `instantActions` in 2.0, too.
  std::vector<std::string> options;
};

class VirtualAgv : public EndToEnd, public ::testing::WithParamInterface<Dialect> {
 protected:
  explicit VirtualAgv(const char* state_interval = "30000")
      : robot_({.arguments = {"node", FLEETPUB_SOURCE_DIR "/tests/peers/virtual_agv.mjs",
                              broker_.Url(), GetParam().version, "LIB", "0001", state_interval}}) {
    // Its library calls itself started before the broker has its subscriptions.
    const bool listens =
        robot_.AwaitOutput("online") && broker_.AwaitLog("/LIB/0001/instantActions (QoS");
    if (!listens) throw std::runtime_error(robot_.Errors());
  }

  /// Commands the robot and waits for its word.
  [[nodiscard]] Finished Command(std::vector<std::string> arguments) const {
    for (const char* argument : {"--vda", GetParam().version, "--wait", "-W", "60s"}) {
      arguments.emplace_back(argument);
    }
    const auto& more = GetParam().options;
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Fleetpub(std::move(arguments));
  }

  Process robot_;
};

INSTANTIATE_TEST_SUITE_P(Versions, VirtualAgv,
                         ::testing::Values(Dialect{"1.1.0", {}},
                                           Dialect{"2.0.0", {"--actions-key", "instantActions"}}),
                         [](const auto& robot) { return robot.index == 0 ? "V110" : "V200"; });

TEST_P(VirtualAgv, PausesAndGoesOn) {
  const Finished pause = Command({"pause", "LIB/0001"});
  EXPECT_EQ(pause.exit_code, 0) << pause.errors;
  EXPECT_THAT(pause.output, HasSubstr("LIB/0001  startPause  FINISHED"));
  const Finished resume = Command({"resume", "LIB/0001"});
  EXPECT_EQ(resume.exit_code, 0) << resume.errors;
  EXPECT_THAT(resume.output, HasSubstr("stopPause  FINISHED"));
}

TEST_P(VirtualAgv, TakesOverAPosition) {
  const Finished run = Command({"initPosition", "LIB/0001", "--x", "1.5", "--y", "-2", "--theta",
                                "0.5", "--mapId", "hall-1", "--lastNodeId", "n1"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, HasSubstr("initPosition  FINISHED"));
}

TEST_P(VirtualAgv, AnswersAStateRequest) {
  EXPECT_EQ(Command({"stateRequest", "LIB/0001"}).exit_code, 0);
}

TEST_P(VirtualAgv, DrivesAnOrderOfOursToItsEnd) {
  const auto rows = [&](const char* name, const char* text) {
    return operator_.home().Write(name, text).string();
  };
  const Finished order =
      Command({"order", "LIB/0001", "--route",
               rows("tour.csv",
                    "node,x,y,map,actions\n0,0,0,local,\nn1,1,0,local,noop duration:=0.1\n"
                    "n2,1,0.5,local,\nn3,2,0.5,local,\n"),
               "--release", "3", "--wait-for", "accepted"});
  EXPECT_EQ(order.exit_code, 0) << order.output << order.errors;
  const Finished release = Command({"order", "release", "LIB/0001"});
  EXPECT_EQ(release.exit_code, 0) << release.output << release.errors;
  EXPECT_THAT(release.errors, HasSubstr("n3 (4 of 4)"));
  const Finished extend =
      Command({"order", "extend", "LIB/0001", "--route",
               rows("more.csv", "node,x,y,map\nn3,2,0.5,local\nn4,2,0,local\n")});
  EXPECT_EQ(extend.exit_code, 0) << extend.output << extend.errors;
  EXPECT_THAT(extend.output, HasSubstr("order  FINISHED"));
}

TEST_P(VirtualAgv, RefusesAnOrderThatItCannotDrive) {
  const Finished run = Command({"order", "LIB/0001", "0", "n1", "--no-check"});
  EXPECT_EQ(run.exit_code, 5) << run.output << run.errors;
  EXPECT_THAT(run.output, HasSubstr("REJECTED"));
}

TEST_P(VirtualAgv, RefusesAnActionThatItDoesNotKnow) {
  const Finished run = Command({"action", "beep", "LIB/0001", "--no-check"});
  EXPECT_EQ(run.exit_code, 5);
  EXPECT_THAT(run.output + run.errors, HasSubstr("not supported"));
}

TEST_P(VirtualAgv, HasNoOrderToCancel) {
  const Finished run = Command({"cancel", "LIB/0001"});
  EXPECT_EQ(run.exit_code, 5);
  EXPECT_THAT(run.output + run.errors, HasSubstr("no active order"));
}

TEST_P(VirtualAgv, RefusesAMessageThatItCallsInvalid) {
  const Finished run = Command({"pause", "LIB/0001", "--header-version", "2.1.0", "--no-check"});
  EXPECT_EQ(run.exit_code, 5);
  EXPECT_THAT(run.output + run.errors, HasSubstr("not compatible"));
}

TEST_P(VirtualAgv, IsNotTheOneWhoseSerialNumberIsMistyped) {
  const Finished run = Command({"resume", "LIB/0002"});
  EXPECT_EQ(run.exit_code, 7);
  EXPECT_THAT(run.output + run.errors, HasSubstr("LIB/0002"));
}

// ---- What `conform` finds of it ----

class VirtualAgvUnderTest : public VirtualAgv {
 protected:
  VirtualAgvUnderTest() : VirtualAgv("200") {}

  using Ids = std::set<std::string>;
  /// The cases that fail.
  [[nodiscard]] Ids Failures(std::vector<std::string> words) const {
    words.insert(words.begin(), {"conform", "LIB/0001", "--for", "300ms", "-o", "json", "--vda",
                                 GetParam().version});
    const auto& more = GetParam().options;
    words.insert(words.end(), more.begin(), more.end());
    const Finished run = Fleetpub(std::move(words));
    EXPECT_EQ(run.exit_code, 5) << run.output << run.errors;
    Ids failed;
    for (const std::string& line : Lines(run.output)) {
      const auto result = Json(line);
      if (result.HasMember("id") && result["verdict"] == "FAIL") {
        failed.emplace(result["id"].GetString());
      }
    }
    return failed;
  }
  [[nodiscard]] bool Is20() const { return std::string_view(GetParam().version) == "2.0.0"; }
};

INSTANTIATE_TEST_SUITE_P(Versions, VirtualAgvUnderTest,
                         ::testing::Values(Dialect{"1.1.0", {}},
                                           Dialect{"2.0.0", {"--actions-key", "instantActions"}}),
                         [](const auto& robot) { return robot.index == 0 ? "V110" : "V200"; });

// docs/reliability.md lists them, too.
TEST_P(VirtualAgvUnderTest, DeviatesWithoutAnOrderWhereItIsKnownTo) {
  Ids known = {
      "I07",  // startPause while it is paused is FAILED: to be as wanted already is no success
      "I09",  // cancelOrder without an order: an error, but no action state with its actionId
  };
  if (Is20()) {
    known.merge(Ids{
        "C02",  // connection, and its last will, have QoS 0
        "F01",  // no factsheet is retained: it has to be asked for
        "F02",  // and that one has a header, and nothing else
    });
  }
  EXPECT_EQ(Failures({"--level", "actions"}), known);
}

// It knows no detectObject, which the cases of an order's actions do: from 2.0 they are left out, up to
// 1.1, where no factsheet tells, they would be INCONCLUSIVE after 5 s each. D06 would wait for 10 s.
const std::vector<std::string> kDrive = {"--level", "drive",  "--yes",       "--distance",
                                         "2",       "--skip", "O04,O05,D06", "--only"};
std::vector<std::string> Drive(const char* cases) {
  auto words = kDrive;
  words.emplace_back(cases);
  return words;
}

// The state that takes an order has the lastNodeId of before; the next one has the new one.
TEST_P(VirtualAgvUnderTest, DeviatesInTakingOrdersWhereItIsKnownTo) {
  EXPECT_EQ(Failures(Drive("O")), Ids{"O02"});
}

// It stands for 0.2 s at every node, driving false, whatever comes behind it.
TEST_P(VirtualAgvUnderTest, DeviatesInDrivingWhereItIsKnownTo) {
  EXPECT_EQ(Failures(Drive("D")), Ids{"D08"});
}

// Ended instant actions outlast a new order.
TEST_P(VirtualAgvUnderTest, DeviatesInEndingOrdersWhereItIsKnownTo) {
  EXPECT_EQ(Failures(Drive("X")), Ids{"X06"});
}

}  // namespace
}  // namespace fleetpub::testing
