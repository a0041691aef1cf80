// The mutation matrix: a virtual robot that does one thing wrong fails exactly the cases of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>

#include "app/conformance/case.h"
#include "app/conformance/orders.h"
#include "app/conformance/virtual_wire.h"
#include "simulator/faults.h"

namespace fleetpub::app::conformance {
namespace {

using simulator::Fault;
using testing::VirtualWire;
using vda5050::Version;
using Ids = std::set<std::string>;

simulator::Settings MakeSettings(Version version) {
  simulator::Settings settings;
  settings.version = version;
  settings.delay = std::chrono::milliseconds(2'500);
  settings.min_state_interval = std::chrono::milliseconds(0);
  settings.visualization_interval = std::chrono::milliseconds(1'000);
  simulator::PlaceAt({.x = 3, .y = 4, .theta = 0.5}, settings.initial);
  return settings;
}

const vda5050::RobotAddress kRobot{"KIT", "0001"};

Subject MakeSubject(const simulator::Settings& settings) {
  Subject subject{.address = kRobot, .dialect = {}, .factsheet = {}, .way = {.distance = 4}};
  subject.dialect.version = settings.version;
  subject.dialect.topics = settings.topics;
  return subject;
}

Outcome Conform(const simulator::Settings& settings, const Selection& selection,
                const std::function<void(VirtualWire&)>& prepare) {
  schema::Registry registry;
  VirtualWire wire(settings, kRobot, registry);
  prepare(wire);
  conformance::Run run(MakeSubject(settings), wire, registry);
  return Conduct(run, selection);
}

Outcome Conform(const simulator::Settings& settings, Selection selection = {.level = Level::kDrive},
                double lose = 0, unsigned seed = 0) {
  return Conform(settings, selection, [&](VirtualWire& wire) { wire.Lose(lose, seed); });
}

Ids With(const Outcome& outcome, Verdict verdict) {
  Ids ids;
  for (const CaseResult& result : outcome.results) {
    if (result.finding.verdict == verdict) ids.emplace(result.of.id);
  }
  return ids;
}

std::string Describe(const Outcome& outcome, Verdict verdict) {
  std::string text;
  for (const auto& [of, finding] : outcome.results) {
    if (finding.verdict == verdict) {
      text += std::string(of.id) + ": " + finding.why + "\n";
    }
  }
  return text;
}

// What a fault makes fail: in all versions, and besides where a version knows more cases.
struct Mutation {
  std::string_view fault;
  Ids all;
  Ids from_20 = {};
  Ids from_21 = {};
  Ids in_30 = {};
  Ids up_to_20 = {};  ///< alone
  Ids up_to_21 = {};
};

const std::vector<Mutation> kMutations = {
    {"deviation", {}, {}, {"D03"}},
    {"wrong-last-node", {"D02", "D15"}},
    {"enter-horizon", {"D06"}},
    {"skip-theta", {"D04"}},
    {"ignore-speed-limit", {"D05"}},
    // It stands, which is the deviation of several.
    {"stop-at-nodes", {"A01", "D08"}, {}, {}, {"A04"}},
    {"never-driving", {"D01"}},
    {"node-before-edge", {"A01", "D02", "D08", "D15", "S04"}, {}, {}, {"A04"}},
    {"list-first-node", {}, {}, {}, {"O03"}},
    {"ignore-updates", {"D08", "D09", "D10", "D11", "D12"}, {}, {}, {"D14", "O07", "X03"}},
    {"append-horizon", {"D08", "D09", "D10", "S04"}},
    {"drop-horizon", {"D06", "O05"}},
    {"omit-horizon-actions", {"O05"}},
    {"rerun-stitched", {}, {}, {}, {"D13"}},
    {"take-any-stitch", {"D11"}},
    {"take-any-start", {"O17"}},
    {"exact-start", {"X02"}},
    {"take-while-busy", {"O19"}},
    {"take-any-update-id", {"O08"}, {}, {}, {"O14"}},
    {"take-unsupported", {}, {"O16"}},
    {"take-unknown-actions", {"O15"}},
    {"take-unknown-maps", {}, {}, {"O18"}},
    {"take-after-cancel", {}, {}, {}, {"X03"}},
    {"take-malformed", {"O11", "O12", "O13", "S04"}},
    {"take-base-behind-horizon", {"O13", "S04"}},
    {"take-sequence-gaps", {}, {}, {}, {"O13"}},
    {"refuse-resend", {"O06"}},
    {"silent-rejection",
     {"D11", "O08", "O11", "O12", "O13", "O15", "O17", "O19"},
     {"O16"},
     {"O18"},
     {"O07", "O14", "X03"}},
    {"brief-rejection", {"O09"}},
    // Where the text names another type.
    {"order-error-for-all",
     {"O08", "O11", "O12", "O13"},
     {},
     {},
     {"O07", "O15", "O16", "O17", "O18", "O19", "S09", "X03"},
     {"D11", "O17", "O19"}},
    {"no-references", {"I09"}, {}, {}, {"I05", "O10"}, {}, {"I04"}},
    {"wipe-order-at-end", {"D10", "O01", "O04"}},
    {"no-empty-order", {"D10", "O01"}},
    {"hard-in-parallel", {"A02"}},
    {"hard-first", {"A05"}},
    {"single-in-parallel", {}, {}, {}, {"A04"}},
    {"actions-never-stop", {"A02", "A03"}},
    {"soft-one-by-one", {"A03"}},
    {"none-stops", {"A01"}},
    {"single-stops", {}, {}, {}, {"A04"}},
    {"edge-actions-run-on", {"A06"}},
    {"edge-actions-early", {"A02", "A03"}},
    {"no-loads", {"A07"}},
    {"cancel-wipes-order-id", {"X01"}},
    {"cancel-finished-first", {"X01"}},
    {"cancel-drops-actions", {"X01"}},
    {"cancel-any-order", {}, {}, {}, {"X04"}},
    {"no-cancel-error", {"I09"}},
    {"pause-drives", {"X05"}},
    {"pause-loses-order", {"X05"}},
    {"pause-once", {"I07"}, {}, {}, {"S09"}},
    {"no-state-on-change", {"D01", "D02", "D15", "I01", "I03"}},
    {"new-base-stuck", {"D07"}},
    {"lower-case", {"S01"}},
    {"degrees", {"S01"}},
    {"instant-in-action-states", {}, {}, {}, {"S06"}},
    {"forget-instant-actions", {}, {}, {}, {"I10"}},
    // Each version has its own rule, which the fault turns round.
    {"instant-actions-over-order", {}, {}, {}, {"I13"}, {}, {"X06"}},
    {"header-id-restart", {"H03"}, {}, {}, {"V02"}},
    {"header-id-zero", {"H03"}, {}, {}, {"V02"}},
    {"header-id-shared", {"H03"}},
    {"header-version", {"H01"}},
    {"header-name", {"H02"}},
    {"local-time", {"H04"}},
    {"connection-not-retained", {"C01"}},
    {"connection-qos-0", {}, {"C02"}},
    {"factsheet-not-retained", {}, {"F01"}},
    {"factsheet-not-live", {}, {"I02"}},
    {"factsheet-without-actions", {}, {}, {}, {"F03"}},
    {"no-visualization", {}, {"V01"}},
    {"visualization-without-reference", {}, {}, {}, {"V02"}},
    // Nobody can hear that these are wrong.
    {"lose-states", {}},
    {"new-base-never", {}},
    {"stuck", {}},
};

class MutationMatrix : public ::testing::TestWithParam<Version> {};

TEST_P(MutationMatrix, ACleanRobotFailsNothingAndLeavesNothing) {
  const auto outcome = Conform(MakeSettings(GetParam()));
  EXPECT_EQ(Describe(outcome, Verdict::kFail), "");
  EXPECT_EQ(Describe(outcome, Verdict::kInconclusive), "");
  EXPECT_TRUE(outcome.leftover.empty());
}

TEST_P(MutationMatrix, EachFaultFailsItsCasesAndNoOthers) {
  const Version version = GetParam();
  for (const Mutation& mutation : kMutations) {
    auto settings = MakeSettings(version);
    settings.faults.Add(*simulator::FindFault(mutation.fault));
    Ids expected = mutation.all;
    const auto add = [&](bool applies, const Ids& more) {
      if (applies) expected.insert(more.begin(), more.end());
    };
    add(version >= Version::k200, mutation.from_20);
    add(version >= Version::k210, mutation.from_21);
    add(version >= Version::k300, mutation.in_30);
    add(version <= Version::k200, mutation.up_to_20);
    add(version <= Version::k210, mutation.up_to_21);
    const auto outcome = Conform(settings);
    EXPECT_EQ(With(outcome, Verdict::kFail), expected) << mutation.fault << "\n"
                                                       << Describe(outcome, Verdict::kFail);
  }
}

TEST_P(MutationMatrix, ARobotThatHidesItsStateFromARequestIsFound) {
  auto settings = MakeSettings(GetParam());
  settings.delay = std::chrono::milliseconds(0);
  settings.faults.Add(Fault::kNoStateOnRequest);
  const auto outcome = Conform(settings, {.level = Level::kActions, .only = {"I01", "I03"}});
  EXPECT_EQ(With(outcome, Verdict::kFail), Ids{"I01"}) << Describe(outcome, Verdict::kFail);
}

TEST_P(MutationMatrix, LostStatesNeverMakeACaseFail) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const auto outcome = Conform(MakeSettings(GetParam()), {.level = Level::kDrive}, 0.25, seed);
    EXPECT_EQ(Describe(outcome, Verdict::kFail), "") << "seed " << seed;
  }
}

std::string NameVersion(const ::testing::TestParamInfo<Version>& version) {
  std::string name(vda5050::GetFacts(version.param).name);
  std::erase(name, '.');
  return "V" + name;
}

INSTANTIATE_TEST_SUITE_P(InEachVersion, MutationMatrix, ::testing::ValuesIn(vda5050::kVersions),
                         NameVersion);

// ---- Selection, and what is left ----

TEST(Conduct, ListeningSendsNothingAndSkipsTheRest) {
  const auto outcome = Conform(MakeSettings(Version::k300), {.level = Level::kListen});
  for (const CaseResult& result : outcome.results) {
    if (result.of.level != Level::kListen) {
      EXPECT_EQ(result.finding.verdict, Verdict::kSkipped) << result.of.id;
    }
  }
  EXPECT_TRUE(With(outcome, Verdict::kPass).contains("S02"));
}

TEST(Conduct, OnlyAndSkipNameCasesAndGroups) {
  const auto outcome = Conform(MakeSettings(Version::k210),
                               {.level = Level::kActions, .only = {"h", "I01"}, .skip = {"H03"}});
  Ids ids;
  for (const CaseResult& result : outcome.results) ids.emplace(result.of.id);
  EXPECT_EQ(ids, (Ids{"H01", "H02", "H04", "I01"}));
}

TEST(Conduct, EndsWhenTheModeChanges) {
  auto settings = MakeSettings(Version::k300);
  settings.mode_changes = {{std::chrono::seconds(60), "MANUAL"}};
  const auto outcome = Conform(settings);
  EXPECT_EQ(Describe(outcome, Verdict::kFail), "");
  const std::string open = Describe(outcome, Verdict::kInconclusive);
  EXPECT_NE(open.find("operating mode"), std::string::npos) << open;
}

// Somebody stops it after that time, and looks at it ten times a second.
class StoppedWire final : public VirtualWire {
 public:
  StoppedWire(const simulator::Settings& settings, schema::Registry& registry,
              std::chrono::milliseconds stop_after)
      : VirtualWire(settings, kRobot, registry), stop_at_(Now() + stop_after) {}

