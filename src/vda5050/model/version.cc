#include "vda5050/model/version.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

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

constexpr std::array<std::pair<std::string_view, Version>, 11> kNames = {{
    {"1", Version::k110},
    {"1.1", Version::k110},
    {"1.1.0", Version::k110},
    {"2", Version::k210},
    {"2.0", Version::k200},
    {"2.0.0", Version::k200},
    {"2.1", Version::k210},
    {"2.1.0", Version::k210},
    {"3", Version::k300},
    {"3.0", Version::k300},
    {"3.0.0", Version::k300},
}};

}  // namespace

const VersionFacts& FactsOf(Version version) { return kFacts[static_cast<std::size_t>(version)]; }

Result<Version> ParseVersion(std::string_view text) {
  const auto* const found = std::find_if(kNames.begin(), kNames.end(),
                                         [&](const auto& name) { return name.first == text; });
  if (found != kNames.end()) return found->second;
  return Fail(ErrorKind::kUsage,
              fmt::format("'{}' is not a VDA 5050 version that fleetpub speaks: use 1.1.0, 2.0.0, "
                          "2.1.0 or 3.0.0 (short: 1.1, 2.0, 2.1, 3)",
                          base::Printable(text)));
}

}  // namespace fleetpub::vda5050
