// The walk over schema and message: whether a message is valid, and in a person's words why not.
#pragma once

#include <vector>

#include "base/rapidjson.h"
#include "schema/schema.h"
#include "schema/schema_loader.h"

namespace fleetpub::schema {

/// How often references may be followed for one message. Only they let the work grow beyond schema
/// times message, and then exponentially. Far above any message that base::ParseJson takes for one
/// reference per value.
constexpr int kMostWork = 10'000'000;

/// The causes, in the order of the message, each once; at most Schema::kMostViolations and one line
/// that says so. Empty when the message is valid. Beyond `most_work` one line says that it could
/// not be checked. May be called by several threads at once.
[[nodiscard]] std::vector<Violation> CollectViolations(const CheckedSchema& schema,
                                                       const base::JsonValue& message,
                                                       int most_work = kMostWork);

}  // namespace fleetpub::schema
