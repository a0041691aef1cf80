// The predefined actions of every version, as data (VDA 5050 1.1–2.1 §6.8.1, 3.0 §6.2.4).
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "vda5050/model/version.h"

namespace fleetpub::vda5050 {

/// The largest angle, as the published schemas write π: a little more than the nearest double.
inline constexpr double kMaxAngle = 3.14159265359;

enum class ParameterType {
  kString,
  kLength,  ///< a float64 in metres
  kAngle,   ///< a float64 in radians within ±π
  kStringArray,
};

/// As the specification's table prints it: `string`, `float64`, `array of string`.
[[nodiscard]] std::string_view GetName(ParameterType type);

struct ParameterSpec {
  std::string_view name;
  ParameterType type;
  bool required;
  std::string_view meaning;       ///< for the help, in a few words
  std::string_view example = {};  ///< a value as people type it; empty: of what is optional
};

/// Where an action may stand.
struct Scopes {
  bool instant = false;
  bool node = false;
  bool edge = false;
  bool zone = false;
};

/// The versions that have a row, as a range.
struct VersionRange {
  Version first;
  Version last;

  [[nodiscard]] bool Contains(Version version) const { return version >= first && version <= last; }
};
inline constexpr VersionRange kAllVersions{Version::k110, Version::k300};
inline constexpr VersionRange kUpTo21{Version::k110, Version::k210};
inline constexpr VersionRange kFrom20{Version::k200, Version::k300};
inline constexpr VersionRange kFrom21{Version::k210, Version::k300};
inline constexpr VersionRange kFrom30{Version::k300, Version::k300};

struct ActionSpec {
  std::string_view type;  ///< `actionType`, spelled as the specification spells it
  VersionRange versions;
  Scopes scopes;
  std::span<const ParameterSpec> parameters;
  std::string_view counter_action;  ///< "" when there is none
  std::string_view linked_state;    ///< the state's fields that it changes; "" when there are none
  bool idempotent;
  std::string_view summary;  ///< what it makes the robot do, in a few words
};

/// Every row. An action whose scopes or parameters differ between versions has a row for each.
[[nodiscard]] std::span<const ActionSpec> AllActions();

/// The version's own rows, in the order of its table.
[[nodiscard]] std::vector<const ActionSpec*> ListActions(Version version);

/// The version's row of exactly this name (names are case-sensitive on the wire), or null.
[[nodiscard]] const ActionSpec* FindAction(Version version, std::string_view type);

/// The name under which this version knows an action: `initPosition` up to 2.1 is
/// `initializePosition` from 3.0. Returns `type` itself when the version has no other name for it.
[[nodiscard]] std::string_view NameIn(Version version, std::string_view type);

/// What a person may call an action on the command line: the predefined name in any letter case, or
/// a short name. Returns the newest version's name (`initializePosition`), or nothing.
[[nodiscard]] std::optional<std::string_view> ActionCalled(std::string_view word);

/// All that ActionCalled() understands: predefined names and short names.
[[nodiscard]] std::vector<std::string_view> AllActionWords();

/// What a person may have meant by a word that is neither an action nor one of `others`: of what
/// undoes an action, its counter action (`unpause` → resume), never the action itself.
[[nodiscard]] std::optional<std::string> ActionMeant(std::string_view word,
                                                     std::span<const std::string_view> others = {});

/// The short names of a predefined action: `pause` of `startPause`.
[[nodiscard]] std::vector<std::string_view> ListShortNames(std::string_view type);

/// One name per predefined action, the newest version's, in table order; with those that are never
/// instant.
[[nodiscard]] std::vector<std::string_view> AllActionNames();

/// True when some version allows it as an instant action.
[[nodiscard]] bool IsEverInstant(std::string_view type);

/// The parameters that the action has in any version, each once; the newest version's row wins.
[[nodiscard]] std::vector<ParameterSpec> ParametersInAnyVersion(std::string_view type);

/// `2.1.0`, `3.0.0`: the versions in which the action may be instant, for messages.
[[nodiscard]] std::string VersionsWithInstant(std::string_view type);

}  // namespace fleetpub::vda5050
