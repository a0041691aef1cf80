#include <gmock/gmock.h>

#include <thread>

#include "ledger/contract.h"

namespace fleetpub::ledger {
namespace {

using std::chrono::system_clock;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class History : public Contract {
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

  std::unique_ptr<Ledger> ledger_ = place_.MustOpen();
};

FLEETPUB_FOR_EACH_LEDGER(History);

TEST_P(History, KeepsEverythingOfAMessage) {
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
  EXPECT_EQ(record.topic, MakeTopic(1));
  EXPECT_EQ(record.header_id, 0U);
  EXPECT_EQ(record.actions, draft.actions);
  EXPECT_EQ(record.payload, R"({"headerId":0,"text":"'ü; DROP TABLE messages"})");
  EXPECT_EQ(record.status, "RECORDED");
  EXPECT_EQ(record.detail, "");
}

TEST_P(History, IsAskedForOneBroker) {
  const std::int64_t here = Add();
  Draft draft = DraftFor();
  draft.broker = "mqtts://north:8883";
  const std::int64_t there = Add(draft);
  EXPECT_THAT(Rows({.brokers = {"mqtts://north:8883"}}), ElementsAre(there));
  EXPECT_THAT(Rows({.target = draft.target, .brokers = {DraftFor().broker, "mqtt://south:1883"}}),
              ElementsAre(here));
  EXPECT_THAT(Rows({.brokers = {"mqtts://north"}}), IsEmpty());
}

TEST_P(History, LearnsTheOutcome) {
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

TEST_P(History, LearnsManyOutcomesAtOnce) {
  const std::vector<StatusUpdate> outcomes = {
      {Add(), "SENT", ""}, {0, "SENT", ""}, {Add(), "FINISHED", ""}};
  ASSERT_TRUE(ledger_->RecordOutcomes(outcomes));
  EXPECT_THAT(Rows({.status = "SENT"}), ElementsAre(outcomes[0].row));
  EXPECT_THAT(Rows({.status = "FINISHED"}), ElementsAre(outcomes[2].row));
}

TEST_P(History, GivesTheNewestOldestFirst) {
  std::vector<std::int64_t> rows;
  rows.reserve(5);
  for (int i = 0; i < 5; ++i) rows.push_back(Add());
  EXPECT_THAT(Rows({.limit = 2}), ElementsAre(rows[3], rows[4]));
  EXPECT_EQ(Rows({.limit = 0}), rows);
}

TEST_P(History, GivesFiftyUnlessAsked) {
  const std::vector<Draft> drafts(60, DraftFor());
  ASSERT_TRUE(ledger_->Reserve(drafts));
  EXPECT_EQ(Rows({}).size(), 50U);
  EXPECT_EQ(Rows({.limit = 0}).size(), 60U);
}

TEST_P(History, IsReadPageByPage) {
  std::vector<std::int64_t> rows;
  for (int i = 0; i < 4; ++i) rows.push_back(Add());
  EXPECT_THAT(Rows({.below = rows[3], .limit = 2}), ElementsAre(rows[1], rows[2]));
  EXPECT_THAT(Rows({.below = rows[0]}), IsEmpty());
}

TEST_P(History, IsFilteredByTarget) {
  Add(DraftFor(1));
  const std::int64_t row = Add(DraftFor(12));
  EXPECT_THAT(Rows({.target = "KIT/12"}), ElementsAre(row));
  EXPECT_THAT(Rows({.target = "KIT/%"}), IsEmpty());
}

TEST_P(History, IsFilteredByAnyOfItsActions) {
  const std::int64_t pause = AddAction("startPause");
  AddAction("stopPause", "startPause");  // the word as an id is no such action
  EXPECT_THAT(Rows({.action = "startPause"}), ElementsAre(pause));
  EXPECT_EQ(Rows({.action = "stateRequest"}).size(), 2U);
  EXPECT_THAT(Rows({.action = "Pause"}), IsEmpty());
}

TEST_P(History, IsFilteredByUserAndTime) {
  const std::int64_t first = Add();
  const WallTime between = Moment();
  Options options = OptionsFor("");
  options.user = "somebody";
  ledger_ = place_.MustOpen(OpenMode::kCreate, options);
  const std::int64_t second = Add();
  EXPECT_THAT(Rows({.user = "somebody"}), ElementsAre(second));
  EXPECT_THAT(Rows({.since = between}), ElementsAre(second));
  EXPECT_THAT(Rows({.until = between}), ElementsAre(first));
  EXPECT_THAT(Rows({.user = "somebody", .until = between}), IsEmpty());
}

TEST_P(History, SaysHowMuchThereIs) {
  EXPECT_EQ(ledger_->Describe()->rows, 0);
  Add(DraftFor(1));
  Add(DraftFor(1));
  Add(DraftFor(2));
  const auto info = place_.MustOpen(OpenMode::kReadOnly)->Describe();
  ASSERT_TRUE(info) << info.error().message;
  EXPECT_EQ(info->kind, IsSqlite() ? "SQLite" : "PostgreSQL");
  EXPECT_EQ(info->place, place_.where);
  EXPECT_EQ(info->version, 1);
  EXPECT_EQ(info->rows, 3);
  EXPECT_EQ(info->topics, 2);
  EXPECT_GT(info->bytes, 1'000);
}

TEST_P(History, IsEmptyWhereThereIsNoLedger) {
  const auto ledger = NewPlace().MustOpen(OpenMode::kReadOnly);
  EXPECT_TRUE(ledger->History({})->empty());
  EXPECT_EQ(*ledger->Find(1), std::nullopt);
  EXPECT_EQ(ledger->PeekNext(MakeTopic(1)), 0U);
  EXPECT_EQ(ledger->Describe()->version, 0);
}

TEST_P(History, IsNotWrittenByAReader) {
  const auto reader = place_.MustOpen(OpenMode::kReadOnly);
  const std::string topic = MakeTopic(1);
  const Draft draft = DraftFor();
  EXPECT_FALSE(reader->Lock(std::span(&topic, 1), In(milliseconds(0))));
  EXPECT_FALSE(reader->Reserve(std::span(&draft, 1)));
  EXPECT_FALSE(reader->RecordOutcomes({}));
  EXPECT_FALSE(reader->Prune(system_clock::now()));
}

TEST_P(History, HasNoRowThatIsNotThere) {
  const auto found = ledger_->Find(4711);
  ASSERT_TRUE(found);
  EXPECT_EQ(*found, std::nullopt);
}

TEST_P(History, IsPrunedByAgeButKeepsTheIds) {
  Add();
  Add();
  const WallTime between = Moment();
  const std::int64_t young = Add();
  EXPECT_EQ(ledger_->Prune(between), 2);
  EXPECT_THAT(Rows({}), ElementsAre(young));
  EXPECT_EQ(ledger_->PeekNext(MakeTopic(1)), 3U);
  EXPECT_EQ(ledger_->Prune(between), 0);
}

TEST_P(History, NeverGivesARowNumberTwice) {
  Add();
  const std::int64_t last = Add();
  EXPECT_EQ(ledger_->Prune(system_clock::now() + std::chrono::hours(1)), 2);
  EXPECT_GT(Add(), last);
}

}  // namespace
}  // namespace fleetpub::ledger
