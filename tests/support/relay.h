// A network between a client and a broker, as slow or as dead as a test wants it.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "mqtt/descriptor.h"
#include "support/broken_broker.h"

namespace fleetpub::testing {

/// To a port of 127.0.0.1; not open when nobody listens there.
[[nodiscard]] mqtt::Descriptor ConnectTo(std::uint16_t port);

/// Passes on what arrives at its own port to a port of 127.0.0.1, and back, each byte after the
/// delay, and so many in a millisecond (0: all).
class Relay {
 public:
  explicit Relay(std::uint16_t port,
                 std::chrono::milliseconds one_way = std::chrono::milliseconds(0),
                 std::size_t bytes_per_ms = 0)
      : port_(port),
        one_way_(one_way),
        bytes_per_ms_(bytes_per_ms),
        listener_([this](int socket) { Pass(socket); }) {}

  [[nodiscard]] std::string Url() const { return listener_.Url(); }
  [[nodiscard]] int connections() const { return connections_; }
  /// The network is dead from now on: connections stay, and nothing gets through.
  void Die() { dead_ = true; }
  /// New connections get through again; those from before never will.
  void Revive() {
    ++generation_;
    dead_ = false;
  }

 private:
  void Pass(int socket);

  std::uint16_t port_;
  std::chrono::milliseconds one_way_;
  std::size_t bytes_per_ms_;
  std::atomic<bool> dead_ = false;
  std::atomic<int> generation_ = 0;
  std::atomic<int> connections_ = 0;
  BrokenBroker listener_;  // the last: its threads use the others
};

}  // namespace fleetpub::testing
