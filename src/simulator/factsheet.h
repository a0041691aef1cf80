// The factsheet of a virtual robot (VDA 5050 2.0 and 2.1 §6.15, 3.0 §7.9).
#pragma once

#include <string>

#include "simulator/settings.h"

namespace fleetpub::simulator {

/// Its members without the header, as JSON without braces. Lists every predefined action of the
/// version with all of its scopes and parameters, and the optional members of an order that it can
/// use. "" for 1.1.0, which has no factsheet.
[[nodiscard]] std::string FactsheetBody(const Settings& settings);

}  // namespace fleetpub::simulator
