// A virtual robot in place of a broker, in virtual time: what is waited for takes no time.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "app/conformance/run.h"
#include "simulator/fleet.h"

namespace fleetpub::testing {

class VirtualWire : public app::conformance::Wire {
 public:
  VirtualWire(const simulator::Settings& settings, const vda5050::RobotAddress& robot,
              schema::Registry& registry)
      : settings_(settings) {
    fleet_ = *simulator::Fleet::Make(settings, {robot}, registry, [](auto, const auto&) {});
    std::vector<simulator::Outgoing> out;
    fleet_->Start(Moment(), out);
    // The broker keeps what is retained; nobody has heard the rest.
    for (auto& one : out) {
      if (!one.retain) continue;
      one.message.retained = true;
      Arrive(std::move(one.message));
    }
    now_ += std::chrono::milliseconds(10);
  }

  /// This share of the states is lost on the way.
  void Lose(double share, unsigned seed) {
    lose_ = share;
    random_.seed(seed);
  }
  /// What becomes of each state on the way.
  void Alter(std::function<std::string(std::string state)> alter) { alter_ = std::move(alter); }

  Status Send(const message::Command& command) override {
    std::vector<simulator::Outgoing> out;
    fleet_->Receive(
        {.topic = command.topic, .payload = command.payload.Render(++header_id_, WallNow())},
        Moment(), out);
    Say(out);
    return {};
  }

  std::optional<std::pair<std::string, mqtt::Message>> Next(
      app::conformance::TimePoint until) override {
    while (arrived_.empty() && now_ < until) {
      now_ = std::max(now_, std::min(until, fleet_->Due()));
      std::vector<simulator::Outgoing> out;
      fleet_->Tick(Moment(), out);
      Say(out);
      if (out.empty() && fleet_->Due() <= now_) now_ += std::chrono::milliseconds(1);
    }
    if (arrived_.empty()) return std::nullopt;
    mqtt::Message message = std::move(arrived_.front());
    arrived_.pop_front();
    const auto slash = message.topic.rfind('/');
    return std::pair(message.topic.substr(slash + 1), std::move(message));
  }

  app::conformance::TimePoint Now() const override { return now_; }
  base::WallTime WallNow() const override { return Moment().wall; }

 private:
  simulator::Moment Moment() const {
    return {now_,
            start_ + std::chrono::duration_cast<base::WallTime::duration>(now_.time_since_epoch())};
  }
  void Say(std::vector<simulator::Outgoing>& out) {
    for (auto& one : out) {
      const bool is_state = one.message.topic.ends_with("/state");
      if (is_state && std::uniform_real_distribution<>(0, 1)(random_) < lose_) continue;
      mqtt::Message message = one.message;
      message.retained = false;
      if (is_state && alter_) message.payload = alter_(std::move(message.payload));
      Arrive(std::move(message));
    }
  }
  void Arrive(mqtt::Message message) { arrived_.push_back(std::move(message)); }

  simulator::Settings settings_;
  std::unique_ptr<simulator::Fleet> fleet_;
  app::conformance::TimePoint now_{std::chrono::hours(1)};
  base::WallTime start_ = base::WallTime(std::chrono::hours(24 * 365 * 50));
  std::deque<mqtt::Message> arrived_;
  std::uint32_t header_id_ = 0;
  double lose_ = 0;
  std::function<std::string(std::string)> alter_;
  std::mt19937 random_;
};

}  // namespace fleetpub::testing
