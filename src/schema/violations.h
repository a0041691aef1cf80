// The walk over schema and message: whether a message is valid, and in a person's words why not.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "base/rapidjson.h"
#include "schema/schema.h"
#include "schema/schema_loader.h"

namespace fleetpub::schema {

/// Where in the message. A link of a chain on the stack.
struct Where {
  const Where* up = nullptr;
  std::string_view name = {};  ///< of a member; data() is null for an item
  std::size_t index = 0;       ///< among its siblings
};

/// `/nodes/3/nodeId`; "" for the whole message.
[[nodiscard]] std::string MakePointer(const Where& where);

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
