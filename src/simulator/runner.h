// Connects a fleet of virtual robots to a broker and keeps it there.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "mqtt/transport.h"
#include "simulator/fleet.h"

namespace fleetpub::simulator {

/// Up to so many robots each have a connection of their own that holds their last will: MQTT knows
/// one will per connection. More of them have none.
constexpr std::size_t kMostWills = 32;

/// More robots leave OFFLINE behind, whatever was there before.
constexpr std::size_t kMostPutBack = 1'000;

struct RunOptions {
  mqtt::ConnectOptions connect;
  std::optional<std::chrono::milliseconds> duration;  ///< none: until `stopped`
  std::function<bool()> stopped;                      ///< asked several times a second
  std::function<void()> on_ready;                     ///< everybody is ONLINE, for the first time
  /// Called before the robots leave anything at the broker: from then on they need an orderly end.
  std::function<void()> on_arrival = [] {};
  /// Filters of the robots' connection messages: nobody may be ONLINE there. Empty: nobody looks.
  std::vector<std::string> places;
  /// The connection broke and is opened again; told once, however many attempts fail.
  std::function<void(const Error&)> on_lost;
  /// Over MQTT 3.1.1: this message was sent and did not come back, so the broker may have dropped it.
  std::function<void(std::string_view topic)> on_unheard;
};

/// What lives at a broker.
class Inhabitant {
 public:
  virtual ~Inhabitant() = default;

  /// Connects and says that it is there.
  [[nodiscard]] virtual Status Connect() = 0;
  /// Reads and answers for a while, kStopPollInterval at most. Errors: the connection is lost.
  [[nodiscard]] virtual Status Turn() = 0;
  /// Forgets a connection that is lost.
  virtual void Drop() = 0;
  /// Whether a Connect that failed may end otherwise later.
  [[nodiscard]] virtual bool MayHeal() const { return false; }
  /// Takes its leave, over an open connection.
  [[nodiscard]] virtual Status Disconnect() = 0;
  /// Whether it has gone by itself.
  [[nodiscard]] virtual bool IsGone() const { return false; }
};

/// Keeps it there until the time is over, `stopped` says so or it has gone. A connection that is
/// lost is made again; so is the first, for as long as the connect timeout and while it may heal.
/// Errors: those of the first Connect, and Disconnect's.
[[nodiscard]] Status KeepAtBroker(Inhabitant& inhabitant, const RunOptions& options);

/// Runs the robots until the time is over, `stopped` says so, or all of them have shut down; then
/// says OFFLINE for them, and leaves retained messages as it found them. A connection that is lost
/// is made again. Errors: the first connection cannot be made, or the broker refuses what they say
/// (kBroker); kPreflight: a robot of such a name is ONLINE already, as far as the broker hands
/// out its retained messages before it acknowledges the next request.
[[nodiscard]] Status Run(Fleet& fleet, const RunOptions& options);

}  // namespace fleetpub::simulator
