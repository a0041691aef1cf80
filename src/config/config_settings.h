// The keys that a configuration file may have, and what each may hold.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "base/result.h"

namespace fleetpub::config {

enum class SettingType {
  kText,
  kTexts,        ///< a text or a list of texts
  kPath,         ///< a text; relative to the file's folder
  kFlag,         ///< true, false
  kWhole,        ///< an integer
  kTextOrWhole,  ///< `5`, `"3.1.1"`
};

struct Setting {
  std::string_view key;
  SettingType type;
  std::string_view standard;  ///< what holds when nobody says anything, as `config show` prints it
  /// Whether a value can be right at all. Null: what uses it decides.
  Status (*check)(const std::string& value) = nullptr;
};

/// At the top and in `[profile.NAME]`.
[[nodiscard]] std::span<const Setting> Settings();

/// In `[robot."KIT/0001"]`.
[[nodiscard]] std::span<const Setting> RobotSettings();

/// A name that can be written as a target: an alias, a group. Errors: ErrorKind::kUsage.
[[nodiscard]] Status CheckTargetName(const std::string& name);

}  // namespace fleetpub::config
