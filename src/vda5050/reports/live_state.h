// The last states of a fleet, in bounded memory, and how bad it is what they say.
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

#include "vda5050/reports/robot_messages.h"

namespace fleetpub::vda5050 {

/// Texts are the robot's own and untrusted.
struct LiveState : RobotState {
  /// Of it is there what a table shows; not its actions, loads, position and references.
  bool is_slim = false;
  /// When there was more than could be kept at all: errors beyond the one that weighs most. Texts
  /// are cut with `…` then, and requests are not there.
  std::size_t errors_left_out = 0;
  bool is_abridged = false;
  std::size_t bytes = 0;  ///< of what it says at any length
};

/// Keeps what robots say at any length: 20 MiB for all of them together.
class StateMemory {
 public:
  /// In place of what `slot` has.
  void Keep(std::shared_ptr<const LiveState>& slot, RobotState state);

  /// States that are abridged.
  [[nodiscard]] std::size_t abridged() const { return abridged_; }

 private:
  std::size_t kept_ = 0;
  std::size_t abridged_ = 0;
};

/// The text, cut to what is short in every message that means well.
void CutHeaderTexts(ConnectionMessage& message);

/// FATAL, CRITICAL, URGENT, WARNING in falling order from 3 to 0; -1: another.
[[nodiscard]] int WeighLevel(std::string_view level);

/// The entry whose level weighs most, or null.
[[nodiscard]] const RobotError* WorstError(const std::vector<RobotError>& errors);

}  // namespace fleetpub::vda5050
