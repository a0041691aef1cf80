// Who commands, for the audit trail.
#pragma once

#include <string>

namespace fleetpub::cli {

/// The account's name in /etc/passwd by the real user id, which no environment variable can change.
/// For an account of a directory service `uid 1234 (alice)`, where the name is only what LOGNAME
/// claims. (getpwuid would ask every such service: that costs more than sending the command, and a
/// static binary cannot.)
[[nodiscard]] std::string UserName();

[[nodiscard]] std::string HostName();

}  // namespace fleetpub::cli
