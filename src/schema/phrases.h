// What a schema asks of a value, in words: the second half of `must be …`.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/rapidjson.h"

namespace fleetpub::schema {

/// `a string`, `an integer between 0 and 4294967295`, `a string or a number`: `type`, with the
/// limits of a number.
[[nodiscard]] std::string TypePhrase(const base::JsonValue& schema);

/// `between 0 and 9`, `at least 0`, `more than 0 and at most 1`; empty without limits.
[[nodiscard]] std::string RangePhrase(const base::JsonValue& schema);

/// What kind of value it is, where its kind is what is wrong: `a number`, `null`; a number with a
/// fraction is shown where only the fraction is wrong.
[[nodiscard]] std::string KindPhrase(const base::JsonValue& value, const base::JsonValue& schema);

/// `one of NONE, SOFT, HARD`; the first dozen of many.
[[nodiscard]] std::string ChoicePhrase(const base::JsonValue& values);

/// `a`, `a or b`, `a, b or c`.
[[nodiscard]] std::string Alternatives(const std::vector<std::string>& parts);

}  // namespace fleetpub::schema
