#include "base/json_place.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

namespace fleetpub::base {
namespace {

std::string Written(const JsonPlace& place) {
  return std::to_string(place.line) + ":" + std::to_string(place.column);
}

TEST(JsonPlace, IsWhereAMembersNameOrAnElementBegins) {
  constexpr std::string_view kText = R"({
  "a": {"x": "}, \"[", "y": [1, {"z": null}]},
  "b/c~": [[], "text",
    -1.5e3, true]
})";
  const std::pair<std::string_view, std::string_view> cases[] = {
      {"", "1:1"},           {"/a", "2:3"},         {"/a/y", "2:24"},      {"/a/y/1", "2:33"},
      {"/a/y/1/z", "2:34"},  {"/b~1c~0", "3:3"},    {"/b~1c~0/1", "3:16"}, {"/b~1c~0/2", "4:5"},
      {"/b~1c~0/3", "4:13"}, {"/a/missing", "2:3"}, {"/a/y/7", "2:24"},    {"/a/x/deeper", "2:9"},
  };
  for (const auto& [pointer, place] : cases) {
    EXPECT_EQ(Written(FindPlace(kText, pointer)), place) << pointer;
  }
}

TEST(JsonPlace, IsFoundForManyAtOnceInAnyOrder) {
  const std::vector<std::string> pointers = {"/b/1", "", "/a", "/b/1", "/b/0/x", "/c/d"};
  std::vector<std::string> places;
  for (const JsonPlace& place : FindPlaces("{\"a\":1,\n\"b\":[{\"x\":0},\n2]}", pointers)) {
    places.push_back(Written(place));
  }
  EXPECT_EQ(places, (std::vector<std::string>{"3:1", "1:1", "1:2", "3:1", "2:7", "1:1"}));
}

TEST(JsonPlace, KnowsAnEscapedName) {
  EXPECT_EQ(Written(FindPlace("{\"x\":1,\n \"\\u0061\":2}", "/a")), "2:2");
}

TEST(JsonPlace, HasNoFaultInWhatIsJson) {
  EXPECT_FALSE(FindFault(R"({"a":[1,2]})"));
  const auto fault = FindFault("{\"a\":1,\n \"b\":}");
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->line, 2U);
  EXPECT_TRUE(FindFault(""));
}

}  // namespace
}  // namespace fleetpub::base
