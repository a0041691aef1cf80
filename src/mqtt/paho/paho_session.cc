#include "mqtt/paho/paho_session.h"

#include <MQTTClient.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <mutex>
#include <utility>

#include "base/text.h"
#include "mqtt/paho/paho_errors.h"
#include "mqtt/paho/paho_properties.h"
#include "mqtt/paho/paho_sockets.h"
#include "mqtt/paho/paho_watch.h"

namespace fleetpub::mqtt {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

// What one step may take when it has to write, and how long to wait for the broker to close after
// DISCONNECT.
constexpr milliseconds kWriteTime{1000};

// A SUBACK that stands behind much else may take so much longer.
constexpr int kSubackPatiences = 6;
constexpr std::chrono::seconds kSubackTime{60};
// Paho's own limit, which counts whatever comes meanwhile; our deadlines end its waits.
constexpr unsigned long kNoCommandTimeout = 3'600'000;

// Paho reads every connection's socket whichever client asks, so with several of them a message can
// be in our queue without our socket showing it. Then nobody sleeps for long.
std::atomic<int> open_sessions = 0;
constexpr milliseconds kSharedSlice{10};
constexpr milliseconds kLongestSlice{1000};
// Without the descriptor there is only Paho's own waiting.
constexpr unsigned long kBlindMilliseconds = 5;

constexpr std::string_view kClosed =
    "the broker closed it (does another client use the same client id? Is something not allowed?)";
constexpr std::string_view kClosedBySubscribing =
    "the broker closed it when we subscribed (may this client read these topics? Does another one "
    "use "
    "the same client id?)";
constexpr std::string_view kSilent = "the broker did not answer the keep-alive pings";

milliseconds SliceFor(std::chrono::seconds keep_alive) {
  if (keep_alive.count() <= 0) return kLongestSlice;
  return std::min<milliseconds>(kLongestSlice, milliseconds(keep_alive) / 10);
}

// As Paho takes them; it copies the texts.
std::vector<char*> MakeNames(std::span<const std::string> filters) {
  std::vector<char*> names;
  names.reserve(filters.size());
  for (const std::string& filter : filters) names.push_back(const_cast<char*>(filter.c_str()));
  return names;
}

// Reads until the broker has closed.
void Drain(int descriptor) {
  const Deadline deadline = steady_clock::now() + kWriteTime;
  std::array<char, 16'384> scrap;
  while (steady_clock::now() < deadline) {
    if (WaitFor(descriptor, POLLIN, deadline) == 0) return;
    const ssize_t got = recv(descriptor, scrap.data(), scrap.size(), MSG_DONTWAIT);
    if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) return;
  }
}

// Whether one of the descriptors is readable; waits until one is, or `other`, or the deadline.
bool AnyReadable(std::span<const int> descriptors, int other = -1, Deadline deadline = {}) {
  std::vector<pollfd> polled = {{other, POLLIN, 0}};
  for (const int descriptor : descriptors) polled.push_back({descriptor, POLLIN, 0});
  const auto left = std::chrono::ceil<milliseconds>(deadline - steady_clock::now());
  const int wait = std::max(0, static_cast<int>(std::min(left, kLongestSlice).count()));
  if (poll(polled.data(), polled.size(), wait) <= 0) return false;
  return std::any_of(polled.begin() + 1, polled.end(),
                     [](const pollfd& one) { return one.revents != 0; });
}

}  // namespace

// All callbacks of Paho come on the thread that called it, with PahoMutex() held.
struct SessionCallbacks {
  static void OnPublished(void* session, int token, int /*packet*/, MQTTProperties* /*properties*/,
                          enum MQTTReasonCodes reason) {
    static_cast<PahoSession*>(session)->Acknowledge(token, reason);
  }
  static void OnDelivered(void* session, MQTTClient_deliveryToken token) {
    static_cast<PahoSession*>(session)->Acknowledge(token, 0);
  }
  static int OnNothing(void* /*session*/, char* /*topic*/, int /*length*/,
                       MQTTClient_message* /*message*/) {
    return 1;
  }
};

PahoSession::PahoSession(PahoConnection connection, std::chrono::seconds keep_alive,
                         const PublishProperties& properties)
    : connection_(std::move(connection)), slice_(SliceFor(keep_alive)) {
  ++open_sessions;
  const std::lock_guard lock(PahoMutex());
  // Only MQTT 5 tells the reason. Connecting without a messageArrived callback is what keeps Paho
  // from starting a thread; one given afterwards, without which there is no deliveryComplete
  // either, starts none.
  if (connection_.server.version == ProtocolVersion::k5) {
    properties_ = std::make_unique<PahoProperties>(properties);
    MQTTClient_setPublished(connection_.client, this, SessionCallbacks::OnPublished);
  } else {
    MQTTClient_setCallbacks(connection_.client, this, nullptr, SessionCallbacks::OnNothing,
                            SessionCallbacks::OnDelivered);
  }
}

