#include "delivery/topic_filter.h"

#include <gtest/gtest.h>

#include <array>
#include <string_view>

namespace fleetpub::delivery {
namespace {

struct Case {
  std::string_view filter;
  std::string_view topic;
  bool matches;
};

// The examples of MQTT 3.1.1 §4.7 among them.
constexpr std::array kCases = {
    Case{"a/b", "a/b", true},     Case{"a/b", "a/b/c", false},   Case{"a/b", "a", false},
    Case{"a/+", "a/b", true},     Case{"a/+", "a/", true},       Case{"a/+", "a", false},
    Case{"a/+", "a/b/c", false},  Case{"+/+", "/a", true},       Case{"/+", "/a", true},
    Case{"+", "/a", false},       Case{"a/#", "a", true},        Case{"a/#", "a/b/c", true},
    Case{"a/#", "ab", false},     Case{"#", "a/b", true},        Case{"+/b/#", "a/b/c/d", true},
    Case{"#", "$SYS/x", false},   Case{"+/x", "$SYS/x", false},  Case{"$SYS/#", "$SYS/x", true},
    Case{"a/+/c", "a/b/c", true}, Case{"a/+/c", "a/b/d", false},
};

TEST(TopicFilter, MatchesAsABrokerDoes) {
  for (const auto& [filter, topic, matches] : kCases) {
    EXPECT_EQ(Matches(filter, topic), matches) << filter << " " << topic;
  }
}

TEST(TopicFilter, KnowsItsWildcards) {
  EXPECT_TRUE(HasWildcard("a/+/b"));
  EXPECT_TRUE(HasWildcard("#"));
  EXPECT_FALSE(HasWildcard("a/b"));
}

}  // namespace
}  // namespace fleetpub::delivery
