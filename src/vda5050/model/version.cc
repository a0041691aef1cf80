#include "vda5050/model/version.h"

#include <fmt/format.h>

#include <charconv>

#include "base/text.h"

namespace fleetpub::vda5050 {
namespace {

constexpr std::array<VersionFacts, kVersions.size()> kFacts = {{
    // The 1.1 text's example topic says v2, its rule says the major version: v1
    // (VDA5050/VDA5050#272).
    {Version::k110, "1.1.0", "v1", "uagv", "instantActions", "actionDescription", false, true},
    {Version::k200, "2.0.0", "v2", "uagv", "actions", "actionDescription", false, false},
    {Version::k210, "2.1.0", "v2", "uagv", "actions", "actionDescription", false, false},
    {Version::k300, "3.0.0", "v3", "vda5050", "actions", "actionDescriptor", true, false},
}};

struct Release {
  int major;
  int minor;             ///< -1: not said
  bool is_exact = true;  ///< digits and dots alone, at most three numbers
  bool is_full = false;  ///< with its patch level
};

// Takes a number off the front; -1 when there is none.
int TakeNumber(std::string_view& text) {
  int number = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || number < 0) return -1;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

// `2`, `v2.1`, ` V2.1.0 `, `2.0.0-rc`.
std::optional<Release> ReadRelease(std::string_view text) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t'; };
  Release release{0, -1};
  while (!text.empty() && is_blank(text.front())) {
    text.remove_prefix(1);
    release.is_exact = false;
  }
  if (!text.empty() && (text.front() == 'v' || text.front() == 'V')) {
    text.remove_prefix(1);
    release.is_exact = false;
  }
  release.major = TakeNumber(text);
  if (release.major < 0) return std::nullopt;
  if (text.empty()) return release;
  if (text.front() == '.') {
    text.remove_prefix(1);
    release.minor = TakeNumber(text);
    if (release.minor < 0) return std::nullopt;
    if (text.empty()) return release;
    if (text.front() == '.') {
      text.remove_prefix(1);
      release.is_full = TakeNumber(text) >= 0;
      release.is_exact = release.is_exact && release.is_full && text.empty();
      return release;
    }
  }
  if (!is_blank(text.front())) return std::nullopt;
  release.is_exact = false;
  return release;
}

std::optional<Version> Known(const Release& release) {
  for (const Version version : kVersions) {
    const auto ours = ReadRelease(GetFacts(version).name);
    if (ours->major == release.major && ours->minor == release.minor) return version;
  }
  return std::nullopt;
}

std::optional<Version> FindNewest(int major) {
  std::optional<Version> newest;
  for (const Version version : kVersions) {
    if (ReadRelease(GetFacts(version).name)->major == major) newest = version;
  }
  return newest;
}

}  // namespace

const VersionFacts& GetFacts(Version version) { return kFacts[static_cast<std::size_t>(version)]; }

Result<Version> ParseVersion(std::string_view text) {
  const auto release = ReadRelease(text);
  if (release && release->is_exact) {
    const auto version = release->minor < 0 ? FindNewest(release->major) : Known(*release);
    if (version) return *version;
  }
  return Fail(ErrorKind::kUsage,
              fmt::format("'{}' is not a VDA 5050 version that fleetpub speaks: use 1.1.0, 2.0.0, "
                          "2.1.0 or 3.0.0 (short: 1.1, 2.0, 2.1, 3)",
                          base::Printable(text)));
}

std::optional<SpokenVersion> VersionSpoken(std::string_view header_version,
                                           std::string_view major_level) {
  const auto said = ReadRelease(header_version);
  const auto level = ReadRelease(major_level);
  std::optional<Version> chosen;
  if (level) chosen = FindNewest(level->major);
  if (said) {
    if (const auto known = Known(*said)) {
      return SpokenVersion{*known, said->is_exact && said->is_full};
    }
    const auto own = FindNewest(said->major);
    if (!own) return std::nullopt;  // said, and not ours
    if (!chosen) chosen = own;
  }
  if (!chosen) return std::nullopt;
  return SpokenVersion{*chosen, false};
}

std::string NoReleaseText(std::string_view header_version, Version taken_as) {
  return fmt::format("\"{}\" is not a release of VDA 5050: taken as {}",
                     base::Printable(header_version.substr(0, 80)), GetFacts(taken_as).name);
}

}  // namespace fleetpub::vda5050
