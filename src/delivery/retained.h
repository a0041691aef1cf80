// Reads what the broker has retained. MQTT does not mark the end of it: absence is decided after
// a silence.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <unordered_set>
#include <vector>

#include "base/result.h"
#include "mqtt/transport.h"

namespace fleetpub::delivery {

/// More filters are subscribed some at a time, reading in between: a default mosquitto drops what
/// it has to queue beyond 1,000 messages, retained ones included.
inline constexpr std::size_t kFiltersAtOnce = 500;

/// Filters.
using Subscribed = std::unordered_set<std::string>;

struct RetainedOptions {
  std::chrono::milliseconds quiet{300};  ///< so long a silence is an end
  std::chrono::milliseconds most{2'000};
  std::chrono::milliseconds subscribe{10'000};  ///< for the broker to acknowledge
  /// One of the filters, the last: a topic of which a message is known to be retained. Until it has
  /// come a silence is the network's, and lasts as long as a SUBACK may take. Empty: none.
  std::string marker = {};
  /// Subscribed to when the others seem to have brought all, some milliseconds later; the silence
  /// begins anew then, and ends both. Not for filters of which what is retained counts.
  std::vector<std::string> behind = {};
  /// Done while the last messages are awaited, when enough was taken: a millisecond costs nothing
  /// then. May be empty.
  std::function<void()> meanwhile = {};
  /// Gets every message too: whoever waits for others on the same connection. May be empty.
  std::function<void(const mqtt::Message&)> also = {};
  /// So many filters may stay subscribed; more are ended, as they would make each later
  /// subscription dearer.
  std::size_t keep = kFiltersAtOnce;
  /// What is subscribed to over the same connection: none of it is ended, what stays is added. Null:
  /// nothing is.
  Subscribed* subscribed = nullptr;
};

/// Takes a message, retained or not; true when it was the last that is wanted.
using MessageCallback = std::function<bool(const mqtt::Message&)>;

/// Subscribes to the filters, many of them some at a time, and hands over what arrives until the
/// silence or until enough is taken. A broker may drop messages of a filter with wildcards that
/// finds thousands. Only what was retained puts the silence off: a busy fleet is never silent. Where
/// a SUBACK took long, silences are as long.
[[nodiscard]] Status ReadRetained(mqtt::Transport& transport, std::span<const std::string> filters,
                                  const RetainedOptions& options, const MessageCallback& take);

/// For filters that may find thousands: asks again while so much came that the broker may have
/// dropped some, and `known` tells of more senders than before. Those that are known by then are
/// read faster. Takes everything; ends after a minute at the latest, per asking.
[[nodiscard]] Status ReadAllRetained(mqtt::Transport& transport,
                                     std::span<const std::string> filters, RetainedOptions options,
                                     const std::function<void(const mqtt::Message&)>& take,
                                     const std::function<std::size_t()>& known);

}  // namespace fleetpub::delivery
