// Reading JSON that comes from outside, and writing our own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/rapidjson.h"
#include "base/result.h"

namespace fleetpub::base {

struct JsonLimits {
  std::size_t bytes = std::size_t{16} * 1024 * 1024;
  /// Arrays and objects inside each other. Far above any message; RapidJSON's copies and
  /// comparisons and the validator recurse, and a hostile text would exhaust the stack.
  int depth = 64;
  /// Refuses whole numbers of more than 64 bits, which a double would make another number: for texts
  /// that are sent on.
  bool exact = false;
};

/// Parses one JSON text (RFC 8259) strictly: valid UTF-8 (a byte order mark is passed over), no
/// NUL, no key twice in one object, nothing after the value, within the limits. Errors:
/// ErrorKind::kInvalid with line and column, or with the JSON Pointer of a repeated key.
[[nodiscard]] Result<JsonDocument> ParseJson(std::string_view text, JsonLimits limits = {});

/// Parses what somebody else's program wrote, as far as it can only mean one thing. NULs at its end
/// are dropped; `NaN` and infinities are null; bytes that are no UTF-8 and halves of surrogate
/// pairs become U+FFFD; control characters may stand in texts; of a member that stands there twice
/// the last one counts. Errors: as ParseJson, for all else.
[[nodiscard]] Result<JsonDocument> ParseJsonLeniently(std::string_view text,
                                                      JsonLimits limits = {});

/// The value as compact JSON.
[[nodiscard]] std::string ToJson(const JsonValue& value);

/// The value as JSON with an indentation of two.
[[nodiscard]] std::string ToPrettyJson(const JsonValue& value);

/// The JSON text as it may be shown: characters that a person does not see (IsHidden) are escaped
/// as \uXXXX, which changes no value; bytes that are no UTF-8 become U+FFFD.
[[nodiscard]] std::string ShownJson(std::string_view json);

/// The text as a JSON string with its quotation marks.
[[nodiscard]] std::string JsonString(std::string_view text);

/// Texts as an array of such.
template <class Texts>
[[nodiscard]] std::string JsonStrings(const Texts& texts) {
  std::string json = "[";
  for (const auto& text : texts) json += (json.size() == 1 ? "" : ",") + JsonString(text);
  return json + "]";
}

/// The member's text, or "" when it is not there or no string.
[[nodiscard]] std::string_view StringMember(const JsonValue& object, std::string_view name);

/// The member as a whole number of 32 bits; nothing when it is not there or none.
[[nodiscard]] std::optional<std::uint32_t> UintMember(const JsonValue& object,
                                                      std::string_view name);

/// The member as a number; nothing when it is not there or none.
[[nodiscard]] std::optional<double> NumberMember(const JsonValue& object, std::string_view name);

/// Whether the member is there and true.
[[nodiscard]] bool IsTrueMember(const JsonValue& object, std::string_view name);

/// The member, or null when it is not there or `value` is no object.
[[nodiscard]] const JsonValue* FindMember(const JsonValue& value, std::string_view name);

/// The member, or null when it is not there or no array.
[[nodiscard]] const JsonValue* FindArray(const JsonValue& value, std::string_view name);

/// Gives a top-level member another name; nothing happens when there is none of the first name.
void RenameMember(JsonDocument& document, std::string_view from, std::string_view to);

[[nodiscard]] inline std::string_view ToView(const JsonValue& string) {
  return {string.GetString(), string.GetStringLength()};
}

/// A reference token of a JSON Pointer: `~` and `/` escaped (RFC 6901 §3).
[[nodiscard]] std::string PointerToken(std::string_view name);

}  // namespace fleetpub::base
