// Chooses, of the robots that there are, those that somebody means.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "app/dialect_resolver.h"
#include "app/observer.h"
#include "app/robot_discovery.h"
#include "app/targets.h"
#include "base/result.h"
#include "config/config.h"
#include "vda5050/reports/robot_directory.h"

namespace fleetpub::app {

/// Robots of a directory. Valid as long as that.
struct Chosen {
  std::vector<const ListedRobot*>
      robots;  ///< named ones in their order, then the found ones by name
  std::vector<const ListedRobot*> unheard;  ///< whether --where is true of them is not known
  std::size_t left_out = 0;                 ///< robots that are offline, by --online
};

/// Whether every --where is true of it.
enum class Answer {
  kYes,
  kNo,
  kUnheard,  ///< it is there, and has not said enough
  kOffline,  ///< it is not there, and has left nothing that tells
};
[[nodiscard]] Answer Satisfies(const Targets& targets, const vda5050::RobotEntry& entry);

/// The first exception that spares nobody of those that the patterns have found: a misspelt one
/// would command whom it should spare. One that the configuration names may just be away.
[[nodiscard]] std::optional<std::string> UnusedExclusion(const Targets& targets,
                                                         const Excluded& excluded,
                                                         const config::Config& config);

/// Those that are meant, and satisfy the conditions. Robots that have neither left a connection
/// message nor sent a state are meant only when they are named outright. Tells of robots that are
/// offline and therefore left out, whether --online says so or --where cannot be decided. Nobody at
/// all is not an error.
[[nodiscard]] Chosen Choose(const Targets& targets, const vda5050::RobotDirectory& directory,
                            Log& log);

/// Why nobody was chosen: what was heard instead. ErrorKind::kPreflight, or the connection's.
[[nodiscard]] Error NobodyChosen(mqtt::Transport& transport, const Targets& targets,
                                 const DialectResolver& resolver,
                                 const vda5050::RobotDirectory& directory,
                                 const delivery::RetainedOptions& discover,
                                 const std::string& site);

}  // namespace fleetpub::app
