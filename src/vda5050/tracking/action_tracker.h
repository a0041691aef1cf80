// Follows an instant action until the robot says what became of it (VDA 5050 1.1–2.1 §6.11
// "actionStates", 3.0 §6.6).
//
// The action is recognised by its actionId in `actionStates` and in `instantActionStates`, in every
// version: 3.0's own flow chart puts cancelOrder into the former. Terms of an end:
//
//   FINISHED, or what tracking/ending.h says      kFinished, with the robot's result
//   FAILED                                        kFailed, with result and the errors that name it
//   an error names our actionId, no entry does    kRejected (robots use several keys: by value)
//   a new error names our headerId and topic      kRejected, told as "probably"
//   cancelOrder, and the error is noOrderToCancel kNoOrder, unless the state shows an order to go
//   RETRIABLE                                     kRetriable
//   listed without an end, then no longer         kVanished
//   connection lost                               kOffline
//
// A message whose header names another robot confirms nothing, nor does an entry of another action
// type, nor what cannot be read (each is counted and told), nor a state that arrives after a newer
// one. FINISHED and FAILED in one state are
// FAILED.
//
// Never by the type of an error alone: errors of earlier attempts persist. Retained messages and
// those received before publishing confirm nothing; they tell which errors are old and which mode
// the robot was in.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "base/result.h"
#include "message/response_tracker.h"
#include "vda5050/messages/instant_actions.h"
#include "vda5050/model/robot_address.h"

namespace fleetpub::vda5050 {

enum class WaitFor {
  kAccepted,  ///< the robot lists it and not as FAILED: ends with kAccepted
  kFinished,
};

/// Follows an action, by its id and the name that the version has for its type. Errors:
/// ErrorKind::kUsage (topic).
[[nodiscard]] Result<std::unique_ptr<message::ResponseTracker>> TrackInstantAction(
    const RobotAddress& robot, const Dialect& dialect, const InstantAction& action,
    WaitFor wait_for = WaitFor::kFinished);

}  // namespace fleetpub::vda5050
