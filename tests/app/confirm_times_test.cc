#include "app/confirm_times.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "support/fake_ledger.h"

namespace fleetpub::app {
namespace {

using std::chrono::milliseconds;
using std::chrono::minutes;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::SizeIs;

const ledger::WallTime kNow{std::chrono::hours(500'000)};

ledger::Record Row(minutes age, milliseconds took,
                   const std::string& topic = "uagv/v2/KIT/1/order") {
  ledger::Record row;
  row.recorded_at = kNow - age;
  row.outcome_at = row.recorded_at + took;
  row.topic = topic;
  row.target = "KIT/1";
  row.status = "FINISHED";
  return row;
}

testing::Journal kept_nowhere;

// Hands out its rows as a ledger does: the newest of those below, oldest first.
class Rows : public testing::FakeLedger {
 public:
  explicit Rows(std::vector<ledger::Record> rows)
      : FakeLedger(kept_nowhere), rows_(std::move(rows)) {
    for (std::size_t i = 0; i < rows_.size(); ++i) rows_[i].id = static_cast<std::int64_t>(i) + 1;
  }
  Result<std::vector<ledger::Record>> History(const ledger::HistoryFilter& filter) override {
    ++asked;
    if (error) return Fail(*error);
    const auto end = rows_.begin() + std::min<std::int64_t>(filter.below.value_or(1'000'000) - 1,
                                                            std::ssize(rows_));
    return std::vector<ledger::Record>(
        std::max(rows_.begin(), end - std::min<std::int64_t>(filter.limit, end - rows_.begin())),
        end);
  }

  int asked = 0;
  std::optional<Error> error;

 private:
  std::vector<ledger::Record> rows_;
};

ConfirmTimes Read(Rows& rows) {
  return ReadConfirmTimes(rows, kNow,
                          [](const ledger::Record& row) { return row.target == "KIT/1"; })
      .value();
}

TEST(ConfirmTimes, AreThoseThatRobotsConfirmedByTopic) {
  std::vector<ledger::Record> rows = {
      Row(minutes(50), milliseconds(1500)),
      Row(minutes(40), milliseconds(250), "x/instantActions/KIT/1"),
      Row(minutes(30), milliseconds(-5)),  // a clock that was set back
      Row(minutes(20), milliseconds(1), "soar/plan"),
  };
  rows.push_back(Row(minutes(10), milliseconds(1)));
  rows.back().status = "TIMEOUT";
  rows.push_back(Row(minutes(10), milliseconds(1)));
  rows.back().outcome_at.reset();
  rows.push_back(Row(minutes(10), milliseconds(1)));
  rows.back().target = "KIT/2";
  Rows ledger(rows);
  EXPECT_THAT(Read(ledger), ElementsAre(Pair("instantActions", ElementsAre(0.25)),
                                        Pair("order", ElementsAre(1.5, 0.0))));
}

TEST(ConfirmTimes, AreOfTheLastHour) {
  Rows ledger({Row(minutes(61), milliseconds(1)), Row(minutes(59), milliseconds(2))});
  EXPECT_THAT(Read(ledger), ElementsAre(Pair("order", ElementsAre(0.002))));
}

TEST(ConfirmTimes, AreReadPageByPageAsFarAsNeeded) {
  Rows old(std::vector<ledger::Record>(5'000, Row(minutes(120), milliseconds(1))));
  EXPECT_THAT(Read(old), IsEmpty());
  EXPECT_EQ(old.asked, 1) << "the rest is older still";
  Rows busy(std::vector<ledger::Record>(12'345, Row(minutes(5), milliseconds(1))));
  EXPECT_THAT(Read(busy).at("order"), SizeIs(10'000));
  EXPECT_EQ(busy.asked, 10);
  Rows some(std::vector<ledger::Record>(1'001, Row(minutes(5), milliseconds(1))));
  EXPECT_THAT(Read(some).at("order"), SizeIs(1'001));
}

TEST(ConfirmTimes, NeedALedger) {
  Rows ledger({});
  ledger.error = Error{ErrorKind::kLedger, "it is locked"};
  EXPECT_FALSE(ReadConfirmTimes(ledger, kNow, [](const ledger::Record&) { return true; }));
}

}  // namespace
}  // namespace fleetpub::app