PahoSession::~PahoSession() {
  --open_sessions;
  const std::lock_guard lock(PahoMutex());
  const PahoCall call(connection_.descriptor, steady_clock::now());
  if (Connected()) {
    // Paho cannot drop a connection without DISCONNECT, but a DISCONNECT can be kept from arriving.
    if (connection_.descriptor >= 0) shutdown(connection_.descriptor, SHUT_RDWR);
    MQTTClient_disconnect(connection_.client, 0);
  }
  MQTTClient_destroy(&connection_.client);
  connection_.input.reset();
}

void PahoSession::Disconnect() {
  Descriptor kept;
  {
    const std::lock_guard lock(PahoMutex());
    if (!Connected()) return;
    // Closing a socket with unread input makes TCP reset the connection, and a reset may overtake
    // what we sent last.
    if (subscribed_ && connection_.descriptor >= 0) kept = Descriptor(dup(connection_.descriptor));
    const PahoCall call(connection_.descriptor, steady_clock::now() + kWriteTime);
    MQTTClient_disconnect(connection_.client, 0);
  }
  if (kept.open()) Drain(kept.get());
}

bool PahoSession::Connected() const { return MQTTClient_isConnected(connection_.client) != 0; }

void PahoSession::Acknowledge(int token, int reason) {
  if (in_flight_.erase(token) == 0) {
    if (publishing_) early_.emplace_back(token, reason);
    return;
  }
  Acknowledgement& acknowledgement = acknowledgements.emplace_back();
  acknowledgement.token = token;
  acknowledgement.reason_code = reason;
  if (acknowledgement.Refused()) {
    acknowledgement.reason = ReasonText(reason, connection_.input->check().reason());
  }
}

tl::unexpected<Error> PahoSession::Lose(const PahoCall& call, int code, std::string_view cause) {
  const PacketCheck& check = connection_.input->check();
  std::string broken;
  if (!connection_.input->fault().empty()) {
    broken = fmt::format("the broker sent {}", connection_.input->fault());
  } else if (check.HasDisconnected() && check.reason().code != 0) {
    broken = fmt::format("the broker closed it: {}",
                         ReasonText(static_cast<int>(check.reason().code), check.reason()));
  }
  if (!broken.empty()) {
    cause = broken;
  } else if (call.expired()) {
    cause = "the broker did not take or answer what was sent in time";
  }
  if (!lost_) {
    lost_ =
        Error{ErrorKind::kBroker, fmt::format("the connection to {} was lost: {}", Name(), cause),
              fmt::format("Paho: {}", code)};
  }
  return Fail(*lost_);
}

bool PahoSession::Step() {
  const std::lock_guard lock(PahoMutex());
  if (lost_) return false;
  const std::size_t before = received_.size() + acknowledgements.size();
  PahoCall call(connection_.descriptor, steady_clock::now() + kWriteTime);
  // A packet more than what poll() knows of may be in OpenSSL's hands (Paho forgets it behind a
  // packet without a body).
  if (connection_.tls->HasBufferedData()) call.Probe();
  char* topic = nullptr;
  int topic_length = 0;
  MQTTClient_message* message = nullptr;
  const int code = MQTTClient_receive(connection_.client, &topic, &topic_length, &message,
                                      connection_.descriptor < 0 ? kBlindMilliseconds : 0);
  if (message != nullptr && !Keep(topic, topic_length, message)) call.Abort();
  if (!Connected()) {
    const bool unasked = connection_.descriptor < 0 || call.readable();
    static_cast<void>(Lose(call, code, unasked ? kClosed : kSilent));
    return false;
  }
  const bool gained = received_.size() + acknowledgements.size() > before;
  stuck_ = call.readable() && !gained;
  return gained;
}

