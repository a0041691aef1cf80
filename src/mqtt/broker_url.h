// Where a broker is: `mqtt|mqtts|ws|wss://[user@]host[:port][/path]`.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/result.h"

namespace fleetpub::mqtt {

enum class Scheme { kMqtt, kMqtts, kWs, kWss };

struct BrokerUrl {
  Scheme scheme = Scheme::kMqtt;
  std::string host;  ///< decoded, an IPv6 address without its brackets
  std::uint16_t port = 1883;
  std::string path;      ///< of a WebSocket, as written and with its slash; else empty
  std::string username;  ///< decoded; empty: none

  [[nodiscard]] bool UsesTls() const { return scheme == Scheme::kMqtts || scheme == Scheme::kWss; }
  [[nodiscard]] bool UsesWebSocket() const {
    return scheme == Scheme::kWs || scheme == Scheme::kWss;
  }
  /// For people and for the ledger: the URL without the user name.
  [[nodiscard]] std::string ToString() const;

  friend bool operator==(const BrokerUrl&, const BrokerUrl&) = default;
};

/// Parses a URL with real percent-decoding (RFC 3986). A bare `host` or `host:port` is refused with
/// the right form; so is a password (the process list would show it) without repeating it, an
/// unknown scheme, an empty host, a port outside 1..65535, a path on mqtt:// or mqtts://. Default
/// ports: 1883, 8883, 80, 443. Errors: ErrorKind::kUsage.
[[nodiscard]] Result<BrokerUrl> ParseBrokerUrl(std::string_view text);

}  // namespace fleetpub::mqtt
