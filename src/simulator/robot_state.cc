#include "simulator/robot_state.h"

#include <array>

namespace fleetpub::simulator {

std::string_view GetName(ActionStatus status) {
  constexpr std::array<std::string_view, 6> kNames = {"WAITING",   "INITIALIZING", "RUNNING",
                                                      "RETRIABLE", "FINISHED",     "FAILED"};
  return kNames.at(static_cast<std::size_t>(status));
}

}  // namespace fleetpub::simulator
