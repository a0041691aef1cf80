#include <gmock/gmock.h>

#include <algorithm>
#include <limits>

#include "ledger/contract.h"

namespace fleetpub::ledger {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::uint32_t kHighest = std::numeric_limits<std::uint32_t>::max();

class HeaderIds : public Contract {
 protected:
  std::uint32_t Next(const Draft& draft = DraftFor()) {
    return MustReserve(*ledger_, draft).header_id;
  }

  std::unique_ptr<Ledger> ledger_ = place_.MustOpen();
};

FLEETPUB_FOR_EACH_LEDGER(HeaderIds);

TEST_P(HeaderIds, BeginAtZeroAndRiseByOne) {
  EXPECT_EQ(Next(), 0U);
  EXPECT_EQ(Next(), 1U);
  EXPECT_EQ(Next(), 2U);
}

TEST_P(HeaderIds, AreCountedPerTopic) {
  EXPECT_EQ(Next(DraftFor(1)), 0U);
  EXPECT_EQ(Next(DraftFor(2)), 0U);
  EXPECT_EQ(Next(DraftFor(1)), 1U);
}

TEST_P(HeaderIds, SurviveTheProcess) {
  Next();
  ledger_ = place_.MustOpen();
  EXPECT_EQ(Next(), 1U);
}

TEST_P(HeaderIds, BeginAtTheUnixTimeWhenAsked) {
  Options options = OptionsFor("");
  options.start = HeaderIdStart::kEpoch;
  const auto now = static_cast<std::uint32_t>(time(nullptr));
  const auto ledger = NewPlace().MustOpen(OpenMode::kCreate, options);
  const std::uint32_t first = MustReserve(*ledger).header_id;
  EXPECT_GE(first, now);
  EXPECT_LE(first, now + 2);
  EXPECT_EQ(MustReserve(*ledger).header_id, first + 1);
}

TEST_P(HeaderIds, WrapAfterTheHighest) {
  EXPECT_EQ(Next(DraftWithId(kHighest)), kHighest);
  EXPECT_EQ(ledger_->PeekNext(MakeTopic(1)), 0U);
  EXPECT_EQ(Next(), 0U);
  EXPECT_EQ(Next(), 1U);
}

TEST_P(HeaderIds, AskedForAreTakenAndCountedOn) {
  EXPECT_EQ(Next(DraftWithId(41)), 41U);
  EXPECT_EQ(Next(), 42U);
}

TEST_P(HeaderIds, AskedForAtOrBelowTheLastAreRefusedAndTakeNothing) {
  Next(DraftWithId(41));
  for (const std::uint32_t asked : {41U, 40U, 0U}) {
    const Draft draft = DraftWithId(asked);
    const auto refused = ledger_->Reserve(std::span(&draft, 1));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, ErrorKind::kUsage);
    EXPECT_THAT(refused.error().message, HasSubstr("not above 41"));
    EXPECT_THAT(refused.error().message, HasSubstr(MakeTopic(1)));
  }
  EXPECT_EQ(Next(), 42U);
}

TEST_P(HeaderIds, AskedForMayBeAnyAfterTheHighest) {
  Next(DraftWithId(kHighest));
  EXPECT_EQ(Next(DraftWithId(7)), 7U);
  EXPECT_EQ(Next(), 8U);
}

TEST_P(HeaderIds, OfOneCallOnOneTopicAreConsecutive) {
  const std::vector<Draft> drafts = {DraftFor(1), DraftFor(2), DraftFor(1), DraftFor(1)};
  const auto reserved = ledger_->Reserve(drafts);
  ASSERT_TRUE(reserved);
  std::vector<std::uint32_t> ids(reserved->size());
  std::transform(reserved->begin(), reserved->end(), ids.begin(),
                 [](const Reservation& one) { return one.header_id; });
  EXPECT_THAT(ids, ElementsAre(0, 0, 1, 2));
}

TEST_P(HeaderIds, AreAllGivenOrNone) {
  Next(DraftWithId(5));
  const std::vector<Draft> drafts = {DraftFor(2), DraftFor(1), DraftWithId(3)};
  EXPECT_FALSE(ledger_->Reserve(drafts));
  EXPECT_EQ(ledger_->PeekNext(MakeTopic(1)), 6U);
  EXPECT_EQ(ledger_->PeekNext(MakeTopic(2)), 0U);
  EXPECT_EQ(ledger_->History({})->size(), 1U);
}

TEST_P(HeaderIds, AreNotTakenByWhatIsNotCounted) {
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

TEST_P(HeaderIds, CanBeSeenBeforeTheyAreTaken) {
  EXPECT_EQ(ledger_->PeekNext(MakeTopic(1)), 0U);
  Next(DraftWithId(9));
  EXPECT_EQ(ledger_->PeekNext(MakeTopic(1)), 10U);
  EXPECT_EQ(ledger_->PeekNext(MakeTopic(1)), 10U);
  EXPECT_EQ(ledger_->Peek(DraftWithId(12)), 12U);
  EXPECT_EQ(ledger_->Peek(DraftWithId(9)).error().kind, ErrorKind::kUsage);
  Next(DraftWithId(kHighest));
  EXPECT_EQ(ledger_->Peek(DraftWithId(3)), 3U);
}

TEST_P(HeaderIds, AreKeptWithoutHistory) {
  Options options = OptionsFor("");
  options.keep_history = false;
  ledger_ = place_.MustOpen(OpenMode::kCreate, options);
  const Reservation reserved = MustReserve(*ledger_);
  EXPECT_EQ(reserved.row, 0);
  MustRecord(*ledger_, {reserved.row, "SENT", ""});
  EXPECT_TRUE(ledger_->History({})->empty());
  EXPECT_EQ(Next(), 1U);
}

TEST_P(HeaderIds, OfThousandsOfTopicsTakeOneCall) {
  std::vector<Draft> drafts;
  drafts.reserve(5'000);
  for (int robot = 0; robot < 5'000; ++robot) drafts.push_back(DraftFor(robot));
  ASSERT_TRUE(ledger_->Reserve(drafts));
  EXPECT_EQ(ledger_->PeekNext(MakeTopic(4'999)), 1U);
}

TEST(Payload, CarriesTheIdBetweenItsParts) {
  EXPECT_EQ(BuildPayload(DraftFor(), kHighest), R"({"headerId":4294967295})");
}

TEST(Payload, OfWhatIsNotCountedStaysAsItIs) {
  Draft draft;
  draft.counted = false;
  draft.before_id = "{}";
  draft.after_id = "never";
  EXPECT_EQ(BuildPayload(draft, 5), "{}");
}

}  // namespace
}  // namespace fleetpub::ledger