  Status Send(const message::Command& command) override {
    if (IsStopped() && command.topic.ends_with("/order")) ++late_orders_;
    return VirtualWire::Send(command);
  }
  std::optional<std::pair<std::string, mqtt::Message>> Next(TimePoint until) override {
    if (falls_silent_ && IsStopped()) Lose(1, 0);
    return VirtualWire::Next(std::min(until, Now() + std::chrono::milliseconds(100)));
  }
  bool IsStopped() const override { return !goes_on_ && Now() >= stop_at_; }

  void GoOn() { goes_on_ = true; }
  void FallSilent() { falls_silent_ = true; }
  TimePoint stop_at() const { return stop_at_; }
  int late_orders() const { return late_orders_; }

 private:
  TimePoint stop_at_;
  bool goes_on_ = false;
  bool falls_silent_ = false;
  int late_orders_ = 0;
};

class StoppedRun : public ::testing::TestWithParam<Version> {};

// Wherever it is, under way or paused.
TEST_P(StoppedRun, SendsNoOrderAnyMoreAndTakesBackWhatItDid) {
  schema::Registry registry;
  auto settings = MakeSettings(GetParam());
  settings.delay = std::chrono::milliseconds(400);
  for (int tenths = 8; tenths < 6'000; tenths += 37) {
    SCOPED_TRACE(tenths);
    StoppedWire wire(settings, registry, std::chrono::milliseconds(100 * tenths));
    conformance::Run run(MakeSubject(settings), wire, registry);
    const auto outcome = Conduct(run, {.level = Level::kDrive});
    if (!run.is_stopped()) return;
    EXPECT_EQ(run.abort_reason(), "interrupted");
    EXPECT_EQ(wire.late_orders(), 0);
    EXPECT_LE(run.Now() - wire.stop_at(), kTakingBack + seconds(1));
    EXPECT_EQ(Describe(outcome, Verdict::kFail), "");
    EXPECT_TRUE(outcome.leftover.empty()) << outcome.leftover.front();
    wire.GoOn();
    run.Listen(seconds(40));
    EXPECT_FALSE(run.last_state()->state->paused.value_or(false));
    EXPECT_TRUE(IsIdle(*run.last_state()->state));
  }
}

INSTANTIATE_TEST_SUITE_P(InEachVersion, StoppedRun, ::testing::ValuesIn(vda5050::kVersions),
                         NameVersion);

TEST(Conduct, OfARobotThatNoLongerAnswersTellsThatItIsNotKnownHowItWasLeft) {
  schema::Registry registry;
  const auto settings = MakeSettings(Version::k210);
  StoppedWire wire(settings, registry, seconds(60));
  wire.FallSilent();
  conformance::Run run(MakeSubject(settings), wire, registry);
  const auto outcome = Conduct(run, {.level = Level::kDrive});
  EXPECT_FALSE(outcome.leftover.empty());
  EXPECT_LE(run.Now() - wire.stop_at(), kTakingBack + seconds(1));
}

TEST(Conduct, ASilentRobotIsInconclusive) {
  auto settings = MakeSettings(Version::k210);
  settings.silent = true;
  const auto outcome =
      Conform(settings, {.level = Level::kDrive, .only = {"I", "O", "D", "X", "S01"}});
  EXPECT_EQ(Describe(outcome, Verdict::kFail), "");
  EXPECT_TRUE(With(outcome, Verdict::kPass).empty());
}

// At the end of its way it says that it drives, and then nothing of it any more.
TEST(Conduct, AStateWithoutDrivingShowsNoRest) {
  int ends = 0;
  bool drove = false;
  const auto alter = [&](std::string state) {
    constexpr std::string_view kRest = R"("driving":false,)";
    drove = drove || state.find(R"("driving":true)") != std::string::npos;
    const auto at = state.find(kRest);
    if (!drove || at == std::string::npos) return state;
    return state.replace(at, kRest.size(), ends++ == 0 ? R"("driving":true,)" : "");
  };
  const auto outcome =
      Conform(MakeSettings(Version::k210), {.level = Level::kDrive, .only = {"D01"}},
              [&](VirtualWire& wire) { wire.Alter(alter); });
  EXPECT_GT(ends, 1);
  EXPECT_EQ(Describe(outcome, Verdict::kFail), "D01: driving stays true at rest\n");
}

TEST(Conduct, IdsAreUniqueAndEachCaseSaysWhatToDo) {
  Ids ids;
  for (const Case& one : ListCases()) {
    EXPECT_TRUE(ids.emplace(one.id).second) << one.id;
    EXPECT_FALSE(one.says.empty() || one.clause.empty() || one.advice.empty()) << one.id;
  }
}

}  // namespace
}  // namespace fleetpub::app::conformance
