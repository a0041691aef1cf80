// What makes no sense although the schema allows it. The schema document's own examples break some
// of it (latitudes of 178.2), so that it is warned about, and refused only where somebody asks for
// that.
#pragma once

#include <vector>

#include "message/command.h"

namespace fleetpub::soar {

enum class Strictness { kWarn, kRefuse };

/// Checks a whole message, or a payload alone, that satisfies its schema: latitudes within ±90 and
/// longitudes within ±180 (also in zones, where the longitude comes first), zones of four points,
/// plans and squads that are not empty, as many platforms as no_of_platforms says, no platform_ID
/// twice, velocities the right way round, heading and battery within their ranges, an action that
/// nearly is one of the named ones, and a header that does not fit its payload.
[[nodiscard]] std::vector<message::TextFinding> CheckMessage(const base::JsonValue& message,
                                                             Strictness strictness);

}  // namespace fleetpub::soar
