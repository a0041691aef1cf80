// What a robot's states say that a person wants to know at once, while a command is waited for.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "vda5050/reports/robot_errors.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::vda5050 {

/// Each is told once.
class Alerts {
 public:
  /// `topic`: on which the command is sent. It outlives this.
  Alerts(std::string robot, std::string_view topic) : robot_(std::move(robot)), topic_(topic) {}

  void Published(std::uint32_t header_id);

  /// A live state, before or after publishing.
  void Look(const RobotState& state);

  /// Errors that keep the robot from going on, or anything else that is told with its name.
  void Add(const std::vector<std::string>& texts);

  /// The robot can keep no further ended instant actions.
  [[nodiscard]] bool list_full() const { return list_full_; }

  /// What is to be told, as lines.
  [[nodiscard]] std::vector<std::string> Take() { return std::exchange(lines_, {}); }

 private:
  void TellOfHigherIds();

  std::string robot_;
  std::string_view topic_;
  bool list_full_ = false;
  std::uint32_t highest_id_ = 0;  // that the robot names
  std::optional<std::uint32_t> first_id_;
  std::vector<std::string> lines_;
};

}  // namespace fleetpub::vda5050
