#include "schema/values.h"

#include <gtest/gtest.h>

#include "base/json.h"

namespace fleetpub::schema {
namespace {

base::JsonDocument Parse(std::string_view text) { return std::move(base::ParseJson(text).value()); }

TEST(Values, AreEqualByMeaning) {
  struct Pair {
    std::string_view a, b;
    bool equal;
  };
  for (const auto& [a, b, equal] : {
           Pair{"1", "1.0", true},
           Pair{"0", "-0.0", true},
           Pair{"18446744073709551615", "-1", false},
           Pair{"9223372036854775808", "9223372036854775808.0", true},
           Pair{"9007199254740993", "9007199254740992.0", false},
           Pair{"1e300", "1e300", true},
           Pair{"1", "true", false},
           Pair{"null", "false", false},
           Pair{"\"a\"", "\"a\\u0000\"", false},
           Pair{R"({"a":1,"b":[2]})", R"({"b":[2.0],"a":1})", true},
           Pair{R"({"a":1})", R"({"b":1})", false},
           Pair{"[1,2]", "[2,1]", false},
           Pair{"[[],{}]", "[[],{}]", true},
       }) {
    EXPECT_EQ(Equal(Parse(a), Parse(b)), equal) << a << " " << b;
    // Repeats are found by another way, which must agree.
    const std::string both = "[" + std::string(a) + "," + std::string(b) + "]";
    EXPECT_EQ(FirstRepeat(Parse(both)).has_value(), equal) << both;
  }
}

TEST(Values, TheFirstRepeatIsTheEarliestOne) {
  const auto repeat = FirstRepeat(Parse(R"([3,"a",{"x":[]},"b","a",3])"));
  ASSERT_TRUE(repeat);
  EXPECT_EQ(repeat->first, 1U);
  EXPECT_EQ(repeat->second, 4U);
}

TEST(Values, CountsCharactersNotBytes) {
  EXPECT_EQ(CountCharacters("aä€😀"), 4U);
  EXPECT_EQ(CountCharacters(""), 0U);
}

TEST(Values, AreShownShort) {
  EXPECT_EQ(Shown(Parse(R"("LOUD")")), R"("LOUD")");
  EXPECT_EQ(Shown(Parse("[1]")), "an array");
  const std::string shown = Shown(Parse("\"" + std::string(45, 'x') + "ää€€€€€€€€\""));
  EXPECT_TRUE(shown.ends_with("… (55 characters)")) << shown;
}

}  // namespace
}  // namespace fleetpub::schema
