// What this program is made of.
#pragma once

#include <string>

namespace fleetpub::cli {

/// What only the build knows.
struct BuildInfo {
  const char* version;      ///< `1.0.0`
  const char* description;  ///< type, way of linking, system, compiler
};

/// `fleetpub 1.0.0` on the first line, for scripts; then the build, the libraries, the schemas.
[[nodiscard]] std::string VersionText(const BuildInfo& build);

}  // namespace fleetpub::cli
