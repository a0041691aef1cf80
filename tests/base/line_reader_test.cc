#include "base/line_reader.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <vector>

#include "support/temporary_folder.h"

namespace fleetpub::base {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<std::string> ListLines(std::string_view content) {
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
  EXPECT_THAT(ListLines(""), IsEmpty());
  EXPECT_THAT(ListLines("a\n"), ElementsAre("a"));
  EXPECT_THAT(ListLines("a\n\nb"), ElementsAre("a", "", "b"));
  EXPECT_THAT(ListLines("\n"), ElementsAre(""));
}

TEST(LineReader, HandsOutLinesLargerThanWhatIsReadAtOnce) {
  const std::string large(700'000, 'x');
  const std::string small(99'999, 'y');
  EXPECT_THAT(ListLines(large + "\n" + small + "\n" + large + "\n" + small),
              ElementsAre(large, small, large, small));
}

TEST(LineReader, RefusesALineThatIsTooLong) {
  const fleetpub::testing::TemporaryFolder folder;
  auto reader = LineReader::Open(folder.Write("lines", "a\n" + std::string(300'000, 'x')));
  EXPECT_EQ(reader->Next(10).value(), "a");
  const auto line = reader->Next(10);
  ASSERT_FALSE(line);
  EXPECT_THAT(line.error().message, HasSubstr("has a line of more than 10 bytes"));
  EXPECT_EQ(reader->Next(10).value(), std::nullopt);
}

TEST(LineReader, GoesOnBehindALineThatIsTooLong) {
  const fleetpub::testing::TemporaryFolder folder;
  const std::string content =
      std::string(700'000, 'x') + "\na\n" + std::string(11, 'y') + "\nb\n" + std::string(20, 'z');
  auto reader = LineReader::Open(folder.Write("lines", content));
  std::vector<std::string> got;
  for (int i = 0; i < 5; ++i) {
    const auto line = reader->Next(10);
    EXPECT_TRUE(line || line.error().kind == ErrorKind::kInvalid);
    got.push_back(line ? std::string(line->value()) : "too long");
  }
  EXPECT_THAT(got, ElementsAre("too long", "a", "too long", "b", "too long"));
  EXPECT_EQ(reader->Next(10).value(), std::nullopt);
}

TEST(LineReader, PassesOverAByteOrderMarkAtTheBeginningOnly) {
  const fleetpub::testing::TemporaryFolder folder;
  std::ofstream(folder / "list") << "\xEF\xBB\xBF"
                                    "a\n"
                                    "\xEF\xBB\xBF"
                                    "b\n";
  auto reader = LineReader::Open(folder / "list");
  EXPECT_EQ(reader->Next().value(), "a");
  EXPECT_EQ(reader->Next().value(),
            "\xEF\xBB\xBF"
            "b");
}

TEST(LineReader, TellsWhetherALineIsThereWithoutWaitingForIt) {
  const fleetpub::testing::TemporaryFolder folder;
  const std::string pipe = (folder / "pipe").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int writer = open(pipe.c_str(), O_RDWR | O_CLOEXEC);
  auto reader = LineReader::Open(pipe);
  EXPECT_FALSE(reader->Ready());
  ASSERT_EQ(write(writer, "a\nb", 3), 3);
  EXPECT_TRUE(reader->Ready());
  EXPECT_EQ(reader->Next().value(), "a");
  EXPECT_FALSE(reader->Ready());
  ASSERT_EQ(write(writer, "c\n", 2), 2);
  EXPECT_TRUE(reader->Ready());
  EXPECT_EQ(reader->Next().value(), "bc");
  close(writer);
  EXPECT_TRUE(reader->Ready());
  EXPECT_EQ(reader->Next().value(), std::nullopt);
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
