// From a host name to a connected TCP socket, within a deadline.
#pragma once

#include <sys/socket.h>

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "mqtt/descriptor.h"
#include "mqtt/transport.h"

namespace fleetpub::mqtt {

struct Address {
  sockaddr_storage storage{};
  socklen_t length = 0;

  [[nodiscard]] const sockaddr* get() const {
    return reinterpret_cast<const sockaddr*>(&storage);  // as the sockets API wants it
  }
};

/// The addresses of a host, at least one. A numeric host and `localhost` (RFC 6761 §6.3) cost no
/// lookup; any other name is looked up on a thread of its own, since getaddrinfo() knows no
/// timeout: at the deadline that thread is left behind. Errors: ErrorKind::kBroker with the cause
/// alone ("the name broker.example is not known").
[[nodiscard]] Result<std::vector<Address>> Lookup(const std::string& host, std::uint16_t port,
                                                  Deadline deadline);

/// A connected, non-blocking socket with TCP_NODELAY. The addresses are tried in their order, the
/// next one being started when one has failed or has not answered for 250 ms (RFC 8305 §5). Errors
/// as above ("connection refused").
[[nodiscard]] Result<Descriptor> TcpConnect(const std::vector<Address>& addresses,
                                            Deadline deadline);

/// Waits for these poll() events or until the deadline; what was seen, 0 at the deadline.
[[nodiscard]] short WaitFor(int descriptor, short events, Deadline deadline);

/// Lets the next packet on this TCP connection be acknowledged at once. A broker with Nagle's
/// algorithm (mosquitto's default) holds a packet back until the one before is acknowledged, which
/// TCP delays by 40 ms. To be called before each wait: the kernel forgets it.
void AcknowledgeAtOnce(int descriptor);

/// Milliseconds left for poll(), rounded up so that a wait never ends early and spins.
[[nodiscard]] int MillisecondsUntil(Deadline deadline);

}  // namespace fleetpub::mqtt
