// One robot that is listened to and spoken to over the same connection, however often it is lost.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/environment.h"
#include "app/follow_order.h"
#include "app/observer.h"
#include "app/robot_discovery.h"
#include "base/result.h"
#include "delivery/subscription.h"
#include "message/command.h"
#include "vda5050/reports/robot_directory.h"

namespace fleetpub::app {

/// What is heard of it.
struct RobotTopics {
  std::vector<std::string_view> names = {"state", "connection"};
  mqtt::Qos qos = mqtt::kListeningQos;
};

class RobotListener {
 public:
  /// All but the directory and the topics outlive it.
  RobotListener(const FollowRequest& request, const Environment& environment, Observer& observer,
                vda5050::RobotDirectory directory, RobotTopics topics)
      : request_(request),
        environment_(environment),
        observer_(observer),
        directory_(std::move(directory)),
        topics_(std::move(topics)) {}

  /// Finds the robot, subscribes, and asks for its state where the request says so. Errors:
  /// ErrorKind::kBroker, kUsage; kPreflight: the robot is unknown or not there.
  Status Connect();
  void Ask();
  /// Validates nothing. Errors: ErrorKind::kBroker, kLedger.
  Status Send(const message::Command& command, mqtt::Qos qos);

  [[nodiscard]] const vda5050::RobotAddress& address() const { return robot_->first; }
  [[nodiscard]] const vda5050::Dialect& dialect() const { return *robot_->second.Spoken(); }
  [[nodiscard]] const ListedRobot& robot() const { return *robot_; }
  [[nodiscard]] std::string name() const;
  [[nodiscard]] const std::string& state_topic() const { return filters_.front(); }
  [[nodiscard]] const std::vector<std::string>& filters() const { return filters_; }
  [[nodiscard]] const mqtt::ServerInfo& server() const { return server_; }
  [[nodiscard]] std::chrono::steady_clock::time_point end() const { return end_; }
  [[nodiscard]] delivery::Subscription& subscription() { return *subscription_; }

 private:
  void Lend(const std::function<void(Link& link)>& use);
  [[nodiscard]] Status CheckPresence() const;

  const FollowRequest& request_;
  const Environment& environment_;
  Observer& observer_;
  vda5050::RobotDirectory directory_;
  RobotTopics topics_;
  const ListedRobot* robot_ = nullptr;
  Connection connection_;
  mqtt::ServerInfo server_;
  std::vector<std::string> filters_;  // one for each topic
  std::chrono::steady_clock::time_point end_;
  std::optional<delivery::Subscription> subscription_;
};

/// Hands a connected listener to somebody. Errors: as Connect; those of `use`.
template <class Use>
auto WithListener(const FollowRequest& request, const Environment& environment, Observer& observer,
                  RobotTopics topics, Use use) -> decltype(use(std::declval<RobotListener&>())) {
  Excluded excluded;
  auto directory = MakeDirectory(request.targets, request.resolver, excluded);
  if (!directory) return Fail(std::move(directory.error()));
  RobotListener listener(request, environment, observer, *std::move(directory), std::move(topics));
  if (auto ok = listener.Connect(); !ok) return Fail(std::move(ok.error()));
  return use(listener);
}

}  // namespace fleetpub::app
