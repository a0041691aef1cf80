// Asks robots how they are, so that their states come at once: they are not retained, and a robot
// repeats its own every 30 s only.
#pragma once

#include <chrono>
#include <span>
#include <string_view>

#include "app/environment.h"
#include "app/observer.h"
#include "app/robot_discovery.h"

namespace fleetpub::app {

/// The action that asks.
inline constexpr std::string_view kStateRequest = "stateRequest";

/// Sends it to those of these robots that are there and have the action, as far as is known.
/// Recorded as every command is; waits for no answer, and no longer than `patience` for the ledger
/// or the connection. What keeps one from leaving is warned of: whoever asks goes on without.
/// `link.transport` is null afterwards if that has cost the connection.
void AskForStates(std::span<const ListedRobot* const> robots, std::chrono::milliseconds patience,
                  Link& link, const Environment& environment, Log& log);

}  // namespace fleetpub::app
