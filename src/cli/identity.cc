#include "cli/identity.h"

#include <fmt/format.h>
#include <pwd.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "base/text.h"

namespace fleetpub::cli {

std::string UserName() {
  const uid_t user = getuid();
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> accounts(std::fopen("/etc/passwd", "re"),
                                                                 std::fclose);
  while (accounts != nullptr) {
    const passwd* account = fgetpwent(accounts.get());
    if (account == nullptr) break;
    if (account->pw_uid == user) return account->pw_name;
  }
  const char* claimed = std::getenv("LOGNAME");
  if (claimed == nullptr) return fmt::format("uid {}", user);
  return fmt::format("uid {} ({})", user, base::Printable(claimed));
}

std::string HostName() {
  std::array<char, 256> name{};
  gethostname(name.data(), name.size() - 1);
  return name.data();
}

}  // namespace fleetpub::cli
