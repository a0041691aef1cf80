// What this program is made of.
#pragma once

#include <string>

namespace fleetpub::cli {

/// `fleetpub 0.1.0` on the first line, for scripts; then the build, the libraries, the schemas.
[[nodiscard]] std::string VersionText();

}  // namespace fleetpub::cli
