#include "simulator/platform_runner.h"

#include <algorithm>
#include <thread>

#include "mqtt/paho/paho_transport.h"

namespace fleetpub::simulator {
namespace {

using std::chrono::steady_clock;

class PlatformRunner {
 public:
  PlatformRunner(PlatformFleet& fleet, const RunOptions& options)
      : fleet_(fleet),
        options_(options),
        end_(options.duration ? steady_clock::now() + *options.duration
                              : steady_clock::time_point::max()) {}

  Status Run() {
    bool ready = false;
    while (!Over()) {
      auto lost = Connect();
      if (!lost && !ready) return lost;
      if (lost && !ready) options_.on_ready();
      ready = true;
      while (lost && !Over()) lost = Turn();
      if (lost) break;
      options_.on_lost(lost.error());
      transport_.reset();
      out_.clear();
      std::this_thread::sleep_for(kReconnectInterval);
    }
    if (transport_ != nullptr) transport_->Disconnect();
    return {};
  }

 private:
  [[nodiscard]] bool Over() const { return options_.stopped() || steady_clock::now() >= end_; }
  [[nodiscard]] mqtt::Deadline Patience() const {
    return steady_clock::now() + options_.connect.connect_timeout;
  }

  Status Connect() {
    auto transport = mqtt::ConnectPaho(options_.connect);
    if (!transport) return Fail(std::move(transport.error()));
    transport_ = *std::move(transport);
    const auto filters = fleet_.Subscriptions();
    auto subscribed = transport_->Subscribe(filters, mqtt::kListeningQos, Patience());
    if (!subscribed) return subscribed;
    fleet_.Start(Now(), out_);
    return Send();
  }

  Status Turn() {
    const auto until = std::min({fleet_.Due(), steady_clock::now() + kStopPollInterval, end_});
    auto message = transport_->Receive(until);
    if (!message) return Fail(std::move(message.error()));
    if (*message) fleet_.Receive(**message, Now(), out_);
    if (fleet_.Due() <= steady_clock::now()) fleet_.Tick(Now(), out_);
    return Send();
  }

  Status Send() {
    for (const mqtt::Message& message : out_) {
      if (auto sent = transport_->Publish(message, Patience()); !sent) {
        return Fail(std::move(sent.error()));
      }
    }
    out_.clear();
    return {};
  }

  PlatformFleet& fleet_;
  const RunOptions& options_;
  steady_clock::time_point end_;
  std::unique_ptr<mqtt::Transport> transport_;
  std::vector<mqtt::Message> out_;
};

}  // namespace

Status RunPlatforms(PlatformFleet& fleet, const RunOptions& options) {
  return PlatformRunner(fleet, options).Run();
}

}  // namespace fleetpub::simulator
