// fleetpub layout check, show and route, and what completes their words.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include "layout/layouts.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAre;

class LayoutCommand : public ::testing::Test {
 protected:
  [[nodiscard]] Finished Fleetpub(std::vector<std::string> arguments) const {
    return operator_.Fleetpub(std::move(arguments));
  }
  [[nodiscard]] std::string Write(const std::string& name, const std::string& text) const {
    return operator_.home().Write(name, text).string();
  }
  // n1 to n3 in a line, both ways; a station at n3 and n2.
  [[nodiscard]] std::string WriteHall() const {
    const std::string scan =
        R"({"vehicleTypeId":"T","actions":[{"actionType":"beep","blockingType":"NONE",)"
        R"("requirementType":"REQUIRED"}]})";
    return Write(
        "hall.lif.json",
        FileText({NodeText("n1", 0, 0), NodeText("n2", 10, 0, scan), NodeText("n3", 10, 13.4)},
                 {EdgeText("n1", "n2"), EdgeText("n2", "n1"), EdgeText("n2", "n3"),
                  EdgeText("n3", "n2")},
                 R"({"stationId":"dock-3","stationName":"Dock 3","interactionNodeIds":["n3"]})"));
  }
  void Configure(const std::string& text) const {
    const std::string file = Write(".config/fleetpub/config.toml", text);
    chmod(file.c_str(), 0600);
  }
  [[nodiscard]] std::vector<std::string> Candidates(std::vector<std::string> words) const {
    words.insert(words.begin(), "__complete");
    std::vector<std::string> texts;
    for (const std::string& line : Lines(Fleetpub(words).output)) {
      texts.push_back(line.substr(0, line.find('\t')));
    }
    return texts;
  }

  Operator operator_;
};

TEST_F(LayoutCommand, ShowsARouteToAPersonAndToAProgram) {
  const std::string hall = WriteHall();
  const Finished text = Fleetpub({"layout", "route", hall, "--from", "n1", "--to", "Dock 3"});
  EXPECT_EQ(text.exit_code, 0) << text.errors;
  EXPECT_THAT(text.output, AllOf(HasSubstr("n1 → n2 → n3"), HasSubstr("23.4 m"),
                                 HasSubstr("1 action"), HasSubstr("Dock 3")));
  const Finished json = Fleetpub({"layout", "route", hall, "--from", "n3", "--via", "n1", "--to",
                                  "dock-3", "--by", "time", "--speed", "2", "-o", "json"});
  ASSERT_EQ(json.exit_code, 0) << json.errors;
  const auto route = Json(json.output);
  EXPECT_EQ(route["nodes"].Size(), 5U);
  EXPECT_EQ(route["edges"].Size(), 4U);
  EXPECT_DOUBLE_EQ(route["length"].GetDouble(), 46.8);
  EXPECT_DOUBLE_EQ(route["seconds"].GetDouble(), 23.4);
  EXPECT_STREQ(route["stops"][0]["place"].GetString(), "n1");
  EXPECT_STREQ(route["stops"][1]["node"].GetString(), "n3");
}

TEST_F(LayoutCommand, TellsWhyThereIsNoRoute) {
  const std::string one_way = Write(
      "one.json", FileText({NodeText("n1", 0, 0), NodeText("n2", 1, 0)}, {EdgeText("n2", "n1")}));
  const Finished run = Fleetpub({"layout", "route", one_way, "--from", "n1", "--to", "n2"});
  EXPECT_EQ(run.exit_code, 7);
  EXPECT_THAT(run.errors, HasSubstr("n2-n1"));
  EXPECT_EQ(Fleetpub({"layout", "route", one_way, "--from", "n1"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"layout", "route", one_way, "--from", "n1", "--to", "x"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"layout", "route", one_way, "--from", "n1", "--to", "n2", "--by", "luck"})
                .exit_code,
            2);
  EXPECT_EQ(
      Fleetpub({"layout", "route", one_way, "--from", "n1", "--to", "n2", "--vehicle-type", "none"})
          .exit_code,
      2);
}

TEST_F(LayoutCommand, ChecksWithPlacesAndExitCodes) {
  const std::string hall = WriteHall();
  const std::string bad =
      Write("bad.json", FileText({NodeText("a", 0, 0, R"({"vehicleTypeId":"T","theta":90})")}, {}));
  const Finished good = Fleetpub({"layout", "check", hall});
  EXPECT_EQ(good.exit_code, 0) << good.output << good.errors;
  const Finished both = Fleetpub({"layout", "check", hall, bad, "-o", "json"});
  EXPECT_EQ(both.exit_code, 3);
  const auto lines = Lines(both.output);
  ASSERT_FALSE(lines.empty());
  const auto summary = Json(lines.back());
  EXPECT_EQ(summary["summary"]["files"].GetInt(), 2);
  EXPECT_EQ(summary["summary"]["errors"].GetInt(), 1);
  EXPECT_EQ(summary["summary"]["exitCode"].GetInt(), 3);
  std::size_t errors = 0;
  for (const std::string& line : lines) {
    const auto finding = Json(line);
    if (!finding.HasMember("level") || finding["level"] != "error") continue;
    ++errors;
    EXPECT_STREQ(finding["file"].GetString(), bad.c_str());
    EXPECT_THAT(finding["path"].GetString(), HasSubstr("/theta"));
    EXPECT_GT(finding["column"].GetInt(), 100);
  }
  EXPECT_EQ(errors, 1U);
  EXPECT_THAT(Fleetpub({"layout", "check", bad}).output, HasSubstr("bad.json:1:"));
}

