#include "cli/output/table.h"

#include <gmock/gmock.h>

#include <array>

namespace fleetpub::cli {
namespace {

using ::testing::ElementsAre;

constexpr std::size_t kPlenty = 1000;
const Output kOutput({});

constexpr std::array kColumns = {
    Column{.name = "NAME", .least = 6}, Column{.name = "SINCE", .rank = 2},
    Column{.name = "ORDER", .rank = 1, .least = 5}, Column{.name = "END"}};

std::vector<std::string> Lines(const Row& row, std::size_t width) {
  const std::vector<Row> rows = {row};
  return TableLines(kColumns, rows, width, kOutput);
}

TEST(Table, AlignsColumnsByWhatATerminalShows) {
  const std::vector<Row> rows = {{{"KIT/0001"}, {"1 s"}, {"none"}, {"0"}},
                                 {{"搬送車"}, {"1 min"}, {"Fo\u0308"}, {"🤖"}}};
  EXPECT_THAT(TableLines(kColumns, rows, kPlenty, kOutput),
              ElementsAre("NAME      SINCE  ORDER  END",  //
                          "KIT/0001  1 s    none   0",    //
                          "搬送車    1 min  Fo\u0308     🤖"));
}

TEST(Table, CutsLongTextsBeforeAnyColumnGoes) {
  const Row row = {{"KIT/0001"}, {"1 min"}, {"order-17-b"}, {"0"}};
  EXPECT_THAT(Lines(row, 32), ElementsAre("NAME      SINCE  ORDER       END",  //
                                          "KIT/0001  1 min  order-17-b  0"));
  EXPECT_THAT(Lines(row, 28), ElementsAre("NAME      SINCE  ORDER   END",  //
                                          "KIT/0001  1 min  order…  0"));
  EXPECT_THAT(Lines(row, 25), ElementsAre("NAME    SINCE  ORDER  END",  //
                                          "KIT/0…  1 min  orde…  0"));
}

TEST(Table, LeavesOutTheLeastImportantColumns) {
  const Row row = {{"KIT/0001"}, {"1 min"}, {"order-17-b"}, {"0"}};
  EXPECT_THAT(Lines(row, 24), ElementsAre("NAME      ORDER      END",  //
                                          "KIT/0001  order-17…  0"));
  EXPECT_THAT(Lines(row, 15), ElementsAre("NAME      END", "KIT/0001  0"));
  EXPECT_THAT(Lines(row, 4), ElementsAre("NAME", "KIT/"));
  EXPECT_THAT(Lines(row, 0), ElementsAre("", ""));
}

TEST(Table, PutsNumbersToTheRight) {
  constexpr std::array kNumbers = {Column{.name = "ID", .is_number = true}, Column{.name = "X"}};
  const std::vector<Row> rows = {{{"1"}, {"a"}}, {{"1000"}, {"b"}}};
  EXPECT_THAT(TableLines(kNumbers, rows, kPlenty, kOutput),
              ElementsAre("  ID  X", "   1  a", "1000  b"));
}

TEST(Table, KeepsItsColumnsWhereTheyWere) {
  std::vector<std::size_t> widths;
  const std::vector<Row> before = {{{"KIT/0001"}, {"9 min"}, {"order-17"}, {"0"}}};
  const auto first = TableLines(kColumns, before, kPlenty, kOutput, &widths);
  const std::vector<Row> after = {{{"KIT/1"}, {"1 h"}, {"none"}, {"0"}}};
  const auto second = TableLines(kColumns, after, kPlenty, kOutput, &widths);
  EXPECT_EQ(second.front(), first.front());
  EXPECT_EQ(second.back(), "KIT/1     1 h    none      0");
}

}  // namespace
}  // namespace fleetpub::cli
