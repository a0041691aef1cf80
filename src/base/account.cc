#include "base/account.h"

#include <pwd.h>

#include <cstdio>
#include <memory>

namespace fleetpub::base {

std::optional<Account> FindAccount(uid_t user) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> accounts(std::fopen("/etc/passwd", "re"),
                                                                 std::fclose);
  while (accounts != nullptr) {
    const passwd* entry = fgetpwent(accounts.get());
    if (entry == nullptr) break;
    if (entry->pw_uid == user) return Account{entry->pw_name, entry->pw_dir};
  }
  return std::nullopt;
}

}  // namespace fleetpub::base
