// Messages of the user's own: an order, a zone set, responses, instantActions from a
// file. Their header is made ours; the rest goes out as it was written.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "base/rapidjson.h"
#include "base/result.h"
#include "message/command.h"
#include "vda5050/messages/instant_actions.h"
#include "vda5050/tracking/action_tracker.h"

namespace fleetpub::vda5050 {

enum class HeaderMismatch {
  kRefuse,   ///< version, manufacturer or serialNumber of another robot: an error
  kReplace,  ///< becomes that of the robot addressed
};

/// `order`, `instantActions`, and from 3.0 `zoneSet` and `responses`, in any letter case.
/// Errors: ErrorKind::kUsage, naming those that fleet control publishes.
[[nodiscard]] Result<std::string_view> PublishedTopic(std::string_view text);

/// What the message's header says of its version; nothing when it is none that we speak.
[[nodiscard]] std::optional<SpokenVersion> VersionSaidBy(const base::JsonValue& message);

/// The message as a command for one robot. headerId and timestamp are stamped anew whatever the
/// message says; of the other header fields those that are missing are filled in. Errors:
/// ErrorKind::kInvalid (no object, a header field of another robot or version, actions under the
/// name that the dialect does not use), kUsage (the version has no such topic). Warns of a version
/// that is no release, and of none that had to be assumed.
[[nodiscard]] Result<message::Command> BuildUserMessage(
    const RobotAddress& robot, const Dialect& dialect, std::string_view topic,
    const base::JsonValue& message, HeaderMismatch on_mismatch,
    std::optional<std::uint32_t> header_id = std::nullopt);

/// The actions of an instantActions message, for CheckRobot: types, ids, parameters.
[[nodiscard]] std::vector<InstantAction> ActionsIn(const base::JsonValue& message,
                                                   const Dialect& dialect);

/// One answer to a request of a robot's (3.0 §6.4.3).
struct RequestResponse {
  std::string_view request_id;
  std::string_view grant_type;  ///< GRANTED, QUEUED, REVOKED, REJECTED
  std::optional<base::WallTime> lease_expiry;
};

/// The message, without header, for BuildUserMessage.
[[nodiscard]] base::JsonDocument ResponsesMessage(const RequestResponse& response);

/// Follows a user's message until the robot's state shows it (docs/manual.md, "Waiting"):
///
///   order            orderId and orderUpdateId; kFinished: all nodes, edges and actions are done
///   instantActions   each of its actions
///   zoneSet          the zoneSetId
///   responses        the request's status; null for QUEUED and REJECTED, which no state shows
///
/// or an error that references it. `message` need not outlive the call.
/// Errors: ErrorKind::kUsage (topic; responses that no state shows).
[[nodiscard]] Result<std::unique_ptr<message::ResponseTracker>> TrackUserMessage(
    const RobotAddress& robot, const Dialect& dialect, std::string_view topic,
    const base::JsonValue& message, WaitFor wait_for);

/// The same, to its end, of an order that the robot is known to have taken: from the first state
/// on that comes after Published().
[[nodiscard]] Result<std::unique_ptr<message::ResponseTracker>> TrackTakenOrder(
    const RobotAddress& robot, const Dialect& dialect, const base::JsonValue& order);

}  // namespace fleetpub::vda5050
