// What the configuration files say: defaults for options, sites (profiles), robots and groups.
//
// Two files are laid over each other, key by key: the host's and the user's. A profile goes before
// everything outside of profiles, whichever file it stands in; a robot's own table goes before
// both.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "vda5050/model/robot_address.h"

namespace fleetpub::config {

/// Where something stands.
struct ConfigPlace {
  std::string file;
  unsigned line = 0;
  unsigned column = 0;

  [[nodiscard]] std::string ToString() const;  ///< `/etc/fleetpub/config.toml:12`
};

/// ErrorKind::kUsage: `FILE:LINE:COLUMN: message`.
[[nodiscard]] Error ErrorAt(const ConfigPlace& place, std::string_view message);

struct ConfigValue {
  std::vector<std::string> texts;  ///< several for a list; `true` or `false` for a flag
  ConfigPlace place;
  std::string profile;  ///< in whose table it stands; empty: in none

  /// `profile north of FILE:12`, `FILE:12`.
  [[nodiscard]] std::string Origin() const;
};

using ConfigSection = std::map<std::string, ConfigValue, std::less<>>;

struct ConfiguredRobot {
  ConfigPlace place;
  ConfigSection settings;
};

struct ConfiguredGroup {
  ConfigPlace place;
  std::vector<ConfigValue> members;  ///< one text each
};

struct Config {
  std::vector<std::string> files;  ///< that were there
  ConfigSection settings;
  std::map<std::string, ConfigSection, std::less<>> profiles;
  std::optional<ConfigValue> default_profile;
  std::map<vda5050::RobotAddress, ConfiguredRobot> robots;
  std::map<std::string, ConfiguredGroup, std::less<>> groups;

  // What Resolve() makes of it.
  std::string profile;  ///< the one in use; empty: none
  std::map<std::string, vda5050::RobotAddress, std::less<>> aliases;
  std::map<std::string, std::vector<vda5050::RobotAddress>, std::less<>> group_robots;

  /// What the profile in use, else the files say; null: nothing. Valid while the Config is.
  [[nodiscard]] const ConfigValue* Find(std::string_view key) const;
  /// The robot's own table first.
  [[nodiscard]] const ConfigValue* Find(const vda5050::RobotAddress& robot,
                                        std::string_view key) const;
};

/// All that is wrong, each with its place.
using Mistakes = std::vector<Error>;

/// Lays one file's text over what was read before. Errors: ErrorKind::kUsage with the place.
[[nodiscard]] Status ReadConfig(std::string_view text, const std::string& file, Config& config);

/// Once all files are read: chooses the profile (`asked`, else the default one; "" asks for none)
/// and resolves aliases and groups. Errors: ErrorKind::kUsage: an unknown profile, an alias of two
/// robots, a group's unknown member.
[[nodiscard]] Status Resolve(const std::optional<std::string>& asked, Config& config);

/// Whether a key may have these texts, by what only its user knows. May be empty.
using ValueCheck =
    std::function<Status(std::string_view key, const std::vector<std::string>& texts)>;

/// The same, going on behind a mistake.
void ReadConfig(std::string_view text, const std::string& file, Config& config, Mistakes& mistakes,
                const ValueCheck& check = {});
void Resolve(const std::optional<std::string>& asked, Config& config, Mistakes& mistakes);

}  // namespace fleetpub::config
