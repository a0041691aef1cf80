// Several schema documents made one: what is defined once and used by many
// (`definitions.schema.json`) is copied to where it is used, so that a schema is complete by
// itself. The built-in ones are bundled when the program is built (embed.cc), those of a user's
// folder when they are loaded.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "base/rapidjson.h"
#include "base/result.h"

namespace fleetpub::schema {

/// The document of this URI (a path, or an `$id`), or null when there is none. It lives as long as
/// the bundling lasts.
using FindDocument = std::function<const base::JsonValue*(std::string_view uri)>;

/// Copies every schema that `document` refers to in another one into its own `definitions`, with
/// those that they refer to in turn, and points the references there. `uri` is where the document
/// stands; relative references are seen from there, or from its `$id`. A reference to a document
/// that `find` does not know stays as it is. Errors: ErrorKind::kInvalid, when a document is there
/// but not what is asked for in it. True when anything was copied.
[[nodiscard]] Result<bool> Bundle(base::JsonDocument& document, std::string_view uri,
                                  const FindDocument& find);

}  // namespace fleetpub::schema
