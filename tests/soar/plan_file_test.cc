#include "soar/plan_file.h"

#include <gmock/gmock.h>

#include <array>

#include "base/csv.h"

namespace fleetpub::soar {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

std::string Plan(std::string_view content, std::string_view name) {
  const auto plan = ReadPlan(content, name);
  return plan ? ItemsJson(plan->waypoints) : plan.error().message;
}

TEST(Csv, ReadsRowsAndKnowsTheirLines) {
  const auto rows = base::ParseCsv(
      "\xEF\xBB\xBF"
      "a,b\r\n\n\"x, \"\"y\"\"\nz\",\"\"\n,2");
  ASSERT_TRUE(rows) << rows.error().message;
  ASSERT_THAT(*rows, SizeIs(3));
  EXPECT_THAT((*rows)[0].fields, ElementsAre("a", "b"));
  EXPECT_THAT((*rows)[1].fields, ElementsAre("x, \"y\"\nz", ""));
  EXPECT_EQ((*rows)[1].line, 3U);
  EXPECT_THAT((*rows)[2].fields, ElementsAre("", "2"));
  EXPECT_EQ((*rows)[2].line, 5U);
  EXPECT_THAT(*base::ParseCsv(""), IsEmpty());
  EXPECT_THAT((*base::ParseCsv("a,b\r\n1,2\r"))[1].fields, ElementsAre("1", "2"));
}

TEST(Csv, SaysWhichLineIsNone) {
  struct Case {
    std::string_view text;
    std::string_view why;
  };
  constexpr std::array kCases = {
      Case{"a\n\"b", "line 2: a quotation mark is not closed"},
      Case{"a\n\"b\"c", "line 2: after a closing quotation mark"},
      Case{"a\n\n\xFF", "line 3: it is not valid UTF-8"},
  };
  for (const auto& [text, why] : kCases) {
    const auto rows = base::ParseCsv(text);
    ASSERT_FALSE(rows) << text;
    EXPECT_THAT(rows.error().message, HasSubstr(why));
  }
}

constexpr auto kTwo = R"([{"latitude_waypoint":50.37,"longitude_waypoint":-4.19,"depth":15,)"
                      R"("action":"move"},{"latitude_waypoint":50.36,"longitude_waypoint":-4.2}])";

TEST(PlanFile, ReadsCsvByItsHeader) {
  EXPECT_EQ(Plan("lon, Lat ,depth,action\n-4.19,50.37,15,move\n-4.2,50.36,,\n", "plan.csv"), kTwo);
  EXPECT_EQ(Plan("latitude_waypoint,longitude_waypoint\n", "plan.csv"), "[]");
}

TEST(PlanFile, ReadsJson) {
  constexpr auto kArray = R"([{"lat":50.37,"lon":-4.19,"depth":15,"action":"move"},
                              {"latitude_waypoint":50.36,"longitude_waypoint":-4.2}])";
  EXPECT_EQ(Plan(kArray, "plan.json"), kTwo);
  EXPECT_EQ(Plan(std::string(R"({"plan":)") + kArray + "}", "-"), kTwo);
  EXPECT_EQ(Plan(R"([{"lat":1,"lon":2,"speed":{"knots":3}}])", "x.json"),
            R"([{"latitude_waypoint":1,"longitude_waypoint":2,"speed":{"knots":3}}])")
      << "the format forbids no further members";
}

TEST(PlanFile, ReadsALineStringLongitudeFirst) {
  constexpr auto kLine = R"({"type":"LineString","coordinates":[[-4.19,50.37],[-4.2,50.36]]})";
  constexpr auto kPlan = R"([{"latitude_waypoint":50.37,"longitude_waypoint":-4.19},)"
                         R"({"latitude_waypoint":50.36,"longitude_waypoint":-4.2}])";
  const std::string feature =
      std::string(R"({"type":"Feature","properties":{},"geometry":)") + kLine + "}";
  EXPECT_EQ(Plan(kLine, "route.geojson"), kPlan);
  EXPECT_EQ(Plan(feature, "route.geojson"), kPlan);
  EXPECT_EQ(Plan(R"({"type":"FeatureCollection","features":[{"type":"Feature","geometry":)"
                 R"({"type":"Point","coordinates":[1,2]}},)" +
                     feature + "]}",
                 "-"),
            kPlan);
}

