#include "app/recent_targets.h"

#include <gmock/gmock.h>

#include "support/fake_ledger.h"

namespace fleetpub::app {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(RecentTargets, AreEachNamedOnce) {
  testing::Journal journal;
  const auto open = [&](ledger::OpenMode) -> Result<std::unique_ptr<ledger::Ledger>> {
    auto ledger = std::make_unique<testing::FakeLedger>(journal);
    const std::vector<std::string> topics = {"t"};
    const auto lock = ledger->Lock(topics, ledger::Deadline::max());
    for (const char* target : {"KIT/0001", "KIT/0002", "KIT/0001"}) {
      ledger::Draft draft;
      draft.topic = "t";
      draft.target = target;
      draft.protocol = "vda5050";
      EXPECT_TRUE(ledger->Reserve(std::span(&draft, 1)));
    }
    return ledger;
  };
  EXPECT_THAT(FindRecentTargets(open, "vda5050"), ElementsAre("KIT/0001", "KIT/0002"));
  EXPECT_THAT(FindRecentTargets(open, "soar"), IsEmpty());
}

TEST(RecentTargets, AreNoneWithoutALedger) {
  const auto open = [](ledger::OpenMode) -> Result<std::unique_ptr<ledger::Ledger>> {
    return Fail(ErrorKind::kLedger, "there is none");
  };
  EXPECT_THAT(FindRecentTargets(open, "vda5050"), IsEmpty());
}

}  // namespace
}  // namespace fleetpub::app
