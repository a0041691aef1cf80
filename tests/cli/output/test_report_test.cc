#include "cli/output/test_report.h"

#include <gmock/gmock.h>

#include "support/process.h"
#include "support/temporary_folder.h"

namespace fleetpub::cli {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::TemporaryFolder;

TestReport MakeReport() {
  TestReport report{
      .name = "conform KIT/<1>", .properties = {{"broker", "a & b"}}, .started = {}, .results = {}};
  report.results = {
      {"H", "H01", "keeps \"it\"", app::Verdict::kPass, "yes", {}},
      {"H", "H02", "says # once", app::Verdict::kFail, "no: <b>\x1b[1m</b>", {"state headerId 3"}},
      {"S", "S01", "comes", app::Verdict::kInconclusive, "nothing came", {}},
  };
  return report;
}

std::string Read(const std::vector<std::string>& arguments) {
  return testing::Run({.arguments = arguments}).output;
}

TEST(TestReport, JUnitIsReadByAnotherParser) {
  const TemporaryFolder folder;
  const auto file = folder.Write("out.xml", ToJUnit(MakeReport()));
  const std::string read =
      Read({"python3", "-c",
            "import sys, xml.etree.ElementTree as e\n"
            "r = e.parse(sys.argv[1]).getroot(); s = r.find('testsuite')\n"
            "print(r.tag, s.get('tests'), s.get('failures'), s.get('skipped'), s.get('name'))\n"
            "for c in s.findall('testcase'): print(c.get('name'), [x.tag for x in c])",
            file.string()});
  EXPECT_EQ(read,
            "testsuites 3 1 1 conform KIT/<1>\nH01 keeps \"it\" []\nH02 says # once ['failure']\n"
            "S01 comes ['skipped']\n");
}

TEST(TestReport, TapIsReadByProve) {
  const TemporaryFolder folder;
  const auto file = folder.Write("out.tap", ToTap(MakeReport()));
  const std::string read = Read({"prove", "-e", "cat", file.string()});
  EXPECT_THAT(read, AllOf(HasSubstr("Tests: 3 Failed: 1"), HasSubstr("Failed test:  2")));
}

TEST(TestReport, HtmlNeedsNobodyElseAndShowsNoForeignMarkup) {
  EXPECT_THAT(ToHtml(MakeReport()),
              AllOf(HasSubstr("H02"), HasSubstr("&lt;b&gt;"), Not(HasSubstr("http")),
                    Not(HasSubstr("\x1b")), Not(HasSubstr("<script"))));
}

}  // namespace
}  // namespace fleetpub::cli
