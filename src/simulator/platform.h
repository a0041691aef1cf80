// Virtual platforms of the SoAR backbone: they acknowledge what they are told, step by step, and
// say where they are. No network, no clock.
#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "base/result.h"
#include "mqtt/transport.h"
#include "schema/schema.h"
#include "simulator/virtual_robot.h"
#include "soar/destination.h"
#include "soar/message_type.h"

namespace fleetpub::simulator {

struct PlatformSettings {
  soar::Prefix prefix;
  std::chrono::milliseconds delay{0};  ///< between one level of acknowledgement and the next
  std::optional<soar::Level> stop_at;  ///< goes no further than this
  bool silent = false;                 ///< never says anything
  std::chrono::milliseconds status_interval{30'000};
};

/// One platform with the control system behind which it stands. A short name (`autonomy_engine`)
/// acknowledges to whoever sent the message and has no status.
class VirtualPlatform {
 public:
  using EventCallback = std::function<void(const Event&)>;

  /// What platforms of one fleet share; all of it outlives them.
  struct Shared {
    const PlatformSettings& settings;
    const schema::Schema& schema;
  };

  /// `number` is its platform_ID until a plan calls it otherwise.
  VirtualPlatform(const Shared& shared, soar::Destination self, int number);

  /// Connected, or connected again: its status.
  void Start(const Moment& now, std::vector<mqtt::Message>& out);
  void Receive(const mqtt::Message& message, const Moment& now, std::vector<mqtt::Message>& out,
               const EventCallback& on_event);
  /// To be called at Due() or later.
  void Tick(const Moment& now, std::vector<mqtt::Message>& out);
  [[nodiscard]] std::chrono::steady_clock::time_point Due() const;

  [[nodiscard]] const soar::Destination& self() const { return self_; }

 private:
  struct Place {
    double latitude = 0;
    double longitude = 0;
  };
  // A message on its way through the levels.
  struct Task {
    std::string message_id;
    soar::Destination reply_to;
    soar::Level next = soar::Level::kC2Received;
    std::chrono::steady_clock::time_point due;
    std::string plan_id;      // JSON; "": no mission plan
    std::string platform_id;  // JSON
    std::optional<Place> last;
  };

  [[nodiscard]] Result<Task> ReadTask(const base::JsonValue& message) const;
  [[nodiscard]] bool Remember(const std::string& message_id);
  /// False when the task has gone as far as it goes.
  bool Advance(Task& task, const Moment& now, std::vector<mqtt::Message>& out);
  void SayStatus(const Moment& now, std::vector<mqtt::Message>& out);
  void Say(soar::MessageType type, const soar::Destination& destination, std::string_view payload,
           const Moment& now, std::vector<mqtt::Message>& out) const;

  Shared shared_;
  soar::Destination self_;
  std::string platform_id_;
  std::string plan_id_;
  std::string state_ = "IDLE";
  Place place_;
  std::vector<Task> tasks_;
  std::unordered_set<std::string> known_;
  std::deque<std::string> known_in_order_;
  std::chrono::steady_clock::time_point next_status_;
};

/// Many of them: who a message is for. Belongs to one thread.
class PlatformFleet {
 public:
  /// `platform` is its name: `soar.noc.autosub.ah1`.
  using EventCallback = std::function<void(std::string_view platform, const Event& event)>;

  /// `registry` outlives the fleet. Errors: ErrorKind::kUsage (destinations), or the schema.
  [[nodiscard]] static Result<std::unique_ptr<PlatformFleet>> Make(
      PlatformSettings settings, const std::vector<std::string>& destinations,
      schema::Registry& registry, EventCallback on_event);
  PlatformFleet(const PlatformFleet&) = delete;
  PlatformFleet& operator=(const PlatformFleet&) = delete;

  [[nodiscard]] std::size_t size() const { return platforms_.size(); }
  [[nodiscard]] std::vector<std::string> Subscriptions() const;
  void Start(const Moment& now, std::vector<mqtt::Message>& out);
  void Receive(const mqtt::Message& message, const Moment& now, std::vector<mqtt::Message>& out);
  void Tick(const Moment& now, std::vector<mqtt::Message>& out);
  [[nodiscard]] std::chrono::steady_clock::time_point Due() const;

 private:
  PlatformFleet(PlatformSettings settings, EventCallback on_event)
      : settings_(std::move(settings)), on_event_(std::move(on_event)) {}

  PlatformSettings settings_;
  EventCallback on_event_;
  std::vector<VirtualPlatform> platforms_;
  std::map<std::string, std::size_t, std::less<>> filters_;  // by topic filter
};

}  // namespace fleetpub::simulator
