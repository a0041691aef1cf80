// A broker that does as it is told, packet by packet, and counts what was published.
#pragma once

#include <atomic>
#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "support/broken_broker.h"

namespace fleetpub::testing {

/// An MQTT packet (3.1.1 §2).
struct Packet {
  int type = 0;  ///< of the enumeration in §2.2.1: 1 CONNECT, 3 PUBLISH, 8 SUBSCRIBE …
  int flags = 0;
  std::string body;  ///< what follows the length
};

/// Takes packets out of what a socket brings.
class PacketReader {
 public:
  explicit PacketReader(int socket) : socket_(socket) {}
  /// Nothing at the end of the connection.
  [[nodiscard]] std::optional<Packet> Next();

 private:
  [[nodiscard]] bool Fill(std::size_t size);

  int socket_;
  std::string bytes_;
};

/// How it answers. Everybody may connect.
struct Script {
  std::chrono::milliseconds before_suback{0};
  std::string meanwhile = {};  ///< sent every 20 ms of these
  std::chrono::milliseconds before_puback{0};
  int suback = 0;  ///< to each filter
  int puback = 0;  ///< MQTT 5 only
  bool answers_publish = true;
  /// Instead of an answer, when it has any, and `times` of it.
  std::string on_subscribe = {};
  std::string on_publish = {};
  int times = 1;
  /// Follows each SUBACK.
  std::string after_suback = {};
  /// Follows it instead, so much later, where no filter has a wildcard.
  std::string by_name = {};
  std::chrono::milliseconds before_by_name{0};
  /// Closes the connection instead of reading further, after a packet of this type.
  int hangs_up_after = 0;
};

/// Accepts everybody, in MQTT 3.1.1 and 5, and delivers nothing to anybody.
class ScriptedBroker {
 public:
  explicit ScriptedBroker(Script script)
      : script_(std::move(script)), broker_([this](int socket) { Serve(socket); }) {}

  [[nodiscard]] std::string Url() const { return broker_.Url(); }
  [[nodiscard]] std::uint16_t port() const { return broker_.port(); }
  /// PUBLISH packets so far, over all connections.
  [[nodiscard]] int published() const { return published_; }
  [[nodiscard]] int connected() const { return connected_; }

 private:
  void Serve(int socket);
  void PassTime(int socket) const;  // before a SUBACK
  [[nodiscard]] std::string AnswerTo(int socket, const Packet& packet, bool v5);

  Script script_;
  std::atomic<int> published_ = 0;
  std::atomic<int> connected_ = 0;
  BrokenBroker broker_;  // the last: its threads use the others
};

}  // namespace fleetpub::testing
