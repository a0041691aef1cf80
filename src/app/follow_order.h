// Follows the order that a robot has, whoever sent it, to its end: `fleetpub order follow`.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>

#include "app/dialect_resolver.h"
#include "app/environment.h"
#include "app/observer.h"
#include "app/order_message.h"
#include "app/targets.h"
#include "base/result.h"
#include "delivery/retained.h"
#include "message/report.h"
#include "mqtt/transport.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::app {

struct FollowRequest {
  Targets targets;  ///< one robot, by name
  DialectResolver resolver;
  std::chrono::milliseconds timeout{std::chrono::hours(1)};
  bool ask = true;
  delivery::RetainedOptions discover;
  /// So many nodes ahead of the robot are kept released, by updates of an order of ours.
  std::optional<std::size_t> keep_released;
  mqtt::Qos qos = mqtt::Qos::kAtMostOnce;  ///< of those
};

/// Tells node by node how far it has come (Observer::Info), and returns how it ended: kFinished,
/// kFailed, kVanished, kOffline, kTimeout; kInterrupted once the observer is stopped. Errors:
/// ErrorKind::kBroker, kUsage; kPreflight: the robot is unknown, offline or has no order.
[[nodiscard]] Result<message::Report> FollowOrder(const FollowRequest& request,
                                                  const Environment& environment,
                                                  Observer& observer);

/// Whether an order that replaces what the robot drives can be made, as far as that is known before
/// the robot stops: its places, actions and ids. Sends nothing but a request for a state. A robot
/// that is not there is none of its faults. Errors: ErrorKind::kBroker; as ComposeOrder and
/// BuildOrder; kInvalid.
[[nodiscard]] Status TryReplacing(const OrderTask& task, std::optional<std::uint32_t> header_id,
                                  const FollowRequest& request, const Environment& environment,
                                  Observer& observer);

/// Waits until a live state shows that nothing of an order is left to do. Errors: as FollowOrder;
/// kUnconfirmed: it is still under way after the time.
[[nodiscard]] Status AwaitIdle(const FollowRequest& request, const Environment& environment,
                               Observer& observer);

}  // namespace fleetpub::app
