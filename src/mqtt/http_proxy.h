// A tunnel through an HTTP proxy (RFC 9110 §9.3.6). Paho has one of its own, which waits in steps
// of 250 ms, has no deadline, and writes the credentials into its trace.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/result.h"
#include "mqtt/tcp_connect.h"

namespace fleetpub::mqtt {

struct HttpProxy {
  std::string host;
  std::uint16_t port = 3128;
  std::string credentials;  ///< `user:password`, decoded; empty: none
};

/// `http://[user:password@]host[:port]`. Errors: ErrorKind::kUsage; never repeats the text.
[[nodiscard]] Result<HttpProxy> ParseHttpProxy(std::string_view text);

/// Asks the proxy at the other end of this socket for a tunnel to host:port, and reads its answer
/// and no byte more; `may_heal`: whether the same request may succeed later. Errors:
/// ErrorKind::kBroker with the cause alone.
[[nodiscard]] Status OpenTunnel(int descriptor, const HttpProxy& proxy, const std::string& host,
                                std::uint16_t port, Deadline deadline, bool& may_heal);

/// Whether an HTTP status such as `503` is about the moment, not about the request: what is behind
/// the proxy is away or busy (RFC 9110 §15.5.9 and §15.6, RFC 6585 §4).
[[nodiscard]] bool IsPassing(std::string_view http_status);

}  // namespace fleetpub::mqtt
