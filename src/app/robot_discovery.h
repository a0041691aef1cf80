// Asks the broker which robots there are and what each has said of itself, and chooses those that a
// command is for.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "app/dialect_resolver.h"
#include "app/expected_robots.h"
#include "app/targets.h"
#include "base/result.h"
#include "delivery/retained.h"
#include "mqtt/transport.h"
#include "vda5050/reports/robot_directory.h"

namespace fleetpub::app {

using ListedRobot = std::map<vda5050::RobotAddress, vda5050::RobotEntry>::value_type;

/// Robots of a directory. Valid as long as that.
struct Chosen {
  std::vector<const ListedRobot*>
      robots;  ///< named ones in their order, then the found ones by name
  std::vector<const ListedRobot*> unheard;  ///< whether --where is true of them is not known
};

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
  delivery::RetainedOptions discover;
  /// Of those that patterns mean. When a filter with wildcards does not bring them, they are asked
  /// for by name.
  std::vector<ExpectedRobot> expected = {};
};

/// Why a broker knows nothing.
inline constexpr std::string_view kNothingRetained =
    "it keeps no retained messages, as it says on connecting";

/// Gathers what is retained of the directory's robots and of those that the patterns find; of those
/// that are not ONLINE whether they send states; and, where a condition needs them, the states of all
/// that are there. One round trip for robots that are ONLINE. Errors: ErrorKind::kBroker, kUsage (a
/// topic template).
[[nodiscard]] Status DiscoverRobots(mqtt::Transport& transport, const Targets& targets,
                                    const DiscoveryOptions& options,
                                    vda5050::RobotDirectory& directory, Log& log);

/// The first exception that spares nobody of those that the patterns have found: a misspelt one
/// would command whom it should spare. One that the configuration names may just be away.
[[nodiscard]] std::optional<std::string> UnusedExclusion(const Targets& targets,
                                                         const Excluded& excluded,
                                                         const config::Config& config);

/// Of the robots that the patterns mean, those that are expected at this broker.
[[nodiscard]] std::vector<ExpectedRobot> FindExpectedRobots(const Targets& targets,
                                                            const DialectResolver& resolver,
                                                            const Environment& environment,
                                                            const mqtt::BrokerUrl& broker);

/// Those that are meant, and satisfy the conditions. Robots that have neither left a connection
/// message nor sent a state are meant only when they are named outright. Warns of robots that are offline and whose state is not
/// known. Nobody at all is not an error.
[[nodiscard]] Chosen Choose(const Targets& targets, const vda5050::RobotDirectory& directory,
                            Log& log);

/// Why nobody was chosen: what was heard instead. ErrorKind::kPreflight, or the connection's.
[[nodiscard]] Error NobodyChosen(mqtt::Transport& transport, const Targets& targets,
                                 const DialectResolver& resolver,
                                 const vda5050::RobotDirectory& directory,
                                 const delivery::RetainedOptions& discover,
                                 const std::string& site);

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
