#pragma once

#include <sys/types.h>

#include <optional>
#include <string>

namespace fleetpub::base {

struct Account {
  std::string name;
  std::string home;
};

/// The entry of /etc/passwd. (getpwuid would ask every directory service that the machine knows:
/// that costs more than sending a command, and a static binary cannot.)
[[nodiscard]] std::optional<Account> FindAccount(uid_t user);

}  // namespace fleetpub::base
