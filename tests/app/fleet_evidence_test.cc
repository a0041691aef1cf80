#include "app/fleet_evidence.h"

#include <gmock/gmock.h>

namespace fleetpub::app {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

HeaderIds Count(std::initializer_list<std::uint64_t> ids) {
  HeaderIds counted;
  for (const std::uint64_t id : ids) counted.Take(id);
  return counted;
}

TEST(CountingHeaderIds, TellsLossRestartAndTwoPublishersApart) {
  const auto steady = Count({4294967294, 4294967295, 0, 1});
  EXPECT_EQ(steady.skipped + steady.falls + steady.repeated, 0U);
  EXPECT_EQ(Count({7, 8, 11}).skipped, 2U);
  const auto restarted = Count({8, 9, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10});
  EXPECT_EQ(restarted.falls, 1U);
  EXPECT_EQ(restarted.resumed, 0U);
  const auto two = Count({100, 5, 101, 6, 102, 7});
  EXPECT_EQ(two.resumed, 2U);
  EXPECT_EQ(two.skipped, 0U) << "nothing is lost";
  EXPECT_EQ(Count({3, 3, 4, 4}).repeated, 2U);
}

TEST(MeasuringRhythm, CountsTheSilenceAtBothEnds) {
  Rhythm rhythm;
  EXPECT_EQ(rhythm.FindSilence(seconds(9), {}), seconds(9));
  rhythm.Take(seconds(2), {});
  rhythm.Take(seconds(3), {});
  EXPECT_EQ(rhythm.FindSilence(seconds(4), {}), seconds(2));
  EXPECT_EQ(rhythm.FindSilence(seconds(10), {}), seconds(7));
}

TEST(MeasuringRhythm, PassesOverWhatWasBefore) {
  Rhythm rhythm;
  rhythm.Take(seconds(60), seconds(59));
  EXPECT_EQ(rhythm.FindSilence(seconds(99), seconds(98)), seconds(1));
}

TEST(ComparingClocks, TakesTheMessageThatWasLeastDelayed) {
  Clock clock;
  const auto ours = *base::ParseDateTime("2026-01-02T03:04:05.000Z");
  clock.Take({.timestamp = "2026-01-02T03:04:03.000Z"}, ours);
  clock.Take({.timestamp = "2026-01-02T03:04:04.500Z"}, ours);
  EXPECT_EQ(*clock.offset, milliseconds(-500));
  EXPECT_EQ(clock.backwards, 0U);
  clock.Take({.timestamp = "2026-01-02T03:04:01.000Z"}, ours);
  EXPECT_EQ(clock.backwards, 1U);
}

}  // namespace
}  // namespace fleetpub::app
