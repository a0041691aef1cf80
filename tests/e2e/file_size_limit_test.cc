// The system says no. scripts/torture tries far more of this; here stands what it found and only
// the whole program shows.
#include <gmock/gmock.h>

#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::HasSubstr;

class FileSizeLimit : public EndToEnd {
 protected:
  /// `fleetpub pause KIT/0001` behind another program.
  [[nodiscard]] Finished PauseBehind(std::vector<std::string> program) const {
    Command command = operator_.Prepare(WithoutLook({"pause", "KIT/0001"}));
    command.arguments.insert(command.arguments.begin(), program.begin(), program.end());
    return testing::Run(command);
  }
};

TEST_F(FileSizeLimit, AFileThatMayNotGrowIsLedgerTrouble) {
  const auto limited = PauseBehind({"prlimit", "--fsize=2000"});
  EXPECT_EQ(limited.exit_code, 8) << limited.errors;
  EXPECT_THAT(limited.errors, HasSubstr("nothing was sent: no room for the ledger"));
  EXPECT_EQ(Send({"pause", "KIT/0001"}).exit_code, 0);
}

}  // namespace
}  // namespace fleetpub::testing