// False: Paho hands out what can be no message. PacketCheck lets nothing through that could become
// one.
bool PahoSession::Keep(char* topic, int topic_length, void* opaque) {
  auto* message = static_cast<MQTTClient_message*>(opaque);
  const bool sound = topic_length >= 0 && message->payloadlen >= 0;
  if (sound) {
    Message& kept = received_.emplace_back();
    kept.topic.assign(topic, static_cast<std::size_t>(topic_length));
    kept.payload.assign(static_cast<const char*>(message->payload),
                        static_cast<std::size_t>(message->payloadlen));
    kept.qos = static_cast<Qos>(message->qos);
    kept.retained = message->retained != 0;
    kept.duplicate = message->dup != 0;
    const auto properties = static_cast<std::size_t>(message->properties.length);
    connection_.input->check().Release(PacketCheck::CostOfProperties(properties));
  }
  MQTTClient_freeMessage(&message);
  MQTTClient_free(topic);
  return sound;
}

std::optional<Message> PahoSession::TakeReceived() {
  if (received_.empty()) return std::nullopt;
  std::optional<Message> message = std::move(received_.front());
  received_.pop_front();
  const std::size_t cost =
      PacketCheck::EstimateCost(message->topic.size(), message->payload.size());
  const std::lock_guard lock(PahoMutex());
  connection_.input->check().Release(cost);
  return message;
}

bool PahoSession::HasReadAhead() const {
  const std::lock_guard lock(PahoMutex());
  return connection_.input->HasReadAhead();
}

bool PahoSession::Sleep(Deadline deadline, std::span<const int> wake) const {
  if (connection_.descriptor < 0) return AnyReadable(wake);
  if (lost_ || connection_.tls->HasBufferedData()) return false;
  const milliseconds slice = open_sessions > 1 ? std::min(slice_, kSharedSlice) : slice_;
  const Deadline until = std::min(deadline, steady_clock::now() + slice);
  // Paho reads only from a socket that it could also write to.
  if (stuck_) static_cast<void>(WaitFor(connection_.descriptor, POLLOUT, until));
  if (HasReadAhead()) return false;
  AcknowledgeAtOnce(connection_.descriptor);
  if (!wake.empty()) return AnyReadable(wake, connection_.descriptor, until);
  static_cast<void>(WaitFor(connection_.descriptor, POLLIN, until));
  return false;
}

Status PahoSession::AwaitWritable(Deadline deadline) {
  if (connection_.descriptor < 0 && !lost_) return {};
  if (lost_) return Fail(*lost_);
  const short seen = WaitFor(connection_.descriptor, POLLOUT | POLLRDHUP, deadline);
  if (seen == 0) {
    return Fail(ErrorKind::kBroker,
                fmt::format("{} takes no more data: it or the network is stalled", Name()));
  }
  // A write to a connection that the broker has closed succeeds once; so its end is looked for
  // before. Paho finds it behind what else is still to be read.
  if ((seen & (POLLRDHUP | POLLHUP | POLLERR | POLLNVAL)) != 0) {
    while (!lost_ && steady_clock::now() < deadline) Step();
  }
  if (lost_) return Fail(*lost_);
  return {};
}

Result<int> PahoSession::Publish(const Message& message, Retain retain, Deadline deadline) {
  if (lost_) return Fail(*lost_);
  const std::lock_guard lock(PahoMutex());
  const PahoCall call(connection_.descriptor, deadline);
  early_.clear();
  publishing_ = true;
  int token = 0;
  const int code = PahoPublish(message, retain, token);
  publishing_ = false;
  // At QoS 1 and 2 Paho says "success" of a message that it keeps for the next session: there will
  // be none.
  if (code != MQTTCLIENT_SUCCESS || !Connected()) return Lose(call, code, kClosed);
  if (message.qos == Qos::kAtMostOnce) return 0;
  in_flight_.insert(token);
  for (const auto& [early, reason] : std::exchange(early_, {})) {
    if (early == token) Acknowledge(early, reason);
  }
  return token;
}

void PahoSession::Cork(bool on) const {
  if (connection_.descriptor < 0) return;
  const int value = on ? 1 : 0;
  setsockopt(connection_.descriptor, IPPROTO_TCP, TCP_CORK, &value, sizeof value);
}

std::size_t PahoSession::properties_size() const { return properties_ ? properties_->size() : 0; }

int PahoSession::PahoPublish(const Message& message, Retain retain, int& token) {
  const int size = static_cast<int>(message.payload.size());
  const int qos = static_cast<int>(message.qos);
  if (connection_.server.version == ProtocolVersion::k5) {
    const MQTTResponse response =
        MQTTClient_publish5(connection_.client, message.topic.c_str(), size, message.payload.data(),
                            qos, static_cast<int>(retain), properties_->get(), &token);
    return ReasonCode(response);
  }
  return MQTTClient_publish(connection_.client, message.topic.c_str(), size, message.payload.data(),
                            qos, static_cast<int>(retain), &token);
}

