// The releases of VDA 5050 that we speak, and in what their messages differ.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"

namespace fleetpub::vda5050 {

enum class Version { k110, k200, k210, k300 };

inline constexpr std::array kVersions = {Version::k110, Version::k200, Version::k210,
                                         Version::k300};

/// What the message and topic of each release look like.
struct VersionFacts {
  Version version;
  std::string_view name;            ///< the header's `version`: [Major].[Minor].[Patch]
  std::string_view major;           ///< the topic level: `v3`
  std::string_view interface_name;  ///< of the examples: `uagv` up to 2.x, `vda5050` from 3.0
  std::string_view actions_key;     ///< the array of an instantActions message
  std::string_view descriptor_key;  ///< the action's free description
  /// Up to 2.1 NONE, SOFT and HARD are allowed in instantActions; from 3.0 only NONE (§6.3).
  bool only_blocking_type_none;
  /// 1.1 robots expect `actionParameters` even when there are none.
  bool empty_parameters;
};

[[nodiscard]] const VersionFacts& GetFacts(Version version);

/// What a person states: `1.1.0`, `2.0.0`, `2.1.0`, `3.0.0`, or a patch level of them (`2.1.3`);
/// short `1`, `1.1`, `2`, `2.0`, `2.1`, `3`, `3.0`; `2` is the newest 2.x. Errors:
/// ErrorKind::kUsage, naming those that there are.
[[nodiscard]] Result<Version> ParseVersion(std::string_view text);

/// What a message says of the version that its sender speaks.
struct SpokenVersion {
  Version version;
  bool is_release;  ///< false: the text is no release or patch level of one, and this was chosen

  bool operator==(const SpokenVersion&) const = default;
};

/// Reads a header's version, leniently: `2.1.0`, `2.1.3`, ` v2.1 `, `2.1.0+git`. A release that is
/// not known (`1.3.2`, `2`) is the newest one of the topic's major level (`v2`), or else of its own
/// major version; an unreadable text falls back to the topic's. Nothing when no release of that
/// major version is known.
[[nodiscard]] std::optional<SpokenVersion> VersionSpoken(std::string_view header_version,
                                                         std::string_view major_level);

/// `"1.3.2" is not a release of VDA 5050: taken as 2.1.0`.
[[nodiscard]] std::string NoReleaseText(std::string_view header_version, Version taken_as);

}  // namespace fleetpub::vda5050
