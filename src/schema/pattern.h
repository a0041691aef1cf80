// Regular expressions of schemas, in linear time: std::regex backtracks for hours on `^(a+)+$` and
// overflows the stack on long strings. The only user of RE2.
#pragma once

#include <memory>
#include <string_view>

#include "base/result.h"

namespace re2 {
class RE2;
}

namespace fleetpub::schema {

/// Finds a match anywhere in a text. May be used by several threads at once.
class Pattern {
 public:
  /// Takes ECMA 262 expressions as far as RE2 can: no lookaround, no backreference.
  /// ErrorKind::kInvalid says what it was.
  [[nodiscard]] static Result<Pattern> Compile(std::string_view expression);

  Pattern(Pattern&&) noexcept;
  Pattern& operator=(Pattern&&) noexcept;
  ~Pattern();

  [[nodiscard]] bool Matches(std::string_view text) const;

 private:
  explicit Pattern(std::unique_ptr<re2::RE2> expression);
  std::unique_ptr<re2::RE2> expression_;
};

}  // namespace fleetpub::schema
