#include "simulator/runner.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <thread>
#include <utility>

#include "base/text.h"
#include "delivery/reconnect.h"
#include "mqtt/paho/paho_transport.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::simulator {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kBetweenLooks{1000};  // at the connections that only hold a will
// A broker drops what it cannot queue for us (mosquitto: 1,000 messages), so everything that has
// come is read before much of it is answered.
constexpr std::size_t kMostUnanswered = 100'000;
constexpr std::size_t kAnsweredAtOnce = 50;
// A fault: a broker misses nobody for half as long again.
constexpr std::chrono::seconds kLateKeepAlive{600};
// In which what we publish comes back to us.
constexpr milliseconds kEchoPatience{1000};

class Runner final : public Inhabitant {
 public:
  Runner(Fleet& fleet, const RunOptions& options) : fleet_(fleet), options_(options) {}

  Status Connect() override {
    const bool is_first = !has_greeted_;
    may_heal_ = false;
    auto ok = is_first ? CheckPlaces() : Status();
    if (ok && is_first) options_.on_arrival();
    if (ok) ok = Open();
    if (ok) ok = Greet(is_first);
    has_greeted_ = has_greeted_ || ok;
    return ok;
  }

  // Reads what there is, answers some of it.
  Status Turn() override {
    const auto now = steady_clock::now();
    const auto until = unanswered_.empty() ? std::min(fleet_.Due(), now + kStopPollInterval) : now;
    if (auto read = Read(until); !read) return read;
    for (std::size_t i = 0; i < kAnsweredAtOnce && !unanswered_.empty(); ++i) {
      fleet_.Receive(unanswered_.front(), Now(), out_);
      unanswered_.pop_front();
    }
    if (fleet_.Due() <= steady_clock::now()) fleet_.Tick(Now(), out_);
    if (auto sent = Send(); !sent) return sent;
    return LookAfterWills();
  }

  void Drop() override {
    out_.clear();
    topics_.clear();
    unanswered_.clear();
    wills_.clear();
    transport_.reset();
  }

  // The wills are withdrawn last: until OFFLINE is there, they are still true.
  Status Disconnect() override {
    fleet_.End(Now(), out_);
    auto sent = Send();
    if (sent) sent = AwaitAll();
    if (sent) sent = PutBack();
    if (!sent) {
      options_.on_lost(sent.error());
      return {};
    }
    transport_->Disconnect();
    for (const auto& will : wills_) {
      if (will != nullptr) will->Disconnect();
    }
    return {};
  }

  [[nodiscard]] bool MayHeal() const override { return may_heal_; }

  [[nodiscard]] bool IsGone() const override { return fleet_.present() == 0; }

 private:
  [[nodiscard]] mqtt::Deadline Patience() const {
    return steady_clock::now() + options_.connect.connect_timeout;
  }

  // With one robot the will is on the connection that everything goes over.
  Status Open() {
    const bool has_wills = !fleet_.settings().Has(Fault::kNoWill);
    mqtt::ConnectOptions main = options_.connect;
    if (fleet_.settings().Has(Fault::kLateWill)) main.keep_alive = kLateKeepAlive;
    if (fleet_.size() == 1 && has_wills) main.will = fleet_.MakeWill(0, Now());
    auto transport = mqtt::ConnectPahoAsRobot(main, &may_heal_);
    if (!transport) return Fail(std::move(transport.error()));
    transport_ = *std::move(transport);
    if (fleet_.size() == 1 || fleet_.size() > kMostWills || !has_wills) return {};
    for (std::size_t i = 0; i < fleet_.size(); ++i) {
      wills_.emplace_back();
      if (fleet_.IsGone(i)) continue;
      mqtt::ConnectOptions aside = main;
      aside.will = fleet_.MakeWill(i, Now());
      if (!aside.client_id.empty()) aside.client_id += fmt::format("-{}", i + 1);
      auto connection = mqtt::ConnectPaho(aside, &may_heal_);
      if (!connection) return Fail(std::move(connection.error()));
      wills_.back() = *std::move(connection);
    }
    return {};
  }

