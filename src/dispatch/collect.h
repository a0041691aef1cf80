// Gathers what the broker has retained. MQTT does not mark the end of it: absence is decided after
// a silence.
#pragma once

#include <chrono>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "mqtt/transport.h"

namespace fleetpub::dispatch {

struct CollectOptions {
  std::chrono::milliseconds quiet{300};  ///< so long a silence is an end
  std::chrono::milliseconds most{2'000};
};

/// Whether these are enough; asked after each message.
using Enough = std::function<bool(const std::vector<mqtt::Message>&)>;

/// Subscribes to the filters, which stay subscribed, and returns what arrives, retained or not.
[[nodiscard]] Result<std::vector<mqtt::Message>> Collect(mqtt::Transport& transport,
                                                         std::span<const std::string> filters,
                                                         const CollectOptions& options,
                                                         const Enough& enough);

}  // namespace fleetpub::dispatch
