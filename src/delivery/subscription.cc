#include "delivery/subscription.h"

#include <algorithm>
#include <utility>

namespace fleetpub::delivery {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;

constexpr seconds kSubscribePatience{10};  // to subscribe
constexpr milliseconds kGlance{100};       // between two looks at whether to go on

}  // namespace

Result<Subscription> Subscription::Open(std::unique_ptr<mqtt::Transport> transport,
                                        std::vector<std::string> filters, ReconnectHooks hooks,
                                        mqtt::Deadline end, mqtt::Qos qos) {
  Subscription subscription(std::move(filters), std::move(hooks), end, qos);
  auto ok = subscription.Subscribe(*transport, mqtt::Deadline::max());
  if (!ok) return Fail(std::move(ok.error()));
  subscription.transport_ = std::move(transport);
  return subscription;
}

Status Subscription::Subscribe(mqtt::Transport& transport, mqtt::Deadline end) const {
  return transport.Subscribe(filters_, qos_,
                             std::min(end, steady_clock::now() + kSubscribePatience));
}

Status Subscription::Read(const MessageCallback& take,
                          const std::function<Result<bool>()>& goes_on) {
  do {
    const auto glance = goes_on ? std::min(end_, steady_clock::now() + kGlance) : end_;
    do {
      const auto message = Next(glance);
      if (!message) break;
      if (take(*message)) return {};
    } while (steady_clock::now() < glance);
    const bool has_ended = transport_ != nullptr && transport_->HasEnded();
    const auto more = goes_on ? goes_on() : Result<bool>(true);
    if (!more) return Fail(more.error());
    if (!*more || has_ended) return {};
  } while (steady_clock::now() < end_);
  return {};
}

std::optional<mqtt::Message> Subscription::Next(mqtt::Deadline deadline) {
  if (transport_ == nullptr) {
    transport_ = reconnector_.TryAgain(
        deadline, end_, [this](mqtt::Transport& transport) { return Subscribe(transport, end_); });
  }
  if (transport_ == nullptr) return std::nullopt;
  auto message = transport_->Receive(deadline);
  if (message) return *std::move(message);
  transport_.reset();
  reconnector_.Lose(std::move(message.error()));
  return std::nullopt;
}

void Subscription::Lend(
    const std::function<void(std::unique_ptr<mqtt::Transport>& transport)>& use) {
  if (transport_ == nullptr) return;
  use(transport_);
  if (transport_ == nullptr) reconnector_.Lose({ErrorKind::kBroker, "the connection was lost"});
}

void Subscription::Disconnect() {
  if (transport_ != nullptr) transport_->Disconnect();
  transport_.reset();
}

}  // namespace fleetpub::delivery
