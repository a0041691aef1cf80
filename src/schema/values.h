// What JSON Schema asks of single JSON values.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/rapidjson.h"

namespace fleetpub::schema {

/// `null`, `boolean`, `object`, `array`, `number` or `string`.
[[nodiscard]] std::string_view TypeName(const base::JsonValue& value);

/// A number without a fraction; 1.0 is one (draft-07 §6.1.1).
[[nodiscard]] bool IsInteger(const base::JsonValue& value);

/// The value is of the type, `integer` included.
[[nodiscard]] bool IsOfType(const base::JsonValue& value, std::string_view type);

/// Equal as JSON Schema compares (draft-07 §4.2.3): 1 is 1.0, members have no order.
[[nodiscard]] bool Equal(const base::JsonValue& a, const base::JsonValue& b);

/// The indices of two equal items, the later of which comes earliest. O(n log n): a message may
/// hold millions of items.
[[nodiscard]] std::optional<std::pair<std::size_t, std::size_t>> FirstRepeat(
    const base::JsonValue& array);

/// The limit that `minItems` and its like set; it may be written 3.0, or beyond 64 bits.
[[nodiscard]] std::uint64_t AsCount(const base::JsonValue& limit);

/// Unicode characters, not bytes. `text` is valid UTF-8.
[[nodiscard]] std::uint64_t CountCharacters(std::string_view text);

/// The value for a message: short, on one line, safe for a terminal: `"LOUD"`, `an object`.
[[nodiscard]] std::string Shown(const base::JsonValue& value);

/// `divisor` is above zero. Decimal fractions divide as a person reads them: 0.0075 is a multiple
/// of 0.0001.
[[nodiscard]] bool IsMultipleOf(const base::JsonValue& number, const base::JsonValue& divisor);

}  // namespace fleetpub::schema
