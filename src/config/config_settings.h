// The keys that a configuration file may have, and what each may hold.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>

#include "base/choice.h"
#include "base/result.h"
#include "ledger/options.h"
#include "mqtt/transport.h"

namespace fleetpub::config {

// What a setting of few values may be; the options that stand for it read the same tables.

inline constexpr auto kOutputs = std::to_array<std::string_view>({"text", "json", "csv", "tsv"});
inline constexpr auto kActionsKeys = std::to_array<std::string_view>({"actions", "instantActions"});
inline constexpr auto kQos = std::to_array<base::Choice<mqtt::Qos>>({
    {"0", mqtt::Qos::kAtMostOnce},
    {"1", mqtt::Qos::kAtLeastOnce},
    {"2", mqtt::Qos::kExactlyOnce},
});
inline constexpr auto kMqttVersions = std::to_array<base::Choice<mqtt::ProtocolVersion>>({
    {"3.1.1", mqtt::ProtocolVersion::k311},
    {"311", mqtt::ProtocolVersion::k311},
    {"4", mqtt::ProtocolVersion::k311},
    {"5", mqtt::ProtocolVersion::k5},
    {"5.0", mqtt::ProtocolVersion::k5},
});
inline constexpr auto kHeaderIdStarts = std::to_array<base::Choice<ledger::HeaderIdStart>>({
    {"zero", ledger::HeaderIdStart::kZero},
    {"epoch", ledger::HeaderIdStart::kEpoch},
});

/// Runs a program: only in a file that nobody else can change.
inline constexpr std::string_view kPasswordCommand = "password_command";

enum class SettingType {
  kText,
  kTexts,        ///< a text or a list of texts
  kCommand,      ///< a list of texts: a program, by a path or to be looked for, and its arguments
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
