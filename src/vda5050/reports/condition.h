// What `fleetpub await` waits for: `paused=true`, `/batteryState/batteryCharge>=80`.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/rapidjson.h"
#include "base/result.h"

namespace fleetpub::vda5050 {

enum class Comparison { kEqual, kUnequal, kLess, kAtMost, kMore, kAtLeast };

/// A member of a message, compared with a value.
struct Condition {
  /// A JSON Pointer (RFC 6901) when it begins with `/`; else a top-level member or, when the
  /// message has none of that name, an alias: `battery`, `charging`, `x` …
  std::string path;
  Comparison comparison = Comparison::kEqual;
  /// As written, without blanks around it. A text is compared with this, unless it is a JSON text
  /// itself.
  std::string wanted;
  /// `wanted` as JSON; nothing when it is none.
  std::optional<base::JsonDocument> value;
};

/// Parses `PATH=VALUE`, also with `!=`, `<`, `<=`, `>`, `>=`. Errors: ErrorKind::kUsage with the
/// right form.
[[nodiscard]] Result<Condition> ParseCondition(std::string_view text);

/// What no release's schema of the topic knows would be waited for in vain. Errors:
/// ErrorKind::kUsage when it is a slip of the pen: a member, or a value of an enumeration or a
/// boolean member, that nearly is one. Else a warning, or "". A JSON Pointer is used as it is,
/// and so is a topic without schema.
[[nodiscard]] Result<std::string> CheckCondition(const Condition& condition,
                                                 std::string_view topic_name);

/// `PATH<VALUE`.
[[nodiscard]] std::string ToString(const Condition& condition);

/// What a condition's path names in the message; null: nothing.
[[nodiscard]] const base::JsonValue* FindByPath(const std::string& path,
                                                const base::JsonValue& message);

/// What the message says instead (`paused is false`, `there is no /batteryState`); nothing when it
/// satisfies the condition. A member that is not there satisfies none, not even `!=`. A
/// `connectionState` and an `operatingMode` are compared as NormalisedConnectionState and
/// NormalisedMode spell them.
[[nodiscard]] std::optional<std::string> Unmet(const Condition& condition,
                                               const base::JsonValue& message);

}  // namespace fleetpub::vda5050
