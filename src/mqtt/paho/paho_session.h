// An open connection of Paho: one step of its engine at a time, and what came of the steps.
#pragma once

#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>
#include <vector>

#include "base/result.h"
#include "mqtt/paho/paho_connect.h"
#include "mqtt/transport.h"

namespace fleetpub::mqtt {

class PahoCall;
class PahoProperties;

/// Whether the broker keeps a message for later subscribers.
enum class Retain : int { kNo = 0, kYes = 1 };

/// Belongs to one thread at a time. Nothing here waits longer than it is told.
class PahoSession {
 public:
  /// `properties` go with each message, on MQTT 5.
  PahoSession(PahoConnection connection, std::chrono::seconds keep_alive,
              const PublishProperties& properties);
  PahoSession(const PahoSession&) = delete;
  PahoSession& operator=(const PahoSession&) = delete;
  /// Drops the connection without DISCONNECT when Disconnect() was not called.
  ~PahoSession();

  [[nodiscard]] const ServerInfo& server() const { return connection_.server; }
  [[nodiscard]] int receive_maximum() const { return connection_.receive_maximum; }
  [[nodiscard]] std::string Name() const { return connection_.server.broker.ToString(); }
  [[nodiscard]] int in_flight() const { return static_cast<int>(in_flight_.size()); }
  /// Why the connection is gone, once it is.
  [[nodiscard]] const std::optional<Error>& lost() const { return lost_; }

  /// Filled by Step(), emptied by whoever uses them.
  std::vector<Acknowledgement> acknowledgements;
  /// The oldest message of those that Step() brought.
  [[nodiscard]] std::optional<Message> TakeReceived();

  /// Lets Paho read at most one packet and send what is due. False: nothing came of it, and nothing
  /// is known to wait.
  bool Step();
  /// Until there is something to read, it is time for Paho to look after its pings, or the
  /// deadline. True: one of the descriptors in `wake` is readable.
  [[nodiscard]] bool Sleep(Deadline deadline, std::span<const int> wake = {}) const;
  /// Until the system takes more data.
  [[nodiscard]] Status AwaitWritable(Deadline deadline);
  /// The token, 0 at QoS 0. The caller has seen to room and writability: Paho would wait for them
  /// without an end.
  [[nodiscard]] Result<int> Publish(const Message& message, Retain retain, Deadline deadline);
  void Cork(bool on) const;
  /// What MQTT 5's properties add to each message, bytes.
  [[nodiscard]] std::size_t properties_size() const;
  /// One SUBSCRIBE packet and its SUBACK.
  [[nodiscard]] Status Subscribe(std::span<const std::string> filters, Qos qos, Deadline deadline);
  /// One UNSUBSCRIBE packet and its UNSUBACK.
  [[nodiscard]] Status Unsubscribe(std::span<const std::string> filters, Deadline deadline);
  void Disconnect();

 private:
  friend struct SessionCallbacks;

  [[nodiscard]] bool Connected() const;
  [[nodiscard]] bool HasReadAhead() const;
  void Acknowledge(int token, int reason);
  [[nodiscard]] bool Keep(char* topic, int topic_length, void* message);
  tl::unexpected<Error> Lose(const PahoCall& call, int code, std::string_view cause);
  int PahoPublish(const Message& message, Retain retain, int& token);
  [[nodiscard]] tl::unexpected<Error> NoAnswer(int result) const;
  int PahoSubscribe(const std::vector<char*>& names, std::vector<int>& codes);
  int PahoUnsubscribe(const std::vector<char*>& names);

  PahoConnection connection_;
  std::unique_ptr<PahoProperties> properties_;  // null on 3.1.1
  std::chrono::milliseconds slice_;             // the longest that Paho may be left alone
  std::deque<Message> received_;
  std::unordered_set<int> in_flight_;
  // Acknowledgements that came before MQTTClient_publish() had returned the token.
  std::vector<std::pair<int, int>> early_;
  std::optional<Error> lost_;
  bool publishing_ = false;
  bool stuck_ = false;  // the last step could have read, but did not get a whole packet
  bool subscribed_ = false;
};

}  // namespace fleetpub::mqtt
