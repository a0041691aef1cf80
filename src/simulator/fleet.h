// Many virtual robots: who a message is for, and whose turn it is. No network, no clock.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <queue>
#include <random>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "base/result.h"
#include "mqtt/transport.h"
#include "schema/schema.h"
#include "simulator/inspection.h"
#include "simulator/settings.h"
#include "simulator/virtual_robot.h"
#include "vda5050/model/robot_address.h"

namespace fleetpub::simulator {

/// A message for the broker.
struct Outgoing {
  mqtt::Message message;
  bool retain = false;
};

/// Belongs to one thread.
class Fleet {
 public:
  /// `robot` is `manufacturer/serialNumber`.
  using EventCallback = std::function<void(std::string_view robot, const Event& event)>;

  /// `registry` outlives the fleet. Errors: ErrorKind::kUsage (topics).
  [[nodiscard]] static Result<std::unique_ptr<Fleet>> Make(
      Settings settings, const std::vector<vda5050::RobotAddress>& robots,
      schema::Registry& registry, EventCallback on_event);
  Fleet(const Fleet&) = delete;
  Fleet& operator=(const Fleet&) = delete;

  [[nodiscard]] std::size_t size() const { return members_.size(); }
  [[nodiscard]] std::size_t present() const { return present_; }
  /// Whether the robot with this index has shut down.
  [[nodiscard]] bool IsGone(std::size_t index) const { return members_[index].robot.gone(); }
  [[nodiscard]] const Settings& settings() const { return settings_; }

  /// The exact topics that the robots listen to.
  [[nodiscard]] std::vector<std::string> Subscriptions() const;
  /// The exact topics on which they leave retained messages: `connection` of each, then `factsheet`.
  [[nodiscard]] std::vector<std::string> RetainedTopics() const;
  [[nodiscard]] mqtt::Will MakeWill(std::size_t index, const Moment& now);

  void Start(const Moment& now, std::vector<Outgoing>& out);
  void Receive(const mqtt::Message& message, const Moment& now, std::vector<Outgoing>& out);
  void Tick(const Moment& now, std::vector<Outgoing>& out);
  void End(const Moment& now, std::vector<Outgoing>& out);
  /// When Tick has something to do.
  [[nodiscard]] std::chrono::steady_clock::time_point Due();

 private:
  struct Member {
    vda5050::RobotAddress address;
    VirtualRobot robot;
  };
  struct Turn {
    std::chrono::steady_clock::time_point due;
    std::size_t index;
    friend bool operator>(const Turn& a, const Turn& b) { return a.due > b.due; }
  };
  struct Destination {
    std::size_t index;
    std::string_view topic;  ///< the last level
  };

  Fleet(Settings settings, schema::Registry& registry, EventCallback on_event);
  [[nodiscard]] Status Add(const vda5050::RobotAddress& address);
  /// Hands on what a robot said, and notes when its next turn is.
  void After(std::size_t index, Utterances& said, std::vector<Outgoing>& out);
  [[nodiscard]] std::string MakeTopic(const Member& member, std::string_view topic) const;

  Settings settings_;
  std::string factsheet_;
  Inspector inspector_;
  EventCallback on_event_;
  std::vector<Member> members_;
  std::size_t present_ = 0;
  std::unordered_map<std::string, Destination> destinations_;
  // A robot may stand in it several times; a turn that came too early does nothing.
  std::priority_queue<Turn, std::vector<Turn>, std::greater<>> turns_;
  std::vector<std::chrono::steady_clock::time_point> noted_;  // each robot's earliest noted turn
  std::vector<bool> counted_as_gone_;
  std::mt19937 random_;
};

/// `KIT/0001` and its followers `KIT/0002` …: the number at the end of the serial number counts up
/// and keeps its width. Errors: ErrorKind::kUsage when there is no number to count.
[[nodiscard]] Result<std::vector<vda5050::RobotAddress>> CountUp(const vda5050::RobotAddress& first,
                                                                 std::size_t count);

}  // namespace fleetpub::simulator
