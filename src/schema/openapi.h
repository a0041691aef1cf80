// OpenAPI 3.0 describes values in a dialect of JSON Schema of its own. It is turned into draft-07,
// so that one loader and one walk serve both.
#pragma once

#include <string>
#include <tl/expected.hpp>

#include "base/rapidjson.h"

namespace fleetpub::schema {

/// Whether the document is an OpenAPI one.
[[nodiscard]] bool IsOpenApi(const base::JsonValue& document);

/// Rewrites every schema under `components` (OpenAPI 3.0.3 "Schema Object"):
///
///   `nullable: true` beside a type      the type, or null
///   `exclusiveMinimum: true`            the `minimum` becomes exclusive; the same for the maximum
///   `oneOf` with a `discriminator`      the one schema that the named property means; an unknown
///                                       value of it is a violation that lists the known ones
///
/// What constrains nothing (`example`, `format: float`, a `discriminator` without alternatives)
/// stays and is passed over. Errors: the JSON Pointer of the place and what is wrong with it.
[[nodiscard]] tl::expected<void, std::string> TranslateOpenApi(base::JsonDocument& document);

}  // namespace fleetpub::schema
