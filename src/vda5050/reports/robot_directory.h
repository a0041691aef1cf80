// The robots that a command may be for, with what each has left at the broker: gathered once,
// before anything is sent. Small, as there may be a hundred thousand: what robots of one make have
// in common is kept once.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "vda5050/model/robot_pattern.h"
#include "vda5050/reports/condition.h"
#include "vda5050/reports/discovery.h"
#include "vda5050/reports/fleet_view.h"
#include "vda5050/rules/preflight.h"

namespace fleetpub::vda5050 {

/// The topic on which a condition's member is looked for: `connection`, `factsheet`, else `state`.
[[nodiscard]] std::string_view FindTopicName(const Condition& condition);

/// What is known of one robot at one place (TopicLevels::Place).
struct RobotPlace {
  std::string place;                   ///< empty: none yet
  std::shared_ptr<const Dialect> own;  ///< null: not known, or none of ours
  std::shared_ptr<const Factsheet> factsheet;
  std::string factsheet_fault;  ///< why it cannot be read
  std::optional<ConnectionMessage> connection;
  std::string topic;         ///< of the message that `own` was told from: `connection`'s, if any
  std::string said_version;  ///< that this message names
  Standing standing;         ///< of what all this was taken from; rank -1: nothing was heard

  bool speaks = false;         ///< a live state came, readable or not, and no leave behind it
  bool state_heard = false;    ///< live: a retained one is the past
  std::string state_fault;     ///< why the last message on its state topic could not be read
  std::string operating_mode;  ///< of its last state; normalised
  /// One for each condition: what is said instead (`paused is false`), or "" when it is satisfied;
  /// nothing until its topic was heard.
  std::vector<std::optional<std::string>> unmet;

  /// It has left a connection message or sent a state.
  [[nodiscard]] bool IsKnown() const { return connection.has_value() || speaks; }
};

/// What is known of one robot: at the place that is to be believed, and of the others.
struct RobotEntry : RobotPlace {
  std::shared_ptr<const Dialect> base;  ///< that it is spoken to in at first
  bool automatic = false;               ///< its own dialect is wanted
  std::vector<RobotPlace> others;       ///< mostly none

  [[nodiscard]] bool WasHeard() const { return standing.rank >= 0; }
  [[nodiscard]] bool IsOnline() const;
  /// ONLINE, or it sends states whatever its connection message says; but not HIBERNATING.
  [[nodiscard]] bool IsAlive() const;
  /// In which it is to be spoken to. Never null.
  [[nodiscard]] const std::shared_ptr<const Dialect>& Spoken() const {
    return automatic && own ? own : base;
  }
  /// Another place at which it may as well live; null: none.
  [[nodiscard]] const RobotPlace* Rival() const;
  [[nodiscard]] KnownRobot Known() const;
};

class RobotDirectory {
 public:
  /// How a robot that a pattern has found is spoken to: base dialect, and whether in its own then.
  /// Nothing: it is not wanted.
  using Admission = std::function<std::optional<std::pair<std::shared_ptr<const Dialect>, bool>>(
      const RobotAddress& robot)>;

  /// `conditions` must outlive the directory. `admit` may be empty: no further robots.
  RobotDirectory(std::span<const Condition> conditions, Admission admit)
      : conditions_(conditions), admit_(std::move(admit)) {}

  /// A robot that is wanted, heard or not.
  void Add(const RobotAddress& robot, std::shared_ptr<const Dialect> base, bool automatic);
  /// A shape of topics under which robots may be found by a pattern.
  void AddScheme(const TopicScheme& scheme);

  /// Takes in a message of one of its robots. That robot; null when it tells nothing.
  const RobotEntry* Deliver(std::string_view topic, std::string_view payload, Origin origin);

  [[nodiscard]] bool Knows(const RobotAddress& robot) const {
    const auto found = robots_.find(robot);
    return found != robots_.end() && found->second.IsKnown();
  }
  [[nodiscard]] const std::map<RobotAddress, RobotEntry>& robots() const { return robots_; }
  [[nodiscard]] std::span<const TopicScheme> schemes() const { return schemes_; }

 private:
  // Who a topic is of; where it tells no manufacturer, of the robots that are known.
  [[nodiscard]] std::optional<TopicLevels> Read(const TopicScheme& scheme,
                                                std::string_view topic) const;
  RobotEntry* Find(const RobotAddress& robot, const TopicScheme& scheme);
  bool Take(RobotEntry& entry, const TopicLevels& levels, std::string_view topic,
            std::string_view payload, Origin origin);
  void TakeState(RobotPlace& place, const Dialect& base, std::string_view topic,
                 const Result<base::JsonDocument>& message, Origin origin);
  bool TakeOther(RobotPlace& place, const Dialect& base, std::string_view topic,
                 const Result<base::JsonDocument>& message);
  void TakeDialect(RobotPlace& place, Discovered found);
  void TestConditions(RobotPlace& place, std::string_view topic_name,
                      const base::JsonValue& message);
  std::shared_ptr<const Dialect> Share(Dialect dialect);
  std::shared_ptr<const Factsheet> Share(Factsheet factsheet);

  std::span<const Condition> conditions_;
  Admission admit_;
  std::map<RobotAddress, RobotEntry> robots_;
  std::vector<TopicScheme> schemes_;  // few, however many robots there are
  std::vector<std::shared_ptr<const Dialect>> dialects_;
  std::vector<std::shared_ptr<const Factsheet>> factsheets_;
};

}  // namespace fleetpub::vda5050
