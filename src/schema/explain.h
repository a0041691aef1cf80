// Why a message is invalid, in a person's words. A walk of its own over schema and message, taken
// only when the validator has said no: slower, and free to say what it likes. tests/schema hold the
// two against each other.
#pragma once

#include <cstddef>
#include <vector>

#include "base/rapidjson.h"
#include "schema/schema.h"
#include "schema/vet.h"

namespace fleetpub::schema {

/// The causes, in the order of the message, each once; at most `most` and one line that says so.
/// Empty when it finds none.
[[nodiscard]] std::vector<Violation> Explain(const Vetted& vetted, const base::JsonValue& message,
                                             std::size_t most);

}  // namespace fleetpub::schema
