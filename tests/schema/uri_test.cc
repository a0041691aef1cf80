#include "schema/uri.h"

#include <gtest/gtest.h>

#include <array>

namespace fleetpub::schema {
namespace {

// RFC 3986 §5.4, and what schemas do.
TEST(Uri, ResolvesAsTheStandardSays) {
  struct Example {
    std::string_view base, reference, result;
  };
  constexpr std::string_view kBase = "http://a/b/c/d?q";
  for (const auto& [base, reference, result] : {
           Example{kBase, "g:h", "g:h"},
           Example{kBase, "g", "http://a/b/c/g"},
           Example{kBase, "./g", "http://a/b/c/g"},
           Example{kBase, "g/", "http://a/b/c/g/"},
           Example{kBase, "/g", "http://a/g"},
           Example{kBase, "//g", "http://g"},
           Example{kBase, "?y", "http://a/b/c/d?y"},
           Example{kBase, "#s", "http://a/b/c/d?q#s"},
           Example{kBase, "", "http://a/b/c/d?q"},
           Example{kBase, ".", "http://a/b/c/"},
           Example{kBase, "..", "http://a/b/"},
           Example{kBase, "../../g", "http://a/g"},
           Example{kBase, "../../../g", "http://a/g"},
           Example{"http://a", "g", "http://a/g"},
           Example{"", "#/definitions/a", "#/definitions/a"},
           Example{"", "x.json", "x.json"},
           Example{"urn:uuid:1", "#a", "urn:uuid:1#a"},
       }) {
    EXPECT_EQ(ResolveUri(base, reference), result) << base << " + " << reference;
  }
}

TEST(Uri, SplitsAndDecodesTheFragment) {
  using Parts = std::pair<std::string, std::string>;
  EXPECT_EQ(SplitFragment("a#/b%25c%2Fd"), Parts("a", "/b%c/d"));
  EXPECT_EQ(SplitFragment("a"), Parts("a", ""));
  EXPECT_EQ(SplitFragment("#%"), Parts("", "%"));
  EXPECT_EQ(SplitFragment("#%4"), Parts("", "%4"));
  EXPECT_EQ(SplitFragment("#%zz"), Parts("", "%zz"));
}

}  // namespace
}  // namespace fleetpub::schema
