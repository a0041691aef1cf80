// Where `explain` has from what it tells: a recording, or what a robot says now.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/dialect_resolver.h"
#include "app/environment.h"
#include "app/observer.h"
#include "base/result.h"
#include "base/time.h"
#include "recording/entry.h"
#include "recording/reader.h"
#include "vda5050/model/robot_address.h"

namespace fleetpub::app {

/// Whoever takes what is known, in its order.
struct MessageTakers {
  std::function<void(const recording::Message& message, const std::string& topic_name)> message;
  std::function<void(const recording::Event& event)> event;
};
/// Hands over all that it has of the robot, as often as it is asked.
using MessageSource = std::function<Result<recording::Faults>(const MessageTakers& takers)>;

[[nodiscard]] MessageSource FromRecording(std::filesystem::path file, vda5050::RobotAddress robot,
                                          vda5050::TopicScheme scheme);
[[nodiscard]] MessageSource FromEntries(std::vector<recording::Entry> entries,
                                        vda5050::RobotAddress robot, vda5050::TopicScheme scheme);

/// Listens to a robot, once.
class ListeningPost {
 public:
  explicit ListeningPost(vda5050::RobotAddress robot) : robot_(std::move(robot)) {}

  /// For so long; nothing: until its next state, for kLongestSilence at most, or until it is known that it
  /// is not connected. Errors: ErrorKind::kUsage, kBroker, kLedger.
  [[nodiscard]] Status Listen(const VdaOptions& vda,
                              std::optional<std::chrono::milliseconds> listen,
                              const Environment& environment, Log& log);

  [[nodiscard]] const std::vector<recording::Entry>& heard() const { return heard_; }
  /// Where it listened, as ServerInfo::ListSite.
  [[nodiscard]] const std::vector<std::string>& brokers() const { return brokers_; }
  /// That nobody listened before.
  [[nodiscard]] recording::Event Gap() const;
  /// In the time of what was heard.
  [[nodiscard]] recording::Moment ToMoment(base::WallTime at) const;

 private:
  vda5050::RobotAddress robot_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  recording::Moment began_;
  std::vector<recording::Entry> heard_;
  std::vector<std::string> brokers_;
};

}  // namespace fleetpub::app
