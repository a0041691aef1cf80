#include "ledger/header_id_checkpoints.h"

#include <gmock/gmock.h>

#include <fstream>

#include "ledger/ledger_support.h"

namespace fleetpub::ledger {
namespace {

using ::testing::HasSubstr;
using ::testing::Optional;
namespace fs = std::filesystem;

class Marks : public ::testing::Test {
 protected:
  Marks() { folder_.Write("ledger.db.locks", ""); }

  testing::TemporaryFolder folder_;
  fs::path path_ = folder_ / "ledger.db";
};

TEST_F(Marks, AreReadAsTheyWereWritten) {
  const HeaderIdCheckpoints marks(path_);
  EXPECT_EQ(marks.Read("a"), std::nullopt);
  marks.Write("a", 7);
  marks.Write("b", 4'294'967'295);
  EXPECT_THAT(HeaderIdCheckpoints(path_).Read("a"), Optional(7U));
  EXPECT_THAT(marks.Read("b"), Optional(4'294'967'295U));
}

TEST_F(Marks, CountForNothingWhenAnyBitOfThemIsDamaged) {
  const HeaderIdCheckpoints marks(path_);
  marks.Write("a", 7);
  const auto begin = static_cast<std::streamoff>(fs::file_size(path_.string() + ".locks") - 8);
  for (int bit = 0; bit < 64; ++bit) {
    std::fstream file(path_.string() + ".locks", std::ios::binary | std::ios::in | std::ios::out);
    file.seekg(begin + bit / 8);
    const int byte = file.get();
    file.seekp(begin + bit / 8);
    file.put(static_cast<char>(byte ^ (1 << bit % 8)));
    file.close();
    EXPECT_EQ(marks.Read("a"), std::nullopt) << bit;
    marks.Write("a", 7);
  }
}

TEST_F(Marks, AreNotThereWithoutAFile) {
  fs::remove(path_.string() + ".locks");
  const HeaderIdCheckpoints marks(path_);
  marks.Write("a", 7);
  EXPECT_EQ(marks.Read("a"), std::nullopt);
  EXPECT_FALSE(fs::exists(path_.string() + ".locks"));
}

TEST(LaterId, IsTheOneLessThanHalfTheRangeAhead) {
  EXPECT_EQ(LaterId(std::nullopt, std::nullopt), std::nullopt);
  EXPECT_EQ(LaterId(5, std::nullopt), 5U);
  EXPECT_EQ(LaterId(std::nullopt, 5), 5U);
  EXPECT_EQ(LaterId(5, 6), 6U);
  EXPECT_EQ(LaterId(6, 5), 6U);
  EXPECT_EQ(LaterId(4'294'967'295, 0), 0U) << "wrapped";
  EXPECT_EQ(LaterId(0, 4'294'967'295), 0U) << "wrapped";
}

class LostIds : public ::testing::Test {
 protected:
  LostIds() {
    for (int i = 0; i < 5; ++i) MustReserve(*MustOpen(path_));
  }
  [[nodiscard]] std::string Log() const { return path_.string() + "-wal"; }

  testing::TemporaryFolder folder_;
  fs::path path_ = folder_ / "ledger.db";
};

TEST_F(LostIds, ToADamagedLogAreNotGivenAgain) {
  std::fstream file(Log(), std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(100);
  file << "damage";
  file.close();
  EXPECT_EQ(MustOpen(path_, OpenMode::kReadOnly)->History({})->size(), 0U) << "nothing was lost";
  EXPECT_THAT(MustOpen(path_, OpenMode::kReadOnly)->PeekNext(MakeTopic(1)), Optional(5U));
  EXPECT_EQ(MustReserve(*MustOpen(path_)).header_id, 5U);
}

TEST_F(LostIds, WithTheLedgerAreNotGivenAgain) {
  for (const char* end : {"", "-wal", "-shm"}) fs::remove(path_.string() + end);
  EXPECT_THAT(MustOpen(path_, OpenMode::kReadOnly)->PeekNext(MakeTopic(1)), Optional(5U));
  EXPECT_EQ(MustReserve(*MustOpen(path_)).header_id, 5U);
}

TEST_F(LostIds, AreNotTakenWhenAskedFor) {
  fs::resize_file(Log(), 0);
  const auto ledger = MustOpen(path_);
  const Draft again = DraftWithId(4);
  const auto refused = ledger->Reserve(std::span(&again, 1));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("not above 4"));
}

// SQLite would play the old log into the new file.
TEST_F(LostIds, WithTheLedgerButNotTheLogAreRefused) {
  for (const bool gone : {false, true}) {
    if (gone) {
      fs::remove(path_);
    } else {
      fs::resize_file(path_, 0);
    }
    const auto ledger = OpenSqlite(OptionsFor(path_), OpenMode::kCreate);
    ASSERT_FALSE(ledger);
    EXPECT_EQ(ledger.error().kind, ErrorKind::kLedger);
    EXPECT_THAT(ledger.error().message, HasSubstr("ledger.db-wal is there"));
  }
}

}  // namespace
}  // namespace fleetpub::ledger
