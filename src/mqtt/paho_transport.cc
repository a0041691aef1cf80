#include "mqtt/paho_transport.h"

#include <MQTTClient.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <deque>
#include <unordered_set>

#include "base/text.h"
#include "mqtt/paho_connect.h"
#include "mqtt/paho_errors.h"
#include "mqtt/paho_sockets.h"
#include "mqtt/paho_watch.h"

namespace fleetpub::mqtt {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

// MQTT's largest packet (3.1.1 §2.2.3), less what a PUBLISH adds to topic and payload.
constexpr std::size_t kMaximumPacket = 268'435'455;
constexpr std::size_t kPublishOverhead = 16;
// Brokers limit how many filters one SUBSCRIBE may have.
constexpr std::size_t kFiltersPerPacket = 100;
// How long to wait for the broker to close after DISCONNECT when it may still be sending to us.
constexpr milliseconds kLeaveTime{1000};

// Paho reads every connection's socket whichever client asks, so with several of them a message can be in our queue
// without our socket showing it. Then nobody sleeps for long.
std::atomic<int> open_connections = 0;
constexpr milliseconds kSharedSlice{10};
constexpr milliseconds kLongestSlice{1000};
// Without the descriptor there is only Paho's own waiting.
constexpr milliseconds kBlindSlice{5};

class PahoTransport final : public Transport {
 public:
  PahoTransport(PahoConnection connection, const ConnectOptions& options,
                std::unique_ptr<TraceListener> trace)
      : connection_(std::move(connection)),
        trace_(std::move(trace)),
        window_(std::clamp(options.window, 1, connection_.receive_maximum)),
        slice_(SliceFor(options.keep_alive)) {
    ++open_connections;
    const std::lock_guard lock(PahoMutex());
    // Only MQTT 5 tells the reason. Paho calls these from within our own calls: connecting without a
    // messageArrived callback is what keeps it from starting a thread, and one given later does not.
    if (connection_.server.version == ProtocolVersion::k5) {
      MQTTClient_setPublished(connection_.client, this, OnPublished);
    } else {
      MQTTClient_setCallbacks(connection_.client, this, nullptr, OnNothing, OnDelivered);
    }
  }

  ~PahoTransport() override {
    --open_connections;
    const std::lock_guard lock(PahoMutex());
    const PahoCall call(connection_.descriptor, steady_clock::now());
    if (MQTTClient_isConnected(connection_.client) != 0) {
      // Paho cannot drop a connection without DISCONNECT, but a DISCONNECT can be kept from arriving.
      if (connection_.descriptor >= 0) shutdown(connection_.descriptor, SHUT_RDWR);
      MQTTClient_disconnect(connection_.client, 0);
    }
    MQTTClient_destroy(&connection_.client);
  }

  [[nodiscard]] const ServerInfo& server() const override { return connection_.server; }
  [[nodiscard]] int in_flight() const override { return static_cast<int>(in_flight_.size()); }

  [[nodiscard]] Status Subscribe(std::span<const std::string> filters, Qos qos,
                                 Deadline deadline) override {
    for (const std::string& filter : filters) {
      if (filter.empty() || filter.size() > 65'535 || !base::IsUtf8(filter) ||
          filter.find('\0') != std::string::npos) {
        return Fail(ErrorKind::kUsage, fmt::format("\"{}\" is no topic filter", base::Printable(filter)));
      }
    }
    while (!filters.empty()) {
      const auto some = filters.first(std::min(filters.size(), kFiltersPerPacket));
      if (auto status = SubscribeSome(some, qos, deadline); !status) return status;
      filters = filters.subspan(some.size());
    }
    return {};
  }

  [[nodiscard]] Result<int> Publish(const Message& message, Deadline deadline) override {
    if (auto status = CheckMessage(message); !status) return Fail(std::move(status.error()));
    if (message.qos != Qos::kAtMostOnce) {
      if (auto status = AwaitRoom(deadline); !status) return Fail(std::move(status.error()));
    }
    if (auto status = AwaitWritable(deadline); !status) return Fail(std::move(status.error()));
    const std::lock_guard lock(PahoMutex());
    const PahoCall call(connection_.descriptor, deadline);
    MQTTClient_deliveryToken token = 0;
    const int code = PahoPublish(message, token);
    // At QoS 1 and 2 Paho says "success" of a message that it keeps for the next session: there will be none.
    if (code != MQTTCLIENT_SUCCESS || !Connected()) return Lost(call, code);
    if (message.qos == Qos::kAtMostOnce) return 0;
    in_flight_.insert(token);
    return token;
  }

