// A schema looked over before a validator sees it, so that nothing in it can be misunderstood,
// half-checked, crash or hang: every keyword is one that we check, or one that constrains nothing,
// and has a value of the form that draft-07 asks for; every reference leads to a schema in the same
// document, and none only to itself.
#pragma once

#include <memory>
#include <string_view>
#include <unordered_map>

#include "base/rapidjson.h"
#include "base/result.h"
#include "schema/pattern.h"

namespace fleetpub::schema {

/// A schema that passed. Subschemas are known by their address in `document`, which therefore stays
/// where it is.
struct Vetted {
  base::JsonDocument document;
  const base::JsonValue* root = nullptr;  ///< the schema itself, in `document`

  /// From draft 2019-09 on, what stands beside a `$ref` counts; in draft-07 it does not (§8.3).
  bool reference_has_siblings = false;

  /// From a schema that has a `$ref` to the schema it means.
  std::unordered_map<const base::JsonValue*, const base::JsonValue*> targets;

  /// From the value of `pattern`, or a name in `patternProperties`, to its expression.
  std::unordered_map<const base::JsonValue*, Pattern> patterns;

  /// The schema behind `$ref`, when the schema is nothing but a reference; else null.
  [[nodiscard]] const base::JsonValue* OnlyReference(const base::JsonValue& schema) const;

  /// The schema behind `$ref` wherever one counts; else null.
  [[nodiscard]] const base::JsonValue* Reference(const base::JsonValue& schema) const;
};

/// `pointer` leads to the schema when it is only a part of the document. Errors:
/// ErrorKind::kInvalid with the JSON Pointer of the place and what is wrong with it.
[[nodiscard]] Result<std::unique_ptr<const Vetted>> Vet(std::string_view text,
                                                        std::string_view pointer = {});

}  // namespace fleetpub::schema
