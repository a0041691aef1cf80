#include "mqtt/paho/paho_transport.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/text.h"
#include "mqtt/paho/paho_session.h"

namespace fleetpub::mqtt {
namespace {

using std::chrono::steady_clock;

// MQTT's largest packet (3.1.1 §2.2.3), and what a PUBLISH adds to topic and payload at most.
constexpr std::size_t kMaximumPacket = 268'435'455;
constexpr std::size_t kPublishOverhead = 16;
// Brokers limit how many filters one SUBSCRIBE may have.
constexpr std::size_t kFiltersPerPacket = 100;
// AWS IoT Core takes eight filters in a SUBSCRIBE, and fifty subscriptions of a connection: packets
// need to be that small only while there are no more.
constexpr std::size_t kCloudFilters = 8;
constexpr std::size_t kCloudSubscriptions = 50;
// mosquitto 2.0.11 acknowledges more than its max_inflight_messages (20) of QoS 2 at once to the
// end and delivers 20 of them. MQTT 5 tells the number, 3.1.1 does not.
constexpr int kWindowOfQos2 = 20;

class PahoTransport final : public RobotTransport {
 public:
  PahoTransport(std::unique_ptr<TraceObserver> trace, PahoConnection connection,
                const ConnectOptions& options)
      : trace_(std::move(trace)),
        tell_(options.trace),
        tells_payloads_(options.trace_payloads),
        session_(std::move(connection), options.keep_alive, options.properties),
        window_(std::clamp(options.window, 1, session_.receive_maximum())) {}

  [[nodiscard]] const ServerInfo& server() const override { return session_.server(); }
  [[nodiscard]] int in_flight() const override { return session_.in_flight(); }
  void Disconnect() override { session_.Disconnect(); }

  [[nodiscard]] Status Subscribe(std::span<const std::string> filters, Qos qos,
                                 Deadline deadline) override {
    for (const std::string& filter : filters) {
      if (filter.empty() || !IsMqttString(filter)) {
        return Fail(ErrorKind::kUsage,
                    fmt::format("\"{}\" is not a topic filter", base::Printable(filter)));
      }
    }
    subscriptions_ += filters.size();
    const bool is_beyond_clouds = subscriptions_ > kCloudSubscriptions;
    const std::size_t most = is_beyond_clouds ? kFiltersPerPacket : kCloudFilters;
    const auto patience = deadline - steady_clock::now();
    while (!filters.empty()) {
      const auto some = filters.first(std::min(filters.size(), most));
      const auto end = std::max(deadline, steady_clock::now() + patience);
      if (auto status = session_.Subscribe(some, qos, end); !status) {
        if (is_beyond_clouds) {
          status.error().message += fmt::format(
              " (these would be {} subscriptions of one connection: some brokers take fewer, AWS "
              "IoT Core {})",
              subscriptions_, kCloudSubscriptions);
        }
        return status;
      }
      filters = filters.subspan(some.size());
    }
    return {};
  }

  [[nodiscard]] Status Unsubscribe(std::span<const std::string> filters,
                                   Deadline deadline) override {
    subscriptions_ -= std::min(subscriptions_, filters.size());
    while (!filters.empty()) {
      const auto some = filters.first(std::min(filters.size(), kFiltersPerPacket));
      if (auto status = session_.Unsubscribe(some, deadline); !status) return status;
      filters = filters.subspan(some.size());
    }
    return {};
  }

  [[nodiscard]] Status Admits(const std::string& topic, std::size_t payload_size,
                              Qos qos) const override {
    if (topic.empty() || !IsMqttString(topic) || topic.find_first_of("+#") != std::string::npos) {
      return Fail(ErrorKind::kUsage,
                  fmt::format("\"{}\" is not a topic to publish to: UTF-8, without +, # and NUL",
                              base::Printable(topic)));
    }
    const ServerInfo& server = session_.server();
    const std::size_t limit =
        std::min<std::size_t>(server.maximum_packet_size.value_or(kMaximumPacket), kMaximumPacket);
    const std::size_t overhead = kPublishOverhead + session_.properties_size();
    if (topic.size() + payload_size + overhead > limit) {
      return Fail(ErrorKind::kBroker,
                  fmt::format("a message of {} bytes is too large for {}, which takes packets of "
                              "{} bytes: send less at once, or have its limit raised",
                              payload_size, session_.Name(), limit));
    }
    if (server.maximum_qos && qos > *server.maximum_qos) {
      return Fail(ErrorKind::kBroker,
                  fmt::format("{} takes no QoS above {}: use --qos {}", session_.Name(),
                              static_cast<int>(*server.maximum_qos),
                              static_cast<int>(*server.maximum_qos)));
    }
    return {};
  }

  [[nodiscard]] Result<int> Publish(const Message& message, Deadline deadline) override {
    return Publish(message, Retain::kNo, deadline);
  }

  [[nodiscard]] Result<int> PublishRetained(const Message& message, Deadline deadline) override {
    return Publish(message, Retain::kYes, deadline);
  }

