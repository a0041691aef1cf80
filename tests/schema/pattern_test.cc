#include "schema/pattern.h"

#include <gtest/gtest.h>

#include <string_view>

namespace fleetpub::schema {
namespace {

TEST(Pattern, ReadsEcmaExpressions) {
  struct Example {
    std::string_view expression, text;
    bool matches;
  };
  for (const auto& [expression, text, matches] : {
           Example{"b", "abc", true},
           Example{"^b", "abc", false},
           Example{"^a$", "a\n", false},
           Example{R"(^\d{3}-[a-z]+$)", "123-ab", true},
           Example{R"(^\u00e9$)", "é", true},
           Example{R"(^[\u00e0-\u00ff]+$)", "éö", true},
           Example{R"(^\ud83d\ude00$)", "😀", true},
           Example{"^.$", "😀", true},
           Example{R"(^\s$)", "\xC2\xA0", true},
           Example{R"(^\S$)", "\xC2\xA0", false},
           Example{R"(^[\sx]+$)", "x\v", true},
           Example{R"(^\cJ$)", "\n", true},
           Example{R"(^\/$)", "/", true},
           Example{"^(?<year>[0-9]+)$", "2026", true},
           Example{"^[^]$", "\n", true},
           Example{"^[]$", "]", false},
           Example{R"(^\p{Lu}$)", "Ä", true},
       }) {
    const auto pattern = Pattern::Compile(expression);
    ASSERT_TRUE(pattern) << expression << ": " << pattern.error().message;
    EXPECT_EQ(pattern->Matches(text), matches) << expression << " on " << text;
  }
}

TEST(Pattern, RefusesWhatIsNotRegular) {
  for (const char* expression :
       {"(?=a)", "(?!a)", "(?<=a)", "(?<!a)", R"((a)\1)", "(", "a{2,1}", "[b-a]", R"(\)"}) {
    EXPECT_FALSE(Pattern::Compile(expression)) << expression;
  }
}

}  // namespace
}  // namespace fleetpub::schema
