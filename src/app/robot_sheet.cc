#include "app/robot_sheet.h"

namespace fleetpub::app {

RobotSheet MakeRobotSheet(const vda5050::ListedRobot& robot) {
  const auto& [address, entry] = robot;
  RobotSheet sheet{.robot = address,
                   .version = entry.own || !entry.automatic ? std::optional(entry.Spoken()->version)
                                                            : std::nullopt,
                   .said_version = entry.said_version,
                   .place = entry.place,
                   .connection = entry.connection,
                   .speaks = entry.speaks,
                   .is_alive = entry.IsAlive(),
                   .state_fault = entry.state_fault,
                   .factsheet = entry.factsheet,
                   .factsheet_fault = entry.factsheet_fault};
  if (entry.state) sheet.state = *entry.state;
  return sheet;
}

}  // namespace fleetpub::app