tl::unexpected<Error> PahoSession::NoAnswer(int result) const {
  return Fail(ErrorKind::kBroker, fmt::format("{} did not answer the subscription", Name()),
              MQTTClient_strerror(result));
}

Status PahoSession::Subscribe(std::span<const std::string> filters, Qos qos, Deadline deadline) {
  if (lost_) return Fail(*lost_);
  const std::vector<char*> names = MakeNames(filters);
  std::vector<int> codes(filters.size(), static_cast<int>(qos));
  const std::lock_guard lock(PahoMutex());
  PahoCall call(connection_.descriptor, deadline);
  const auto now = steady_clock::now();
  const auto patience = std::max(deadline - now, steady_clock::duration(0));
  const auto most = std::min<steady_clock::duration>(kSubackPatiences * patience, kSubackTime);
  call.RenewWith(patience, std::max(deadline, now + most));
  if (PahoCall::Supported()) MQTTClient_setCommandTimeout(connection_.client, kNoCommandTimeout);
  subscribed_ = true;
  connection_.input->check().ExpectSuback(filters.size());
  const int result = PahoSubscribe(names, codes);
  if (!Connected()) return Lose(call, result, kClosedBySubscribing);
  if (result != MQTTCLIENT_SUCCESS) {
    return NoAnswer(result);
  }
  const auto refused =
      std::find_if(codes.begin(), codes.end(), [](int code) { return code >= 0x80; });
  if (refused == codes.end()) return {};
  // 3.1.1 has one code for every reason (§3.9.3).
  const bool v5 = connection_.server.version == ProtocolVersion::k5;
  return Fail(
      ErrorKind::kBroker,
      fmt::format("{} refuses the subscription to {}: {}", Name(),
                  base::Printable(filters[static_cast<std::size_t>(refused - codes.begin())]),
                  v5 ? ReasonText(*refused, connection_.input->check().reason())
                     : "this client may not read it"));
}

// Paho's result; into `codes` goes what the broker said to each filter.
int PahoSession::PahoSubscribe(const std::vector<char*>& names, std::vector<int>& codes) {
  const int count = static_cast<int>(names.size());
  if (connection_.server.version != ProtocolVersion::k5) {
    return MQTTClient_subscribeMany(connection_.client, count, names.data(), codes.data());
  }
  MQTTSubscribe_options option = MQTTSubscribe_options_initializer;
  option.retainAsPublished = connection_.retain_as_published ? 1 : 0;
  std::vector<MQTTSubscribe_options> options(names.size(), option);
  const MQTTResponse response = MQTTClient_subscribeMany5(connection_.client, count, names.data(),
                                                          codes.data(), options.data(), nullptr);
  const int first = ReasonCode(response);
  int result = first < 0 ? first : MQTTCLIENT_SUCCESS;
  if (result == MQTTCLIENT_SUCCESS && response.reasonCodeCount != count)
    result = MQTTCLIENT_FAILURE;
  for (std::size_t i = 0; result == MQTTCLIENT_SUCCESS && i < codes.size(); ++i) {
    codes[i] = response.reasonCodes != nullptr ? response.reasonCodes[i] : first;
  }
  MQTTResponse_free(response);
  return result;
}

Status PahoSession::Unsubscribe(std::span<const std::string> filters, Deadline deadline) {
  if (lost_) return Fail(*lost_);
  const std::vector<char*> names = MakeNames(filters);
  const std::lock_guard lock(PahoMutex());
  const PahoCall call(connection_.descriptor, deadline);
  connection_.input->check().ExpectUnsuback(filters.size());
  const int result = PahoUnsubscribe(names);
  if (!Connected()) return Lose(call, result, kClosed);
  if (result == MQTTCLIENT_SUCCESS) return {};
  return NoAnswer(result);
}

// On MQTT 5 the codes say no more than that there was no such subscription (§3.11.3).
int PahoSession::PahoUnsubscribe(const std::vector<char*>& names) {
  const int count = static_cast<int>(names.size());
  if (connection_.server.version != ProtocolVersion::k5) {
    return MQTTClient_unsubscribeMany(connection_.client, count, names.data());
  }
  const MQTTResponse response =
      MQTTClient_unsubscribeMany5(connection_.client, count, names.data(), nullptr);
  const int code = ReasonCode(response);
  MQTTResponse_free(response);
  return code < 0 ? code : MQTTCLIENT_SUCCESS;
}

}  // namespace fleetpub::mqtt