  [[nodiscard]] Result<std::vector<Acknowledgement>> AwaitAcknowledgements(
      Deadline deadline) override {
    while (true) {
      const bool gained = Step(deadline);
      // What was acknowledged before the connection broke is told first; the next call tells that it broke.
      if (lost_ && (acknowledgements_.empty() || in_flight_.empty())) return Fail(*lost_);
      if (lost_ || in_flight_.empty() || steady_clock::now() >= deadline) break;
      if (!gained) Sleep(deadline);
    }
    return std::exchange(acknowledgements_, {});
  }

  [[nodiscard]] Result<std::optional<Message>> Receive(Deadline deadline) override {
    while (true) {
      if (received_.empty() && !lost_) {
        const bool gained = Step(deadline);
        if (!gained && !lost_ && steady_clock::now() < deadline) {
          Sleep(deadline);
          continue;
        }
      }
      if (!received_.empty()) {
        std::optional<Message> message = std::move(received_.front());
        received_.pop_front();
        return message;
      }
      if (lost_) return Fail(*lost_);
      if (steady_clock::now() >= deadline) return std::nullopt;
    }
  }

  void Disconnect() override {
    Descriptor kept;
    {
      const std::lock_guard lock(PahoMutex());
      if (!Connected()) return;
      // Closing a socket with unread input makes TCP reset the connection, and a reset may overtake what we sent last.
      if (subscribed_ && connection_.descriptor >= 0) kept = Descriptor(dup(connection_.descriptor));
      const PahoCall call(connection_.descriptor, steady_clock::now() + kLeaveTime);
      MQTTClient_disconnect(connection_.client, 0);
    }
    if (kept.open()) Drain(kept.get());
  }

 private:
  static milliseconds SliceFor(std::chrono::seconds keep_alive) {
    if (keep_alive.count() <= 0) return kLongestSlice;
    return std::min<milliseconds>(kLongestSlice, milliseconds(keep_alive) / 10);
  }

  // All callbacks of Paho come on the thread that called it, with PahoMutex() held.
  static void OnPublished(void* self, int token, int /*packet*/, MQTTProperties* /*properties*/,
                          enum MQTTReasonCodes reason) {
    static_cast<PahoTransport*>(self)->Acknowledge(token, reason);
  }
  static void OnDelivered(void* self, MQTTClient_deliveryToken token) {
    static_cast<PahoTransport*>(self)->Acknowledge(token, 0);
  }
  static int OnNothing(void*, char*, int, MQTTClient_message*) { return 1; }

  void Acknowledge(int token, int reason) {
    if (in_flight_.erase(token) == 0) return;
    Acknowledgement& acknowledgement = acknowledgements_.emplace_back();
    acknowledgement.token = token;
    acknowledgement.reason_code = reason;
    if (acknowledgement.Refused()) acknowledgement.reason = ReasonText(reason);
  }

  [[nodiscard]] bool Connected() const { return MQTTClient_isConnected(connection_.client) != 0; }

  [[nodiscard]] std::string Name() const { return connection_.server.broker.ToString(); }

  tl::unexpected<Error> Lost(const PahoCall& call, int code) {
    if (!lost_) {
      std::string_view cause = "the broker closed it (does another client use the same client id?)";
      if (call.expired()) {
        cause = "the broker did not take or answer what was sent in time";
      } else if (connection_.descriptor >= 0 && code == MQTTCLIENT_SUCCESS && !call.readable()) {
        cause = "the broker did not answer the keep-alive pings";
      }
      lost_ = Error{ErrorKind::kBroker, fmt::format("the connection to {} was lost: {}", Name(), cause),
                    fmt::format("Paho: {}", code)};
    }
    return Fail(*lost_);
  }

  // Lets Paho read at most one packet and send what is due. Whether a message or an acknowledgement came of it.
  bool Step(Deadline deadline) {
    const std::lock_guard lock(PahoMutex());
    if (lost_) return false;
    const std::size_t before = received_.size() + acknowledgements_.size();
    // A packet more than what poll() knows of may be in OpenSSL's hands (Paho forgets it behind a packet without
    // a body) or, several of them in one frame, in those of Paho's WebSocket layer.
    PahoCall call(connection_.descriptor, std::max(deadline, steady_clock::now() + kLeaveTime));
    if (probes_ > 0 || connection_.tls->HasBufferedData()) call.Probe();
    const unsigned long timeout =
        connection_.descriptor >= 0 ? 0 : static_cast<unsigned long>(BlindWait(deadline).count());
    char* topic = nullptr;
    int topic_length = 0;
    MQTTClient_message* message = nullptr;
    const int code =
        MQTTClient_receive(connection_.client, &topic, &topic_length, &message, timeout);
    if (message != nullptr) Keep(topic, topic_length, message);
    if (!Connected()) static_cast<void>(Lost(call, code));
    const bool gained = received_.size() + acknowledgements_.size() > before;
    stuck_ = call.readable() && !gained;
    if (call.readable() || gained) {
      probes_ = connection_.server.broker.UsesWebSocket() ? 3 : 0;
    } else if (probes_ > 0) {
      --probes_;
    }
    return gained || probes_ > 0;
  }

