// How a connection that was lost is replaced.
#pragma once

#include <functional>
#include <memory>

#include "base/result.h"
#include "mqtt/transport.h"

namespace fleetpub::delivery {

/// Opens another connection to the same broker when the first one is lost. By the deadline.
using ConnectHook =
    std::function<Result<std::unique_ptr<mqtt::Transport>>(mqtt::Deadline deadline)>;

}  // namespace fleetpub::delivery
