// Asks the broker which robots there are and what each has said of itself.
#pragma once

#include <functional>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/dialect_resolver.h"
#include "app/expected_robots.h"
#include "app/targets.h"
#include "base/result.h"
#include "delivery/retained.h"
#include "mqtt/transport.h"
#include "vda5050/reports/robot_directory.h"

namespace fleetpub::app {

using vda5050::ListedRobot;

/// Robots that the patterns have found and an exception spares.
using Excluded = std::set<vda5050::RobotAddress>;

/// A directory with the robots that are named outright, of which nothing is known yet. `targets`,
/// `resolver` and `excluded`, which fills as robots are found, must outlive it. Errors:
/// ErrorKind::kUsage.
[[nodiscard]] Result<vda5050::RobotDirectory> MakeDirectory(const Targets& targets,
                                                            const DialectResolver& resolver,
                                                            Excluded& excluded);

struct DiscoveryOptions {
  bool all = false;         ///< else only those whose dialect is wanted
  bool factsheets = false;  ///< these are wanted too
  /// So are states, of all and from the beginning: until every robot that is there has sent one, or
  /// the targets' time is up. Where nobody is known, until one has; where the broker hands out
  /// nothing, until the end. Robots that are not ONLINE are waited for no longer.
  bool states = false;
  /// Called when states are subscribed to, and before they are waited for; factsheets are there by
  /// then. May be empty. When it fails, the transport may be gone.
  std::function<Status()> ask = {};
  std::function<void()> tick = {};  ///< called about every 100 ms while states are waited for
  delivery::RetainedOptions discover;
  /// Of those that patterns mean. When a filter with wildcards does not bring them, they are asked
  /// for by name.
  std::vector<ExpectedRobot> expected = {};
};

/// Why a broker knows nothing.
inline constexpr std::string_view kNothingRetained =
    "it keeps no retained messages, as it says on connecting";

/// What to subscribe to for messages of these topics, each once: of robots that are named and of those
/// that patterns may find. Errors: ErrorKind::kUsage (a topic template).
[[nodiscard]] Result<std::vector<std::string>> ListFilters(
    const Targets& targets, const vda5050::RobotDirectory& directory,
    std::span<const std::string_view> topic_names);

/// Whether one of them is held against messages of this topic.
[[nodiscard]] bool Need(std::span<const vda5050::Condition> conditions,
                        std::string_view topic_name);

/// Hands a message on to the directory, as its Deliver().
const ListedRobot* Take(const mqtt::Message& message, vda5050::RobotDirectory& directory);

/// Gathers what is retained of the directory's robots and of those that the patterns find; of those
/// that are not ONLINE whether they send states; and, where a condition needs them, the states of all
/// that are there. One round trip for robots that are ONLINE. Errors: ErrorKind::kBroker, kUsage (a
/// topic template).
[[nodiscard]] Status DiscoverRobots(mqtt::Transport& transport, const Targets& targets,
                                    const DiscoveryOptions& options,
                                    vda5050::RobotDirectory& directory, Log& log);

/// Of the robots that the patterns mean, those that are expected at this site.
[[nodiscard]] std::vector<ExpectedRobot> FindExpectedRobots(const Targets& targets,
                                                            const DialectResolver& resolver,
                                                            const Environment& environment,
                                                            const mqtt::ServerInfo& server);

enum class Robots { kAll, kOnline };

/// The names of robots that the broker knows. Nothing when it cannot be asked.
[[nodiscard]] std::vector<vda5050::RobotAddress> ListRobots(
    mqtt::Transport& transport, const vda5050::TopicScheme& scheme,
    const delivery::RetainedOptions& discover, Robots which = Robots::kAll);

/// The same of these, each asked for by its own topics.
[[nodiscard]] std::vector<vda5050::RobotAddress> ListByName(
    mqtt::Transport& transport, const vda5050::TopicScheme& scheme,
    const std::vector<ExpectedRobot>& expected, const delivery::RetainedOptions& discover);

/// For names of which nothing is known, the robot that is ONLINE and may be meant: `did you mean
/// KIT/0001?` For more than twenty names none.
[[nodiscard]] std::map<vda5050::RobotAddress, std::string> FindNearNames(
    std::span<const vda5050::RobotAddress> unknown, mqtt::Transport& transport,
    const vda5050::TopicScheme& scheme, const delivery::RetainedOptions& discover);

}  // namespace fleetpub::app
