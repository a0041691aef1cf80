// Members that a schema does not forbid and does not know, and whose names are nearly ones that it
// knows: they would go unseen.
#pragma once

#include <vector>

#include "base/rapidjson.h"
#include "schema/schema.h"
#include "schema/schema_loader.h"

namespace fleetpub::schema {

/// One for each such member, in the order of the message; at most Schema::kMostViolations. A name
/// that stands beside the one that it is near to is another word, and no slip.
[[nodiscard]] std::vector<Violation> CollectMisspellings(const CheckedSchema& schema,
                                                         const base::JsonValue& message);

}  // namespace fleetpub::schema