  void Keep(char* topic, int topic_length, MQTTClient_message* message) {
    Message& kept = received_.emplace_back();
    // The length is 0 unless the topic contains a NUL.
    if (topic_length > 0) {
      kept.topic.assign(topic, static_cast<std::size_t>(topic_length));
    } else {
      kept.topic = topic;
    }
    kept.payload.assign(static_cast<const char*>(message->payload),
                        static_cast<std::size_t>(message->payloadlen));
    kept.qos = static_cast<Qos>(message->qos);
    kept.retained = message->retained != 0;
    MQTTClient_freeMessage(&message);
    MQTTClient_free(topic);
  }

  [[nodiscard]] static milliseconds BlindWait(Deadline deadline) {
    return std::min(kBlindSlice, milliseconds(MillisecondsUntil(deadline)));
  }

  // Until there is something to read, it is time for Paho to look after its pings, or the deadline.
  void Sleep(Deadline deadline) {
    if (connection_.descriptor < 0 || lost_ || connection_.tls->HasBufferedData()) return;
    const milliseconds slice = open_connections > 1 ? std::min(slice_, kSharedSlice) : slice_;
    const Deadline until = std::min(deadline, steady_clock::now() + slice);
    // Paho reads only from a socket that it could also write to.
    if (stuck_) static_cast<void>(WaitFor(connection_.descriptor, POLLOUT, until));
    static_cast<void>(WaitFor(connection_.descriptor, POLLIN, until));
  }

  Status CheckMessage(const Message& message) {
    if (lost_) return Fail(*lost_);
    if (message.topic.empty() || message.topic.size() > 65'535 || !base::IsUtf8(message.topic) ||
        message.topic.find_first_of(std::string_view("+#\0", 3)) != std::string::npos) {
      return Fail(ErrorKind::kUsage,
                  fmt::format("\"{}\" is no topic to publish to: no +, #, NUL, and UTF-8",
                              base::Printable(message.topic)));
    }
    const std::size_t limit = connection_.server.maximum_packet_size.value_or(kMaximumPacket);
    const std::size_t size = message.topic.size() + message.payload.size() + kPublishOverhead;
    if (size > std::min(limit, kMaximumPacket)) {
      return Fail(ErrorKind::kBroker,
                  fmt::format("a message of {} bytes is more than {} accepts ({})",
                              message.payload.size(), Name(), std::min(limit, kMaximumPacket)));
    }
    if (const auto maximum = connection_.server.maximum_qos; maximum && message.qos > *maximum) {
      return Fail(ErrorKind::kBroker, fmt::format("{} accepts QoS {} at most: use --qos {}", Name(),
                                                  static_cast<int>(*maximum), static_cast<int>(*maximum)));
    }
    return {};
  }

  // Paho would wait for room without an end, in steps of 100 ms.
  Status AwaitRoom(Deadline deadline) {
    while (in_flight() >= window_) {
      const bool gained = Step(deadline);
      if (lost_) return Fail(*lost_);
      if (in_flight() < window_) break;
      if (steady_clock::now() >= deadline) {
        return Fail(ErrorKind::kBroker,
                    fmt::format("{} left {} messages unacknowledged in time", Name(), in_flight()));
      }
      if (!gained) Sleep(deadline);
    }
    return {};
  }

  // A write to a connection that the broker has closed succeeds once; so its end is looked for before.
  Status AwaitWritable(Deadline deadline) {
    if (connection_.descriptor < 0) return {};
    const short seen = WaitFor(connection_.descriptor, POLLOUT | POLLRDHUP, deadline);
    while ((seen & (POLLRDHUP | POLLHUP | POLLERR | POLLNVAL)) != 0 && !lost_) {
      if (!Step(deadline) && steady_clock::now() >= deadline) break;
    }
    if (lost_) return Fail(*lost_);
    if (seen == 0) {
      return Fail(ErrorKind::kBroker, fmt::format("{} takes no more data: it or the network is stalled", Name()));
    }
    return {};
  }

