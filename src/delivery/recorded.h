// What a broker says, as a recording has it.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "mqtt/transport.h"
#include "recording/entry.h"

namespace fleetpub::delivery {

/// Now, in a recording that began then.
[[nodiscard]] recording::Moment MomentSince(std::chrono::steady_clock::time_point start);

/// The first line of a recording that begins `start`: from this broker, by these subscriptions.
[[nodiscard]] recording::Head MakeHead(std::string tool, const mqtt::ServerInfo& server,
                                       std::vector<std::string> subscriptions, mqtt::Qos qos,
                                       std::chrono::steady_clock::time_point start);

/// A message that came then.
[[nodiscard]] recording::Message ToRecorded(const mqtt::Message& message, recording::Moment moment);

}  // namespace fleetpub::delivery
