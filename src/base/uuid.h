#pragma once

#include <string>

namespace fleetpub::base {

/// A random UUID (RFC 4122 version 4), lower case with hyphens.
[[nodiscard]] std::string RandomUuid();

}  // namespace fleetpub::base
