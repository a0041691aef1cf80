#include "cli/options/identity.h"

#include <gmock/gmock.h>
#include <pwd.h>
#include <unistd.h>

#include <array>

#include "support/environment.h"

namespace fleetpub::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// An account of this machine, or of a directory service that /etc/passwd does not list.
bool IsLocalAccount() { return !UserName().starts_with("uid "); }

TEST(Identity, IsTheAccountOfTheRealUser) {
  if (!IsLocalAccount()) GTEST_SKIP() << "this user has no account in /etc/passwd";
  EXPECT_EQ(UserName(), getpwuid(getuid())->pw_name);
}

TEST(Identity, CannotBeChangedByTheEnvironment) {
  const testing::EnvironmentVariable login("LOGNAME", "mallory");
  const testing::EnvironmentVariable user("USER", "mallory");
  const std::string id = std::to_string(getuid());
  EXPECT_EQ(UserName(),
            IsLocalAccount() ? getpwuid(getuid())->pw_name : "uid " + id + " (mallory)");
}

TEST(Identity, ShowsNoControlCharacterOfWhatTheEnvironmentClaims) {
  const testing::EnvironmentVariable login("LOGNAME", "mal\x1b[2Jlory");
  EXPECT_THAT(UserName(), Not(HasSubstr("\x1b")));
}

TEST(Identity, KnowsTheHost) {
  std::array<char, 256> name{};
  ASSERT_EQ(gethostname(name.data(), name.size() - 1), 0);
  EXPECT_EQ(HostName(), name.data());
}

}  // namespace
}  // namespace fleetpub::cli
