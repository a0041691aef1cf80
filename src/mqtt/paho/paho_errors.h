// What brokers and TLS say in numbers, in words.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "mqtt/broker_url.h"
#include "mqtt/packet_check.h"
#include "mqtt/transport.h"

namespace fleetpub::mqtt {

/// What was noticed while Paho tried to connect. Paho itself says "-1" of nearly everything.
struct ConnectFacts {
  int code =
      0;  ///< Paho's: negative its own, 1 to 5 CONNACK of 3.1.1, from 0x80 a reason code of MQTT 5
  bool expired = false;
  std::optional<unsigned char> wrong_first;  ///< PahoCall::wrong_first
  std::string fault;                         ///< PahoInput::fault
  bool wants_more_authentication = false;    ///< PacketCheck::WantsMoreAuthentication
  Reason reason;                             ///< that CONNACK adds to `code`
  bool connect_sent = false;                 ///< the CONNECT packet went out
  long verify_code = 0;            ///< X509_V_ERR_… of the broker's certificate, 0 for none
  std::string certificate_names;   ///< what a refused one is for
  std::string tls_errors;          ///< OpenSSL's, for the detail
  std::string tls_alert;           ///< the last alert sent or received, "unknown CA"
  bool alert_is_theirs = false;    ///< received
  bool wants_certificate = false;  ///< it asked for one of ours
  std::string http_status;         ///< the answer to the WebSocket handshake when it was no 101
};

/// The sentence for a connection that did not come about.
[[nodiscard]] Error ConnectError(const BrokerUrl& broker, const ConnectOptions& options,
                                 const ConnectFacts& facts);

/// `cannot reach mqtt://…: <cause>` for what happened before MQTT, with what to try for the causes
/// that have one.
[[nodiscard]] Error ReachError(const BrokerUrl& broker, const Error& cause);

/// MQTT 5 §2.4: "not authorized (0x87)", and what the broker adds.
[[nodiscard]] std::string ReasonText(int reason_code, const Reason& added);

}  // namespace fleetpub::mqtt
