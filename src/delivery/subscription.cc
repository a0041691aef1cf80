#include "delivery/subscription.h"

#include <algorithm>
#include <thread>
#include <utility>

namespace fleetpub::delivery {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;

constexpr seconds kPatience{10};  // to connect, and again to subscribe
constexpr milliseconds kBetweenTries{300};

}  // namespace

Subscription::Subscription(std::vector<std::string> filters, ConnectHook connect, ListenHooks hooks,
                           mqtt::Deadline end)
    : filters_(std::move(filters)),
      connect_(std::move(connect)),
      hooks_(std::move(hooks)),
      end_(end) {}

Result<std::unique_ptr<Subscription>> Subscription::Open(std::vector<std::string> filters,
                                                         ConnectHook connect, ListenHooks hooks,
                                                         mqtt::Deadline end) {
  std::unique_ptr<Subscription> subscription(
      new Subscription(std::move(filters), std::move(connect), std::move(hooks), end));
  if (auto ok = subscription->Connect(); !ok) return Fail(std::move(ok.error()));
  return subscription;
}

std::optional<mqtt::Message> Subscription::Next(mqtt::Deadline deadline) {
  if (!connected()) TryAgain(deadline);
  if (!connected()) return std::nullopt;
  auto message = transport_->Receive(deadline);
  if (message) return *std::move(message);
  transport_.reset();
  next_try_ = steady_clock::now() + kBetweenTries;
  if (hooks_.lost) hooks_.lost(message.error());
  return std::nullopt;
}

void Subscription::TryAgain(mqtt::Deadline deadline) {
  std::this_thread::sleep_until(std::min(deadline, next_try_));
  const auto now = steady_clock::now();
  if (now < next_try_ || now >= end_) return;
  if (Connect()) {
    if (hooks_.again) hooks_.again();
  }
  next_try_ = steady_clock::now() + kBetweenTries;
}

Status Subscription::Connect() {
  auto transport = connect_(std::min(end_, steady_clock::now() + kPatience));
  if (!transport) return Fail(std::move(transport.error()));
  auto subscribed = (*transport)
                        ->Subscribe(filters_, mqtt::kListeningQos,
                                    std::min(end_, steady_clock::now() + kPatience));
  if (!subscribed) return subscribed;
  transport_ = *std::move(transport);
  return {};
}

void Subscription::Disconnect() {
  if (connected()) transport_->Disconnect();
  transport_.reset();
}

}  // namespace fleetpub::delivery