TEST_F(LayoutCommand, RefusesWhatIsNoLayout) {
  for (const std::string text : {"", "{}", "[1", "\xff", R"({"layouts":3})"}) {
    const std::string file = Write("odd.json", text);
    EXPECT_EQ(Fleetpub({"layout", "check", file}).exit_code, 3) << text;
    EXPECT_EQ(Fleetpub({"layout", "show", file}).exit_code, 3) << text;
  }
  EXPECT_THAT(Fleetpub({"layout", "check", Write("cut.json", "{\n\"layouts\": [,]}")}).output,
              HasSubstr("cut.json:2:"));
  EXPECT_EQ(Fleetpub({"layout", "check", "/there/is/none"}).exit_code, 8);
  EXPECT_EQ(Fleetpub({"layout", "show"}).exit_code, 2);
}

TEST_F(LayoutCommand, HoldsALayoutAgainstVersionAndFactsheet) {
  const std::string odd = Write(
      "odd.json",
      FileText({NodeText("n1", 0, 0,
                         R"({"vehicleTypeId":"KIT.tug","actions":[{"actionType":"initPosition",)"
                         R"("blockingType":"HARD","requirementType":"OPTIONAL"}]})"),
                NodeText("n2", 5, 0, R"({"vehicleTypeId":"KIT.tug"})")},
               {}));
  const std::string sheet = Write(
      "sheet.json",
      R"({"manufacturer":"KIT","typeSpecification":{"seriesName":"tug"},"protocolLimits":)"
      R"({"maxStringLens":{"idLen":1}},"protocolFeatures":{"agvActions":[{"actionType":"beep"}]}})");
  EXPECT_THAT(Fleetpub({"layout", "check", odd}).output,
              HasSubstr("version 3.0.0 calls it initializePosition"));
  EXPECT_THAT(Fleetpub({"layout", "check", odd, "--vda", "2.1"}).output,
              AllOf(HasSubstr("parameter"), Not(HasSubstr("calls it"))));
  EXPECT_THAT(Fleetpub({"layout", "check", odd, "--factsheet", sheet}).output,
              AllOf(HasSubstr("longer"), HasSubstr("not in the factsheet")));
}

TEST_F(LayoutCommand, ShowsWhatALayoutHolds) {
  const std::string hall = WriteHall();
  const Finished text = Fleetpub({"layout", "show", hall});
  EXPECT_THAT(text.output, AllOf(HasSubstr("hall"), HasSubstr("dock-3"), HasSubstr("10.0 x 13.4")));
  for (const std::string& line : Lines(text.output)) EXPECT_LE(line.size(), 80U);
  const auto json = Json(Fleetpub({"layout", "show", hall, "-o", "json"}).output);
  EXPECT_EQ(json["layouts"][0]["nodes"].GetInt(), 3);
  EXPECT_EQ(json["layouts"][0]["extent"]["maxY"].GetDouble(), 13.4);
  EXPECT_STREQ(json["stations"][0]["nodes"][0].GetString(), "n3");
}

TEST_F(LayoutCommand, TakesTheProfilesLayoutAndCompletesItsPlaces) {
  const std::string hall = WriteHall();
  Configure("[profile.north]\nlayout = \"../../hall.lif.json\"\n");
  const Finished run =
      Fleetpub({"layout", "route", "--profile", "north", "--from", "n1", "--to", "n2"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(Fleetpub({"config", "show", "--profile", "north"}).output,
              HasSubstr("hall.lif.json"));
  EXPECT_THAT(Candidates({"layout", "route", "--profile", "north", "--from", ""}),
              ElementsAre("dock-3", "n1", "n2", "n3"));
  EXPECT_THAT(Candidates({"layout", "route", hall, "--from", "n1", "--to", "d"}),
              ElementsAre("dock-3"));
  EXPECT_THAT(Candidates({"layout", "route", hall, "--vehicle-type", ""}), ElementsAre("T"));
  EXPECT_THAT(Candidates({"layout", "route", "--from", ""}), SizeIs(0));
  EXPECT_THAT(Candidates({"layout", ""}), UnorderedElementsAre("check", "show", "route"));
}

}  // namespace
}  // namespace fleetpub::testing
