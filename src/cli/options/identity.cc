#include "cli/options/identity.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cstdlib>

#include "base/account.h"
#include "base/text.h"

namespace fleetpub::cli {

std::string UserName() {
  const uid_t user = getuid();
  if (const auto account = base::FindAccount(user)) return account->name;
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
