// The system says no. scripts/torture tries far more of this; here stands what it found.
#include <gmock/gmock.h>

#include <filesystem>

#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;

class Faults : public EndToEnd {
 protected:
  /// `fleetpub pause KIT/0001` behind another program.
  [[nodiscard]] Finished PauseBehind(std::vector<std::string> program) const {
    Command command = operator_.Prepare({"pause", "KIT/0001"});
    command.arguments.insert(command.arguments.begin(), program.begin(), program.end());
    return testing::Run(command);
  }
};

TEST_F(Faults, AFileThatMayNotGrowIsLedgerTrouble) {
  const auto limited = PauseBehind({"prlimit", "--fsize=2000"});
  EXPECT_EQ(limited.exit_code, 8) << limited.errors;
  EXPECT_THAT(limited.errors, HasSubstr("nothing was sent: no room for the ledger"));
  EXPECT_EQ(Fleetpub({"pause", "KIT/0001"}).exit_code, 0);
}

// SQLite calls a log that could not be copied no error: the new ledger was moved into place empty.
TEST_F(Faults, AMissingLockWhileTheLedgerIsMadeLeavesNoHalfALedger) {
  for (int call = 1;; call += 3) {
    const std::string from = std::to_string(call) + "+";
    const auto hurt = PauseBehind(
        {"strace", "-f", "-qq", "-o", "/dev/null", "-e", "inject=fcntl:error=ENOLCK:when=" + from});
    ASSERT_THAT(hurt.exit_code, AnyOf(0, 8)) << from << hurt.errors;
    const auto next = Fleetpub({"pause", "KIT/0001"});
    ASSERT_EQ(next.exit_code, 0) << from << next.errors;
    if (hurt.exit_code == 0) break;  // no such call is left
    std::filesystem::remove_all(operator_.LedgerPath().parent_path());
  }
}

}  // namespace
}  // namespace fleetpub::testing
