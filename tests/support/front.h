// TLS, WebSocket or both before a broker that speaks neither.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "support/broken_broker.h"

namespace fleetpub::testing {

/// Passes on what arrives at its own port to a port of 127.0.0.1, and back. What the broker writes
/// at once is one frame, whatever it holds.
class Front {
 public:
  /// `scheme`: mqtt, mqtts, ws or wss. TLS takes the certificate and its key, in PEM.
  Front(std::uint16_t port, std::string scheme, std::string certificate, std::string key)
      : port_(port),
        scheme_(std::move(scheme)),
        certificate_(std::move(certificate)),
        key_(std::move(key)),
        listener_([this](int socket) { Pass(socket); }) {}

  [[nodiscard]] std::string Url() const { return listener_.Url(scheme_); }

 private:
  void Pass(int socket) const;

  std::uint16_t port_;
  std::string scheme_;
  std::string certificate_;
  std::string key_;
  BrokenBroker listener_;  // the last: its threads use the others
};

/// A server's answer to this WebSocket handshake (RFC 6455 §4.2.2).
[[nodiscard]] std::string WebSocketAnswer(const std::string& request);
/// An unmasked frame that is its whole message (§5.2), by default of binary data.
[[nodiscard]] std::string WebSocketFrame(std::string_view data, int first = 0x82);

}  // namespace fleetpub::testing
