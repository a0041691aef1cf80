// Which robots there are, with what each has left at the broker and says of itself. Small, as there
// may be a hundred thousand: what robots of one make have in common is kept once, states only when
// somebody asks for them.
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
#include "vda5050/reports/live_state.h"
#include "vda5050/rules/preflight.h"

namespace fleetpub::vda5050 {

/// The topic on which a condition's member is looked for: `connection`, `factsheet`, else `state`.
[[nodiscard]] std::string_view FindTopicName(const Condition& condition);

/// Whether the broker had stored a message before we subscribed.
enum class Origin { kLive, kRetained };

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
  std::shared_ptr<const LiveState> state;   ///< the last live one, where states are kept; or null
  bool has_begun_anew = false;              ///< its next state may count and date anew
  std::optional<base::WallTime> last_said;  ///< the newest time in a header, by its own clock
  /// One for each condition: what is said instead (`paused is false`), or "" when it is satisfied;
  /// nothing until its topic was heard.
  std::vector<std::optional<std::string>> unmet;

  /// It has left a connection message or sent a state.
  [[nodiscard]] bool IsKnown() const { return connection.has_value() || speaks; }
  /// Something of it told more than that there is a topic.
  [[nodiscard]] bool WasSeen() const {
    return connection.has_value() || state_heard || !said_version.empty();
  }
  /// A live state came, be it one that cannot be read.
  [[nodiscard]] bool HasSpoken() const { return state_heard || !state_fault.empty(); }
};

/// What is known of one robot: at the place that is to be believed, and of the others.
struct RobotEntry : RobotPlace {
  std::shared_ptr<const Dialect> base;  ///< that it is spoken to in at first
  bool automatic = false;               ///< its own dialect is wanted
  std::vector<RobotPlace> others;       ///< mostly none

  [[nodiscard]] bool WasHeard() const { return standing.rank >= 0; }
  [[nodiscard]] bool IsOnline() const;
  /// Its levels as its topics have them, `uagv` and `v2`; "" when the template has none.
  [[nodiscard]] std::string_view InterfaceName() const;
  [[nodiscard]] std::string_view TopicLevel() const;
  /// Another place at which a robot of this name is ONLINE or speaks; "": none.
  [[nodiscard]] std::string_view AlsoAt() const;
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

using ListedRobot = std::map<RobotAddress, RobotEntry>::value_type;

class RobotDirectory {
 public:
  /// How a robot that a pattern has found is spoken to: base dialect, and whether in its own then.
  /// Nothing: it is not wanted.
  using Admission = std::function<std::optional<std::pair<std::shared_ptr<const Dialect>, bool>>(
      const RobotAddress& robot)>;

  /// `conditions` must outlive the directory. `admit` may be empty: no further robots.
  RobotDirectory(std::span<const Condition> conditions, Admission admit)
      : conditions_(conditions), admit_(std::move(admit)) {}

  /// From now on the last state of each robot is kept, as StateMemory does.
  void KeepStates() { states_.emplace(); }
  /// Of these, those that are abridged.
  [[nodiscard]] std::size_t abridged() const { return states_ ? states_->abridged() : 0; }

  /// A robot that is wanted, heard or not.
  void Add(const RobotAddress& robot, std::shared_ptr<const Dialect> base, bool automatic);
  /// A shape of topics under which robots may be found by a pattern.
  void AddScheme(const TopicScheme& scheme);

  /// Takes in a message of one of its robots. That robot; null when it tells nothing. A robot with
  /// several places is seen where it speaks, else where its standing is greatest. A retained state is
  /// the past: it tells that there is a robot, not how it is. An empty connection message takes the
  /// last one back; a state that is older than the last one is passed over.
  const ListedRobot* Deliver(std::string_view topic, std::string_view payload, Origin origin);

  [[nodiscard]] bool Knows(const RobotAddress& robot) const {
    const auto found = robots_.find(robot);
    return found != robots_.end() && found->second.IsKnown();
  }
  [[nodiscard]] const std::map<RobotAddress, RobotEntry>& robots() const { return robots_; }
  /// Those of whom something was seen.
  [[nodiscard]] std::size_t CountSeen() const;
  [[nodiscard]] std::span<const TopicScheme> schemes() const { return schemes_; }

 private:
  // Who a topic is of; where it tells no manufacturer, of the robots that are known.
  [[nodiscard]] std::optional<TopicLevels> Read(const TopicScheme& scheme,
                                                std::string_view topic) const;
  ListedRobot* Find(const RobotAddress& robot, const TopicScheme& scheme);
  bool Take(RobotEntry& entry, const TopicLevels& levels, std::string_view topic,
            std::string_view payload, Origin origin);
  static bool TakeBack(RobotEntry& entry, const TopicLevels& levels);
  bool TakeState(RobotPlace& place, const Dialect& base, std::string_view topic,
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
  std::optional<StateMemory> states_;
  std::vector<TopicScheme> schemes_;  // few, however many robots there are
  std::vector<std::shared_ptr<const Dialect>> dialects_;
  std::vector<std::shared_ptr<const Factsheet>> factsheets_;
};

/// How much somebody has to look after a robot, by what it says last: 0, not at all, to 8, an
/// emergency stop. A warning, and a robot that is not at work (another mode than AUTOMATIC, paused),
/// weigh less than 3.
[[nodiscard]] int WeighTrouble(const RobotEntry& entry);
/// It weighs 3 at least: an emergency stop or a violated field, an error that is more than a warning,
/// CONNECTION_BROKEN while it sends no states, or a message that cannot be read.
[[nodiscard]] bool HasProblem(const RobotEntry& entry);

}  // namespace fleetpub::vda5050
