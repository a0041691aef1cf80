// A connection to a broker, as the rest of the program sees it. No type of any MQTT library stands
// here.
//
// Threads: a Transport belongs to one thread at a time and starts none of its own.
// Blocking: every call returns by the deadline that it is given or by the connect timeout.
// Errors: ErrorKind::kBroker with a sentence that names the broker, the cause and what to try.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "mqtt/broker_url.h"

namespace fleetpub::mqtt {

using Deadline = std::chrono::steady_clock::time_point;

enum class Qos : int { kAtMostOnce = 0, kAtLeastOnce = 1, kExactlyOnce = 2 };
/// At which we subscribe. TCP loses nothing on a clean session's way to us, but of messages at QoS
/// 1 a default mosquitto queues 1,000 for a client and drops the rest, retained ones included: of
/// 10,000 robots 1,020 would be seen.
inline constexpr Qos kListeningQos = Qos::kAtMostOnce;

enum class ProtocolVersion { k311, k5 };

/// MQTT 3.1.1 §3.3, MQTT 5 §3.3. The payload is bytes.
struct Message {
  std::string topic;
  std::string payload;
  Qos qos = Qos::kAtMostOnce;
  /// On a received message: the broker had stored it before we subscribed. Never set on what we
  /// send: a retained command would be obeyed by a robot that reconnects tomorrow.
  bool retained = false;
  bool duplicate = false;  ///< DUP of a received message: the broker had sent it before
};

/// What the broker publishes in our name when the connection ends without DISCONNECT (MQTT 3.1.1
/// §3.1.2.5). For a virtual robot's `connection` topic; a command is never anyone's last will.
struct Will {
  std::string topic;
  std::string payload;
  Qos qos = Qos::kAtMostOnce;
  bool retain = false;
};

/// What MQTT 5 sends along with each message (§3.3.2.3); 3.1.1 has no place for it.
struct PublishProperties {
  std::vector<std::pair<std::string, std::string>> user;  ///< §3.3.2.3.7, in this order
  /// §3.3.2.3.3: how long a broker may keep the message for a subscriber that is offline.
  std::optional<std::chrono::seconds> expiry;
};

struct TlsOptions {
  std::string ca_file;  ///< PEM; empty with an empty ca_path: the system's trust store
  std::string ca_path;
  std::string cert_file;  ///< the client's own certificate chain, PEM
  std::string key_file;
  std::optional<std::string> key_password;
  std::string ciphers;  ///< OpenSSL's list; empty: its default
  std::vector<std::string> alpn;
  std::string server_name;  ///< in place of the host in the URL; empty: that
  bool verify = true;       ///< chain and host name; false only for `--insecure`

  /// That the certificate must be for.
  [[nodiscard]] const std::string& FindServerName(const BrokerUrl& broker) const {
    return server_name.empty() ? broker.host : server_name;
  }
};

/// MQTT 5 §4.12, in one step: what CONNECT brings has to do.
struct Authentication {
  std::string method;
  std::optional<std::string> data;
};

struct ConnectOptions {
  /// Tried in this order until one accepts; at least one.
  std::vector<BrokerUrl> brokers;
  std::string client_id;  ///< empty: a random one
  std::string username;   ///< empty: none, or the one in the URL
  std::optional<std::string> password;
  std::optional<Authentication> authentication;  ///< MQTT 5 only
  std::string login;  ///< what a refusal says of all of these, never a secret; may be empty
  std::chrono::seconds keep_alive{60};
  ProtocolVersion version = ProtocolVersion::k311;
  /// MQTT 5 §3.8.3.1: Message::retained of what is received is then what its publisher said.
  bool retain_as_published = false;
  PublishProperties properties;
  /// For name lookup, TCP, TLS and CONNACK together, per broker.
  std::chrono::milliseconds connect_timeout{10'000};
  TlsOptions tls;
  /// `http://[user:password@]host:port`; empty: none, whatever the environment says.
  std::string proxy;
  /// How many QoS 1 and 2 messages may await their acknowledgement at once.
  int window = 1'500;
  std::optional<Will> will;
  /// Receives a line for each protocol step, without secrets. May be empty.
  std::function<void(std::string_view)> trace;
  bool trace_payloads = false;  ///< of messages, beside their topics
};

/// What the broker said to one QoS 1 or 2 message.
struct Acknowledgement {
  int token = 0;
  /// MQTT 5 §2.4; 0 on MQTT 3.1.1, which cannot say no. 0x80 and above: the broker refused the
  /// message.
  int reason_code = 0;
  /// For a person, set when refused: "not authorized (0x87)".
  std::string reason = {};

