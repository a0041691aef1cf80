// One attempt at one broker.
#pragma once

#include <cstring>
#include <memory>
#include <string>

#include "base/result.h"
#include "mqtt/paho/paho_input.h"
#include "mqtt/paho/paho_watch.h"
#include "mqtt/transport.h"

namespace fleetpub::mqtt {

/// A connected client of Paho. Whoever holds it destroys the client before `tls` and
/// `input`, and `input` with PahoMutex() held.
struct PahoConnection {
  void* client = nullptr;  ///< an MQTTClient
  int descriptor = -1;     ///< Paho's socket; -1 when this build cannot know (PahoCall::Supported)
  std::unique_ptr<TlsWatch> tls;
  std::unique_ptr<PahoInput> input;
  ServerInfo server;
  int receive_maximum = 65'535;  ///< MQTT 5 §3.2.2.3.3
  bool retain_as_published = false;
};

/// The code in an MQTTResponse. Paho puts -1 into its enum of reason codes, which C++ may not even
/// load as one.
template <typename Response>
[[nodiscard]] int ReasonCode(const Response& response) {
  int code = 0;
  static_assert(sizeof code == sizeof response.reasonCode);
  std::memcpy(&code, &response.reasonCode, sizeof code);
  return code;
}

/// MQTT §1.5.4: UTF-8 without NUL, 65,535 bytes at most.
[[nodiscard]] bool IsMqttString(const std::string& text);

/// Checks what can be known to be wrong before connecting. Errors: ErrorKind::kUsage.
[[nodiscard]] Status CheckConnectOptions(const ConnectOptions& options);

struct ConnectFailure {
  Error error;
  bool distrusted = false;  ///< who answers has shown a certificate that is not the broker's
  bool may_heal = false;    ///< ConnectPaho's
};

/// Errors: ErrorKind::kBroker, one line that names the broker.
[[nodiscard]] tl::expected<PahoConnection, ConnectFailure> ConnectTo(const BrokerUrl& broker,
                                                                     const ConnectOptions& options);

}  // namespace fleetpub::mqtt
