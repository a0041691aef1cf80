// One robot, whole or in a short block, for people; and as JSON.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "app/robot_sheet.h"
#include "base/time.h"
#include "cli/output/output.h"

namespace fleetpub::cli {

enum class Extent { kWhole, kBlock };

/// Lines of at most `width` columns, broken at blanks. What is not known is said to be not known.
/// `now` is for ages.
[[nodiscard]] std::vector<std::string> RobotSheetLines(const app::RobotSheet& sheet, Extent extent,
                                                       std::size_t width, base::WallTime now,
                                                       const Output& output);

/// A JSON object (docs/manual.md, "Show").
[[nodiscard]] std::string RobotSheetJson(const app::RobotSheet& sheet);

}  // namespace fleetpub::cli
