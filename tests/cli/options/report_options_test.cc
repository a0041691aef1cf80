#include "cli/options/report_options.h"

#include <gmock/gmock.h>

#include "base/file.h"
#include "support/temporary_folder.h"

namespace fleetpub::cli {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::TemporaryFolder;

TestReport MakeReport() {
  TestReport report{.name = "test", .started = base::WallTime::clock::now()};
  report.results = {{"H", "H02", "says it", app::Verdict::kFail, "it does not", {}}};
  return report;
}

TEST(ReportFiles, AreNamedByKind) {
  const TemporaryFolder folder;
  const auto files = ParseReportFiles(
      {"tap=" + (folder.path() / "a").string() + ",json=" + (folder.path() / "b").string()});
  ASSERT_TRUE(files);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << "nothing was tested yet";
  ASSERT_TRUE(WriteReports(*files, MakeReport()));
  EXPECT_THAT(*base::ReadFile(folder.path() / "a"), HasSubstr("TAP version"));
  EXPECT_THAT(*base::ReadFile(folder.path() / "b"),
              AllOf(HasSubstr(R"("failed":1)"), HasSubstr(R"("tool":"fleetpub )")));
  for (const char* word : {"xml=a", "junit", "junit=", "=a", "json=-"}) {
    EXPECT_EQ(ParseReportFiles({word}).error().kind, ErrorKind::kUsage) << word;
  }
}

TEST(ReportFiles, AreDifferentOnes) {
  const TemporaryFolder folder;
  const std::string a = (folder / "a").string();
  const std::string same = (folder / "." / "a").string();
  EXPECT_EQ(ParseReportFiles({"junit=" + a + ",tap=" + a}).error().kind, ErrorKind::kUsage);
  EXPECT_EQ(ParseReportFiles({"junit=" + a, "tap=" + same}).error().kind, ErrorKind::kUsage);
  EXPECT_EQ(ParseReportFiles({"junit=no-file,tap=./no-file"}).error().kind, ErrorKind::kUsage);
  EXPECT_TRUE(ParseReportFiles({"junit=" + a, "tap=" + a + "b"}));
}

TEST(ReportFiles, ThatCannotBeWrittenAreRefusedBefore) {
  const TemporaryFolder folder;
  const auto file = folder.Write("there", "as it was");
  for (const std::string& path :
       {std::string("/no/such/folder/a"), folder.path().string(), file.string() + "/a"}) {
    const auto refused = ParseReportFiles({"junit=" + path});
    ASSERT_FALSE(refused) << path;
    EXPECT_EQ(refused.error().kind, ErrorKind::kLedger);
    EXPECT_THAT(refused.error().message, HasSubstr(path));
  }
  EXPECT_TRUE(ParseReportFiles({"junit=" + file.string()}));
  EXPECT_EQ(*base::ReadFile(file), "as it was");
}

}  // namespace
}  // namespace fleetpub::cli