  // What is retained where the robots will speak, and who is ONLINE where they would be: such a robot
  // would be heard in our voice, and be OFFLINE with us. What is retained comes before the answer to
  // the second request.
  Status CheckPlaces() {
    std::vector<std::string> filters;
    if (fleet_.size() <= kMostPutBack) filters = fleet_.RetainedTopics();
    own_.insert(filters.begin(), filters.end());
    for (const std::string& place : options_.places) {
      if (!own_.contains(place)) filters.push_back(place);  // a broker may not take one twice
    }
    if (filters.empty()) return {};
    // One without a will, which would be told of the robot that is there.
    const auto transport = mqtt::ConnectPaho(options_.connect, &may_heal_);
    if (!transport) return Fail(transport.error());
    auto asked = (*transport)->Subscribe(filters, mqtt::Qos::kAtMostOnce, Patience());
    if (asked) asked = (*transport)->Unsubscribe(filters, Patience());
    while (asked) {
      auto message = (*transport)->Receive(steady_clock::now());
      if (!message) return Fail(message.error());
      if (!*message) break;
      if (!options_.places.empty()) asked = CheckPlace(**message, **transport);
      if (!(*message)->retained || !own_.contains((*message)->topic)) continue;
      std::string topic = (*message)->topic;
      before_.insert_or_assign(std::move(topic), std::move(**message));
    }
    (*transport)->Disconnect();
    return asked;
  }

  static Status CheckPlace(const mqtt::Message& message, const mqtt::Transport& transport) {
    const auto connection = vda5050::ReadConnection(message.payload);
    if (!connection || connection->connection_state != "ONLINE") return {};
    return Fail(ErrorKind::kPreflight,
                fmt::format("nothing was started: a robot is ONLINE at {} of {}, and a virtual one "
                            "would take its place: give another name, or add --force",
                            base::Printable(message.topic), transport.server().broker.ToString()));
  }

  Status Greet(bool is_first) {
    std::vector<std::string> topics = fleet_.Subscriptions();
    const bool may_drop = transport_->server().version == mqtt::ProtocolVersion::k311;
    std::vector<std::string> heard;
    if (is_first && may_drop) {
      heard = fleet_.RetainedTopics();
      heard.resize(std::min({heard.size(), fleet_.size(), kMostWills}));
      topics.insert(topics.end(), heard.begin(), heard.end());
    }
    const auto subscribed = transport_->Subscribe(topics, mqtt::Qos::kAtMostOnce, Patience());
    if (!subscribed) return Fail(subscribed.error());
    fleet_.Start(Now(), out_);
    if (auto sent = Send(); !sent) return sent;
    if (auto taken = AwaitAll(); !taken) return taken;
    return heard.empty() ? Status() : HearOneself(std::move(heard));
  }

  // Over MQTT 3.1.1 a broker has no word for no.
  Status HearOneself(std::vector<std::string> topics) {
    std::set<std::string> missing(topics.begin(), topics.end());
    const auto limit = steady_clock::now() + kEchoPatience;
    while (!missing.empty()) {
      auto message = transport_->Receive(limit);
      if (!message) return Fail(std::move(message.error()));
      if (!*message) break;
      if ((*message)->retained) continue;  // of before
      if (missing.erase((*message)->topic) == 0 && !own_.contains((*message)->topic)) {
        unanswered_.push_back(std::move(**message));
      }
    }
    if (!missing.empty()) options_.on_unheard(*missing.begin());
    return transport_->Unsubscribe(topics, Patience());
  }

  // Everything that has come; waits for the first message.
  Status Read(mqtt::Deadline until) {
    while (unanswered_.size() < kMostUnanswered) {
      auto message = transport_->Receive(until);
      if (!message) return Fail(std::move(message.error()));
      if (!*message) break;
      unanswered_.push_back(std::move(**message));
      until = steady_clock::now();
    }
    return {};
  }

  Status Send() {
    for (const Outgoing& outgoing : out_) {
      const auto sent = outgoing.retain ? transport_->PublishRetained(outgoing.message, Patience())
                                        : transport_->Publish(outgoing.message, Patience());
      if (!sent) {
        out_.clear();
        return Fail(sent.error());
      }
      if (*sent != 0) topics_[*sent] = outgoing.message.topic;
    }
    out_.clear();
    return {};
  }

