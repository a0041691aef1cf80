// What a layout says of robots that the specification or their factsheet does not allow.
#pragma once

#include <string_view>
#include <vector>

#include "base/rapidjson.h"
#include "layout/layout.h"
#include "vda5050/model/version.h"

namespace fleetpub::app {

/// Predefined actions where the version has none, or without what they need.
void CheckLayoutActions(const layout::Site& site, vda5050::Version version,
                        std::vector<layout::LayoutFinding>& findings);

/// What goes beyond a factsheet: actions, load sets, lengths of ids and arrays, optional members.
/// `vehicle_type` is the one that the factsheet is of.
void CheckLayoutBeside(const base::JsonValue& factsheet, const layout::Site& site,
                       std::string_view vehicle_type, std::vector<layout::LayoutFinding>& findings);

}  // namespace fleetpub::app
