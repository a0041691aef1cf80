// Files of every kind, whole, damaged and in parts.
#include "recording/reader.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <chrono>
#include <thread>

#include "base/file.h"
#include "recording/file.h"
#include "recording/writer.h"
#include "support/temporary_folder.h"

namespace fleetpub::recording {
namespace {

using fleetpub::testing::TemporaryFolder;
using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Message Said(std::string payload, std::int64_t t = 0) {
  Message message;
  message.t = std::chrono::microseconds(t);
  message.at = base::WallTime(std::chrono::seconds(1'700'000'000));
  message.topic = "a/b";
  message.payload = std::move(payload);
  return message;
}

// All payloads, and what was wrong.
struct Contents {
  std::vector<std::string> payloads;
  Faults faults;
  std::optional<Error> error;
};

Contents ReadAll(const std::filesystem::path& path) {
  Contents contents;
  auto reader = Reader::Open(path);
  if (!reader) return {.error = reader.error()};
  for (;;) {
    const auto message = reader->NextMessage();
    if (!message) contents.error = message.error();
    if (!message || !*message) break;
    contents.payloads.push_back((*message)->payload);
  }
  contents.faults = reader->faults();
  return contents;
}

class RecordingFile : public ::testing::TestWithParam<const char*> {
 protected:
  [[nodiscard]] std::unique_ptr<Writer> Open(Rotation rotation = {},
                                             std::size_t most_waiting = 1 << 20) const {
    auto writer = Writer::Open({.path = path_, .rotation = rotation, .most_waiting = most_waiting});
    EXPECT_TRUE(writer) << writer.error().message;
    return writer ? *std::move(writer) : nullptr;
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / GetParam();
};

TEST_P(RecordingFile, ComesBackWhole) {
  const auto writer = Open();
  for (const char* payload : {"1", "", "\xff", "ä"}) ASSERT_TRUE(writer->Add(Said(payload)));
  const auto written = writer->End();
  ASSERT_TRUE(written) << written.error().message;
  EXPECT_EQ(written->messages, 4U);
  EXPECT_EQ(written->bytes, std::filesystem::file_size(path_));
  const Contents contents = ReadAll(path_);
  EXPECT_THAT(contents.payloads, ElementsAre("1", "", "\xff", "ä"));
  EXPECT_FALSE(contents.faults.is_cut_off || contents.faults.is_altered);
  EXPECT_EQ(contents.faults.unreadable, 0U);
}

TEST_P(RecordingFile, IsTheOwnersAlone) {
  const auto writer = Open();
  struct stat status {};
  ASSERT_EQ(stat(path_.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600U);
  const auto again = Writer::Open({.path = path_});
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().kind, ErrorKind::kLedger);
}

TEST_P(RecordingFile, CanBeReadWhileItIsWritten) {
  const auto writer = Open();
  ASSERT_TRUE(writer->Add(Said("1")));
  for (int i = 0; i < 500 && ReadAll(path_).payloads.empty(); ++i) {
    ASSERT_TRUE(writer->Add(Said("2")));
    std::this_thread::sleep_for(std::chrono::microseconds(10'000));
  }
  const Contents contents = ReadAll(path_);
  ASSERT_FALSE(contents.payloads.empty());
  EXPECT_EQ(contents.payloads.front(), "1");
  EXPECT_TRUE(contents.faults.is_cut_off);
  EXPECT_EQ(contents.faults.unreadable, 0U);
}

TEST_P(RecordingFile, CanBeReadToWhereItWasCutOff) {
  const auto writer = Open();
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(writer->Add(Said(std::to_string(i * 7919))));
  ASSERT_TRUE(writer->End());
  const std::string whole = *base::ReadFile(path_);
  for (const std::size_t size : {whole.size() - 90, whole.size() / 2}) {
    const Contents contents = ReadAll(folder_.Write("cut", whole.substr(0, size)));
    EXPECT_TRUE(contents.faults.is_cut_off) << size;
    EXPECT_EQ(contents.faults.unreadable, 0U) << contents.faults.first;
    EXPECT_FALSE(contents.error);
  }
}

// Its writer has ended without a word, or goes on.
TEST_P(RecordingFile, CanBeReadToTheLastByteThatWasFlushed) {
  auto file = OutputFile::Create(path_);
  ASSERT_TRUE(file) << file.error().message;
  const std::string line = std::string(100, 'x') + "\n";
  std::size_t written = 0;
  for (int part = 0; part < 3; ++part) {
    for (int i = 0; i < 1'000; ++i, ++written) ASSERT_TRUE(file->Write(line));
    ASSERT_TRUE(file->Flush());
  }
  auto input = InputFile::Open(path_);
  ASSERT_TRUE(input);
  std::size_t read = 0;
  while (*input->Next()) ++read;
  EXPECT_EQ(read, written);
}

TEST_P(RecordingFile, BeginsANewPartAndIsReadInTheirOrder) {
  const auto writer = Open({.bytes = 1});
  for (const char* payload : {"1", "2", "3"}) {
    ASSERT_TRUE(writer->Add(Said(payload)));
    const auto next = PartPath(path_, payload[0] - '0' + 1);
    for (int i = 0; i < 500 && !std::filesystem::exists(next); ++i)
      std::this_thread::sleep_for(std::chrono::microseconds(10'000));
  }
  ASSERT_TRUE(writer->End());
  EXPECT_FALSE(std::filesystem::exists(path_));
  const Contents contents = ReadAll(path_);
  EXPECT_THAT(contents.payloads, ElementsAre("1", "2", "3"));
  EXPECT_FALSE(contents.faults.is_cut_off || contents.faults.is_altered);
}

TEST_P(RecordingFile, SaysWhatItCouldNotKeep) {
  const auto writer = Open({}, 4000);
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(writer->Add(Said(std::string(1000, 'x'))));
  const auto written = writer->End();
  ASSERT_TRUE(written);
  EXPECT_GT(written->lost, 0U);
  EXPECT_EQ(written->messages + written->lost, 100U);
  auto reader = Reader::Open(path_);
  std::uint64_t lost = 0;
  for (auto entry = reader->Next(); entry && *entry; entry = reader->Next()) {
    if (const auto* event = std::get_if<Event>(&**entry)) lost += event->messages;
  }
  EXPECT_EQ(lost, written->lost);
}

INSTANTIATE_TEST_SUITE_P(Plain, RecordingFile, ::testing::Values("shift.jsonl"));
INSTANTIATE_TEST_SUITE_P(Gzip, RecordingFile, ::testing::Values("shift.jsonl.gz"));
INSTANTIATE_TEST_SUITE_P(Zstd, RecordingFile, ::testing::Values("shift.jsonl.zst"));

class RecordingReader : public ::testing::Test {
 protected:
  [[nodiscard]] Contents Read(std::string_view text) const {
    return ReadAll(folder_.Write("file", text));
  }
  TemporaryFolder folder_;
};

TEST_F(RecordingReader, SaysThatAFileWasChanged) {
  auto writer = Writer::Open({.path = folder_ / "a.jsonl"});
  ASSERT_TRUE((*writer)->Add(Said("original")));
  ASSERT_TRUE((*writer)->End());
  std::string text = *base::ReadFile(folder_ / "a.jsonl");
  text.replace(text.find("original"), 8, "modified");
  const Contents contents = Read(text);
  EXPECT_THAT(contents.payloads, ElementsAre("modified"));
  EXPECT_TRUE(contents.faults.is_altered);
}

TEST_F(RecordingReader, PassesOverLinesThatItCannotRead) {
  const Contents contents = Read(
      "\xef\xbb\xbf{\"topic\":\"a\",\"payload\":\"1\"}\r\n\n{\"topic\":\"a\",\"payl\n"
      "{\"unknown\":1}\n{\"topic\":\"a\",\"payload\":\"2\"}");
  EXPECT_THAT(contents.payloads, ElementsAre("1", "2"));
  EXPECT_EQ(contents.faults.unreadable, 1U);
  EXPECT_THAT(contents.faults.first, HasSubstr("file:3: "));
  EXPECT_FALSE(contents.faults.is_cut_off);
}

TEST_F(RecordingReader, SaysThatAFileIsNoRecording) {
  for (const std::string_view text : {"hello\nworld\n", "\x1f\x8b\x08\x00garbage", "{]\n"}) {
    const Contents contents = Read(text);
    EXPECT_THAT(contents.payloads, IsEmpty());
  }
  EXPECT_EQ(Read("hello\n").error->kind, ErrorKind::kInvalid);
  EXPECT_EQ(ReadAll(folder_ / "none").error->kind, ErrorKind::kLedger);
  EXPECT_EQ(ReadAll(folder_.path()).error->kind, ErrorKind::kLedger);
  EXPECT_FALSE(Read("").error);
}

TEST_F(RecordingReader, PutsRowsTogetherThatHaveLineEnds) {
  const Contents contents = Read("a,\"{\n}\",0,False,10,0\nb,x,0,False,11.5,1.5\n");
  EXPECT_THAT(contents.payloads, ElementsAre("{\n}", "x"));
  auto reader = Reader::Open(folder_ / "file");
  EXPECT_EQ((*reader->NextMessage())->t.count(), 0);
  EXPECT_EQ((*reader->NextMessage())->t.count(), 1'500'000);
}

TEST_F(RecordingReader, BeginsWithTheFirstMessageWhereNoTimeIsSaid) {
  folder_.Write("file", R"({"tst":"2026-11-29T07:12:08.000000Z+0000","topic":"a","payload":""}
{"tst":"2026-11-29T07:12:08.250000Z+0000","topic":"a","payload":""}
)");
  auto reader = Reader::Open(folder_ / "file");
  EXPECT_EQ((*reader->NextMessage())->t.count(), 0);
  EXPECT_EQ((*reader->NextMessage())->t.count(), 250'000);
}

TEST(PartPath, PutsTheNumberBeforeTheSuffixes) {
  EXPECT_EQ(PartPath("x/shift.jsonl.zst", 2), "x/shift.0002.jsonl.zst");
  EXPECT_EQ(PartPath("shift", 12), "shift.0012");
  EXPECT_EQ(PartPath(".hidden.jsonl", 1), ".hidden.0001.jsonl");
}

}  // namespace
}  // namespace fleetpub::recording
