#include "base/file.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <array>

#include "support/temporary_folder.h"

namespace fleetpub::base {
namespace {

using ::testing::HasSubstr;

class File : public ::testing::Test {
 protected:
  testing::TemporaryFolder folder_;
};

TEST_F(File, IsReadToItsLastByte) {
  const std::string content = std::string(200'000, 'x') + std::string("\0\n", 2);
  EXPECT_EQ(ReadFile(folder_.Write("large", content)), content);
  EXPECT_EQ(ReadFile(folder_.Write("empty", "")), "");
}

TEST_F(File, ThatIsMissingIsNamed) {
  const auto path = folder_ / "missing.json";
  const auto content = ReadFile(path);
  ASSERT_FALSE(content);
  EXPECT_EQ(content.error().kind, ErrorKind::kLedger);
  EXPECT_EQ(content.error().message,
            "cannot open " + path.string() + ": No such file or directory");
}

TEST_F(File, ThatIsAFolderIsRefused) {
  const auto content = ReadFile(folder_.path());
  ASSERT_FALSE(content);
  EXPECT_EQ(content.error().message, "cannot read " + folder_.path().string() + ": Is a directory");
}

TEST_F(File, MayBeAsLargeAsTheLimitAndNoLarger) {
  const auto path = folder_.Write("file", "12345");
  EXPECT_EQ(ReadFile(path, 5), "12345");
  const auto content = ReadFile(path, 4);
  ASSERT_FALSE(content);
  EXPECT_EQ(content.error().message, path.string() + " is too large: more than 4 bytes");
}

TEST_F(File, WithoutAnEndIsGivenUpAtTheLimit) {
  EXPECT_THAT(ReadFile("/dev/zero", 100'000).error().message, HasSubstr("too large"));
}

TEST(ReadAll, ReadsAPipeToItsEnd) {
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  ASSERT_EQ(write(ends[1], "from a pipe", 11), 11);
  close(ends[1]);
  EXPECT_EQ(ReadAll(ends[0], "standard input"), "from a pipe");
  close(ends[0]);
}

TEST(ReadAll, NamesWhatCannotBeRead) {
  const auto content = ReadAll(-1, "standard input");
  ASSERT_FALSE(content);
  EXPECT_EQ(content.error().message, "cannot read standard input: Bad file descriptor");
}

}  // namespace
}  // namespace fleetpub::base
