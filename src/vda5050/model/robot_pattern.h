// Several robots by one name: `KIT/*`, `*/000?`.
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "vda5050/model/robot_address.h"
#include "vda5050/reports/discovery.h"

namespace fleetpub::vda5050 {

/// `*` stands for any text, `?` for any one character, in each of the two parts; `%` and two
/// hexadecimal digits stand for one byte and for nothing else.
struct RobotPattern {
  std::string manufacturer = "*";
  std::string serial_number = "*";

  /// That means this robot alone.
  [[nodiscard]] static RobotPattern Of(const RobotAddress& robot);

  [[nodiscard]] bool Matches(const RobotAddress& robot) const;
  /// What of it a broker can sort out.
  [[nodiscard]] RobotFilter Filter() const;
};

/// Parses `manufacturer/serialNumber` with wildcards. Errors: ErrorKind::kUsage.
[[nodiscard]] Result<RobotPattern> ParseRobotPattern(std::string_view text);

}  // namespace fleetpub::vda5050
