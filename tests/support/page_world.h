// What the commands of a page of docs/ take for granted.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace fleetpub::testing {

/// Of one chapter.
struct World {
  std::string setup = {};  ///< shell, before the first
  /// Shell before the first command that begins so.
  std::vector<std::pair<std::string, std::string>> before = {};
  /// Other exit codes than the heading's, by the command's beginning.
  std::vector<std::pair<std::string, int>> codes = {};
  /// What is put in the place of something that stands in the commands.
  std::vector<std::pair<std::string, std::string>> changes = {};
};

/// Shell functions for the worlds, such as `online TARGET…`, which returns when the robots are
/// online. $PORT is the broker's, $PORT_1884 and $PORT_8883 are free.
[[nodiscard]] const char* WorldFunctions();

/// By page and heading. A chapter that is not here takes nothing for granted.
[[nodiscard]] const std::map<std::string, std::map<std::string, World>>& Worlds();

}  // namespace fleetpub::testing
