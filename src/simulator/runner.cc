#include "simulator/runner.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <memory>
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

class Runner final : public Inhabitant {
 public:
  Runner(Fleet& fleet, const RunOptions& options) : fleet_(fleet), options_(options) {}

  Status Connect() override {
    auto ok = std::exchange(has_looked_, true) ? Status() : CheckPlaces();
    if (ok) ok = Open();
    if (ok) ok = Greet();
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
    unanswered_.clear();
    wills_.clear();
    transport_.reset();
  }

  // The wills are withdrawn last: until OFFLINE is there, they are still true.
  Status Disconnect() override {
    fleet_.End(Now(), out_);
    auto sent = Send();
    if (sent) sent = AwaitAll();
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

  [[nodiscard]] bool IsGone() const override { return fleet_.present() == 0; }

 private:
  [[nodiscard]] mqtt::Deadline Patience() const {
    return steady_clock::now() + options_.connect.connect_timeout;
  }

  // With one robot the will is on the connection that everything goes over.
  Status Open() {
    mqtt::ConnectOptions main = options_.connect;
    if (fleet_.size() == 1) main.will = fleet_.MakeWill(0, Now());
    auto transport = mqtt::ConnectPahoAsRobot(main);
    if (!transport) return Fail(std::move(transport.error()));
    transport_ = *std::move(transport);
    if (fleet_.size() == 1 || fleet_.size() > kMostWills) return {};
    for (std::size_t i = 0; i < fleet_.size(); ++i) {
      wills_.emplace_back();
      if (fleet_.IsGone(i)) continue;
      mqtt::ConnectOptions aside = options_.connect;
      aside.will = fleet_.MakeWill(i, Now());
      if (!aside.client_id.empty()) aside.client_id += fmt::format("-{}", i + 1);
      auto connection = mqtt::ConnectPaho(aside);
      if (!connection) return Fail(std::move(connection.error()));
      wills_.back() = *std::move(connection);
    }
    return {};
  }

  // A robot that is ONLINE would be heard in our voice, and be OFFLINE with us. What is retained
  // comes before the answer to the second request.
  Status CheckPlaces() {
    if (options_.places.empty()) return {};
    // One without a will, which would be told of the robot that is there.
    const auto transport = mqtt::ConnectPaho(options_.connect);
    if (!transport) return Fail(transport.error());
    auto asked = (*transport)->Subscribe(options_.places, mqtt::Qos::kAtMostOnce, Patience());
    if (asked) asked = (*transport)->Unsubscribe(options_.places, Patience());
    while (asked) {
      const auto message = (*transport)->Receive(steady_clock::now());
      if (!message) return Fail(message.error());
      if (!*message) break;
      const auto connection = vda5050::ReadConnection((*message)->payload);
      if (!connection || connection->connection_state != "ONLINE") continue;
      asked =
          Fail(ErrorKind::kPreflight,
               fmt::format(
                   "nothing was started: a robot is ONLINE at {} of {}, and a virtual one would "
                   "take its place. try: another name, or --force",
                   base::Printable((*message)->topic), (*transport)->server().broker.ToString()));
    }
    (*transport)->Disconnect();
    return asked;
  }

  Status Greet() {
    const auto subscribed =
        transport_->Subscribe(fleet_.Subscriptions(), mqtt::Qos::kAtMostOnce, Patience());
    if (!subscribed) return Fail(subscribed.error());
    fleet_.Start(Now(), out_);
    if (auto sent = Send(); !sent) return sent;
    return AwaitAll();
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
    }
    out_.clear();
    return {};
  }

  Status AwaitAll() {
    const auto acknowledged = transport_->AwaitAcknowledgements(Patience(), 0);
    if (!acknowledged) return Fail(acknowledged.error());
    return {};
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

  Fleet& fleet_;
  const RunOptions& options_;
  bool has_looked_ = false;  // whether its places are free
  std::unique_ptr<mqtt::RobotTransport> transport_;
  std::vector<std::unique_ptr<mqtt::Transport>> wills_;
  steady_clock::time_point next_look_;
  std::deque<mqtt::Message> unanswered_;
  std::vector<Outgoing> out_;
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
    if (!ok && !is_ready) return ok;
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
    was_connected ? schedule.Lost(steady_clock::now()) : schedule.Failed(steady_clock::now());
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
