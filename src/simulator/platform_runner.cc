#include "simulator/platform_runner.h"

#include <algorithm>

#include "mqtt/paho/paho_transport.h"

namespace fleetpub::simulator {
namespace {

using std::chrono::steady_clock;

class PlatformRunner final : public Inhabitant {
 public:
  PlatformRunner(PlatformFleet& fleet, const RunOptions& options)
      : fleet_(fleet), options_(options) {}

  Status Connect() override {
    auto transport = mqtt::ConnectPaho(options_.connect, &may_heal_);
    if (!transport) return Fail(std::move(transport.error()));
    transport_ = *std::move(transport);
    const auto filters = fleet_.Subscriptions();
    auto subscribed = transport_->Subscribe(filters, mqtt::kListeningQos, Patience());
    if (!subscribed) return subscribed;
    fleet_.Start(Now(), out_);
    return Send();
  }

  Status Turn() override {
    const auto until = std::min(fleet_.Due(), steady_clock::now() + kStopPollInterval);
    auto message = transport_->Receive(until);
    if (!message) return Fail(std::move(message.error()));
    if (*message) fleet_.Receive(**message, Now(), out_);
    if (fleet_.Due() <= steady_clock::now()) fleet_.Tick(Now(), out_);
    return Send();
  }

  void Drop() override {
    transport_.reset();
    out_.clear();
  }

  [[nodiscard]] bool MayHeal() const override { return may_heal_; }

  Status Disconnect() override {
    transport_->Disconnect();
    return {};
  }

 private:
  [[nodiscard]] mqtt::Deadline Patience() const {
    return steady_clock::now() + options_.connect.connect_timeout;
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
  bool may_heal_ = false;  // of the last attempt to connect
  std::unique_ptr<mqtt::Transport> transport_;
  std::vector<mqtt::Message> out_;
};

}  // namespace

Status RunPlatforms(PlatformFleet& fleet, const RunOptions& options) {
  PlatformRunner runner(fleet, options);
  return KeepAtBroker(runner, options);
}

}  // namespace fleetpub::simulator