  // Errors: kBroker, also when the broker refuses something.
  Status AwaitAll() {
    const auto acknowledged = transport_->AwaitAcknowledgements(Patience(), 0);
    if (!acknowledged) return Fail(acknowledged.error());
    const auto topics = std::exchange(topics_, {});
    const auto name = [&](int token) {
      const auto topic = topics.find(token);
      return topic == topics.end() ? "a message" : base::Printable(topic->second);
    };
    for (const mqtt::Acknowledgement& one : *acknowledged) {
      if (!one.Refused()) continue;
      return Fail(ErrorKind::kBroker,
                  fmt::format("{} refuses {}: {}. look at its access list",
                              transport_->server().broker.ToString(), name(one.token), one.reason));
    }
    if (transport_->in_flight() == 0) return {};
    return Fail(ErrorKind::kBroker, fmt::format("{} did not acknowledge what the robots say: look "
                                                "at its access list",
                                                transport_->server().broker.ToString()));
  }

  // Their pings; and a robot that has shut down leaves no will.
  Status LookAfterWills() {
    const auto now = steady_clock::now();
    if (wills_.empty() || now < next_look_) return {};
    next_look_ = now + kBetweenLooks;
    for (std::size_t i = 0; i < wills_.size(); ++i) {
      if (wills_[i] == nullptr) continue;
      if (fleet_.IsGone(i)) {
        wills_[i]->Disconnect();
        wills_[i].reset();
      } else if (auto looked = wills_[i]->Receive(now); !looked) {
        return Fail(std::move(looked.error()));
      }
    }
    return {};
  }

  // What was retained before, or nothing.
  Status PutBack() {
    for (const std::string& topic : own_) {
      const auto before = before_.find(topic);
      mqtt::Message message{.topic = topic, .payload = "", .qos = mqtt::Qos::kAtLeastOnce};
      if (before != before_.end()) message.payload = before->second.payload;
      out_.push_back({std::move(message), true});
    }
    auto sent = Send();
    return sent ? AwaitAll() : sent;
  }

  Fleet& fleet_;
  const RunOptions& options_;
  bool has_greeted_ = false;
  bool may_heal_ = false;  // of the last attempt to connect  // whether its places are free
  std::unique_ptr<mqtt::RobotTransport> transport_;
  std::vector<std::unique_ptr<mqtt::Transport>> wills_;
  steady_clock::time_point next_look_;
  std::deque<mqtt::Message> unanswered_;
  std::vector<Outgoing> out_;
  std::map<int, std::string> topics_;            // by token, of what is not acknowledged
  std::set<std::string> own_;                    // on which the robots leave retained messages
  std::map<std::string, mqtt::Message> before_;  // what was retained there
};

}  // namespace

Status KeepAtBroker(Inhabitant& inhabitant, const RunOptions& options) {
  const auto start = steady_clock::now();
  const auto is_over = [&] {
    return options.stopped() || inhabitant.IsGone() ||
           (options.duration && steady_clock::now() >= start + *options.duration);
  };
  delivery::ReconnectSchedule schedule;
  bool is_ready = false;
  bool is_told = false;  // that the connection is lost
  while (!is_over()) {
    auto ok = inhabitant.Connect();
    const bool in_time = steady_clock::now() < start + options.connect.connect_timeout;
    if (!ok && !is_ready && !(in_time && inhabitant.MayHeal())) return ok;
    const bool was_connected = ok.has_value();
    if (ok) {
      schedule.Connected(steady_clock::now());
      if (!std::exchange(is_ready, true)) options.on_ready();
      is_told = false;
      while (ok && !is_over()) ok = inhabitant.Turn();
      if (ok) return inhabitant.Disconnect();
    }
    if (!std::exchange(is_told, true)) options.on_lost(ok.error());
    inhabitant.Drop();
    if (was_connected || !is_ready) {
      schedule.Lost(steady_clock::now());
    } else {
      schedule.Failed(steady_clock::now());
    }
    while (!is_over() && steady_clock::now() < schedule.next()) {
      std::this_thread::sleep_for(kStopPollInterval);
    }
  }
  return {};
}

Status Run(Fleet& fleet, const RunOptions& options) {
  Runner runner(fleet, options);
  return KeepAtBroker(runner, options);
}

}  // namespace fleetpub::simulator
