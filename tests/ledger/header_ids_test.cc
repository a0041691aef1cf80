#include <gmock/gmock.h>

#include <algorithm>
#include <limits>

#include "ledger/ledger_support.h"

namespace fleetpub::ledger {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::uint32_t kHighest = std::numeric_limits<std::uint32_t>::max();

class HeaderIds : public ::testing::Test {
 protected:
  std::uint32_t Next(const Draft& draft = DraftFor()) {
    return MustReserve(*ledger_, draft).header_id;
  }

  testing::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "ledger.db";
  std::unique_ptr<Ledger> ledger_ = MustOpen(path_);
};

TEST_F(HeaderIds, BeginAtZeroAndRiseByOne) {
  EXPECT_EQ(Next(), 0U);
  EXPECT_EQ(Next(), 1U);
  EXPECT_EQ(Next(), 2U);
}

TEST_F(HeaderIds, AreCountedPerTopic) {
  EXPECT_EQ(Next(DraftFor(1)), 0U);
  EXPECT_EQ(Next(DraftFor(2)), 0U);
  EXPECT_EQ(Next(DraftFor(1)), 1U);
}

TEST_F(HeaderIds, SurviveTheProcess) {
  Next();
  ledger_ = MustOpen(path_);
  EXPECT_EQ(Next(), 1U);
}

TEST_F(HeaderIds, BeginAtTheUnixTimeWhenAsked) {
  SqliteOptions options = OptionsFor(folder_ / "epoch.db");
  options.start = HeaderIdStart::kEpoch;
  const auto now = static_cast<std::uint32_t>(time(nullptr));
  const auto ledger = MustOpen(options);
  const std::uint32_t first = MustReserve(*ledger).header_id;
  EXPECT_GE(first, now);
  EXPECT_LE(first, now + 2);
  EXPECT_EQ(MustReserve(*ledger).header_id, first + 1);
}

TEST_F(HeaderIds, WrapAfterTheHighest) {
  EXPECT_EQ(Next(DraftWithId(kHighest)), kHighest);
  EXPECT_EQ(ledger_->PeekNext(TopicOf(1)), 0U);
  EXPECT_EQ(Next(), 0U);
  EXPECT_EQ(Next(), 1U);
}

TEST_F(HeaderIds, AskedForAreTakenAndCountedOn) {
  EXPECT_EQ(Next(DraftWithId(41)), 41U);
  EXPECT_EQ(Next(), 42U);
}

TEST_F(HeaderIds, AskedForAtOrBelowTheLastAreRefusedAndTakeNothing) {
  Next(DraftWithId(41));
  for (const std::uint32_t asked : {41U, 40U, 0U}) {
    const Draft draft = DraftWithId(asked);
    const auto refused = ledger_->Reserve(std::span(&draft, 1));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, ErrorKind::kUsage);
    EXPECT_THAT(refused.error().message, HasSubstr("not above 41"));
    EXPECT_THAT(refused.error().message, HasSubstr(TopicOf(1)));
  }
  EXPECT_EQ(Next(), 42U);
}

TEST_F(HeaderIds, AskedForMayBeAnyAfterTheHighest) {
  Next(DraftWithId(kHighest));
  EXPECT_EQ(Next(DraftWithId(7)), 7U);
  EXPECT_EQ(Next(), 8U);
}

TEST_F(HeaderIds, OfOneCallOnOneTopicAreConsecutive) {
  const std::vector<Draft> drafts = {DraftFor(1), DraftFor(2), DraftFor(1), DraftFor(1)};
  const auto reserved = ledger_->Reserve(drafts);
  ASSERT_TRUE(reserved);
  std::vector<std::uint32_t> ids(reserved->size());
  std::transform(reserved->begin(), reserved->end(), ids.begin(),
                 [](const Reservation& one) { return one.header_id; });
  EXPECT_THAT(ids, ElementsAre(0, 0, 1, 2));
}

TEST_F(HeaderIds, AreAllGivenOrNone) {
  Next(DraftWithId(5));
  const std::vector<Draft> drafts = {DraftFor(2), DraftFor(1), DraftWithId(3)};
  EXPECT_FALSE(ledger_->Reserve(drafts));
  EXPECT_EQ(ledger_->PeekNext(TopicOf(1)), 6U);
  EXPECT_EQ(ledger_->PeekNext(TopicOf(2)), 0U);
  EXPECT_EQ(ledger_->History({})->size(), 1U);
}

TEST_F(HeaderIds, AreNotTakenByWhatIsNotCounted) {
  Draft draft = DraftFor();
  draft.counted = false;
  draft.before_id = R"({"message_ID":"x"})";
  const Reservation reserved = MustReserve(*ledger_, draft);
  EXPECT_EQ(Next(), 0U);
  const auto record = ledger_->Find(reserved.row);
  ASSERT_TRUE(record && *record);
  EXPECT_EQ((*record)->header_id, std::nullopt);
  EXPECT_EQ((*record)->payload, R"({"message_ID":"x"})");
}

TEST_F(HeaderIds, CanBeSeenBeforeTheyAreTaken) {
  EXPECT_EQ(ledger_->PeekNext(TopicOf(1)), 0U);
  Next(DraftWithId(9));
  EXPECT_EQ(ledger_->PeekNext(TopicOf(1)), 10U);
  EXPECT_EQ(ledger_->PeekNext(TopicOf(1)), 10U);
}

TEST_F(HeaderIds, AreKeptWithoutHistory) {
  SqliteOptions options = OptionsFor(path_);
  options.keep_history = false;
  ledger_ = MustOpen(options);
  const Reservation reserved = MustReserve(*ledger_);
  EXPECT_EQ(reserved.row, 0);
  MustRecord(*ledger_, {reserved.row, "SENT", ""});
  EXPECT_TRUE(ledger_->History({})->empty());
  EXPECT_EQ(Next(), 1U);
}

TEST_F(HeaderIds, OfThousandsOfTopicsTakeOneCall) {
  std::vector<Draft> drafts;
  drafts.reserve(5'000);
  for (int robot = 0; robot < 5'000; ++robot) drafts.push_back(DraftFor(robot));
  ASSERT_TRUE(ledger_->Reserve(drafts));
  EXPECT_EQ(ledger_->PeekNext(TopicOf(4'999)), 1U);
}

TEST(Payload, CarriesTheIdBetweenItsParts) {
  EXPECT_EQ(PayloadOf(DraftFor(), kHighest), R"({"headerId":4294967295})");
}

TEST(Payload, OfWhatIsNotCountedStaysAsItIs) {
  Draft draft;
  draft.counted = false;
  draft.before_id = "{}";
  draft.after_id = "never";
  EXPECT_EQ(PayloadOf(draft, 5), "{}");
}

}  // namespace
}  // namespace fleetpub::ledger
