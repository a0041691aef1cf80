// What a person writes of an order's way: actions at places, and files of nodes.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "app/order_path.h"
#include "base/result.h"

namespace fleetpub::app {

/// `TYPE@PLACE` with its parameters as `-P` takes them. Errors: ErrorKind::kUsage.
[[nodiscard]] Result<PlacedAction> ParsePlacedAction(std::string_view word,
                                                     const std::vector<std::string>& parameters);

/// Rows `node,x,y,theta,map,actions`: theta and actions may be left out, and of a node that needs no
/// position x, y and map too. Actions are separated by semicolons: `pick loadType=EPAL; beep`.
/// Errors: ErrorKind::kInvalid, `line 3: …`.
[[nodiscard]] Result<std::vector<PathPoint>> ParsePathFile(std::string_view text);

}  // namespace fleetpub::app
