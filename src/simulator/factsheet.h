// The factsheet of a virtual robot (VDA 5050 2.0 and 2.1 §6.15, 3.0 §7.9).
#pragma once

#include <chrono>
#include <string>

#include "vda5050/model/version.h"

namespace fleetpub::simulator {

/// Its members without the header, as JSON without braces. Lists every predefined action of the
/// version that may be an instant action, with all of its scopes and parameters. "" for 1.1.0,
/// which has no factsheet.
[[nodiscard]] std::string FactsheetBody(vda5050::Version version,
                                        std::chrono::milliseconds state_interval);

}  // namespace fleetpub::simulator
