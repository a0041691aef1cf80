#include "simulator/robot_state.h"

#include <array>

namespace fleetpub::simulator {
namespace {

constexpr std::size_t kMostErrors = 10;

}  // namespace

std::string_view GetName(ActionStatus status) {
  constexpr std::array<std::string_view, 7> kNames = {
      "WAITING", "INITIALIZING", "RUNNING", "PAUSED", "RETRIABLE", "FINISHED", "FAILED"};
  return kNames.at(static_cast<std::size_t>(status));
}

void PlaceAt(Position position, RobotState& state) {
  state.position = std::move(position);
  state.is_placed = true;
  state.maps.front().id = state.position.map_id;
}

void AddError(RobotState& state, RobotError error) {
  std::erase_if(state.errors, [&](const RobotError& old) {
    return old.type == error.type && old.references == error.references;
  });
  const auto oldest = std::find_if(state.errors.begin(), state.errors.end(),
                                   [](const RobotError& old) { return old.until != Until::kEnd; });
  const bool is_full = state.errors.size() >= kMostErrors && oldest != state.errors.end();
  if (is_full) state.errors.erase(oldest);
  state.errors.push_back(std::move(error));
}

void ForgetErrors(RobotState& state, Until until) {
  std::erase_if(state.errors, [&](const RobotError& error) { return error.until == until; });
}

void GiveUpOrder(RobotState& state) {
  state.order.nodes.clear();
  state.order.edges.clear();
  state.order.is_cancelled = true;
  for (OrderAction& action : state.order_actions) {
    if (!IsEnded(action.status)) action.status = ActionStatus::kFailed;
  }
}

}  // namespace fleetpub::simulator
