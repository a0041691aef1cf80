#include "delivery/reconnect.h"

#include <algorithm>
#include <thread>
#include <utility>

namespace fleetpub::delivery {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds kShortestPause{500};
constexpr milliseconds kLongestReconnectPause{5000};
constexpr seconds kLasting{10};
constexpr seconds kPatience{10};  // with one attempt

}  // namespace

void ReconnectSchedule::Lost(Clock::time_point now) {
  pause_ = now - connected_at_ < kLasting
               ? std::clamp(pause_ * 2, kShortestPause, kLongestReconnectPause)
               : kShortestPause;
  next_ = now + pause_;
}

void Reconnector::Lose(Error error) {
  schedule_.Lost(ReconnectSchedule::Clock::now());
  lost_ = std::move(error);
  is_told_ = false;
}

std::unique_ptr<mqtt::Transport> Reconnector::TryAgain(
    mqtt::Deadline deadline, mqtt::Deadline end,
    const std::function<Status(mqtt::Transport&)>& prepare) {
  using Clock = ReconnectSchedule::Clock;
  std::this_thread::sleep_until(std::min(deadline, schedule_.next()));
  const auto now = Clock::now();
  if (now < schedule_.next() || now >= end) return nullptr;
  if (hooks_.lost && !std::exchange(is_told_, true)) hooks_.lost(*lost_);
  auto transport = hooks_.open(std::min(now + kPatience, end));
  if (!transport || !prepare(**transport)) {
    schedule_.Failed(Clock::now());
    return nullptr;
  }
  schedule_.Connected(Clock::now());
  lost_.reset();
  if (hooks_.again) hooks_.again();
  return *std::move(transport);
}

}  // namespace fleetpub::delivery
