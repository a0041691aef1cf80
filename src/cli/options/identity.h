// Who commands, for the audit trail.
#pragma once

#include <string>

namespace fleetpub::cli {

/// The account's name by the real user id, which no environment variable can change. An account of
/// a directory service appears as `uid 1234 (alice)`, where the name is only what LOGNAME claims.
[[nodiscard]] std::string UserName();

[[nodiscard]] std::string HostName();

}  // namespace fleetpub::cli
