// Follows a message until it is acknowledged as far as somebody wants to know.
//
// An acknowledgement belongs to our message when its `acknowledged_message_ID` is ours. Its
// status tells how far the message has come; a later one counts without those before it. Nobody can
// refuse a message in this protocol: the end is a level, or silence.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/rapidjson.h"
#include "message/response_tracker.h"
#include "soar/destination.h"
#include "soar/message_type.h"

namespace fleetpub::soar {

/// What somebody says of a message.
struct Acknowledgement {
  std::string message_id;  ///< of the message that is acknowledged
  Level level = Level::kC2Received;
  std::string from;  ///< the platform, `soar.noc.autosub.ah1`, else the source; may be empty
};

/// Reads one leniently: nothing when the message is none. Any part of the message that does not
/// matter here may be wrong.
[[nodiscard]] std::optional<Acknowledgement> ReadAcknowledgement(std::string_view topic,
                                                                 const base::JsonValue& message,
                                                                 const Prefix& prefix);

struct TrackerOptions {
  std::string message_id;
  std::vector<std::string> topics;  ///< may hold wildcards
  Prefix prefix;
  Level wait_for = Level::kExecuted;
  std::size_t count = 1;  ///< so many must say so, each counted once
  std::string target;     ///< who has reached a level when the acknowledgement does not say it
};

/// Tells of each level that somebody has newly reached as news. Ends with kFinished when the message is executed, with kAccepted when a lower level was waited
/// for and reached.
[[nodiscard]] std::unique_ptr<message::ResponseTracker> TrackAcknowledgements(
    TrackerOptions options);

}  // namespace fleetpub::soar