  int PahoPublish(const Message& message, MQTTClient_deliveryToken& token) {
    const int size = static_cast<int>(message.payload.size());
    const int qos = static_cast<int>(message.qos);
    if (connection_.server.version == ProtocolVersion::k5) {
      const MQTTResponse response =
          MQTTClient_publish5(connection_.client, message.topic.c_str(), size, message.payload.data(),
                              qos, 0, nullptr, &token);
      return response.reasonCode;
    }
    return MQTTClient_publish(connection_.client, message.topic.c_str(), size,
                              message.payload.data(), qos, 0, &token);
  }

  Status SubscribeSome(std::span<const std::string> filters, Qos qos, Deadline deadline) {
    if (lost_) return Fail(*lost_);
    std::vector<char*> names;
    names.reserve(filters.size());
    for (const std::string& filter : filters) names.push_back(const_cast<char*>(filter.c_str()));
    std::vector<int> codes(filters.size(), static_cast<int>(qos));
    const std::lock_guard lock(PahoMutex());
    const PahoCall call(connection_.descriptor, deadline);
    subscribed_ = true;
    const int result = PahoSubscribe(names, codes);
    if (!Connected()) return Lost(call, result);
    if (result != MQTTCLIENT_SUCCESS) {
      return Fail(ErrorKind::kBroker, fmt::format("{} did not answer the subscription", Name()),
                  MQTTClient_strerror(result));
    }
    for (std::size_t i = 0; i < filters.size(); ++i) {
      if (codes[i] < 0x80) continue;
      // 3.1.1 has one code for every reason (§3.9.3).
      const bool v5 = connection_.server.version == ProtocolVersion::k5;
      return Fail(ErrorKind::kBroker,
                  fmt::format("{} refuses the subscription to {}: {}", Name(), base::Printable(filters[i]),
                              v5 ? ReasonText(codes[i]) : "this client may not read it"));
    }
    return {};
  }

  // Paho's result; into `codes` goes what the broker said to each filter.
  int PahoSubscribe(const std::vector<char*>& names, std::vector<int>& codes) {
    const int count = static_cast<int>(names.size());
    if (connection_.server.version != ProtocolVersion::k5) {
      return MQTTClient_subscribeMany(connection_.client, count, names.data(), codes.data());
    }
    const MQTTResponse response = MQTTClient_subscribeMany5(connection_.client, count, names.data(),
                                                            codes.data(), nullptr, nullptr);
    int result = response.reasonCode < 0 ? response.reasonCode : MQTTCLIENT_SUCCESS;
    if (result == MQTTCLIENT_SUCCESS && response.reasonCodeCount != count) result = MQTTCLIENT_FAILURE;
    for (std::size_t i = 0; result == MQTTCLIENT_SUCCESS && i < codes.size(); ++i) {
      codes[i] = response.reasonCodes != nullptr ? response.reasonCodes[i] : response.reasonCode;
    }
    MQTTResponse_free(response);
    return result;
  }

  static void Drain(int descriptor) {
    const Deadline deadline = steady_clock::now() + kLeaveTime;
    std::array<char, 16 * 1024> scrap;
    while (steady_clock::now() < deadline) {
      if (WaitFor(descriptor, POLLIN, deadline) == 0) return;
      const ssize_t got = recv(descriptor, scrap.data(), scrap.size(), MSG_DONTWAIT);
      if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) return;
    }
  }

  PahoConnection connection_;
  std::unique_ptr<TraceListener> trace_;
  int window_;
  milliseconds slice_;
  std::unordered_set<int> in_flight_;
  std::vector<Acknowledgement> acknowledgements_;
  std::deque<Message> received_;
  std::optional<Error> lost_;  // why the connection is gone
  int probes_ = 0;             // steps that look for a packet although nothing seems to be there
  bool stuck_ = false;         // the last step could have read, but did not get a whole packet
  bool subscribed_ = false;
};

}  // namespace

Result<std::unique_ptr<Transport>> ConnectPaho(const ConnectOptions& options) {
  if (auto status = CheckConnectOptions(options); !status) return Fail(std::move(status.error()));
  std::unique_ptr<TraceListener> trace;
  if (options.trace) trace = std::make_unique<TraceListener>(options.trace);
  std::vector<std::string> messages;
  std::vector<std::string> details;
  for (const BrokerUrl& broker : options.brokers) {
    auto connection = ConnectTo(broker, options);
    if (connection) {
      return std::make_unique<PahoTransport>(*std::move(connection), options, std::move(trace));
    }
    if (connection.error().kind != ErrorKind::kBroker) return Fail(std::move(connection.error()));
    messages.push_back(std::move(connection.error().message));
    if (!connection.error().detail.empty()) details.push_back(std::move(connection.error().detail));
  }
  return Fail(ErrorKind::kBroker, base::Join(messages, "; "), base::Join(details, "; "));
}

}  // namespace fleetpub::mqtt
