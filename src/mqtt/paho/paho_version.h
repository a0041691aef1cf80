// The libraries behind this folder.
#pragma once

#include <string>
#include <vector>

namespace fleetpub::mqtt {

/// `Paho 1.3.12`, `OpenSSL 3.0.15`: those that the program runs with.
[[nodiscard]] std::vector<std::string> LibraryVersions();

}  // namespace fleetpub::mqtt