TEST(PlanFile, WarnsOfHeightsThatItDoesNotSend) {
  const auto plan = ReadPlan(R"({"type":"LineString","coordinates":[[1,2,-15]]})", "route.geojson");
  ASSERT_TRUE(plan);
  EXPECT_THAT(plan->warnings, ElementsAre(HasSubstr("third number")));
}

TEST(PlanFile, SaysWhereItIsNone) {
  struct Case {
    std::string_view content;
    std::string_view name;
    std::string_view why;
  };
  constexpr std::array kCases = {
      Case{"", "p.csv", "p.csv: it is empty"},
      Case{"", "-", "standard input: it is empty"},
      Case{"{}", "p.csv", "p.csv: line 1: the column '{}' is not known"},
      Case{"lat,lon,deph\n", "p.csv", "line 1: the column 'deph' is not known: there are lat"},
      Case{"lat,lon\n1,2\n3\n", "p.csv", "p.csv: line 3: it has 1 fields, the header has 2"},
      Case{"lat,lon\n1,2,3\n", "p.csv", "line 2: it has 3 fields"},
      Case{"lat,lon\n1,x\n", "p.csv",
           "p.csv: line 2: longitude_waypoint must be a number, not 'x'"},
      Case{"lat,lon\n\n1,\n", "p.csv", "line 3: longitude_waypoint is missing"},
      Case{"lat\n1\n", "p.csv", "line 2: longitude_waypoint is missing"},
      Case{"lat,lat,lon\n1,1,2\n", "p.csv", "latitude_waypoint is given twice"},
      Case{"lat,lon\n1,\xFF\n", "p.csv", "line 2: it is not valid UTF-8"},
      Case{"[", "p.json", "p.json: not valid JSON at line 1"},
      Case{"[1]", "p.json", "p.json: waypoint 1: it must be an object"},
      Case{R"([{"lat":1,"lon":2},{"lat":1}])", "p.json",
           "p.json: waypoint 2: longitude_waypoint is missing"},
      Case{R"([{"lat":"1","lon":2}])", "p.json", "latitude_waypoint must be a number"},
      Case{R"([{"lat":1,"lon":2,"latitude":3}])", "p.json", "given twice"},
      Case{"{}", "p.json", "it must be an array of waypoints"},
      Case{R"({"type":"Polygon","coordinates":[]})", "p.geojson",
           "from a LineString, not from a Polygon"},
      Case{R"({"type":"LineString"})", "p.geojson", "no array of coordinates"},
      Case{R"({"type":"LineString","coordinates":[[1,2],[1]]})", "p.geojson",
           "waypoint 2: a position must be [longitude, latitude]"},
      Case{R"({"type":"LineString","coordinates":[["1",2]]})", "p.geojson", "waypoint 1"},
      Case{R"({"type":"FeatureCollection","features":[]})", "p.geojson", "0 LineStrings"},
      Case{R"({"type":"FeatureCollection","features":7})", "p.geojson", "0 LineStrings"},
  };
  for (const auto& [content, name, why] : kCases) {
    const auto plan = ReadPlan(content, name);
    ASSERT_FALSE(plan) << content;
    EXPECT_EQ(plan.error().kind, ErrorKind::kInvalid);
    EXPECT_THAT(plan.error().message, HasSubstr(why)) << content;
  }
}

TEST(PlanFile, BearsWhatIsHugeOrDeep) {
  const std::string deep = std::string(100'000, '[');
  EXPECT_THAT(Plan(deep, "p.json"), HasSubstr("p.json: "));
  EXPECT_THAT(Plan(R"([{"lat":1,"lon":2,"x":)" + deep, "p.json"), HasSubstr("p.json: "));
  std::string rows = "lat,lon\n";
  for (int i = 0; i < 100'000; ++i) rows += "50.37,-4.19\n";
  EXPECT_THAT(ReadPlan(rows, "p.csv")->waypoints, SizeIs(100'000));
  EXPECT_THAT(Plan("lat,lon\n1," + std::string(1'000'000, '9') + "x\n", "p.csv").size(),
              ::testing::Lt(200U))
      << "what is shown of it is short";
}

}  // namespace
}  // namespace fleetpub::soar
