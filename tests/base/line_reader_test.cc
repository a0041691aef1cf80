#include "base/line_reader.h"

#include <gmock/gmock.h>

#include <vector>

#include "support/temporary_folder.h"

namespace fleetpub::base {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<std::string> LinesOf(std::string_view content) {
  const fleetpub::testing::TemporaryFolder folder;
  auto reader = LineReader::Open(folder.Write("lines", content));
  std::vector<std::string> lines;
  for (;;) {
    const auto line = reader->Next();
    if (!line || !*line) return lines;
    lines.emplace_back(**line);
  }
}

TEST(LineReader, HandsOutLines) {
  EXPECT_THAT(LinesOf(""), IsEmpty());
  EXPECT_THAT(LinesOf("a\n"), ElementsAre("a"));
  EXPECT_THAT(LinesOf("a\n\nb"), ElementsAre("a", "", "b"));
  EXPECT_THAT(LinesOf("\n"), ElementsAre(""));
}

TEST(LineReader, HandsOutLinesLargerThanWhatIsReadAtOnce) {
  const std::string large(700'000, 'x');
  const std::string small(99'999, 'y');
  EXPECT_THAT(LinesOf(large + "\n" + small + "\n" + large + "\n" + small),
              ElementsAre(large, small, large, small));
}

TEST(LineReader, RefusesALineThatIsTooLong) {
  const fleetpub::testing::TemporaryFolder folder;
  auto reader = LineReader::Open(folder.Write("lines", "a\n" + std::string(300'000, 'x')));
  EXPECT_EQ(reader->Next(10).value(), "a");
  const auto line = reader->Next(10);
  ASSERT_FALSE(line);
  EXPECT_THAT(line.error().message, HasSubstr("has a line of more than 10 bytes"));
}

TEST(LineReader, SaysWhatItCannotRead) {
  const fleetpub::testing::TemporaryFolder folder;
  EXPECT_THAT(LineReader::Open(folder / "none").error().message, HasSubstr("cannot open"));
  auto reader = LineReader::Open(folder.path());
  ASSERT_TRUE(reader);
  EXPECT_THAT(reader->Next().error().message, HasSubstr("cannot read"));
}

}  // namespace
}  // namespace fleetpub::base
