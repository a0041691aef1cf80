#include "cli/output/records.h"

#include <gmock/gmock.h>

namespace fleetpub::cli {
namespace {

using ::testing::HasSubstr;

constexpr std::string_view kObject =
    R"({"target":"KIT/0001","n":-1.5,"is":true,"none":null,"list":[{"id":"a"},2],"text":"x"})";

std::string Rendered(std::string_view output, std::string_view fields, std::string_view json) {
  auto records = Records::Make(output, fields, {"target", "n", "is", "none", "list", "text"});
  return records ? records->Render(json).value_or("as it is") : records.error().message;
}

TEST(Records, ShowJsonAsItIsUnlessItIsNarrowed) {
  EXPECT_EQ(Rendered("json", "", kObject), "as it is");
  EXPECT_EQ(Rendered("text", "", kObject), "as it is");
  EXPECT_EQ(Rendered("json", "n,list.0.id,list.7", kObject), "{\"n\":-1.5,\"list.0.id\":\"a\"}\n");
  EXPECT_EQ(Rendered("json", "n", R"({"summary":{}})"), "as it is");
}

TEST(Records, HaveARowForEachObjectAndOneHeading) {
  auto records = Records::Make("csv", "", {"target", "n", "list"}).value();
  EXPECT_EQ(records.Render(kObject),
            "target,n,list\nKIT/0001,-1.5,\"[{\"\"id\"\":\"\"a\"\"},2]\"\n");
  EXPECT_EQ(records.Render(R"({"n":2})"), ",2,\n");
  EXPECT_EQ(records.Render(R"({"summary":{"robots":2}})"), "");
  EXPECT_EQ(records.Render(R"({"error":{}})"), "");
}

TEST(Records, TakeTheFirstObjectsMembersWhereNobodyKnowsThem) {
  auto records = Records::Make("tsv", "", {}).value();
  EXPECT_EQ(records.Render(R"({"b":1,"a":"x"})"), "b\ta\n1\tx\n");
  EXPECT_EQ(records.Render(R"({"a":"y","c":3})"), "\ty\n");
}

TEST(Records, QuoteInCsvAndEscapeInTsv) {
  constexpr std::string_view kText = R"({"text":"a\tb\\c\n\"d\",\u001b[2J"})";
  EXPECT_EQ(Rendered("csv", "text", kText), "text\n\"a\\tb\\c\n\"\"d\"\",\\x1b[2J\"\n");
  EXPECT_EQ(Rendered("tsv", "text", kText), "text\na\\tb\\\\c\\n\"d\",\\x1b[2J\n");
}

TEST(Records, AreNoFormulasInCsv) {
  for (const std::string_view formula : {"=cmd()", "+1", "-1", "@x"}) {
    const std::string json = R"({"text":")" + std::string(formula) + R"("})";
    EXPECT_EQ(Rendered("csv", "text", json), "text\n'" + std::string(formula) + "\n");
    EXPECT_EQ(Rendered("tsv", "text", json), "text\n" + std::string(formula) + "\n");
  }
  EXPECT_EQ(Rendered("csv", "n", kObject), "n\n-1.5\n") << "a number is none";
}

TEST(Records, FillATemplate) {
  EXPECT_EQ(Rendered("template={target}: {list.0.id}{none}{{{n}}}\\t", "", kObject),
            "KIT/0001: a{-1.5}\t\n");
  EXPECT_EQ(Rendered("template={text}", "", R"({"text":"a\nb"})"), "a\\nb\n");
  EXPECT_EQ(Rendered("template={text}", "", R"({"summary":{}})"), "");
}

TEST(Records, RefuseWhatCannotBeMeant) {
  EXPECT_THAT(Rendered("csv", "targt", kObject), HasSubstr("did you mean target?"));
  EXPECT_THAT(Rendered("json", "n,,is", kObject), HasSubstr("no result"));
  EXPECT_THAT(Rendered("template={targt}", "", kObject), HasSubstr("did you mean target?"));
  for (const std::string_view text : {"template={target", "template=}", "template={}"}) {
    EXPECT_THAT(Rendered(text, "", kObject), HasSubstr("-o template:")) << text;
  }
  EXPECT_THAT(Rendered("text", "target", kObject), HasSubstr("--fields needs"));
}

}  // namespace
}  // namespace fleetpub::cli