  [[nodiscard]] Result<std::vector<Acknowledgement>> AwaitAcknowledgements(
      Deadline deadline, std::size_t left) override {
    while (true) {
      const bool gained = session_.Step();
      if (session_.lost() || std::cmp_less_equal(in_flight(), left) ||
          steady_clock::now() >= deadline)
        break;
      if (!gained) static_cast<void>(session_.Sleep(deadline));
    }
    // What was acknowledged before the connection broke is told first; the next call tells that it
    // broke.
    if (session_.lost() && session_.acknowledgements.empty()) return Fail(*session_.lost());
    return std::exchange(session_.acknowledgements, {});
  }

  [[nodiscard]] Result<std::optional<Message>> Receive(Deadline deadline) override {
    while (true) {
      if (auto message = TakeReceived()) return message;
      if (session_.lost()) return Fail(*session_.lost());
      const bool gained = session_.Step();
      if (auto message = TakeReceived()) return message;
      if (session_.lost()) continue;
      if (steady_clock::now() >= deadline) return std::nullopt;
      if (!gained && session_.Sleep(deadline, wake_)) return std::nullopt;
    }
  }

  void Cork(bool on) override { session_.Cork(on); }

  [[nodiscard]] Status AwaitReady(Deadline deadline) override {
    return session_.AwaitWritable(deadline);
  }

  void WakeOn(std::span<const int> descriptors) override {
    wake_.assign(descriptors.begin(), descriptors.end());
  }

 private:
  void Tell(std::string_view what, const Message& message) const {
    if (!tell_) return;
    tell_(fmt::format("{} {}, {} bytes{}{}", what, message.topic, message.payload.size(),
                      tells_payloads_ ? ": " : "", tells_payloads_ ? message.payload : ""));
  }

  std::optional<Message> TakeReceived() {
    auto message = session_.TakeReceived();
    if (message) Tell("received", *message);
    return message;
  }

  [[nodiscard]] Result<int> Publish(const Message& message, Retain retain, Deadline deadline) {
    if (auto status = Admits(message.topic, message.payload.size(), message.qos); !status)
      return Fail(std::move(status.error()));
    if (auto status = AwaitRoom(message.qos, deadline); !status)
      return Fail(std::move(status.error()));
    if (auto status = session_.AwaitWritable(deadline); !status)
      return Fail(std::move(status.error()));
    auto published = session_.Publish(message, retain, deadline);
    if (published) Tell("sent", message);
    return published;
  }

  // At QoS 0 too: with a full window Paho sleeps 100 ms over any message.
  Status AwaitRoom(Qos qos, Deadline deadline) {
    const bool careful = qos == Qos::kExactlyOnce && server().version == ProtocolVersion::k311;
    const int window = careful ? std::min(window_, kWindowOfQos2) : window_;
    while (in_flight() >= window) {
      session_.Cork(false);  // what is held back cannot be acknowledged
      const bool gained = session_.Step();
      if (session_.lost()) return Fail(*session_.lost());
      if (in_flight() < window) break;
      if (steady_clock::now() >= deadline) {
        return Fail(ErrorKind::kBroker, fmt::format("{} left {} messages unacknowledged in time",
                                                    session_.Name(), in_flight()));
      }
      if (!gained) static_cast<void>(session_.Sleep(deadline));
    }
    return {};
  }

  std::unique_ptr<TraceObserver> trace_;
  std::function<void(std::string_view)> tell_;
  bool tells_payloads_;
  PahoSession session_;
  int window_;
  std::size_t subscriptions_ = 0;
  std::vector<int> wake_;
};

Result<std::unique_ptr<PahoTransport>> Connect(const ConnectOptions& options, bool& may_heal) {
  may_heal = false;
  if (auto status = CheckConnectOptions(options); !status) return Fail(std::move(status.error()));
  std::unique_ptr<TraceObserver> trace;
  if (options.trace) trace = std::make_unique<TraceObserver>(options.trace);
  std::vector<std::string> messages;
  std::vector<std::string> details;
  for (const BrokerUrl& broker : options.brokers) {
    auto connection = ConnectTo(broker, options);
    if (connection) {
      return std::make_unique<PahoTransport>(std::move(trace), *std::move(connection), options);
    }
    auto& [error, distrusted, heals] = connection.error();
    may_heal = !distrusted && (may_heal || heals);
    if (error.kind != ErrorKind::kBroker) {
      may_heal = false;
      return Fail(std::move(error));
    }
    messages.push_back(std::move(error.message));
    if (!error.detail.empty()) details.push_back(std::move(error.detail));
    if (!distrusted) continue;
    // Somebody is in the way, perhaps to have us talk to another of these brokers.
    if (&broker != &options.brokers.back()) {
      messages.emplace_back("after a certificate that failed no other broker is tried");
    }
    break;
  }
  return Fail(ErrorKind::kBroker, base::Join(messages, "; "), base::Join(details, "; "));
}

}  // namespace

Result<std::unique_ptr<Transport>> ConnectPaho(const ConnectOptions& options, bool* may_heal) {
  bool unasked = false;
  return Connect(options, may_heal == nullptr ? unasked : *may_heal);
}

Result<std::unique_ptr<RobotTransport>> ConnectPahoAsRobot(const ConnectOptions& options,
                                                           bool* may_heal) {
  bool unasked = false;
  return Connect(options, may_heal == nullptr ? unasked : *may_heal);
}

}  // namespace fleetpub::mqtt
