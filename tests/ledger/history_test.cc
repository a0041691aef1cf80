#include <gmock/gmock.h>

#include <thread>

#include "ledger/ledger_support.h"

namespace fleetpub::ledger {
namespace {

using std::chrono::system_clock;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class History : public ::testing::Test {
 protected:
  std::int64_t Add(const Draft& draft = DraftFor()) { return MustReserve(*ledger_, draft).row; }

  std::int64_t AddAction(const std::string& type, const std::string& id = "x") {
    Draft draft = DraftFor();
    draft.actions = {{"stateRequest", "first"}, {type, id}};
    return Add(draft);
  }

  std::vector<std::int64_t> Rows(const HistoryFilter& filter) {
    std::vector<std::int64_t> rows;
    const auto records = ledger_->History(filter);
    if (!records) throw std::runtime_error(records.error().message);
    for (const Record& record : *records) rows.push_back(record.id);
    return rows;
  }

  /// A moment that lies between what was added before and what will be after.
  static WallTime Moment() {
    std::this_thread::sleep_for(milliseconds(2));
    const WallTime now = system_clock::now();
    std::this_thread::sleep_for(milliseconds(2));
    return now;
  }

  testing::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "ledger.db";
  std::unique_ptr<Ledger> ledger_ = MustOpen(path_);
};

TEST_F(History, KeepsEverythingOfAMessage) {
  const WallTime before = Moment();
  Draft draft = DraftFor();
  draft.actions = {{"startPause", "a"}, {"say \"hi\"\n", "ü/1"}};
  draft.after_id = R"(,"text":"'ü; DROP TABLE messages"})";
  const std::int64_t row = Add(draft);
  const auto found = ledger_->Find(row);
  ASSERT_TRUE(found && *found);
  const Record& record = **found;
  EXPECT_EQ(record.id, row);
  EXPECT_GE(record.recorded_at, before);
  EXPECT_LE(record.recorded_at, system_clock::now());
  EXPECT_EQ(record.outcome_at, std::nullopt);
  EXPECT_THAT((std::vector{record.user, record.host, record.profile}),
              ElementsAre("operator", "control-room", "hall-3"));
  EXPECT_THAT((std::vector{record.broker, record.target, record.protocol, record.version}),
              ElementsAre("mqtt://localhost:1883", "KIT/1", "VDA5050", "2.1.0"));
  EXPECT_EQ(record.topic, TopicOf(1));
  EXPECT_EQ(record.header_id, 0U);
  EXPECT_EQ(record.actions, draft.actions);
  EXPECT_EQ(record.payload, R"({"headerId":0,"text":"'ü; DROP TABLE messages"})");
  EXPECT_EQ(record.status, "RECORDED");
  EXPECT_EQ(record.detail, "");
}

TEST_F(History, LearnsTheOutcome) {
  const std::int64_t row = Add();
  const std::int64_t other = Add();
  const WallTime before = Moment();
  MustRecord(*ledger_, {row, "FAILED", "no such map"});
  const Record record = ledger_->Find(row)->value();
  EXPECT_EQ(record.status, "FAILED");
  EXPECT_EQ(record.detail, "no such map");
  EXPECT_GE(record.outcome_at, before);
  EXPECT_EQ(ledger_->Find(other)->value().status, "RECORDED");
}

TEST_F(History, LearnsManyOutcomesAtOnce) {
  const std::vector<Outcome> outcomes = {
      {Add(), "SENT", ""}, {0, "SENT", ""}, {Add(), "FINISHED", ""}};
  ASSERT_TRUE(ledger_->RecordOutcomes(outcomes));
  EXPECT_THAT(Rows({.status = "SENT"}), ElementsAre(outcomes[0].row));
  EXPECT_THAT(Rows({.status = "FINISHED"}), ElementsAre(outcomes[2].row));
}

TEST_F(History, GivesTheNewestOldestFirst) {
  std::vector<std::int64_t> rows;
  rows.reserve(5);
  for (int i = 0; i < 5; ++i) rows.push_back(Add());
  EXPECT_THAT(Rows({.limit = 2}), ElementsAre(rows[3], rows[4]));
  EXPECT_EQ(Rows({.limit = 0}), rows);
}

TEST_F(History, GivesFiftyUnlessAsked) {
  const std::vector<Draft> drafts(60, DraftFor());
  ASSERT_TRUE(ledger_->Reserve(drafts));
  EXPECT_EQ(Rows({}).size(), 50U);
  EXPECT_EQ(Rows({.limit = 0}).size(), 60U);
}

TEST_F(History, IsFilteredByTarget) {
  Add(DraftFor(1));
  const std::int64_t row = Add(DraftFor(12));
  EXPECT_THAT(Rows({.target = "KIT/12"}), ElementsAre(row));
  EXPECT_THAT(Rows({.target = "KIT/%"}), IsEmpty());
}

TEST_F(History, IsFilteredByAnyOfItsActions) {
  const std::int64_t pause = AddAction("startPause");
  AddAction("stopPause", "startPause");  // the word as an id is no such action
  EXPECT_THAT(Rows({.action = "startPause"}), ElementsAre(pause));
  EXPECT_EQ(Rows({.action = "stateRequest"}).size(), 2U);
  EXPECT_THAT(Rows({.action = "Pause"}), IsEmpty());
}

TEST_F(History, IsFilteredByUserAndTime) {
  const std::int64_t first = Add();
  const WallTime between = Moment();
  SqliteOptions options = OptionsFor(path_);
  options.user = "somebody";
  ledger_ = MustOpen(options);
  const std::int64_t second = Add();
  EXPECT_THAT(Rows({.user = "somebody"}), ElementsAre(second));
  EXPECT_THAT(Rows({.since = between}), ElementsAre(second));
  EXPECT_THAT(Rows({.until = between}), ElementsAre(first));
  EXPECT_THAT(Rows({.user = "somebody", .until = between}), IsEmpty());
}

TEST_F(History, HasNoRowThatIsNotThere) {
  const auto found = ledger_->Find(4711);
  ASSERT_TRUE(found);
  EXPECT_EQ(*found, std::nullopt);
}

TEST_F(History, IsPrunedByAgeButKeepsTheIds) {
  Add();
  Add();
  const WallTime between = Moment();
  const std::int64_t young = Add();
  EXPECT_EQ(ledger_->Prune(between), 2);
  EXPECT_THAT(Rows({}), ElementsAre(young));
  EXPECT_EQ(ledger_->PeekNext(TopicOf(1)), 3U);
  EXPECT_EQ(ledger_->Prune(between), 0);
}

TEST_F(History, NeverGivesARowNumberTwice) {
  Add();
  const std::int64_t last = Add();
  EXPECT_EQ(ledger_->Prune(system_clock::now() + std::chrono::hours(1)), 2);
  EXPECT_GT(Add(), last);
}

TEST_F(History, GivesSpaceBackWhenPruned) {
  Draft draft = DraftFor();
  draft.after_id = std::string(2'000, 'x');
  const std::vector<Draft> drafts(2'500, draft);
  ASSERT_TRUE(ledger_->Reserve(drafts));
  MustRecord(*ledger_, {1, "SENT", ""});
  EXPECT_GT(std::filesystem::file_size(path_), 5'000'000U);
  EXPECT_EQ(ledger_->Prune(system_clock::now() + std::chrono::hours(1)), 2'500);
  EXPECT_LT(std::filesystem::file_size(path_), 100'000U);
  EXPECT_EQ(std::filesystem::file_size(path_.string() + "-wal"), 0U);
  EXPECT_EQ(MustReserve(*ledger_).header_id, 2'500U);
}

}  // namespace
}  // namespace fleetpub::ledger
