// The first connection, for those who have time until the broker is there.
#pragma once

#include <functional>
#include <memory>

#include "base/result.h"
#include "mqtt/transport.h"

namespace fleetpub::delivery {

struct FirstConnection {
  /// One attempt, by the deadline; says whether a later one may end otherwise.
  std::function<Result<std::unique_ptr<mqtt::Transport>>(mqtt::Deadline deadline, bool& may_heal)>
      open;
  /// The first attempt has failed, and others follow.
  std::function<void(const Error&)> waits;
};

/// Opens it, at the pace of a ReconnectSchedule, until it stands, does not heal, or the end has
/// come. Tries once at least. Errors: those of the last attempt.
[[nodiscard]] Result<std::unique_ptr<mqtt::Transport>> Connect(const FirstConnection& connection,
                                                               mqtt::Deadline end);

}  // namespace fleetpub::delivery