  [[nodiscard]] bool Refused() const { return reason_code >= 0x80; }
};

/// What CONNACK tells (MQTT 5 §3.2.2.3); on 3.1.1 only `broker` and `version`.
struct ServerInfo {
  BrokerUrl broker;
  std::vector<BrokerUrl> site;  ///< all that might have been connected to; empty: this one alone
  ProtocolVersion version = ProtocolVersion::k311;
  std::optional<Qos> maximum_qos;
  std::optional<bool> retain_available;
  std::optional<bool> wildcard_available;
  std::optional<std::uint32_t> maximum_packet_size;
  std::string assigned_client_id;

  /// It has said that it keeps no retained messages.
  [[nodiscard]] bool KeepsNothing() const { return retain_available == false; }
  /// As BrokerUrl::ToString: what went over any of them went to the robots of this site.
  [[nodiscard]] std::vector<std::string> ListSite() const {
    if (site.empty()) return {broker.ToString()};
    std::vector<std::string> names;
    names.reserve(site.size());
    for (const BrokerUrl& one : site) names.push_back(one.ToString());
    return names;
  }
};

/// An open connection with a clean session. Closing: Disconnect(); the destructor drops the
/// connection without a DISCONNECT packet when that was not called.
class Transport {
 public:
  Transport() = default;
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;
  virtual ~Transport() = default;

  [[nodiscard]] virtual const ServerInfo& server() const = 0;

  /// Subscribes and waits for the SUBACK, which may come behind what is retained: the time until the
  /// deadline runs anew with whatever arrives, six times at most and for a minute. A filter that the
  /// broker refuses is an error that names it.
  [[nodiscard]] virtual Status Subscribe(std::span<const std::string> filters, Qos qos,
                                         Deadline deadline) = 0;

  /// Ends subscriptions and waits for the UNSUBACK. What came before it is still to be received.
  [[nodiscard]] virtual Status Unsubscribe(std::span<const std::string> filters,
                                           Deadline deadline) = 0;

  /// Whether a message of this size can go through at all. Errors: kUsage for a topic that is none;
  /// kBroker when the broker has said on connecting (MQTT 5) that it takes no such thing.
  [[nodiscard]] virtual Status Admits(const std::string& topic, std::size_t payload_size,
                                      Qos qos) const = 0;

  /// Waits until the connection takes data. An error is a connection that is lost or stalled:
  /// nothing has been written.
  [[nodiscard]] virtual Status AwaitReady(Deadline deadline) = 0;

  /// QoS 0: returns 0 when the message is with the operating system. QoS 1 and 2: returns the token
  /// by which AwaitAcknowledgements names it; while the window is full, waits for room until the
  /// deadline.
  [[nodiscard]] virtual Result<int> Publish(const Message& message, Deadline deadline) = 0;

  /// Between Cork(true) and Cork(false) messages may leave together in larger packets, and some
  /// only then. For bursts within which nobody waits for an answer.
  virtual void Cork(bool on) = 0;

  /// Waits until no more than `left` messages are in flight, or until the deadline. Returns what
  /// came since the last call, in order of arrival; in_flight() tells what is missing. An error is
  /// a lost connection.
  [[nodiscard]] virtual Result<std::vector<Acknowledgement>> AwaitAcknowledgements(
      Deadline deadline, std::size_t left) = 0;
  [[nodiscard]] virtual int in_flight() const = 0;

  /// The next message of a subscription, in order of arrival; nothing at the deadline.
  [[nodiscard]] virtual Result<std::optional<Message>> Receive(Deadline deadline) = 0;

  /// Whether nothing comes any more, however long one waits: only what plays a recording has an end.
  [[nodiscard]] virtual bool HasEnded() const { return false; }

  /// From now on Receive also returns, with nothing, when one of these descriptors is readable:
  /// who waits for the broker and for something else waits for both. None: the deadline alone.
  virtual void WakeOn(std::span<const int> descriptors) = 0;

  /// Takes leave with DISCONNECT, after which only the destructor may be called.
  virtual void Disconnect() = 0;
};

/// The connection of a virtual robot, whose own topics `connection` and `factsheet` are retained
/// (VDA 5050 §6.1 and chapters on these topics). Commands go through a Transport, which has no way
/// to send anything retained.
class RobotTransport : public Transport {
 public:
  /// As Publish, and the broker keeps the message for later subscribers. For a robot's own topics
  /// only.
  [[nodiscard]] virtual Result<int> PublishRetained(const Message& message, Deadline deadline) = 0;
};

}  // namespace fleetpub::mqtt
