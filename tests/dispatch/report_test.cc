#include "dispatch/report.h"

#include <gmock/gmock.h>

namespace fleetpub::dispatch {
namespace {

TEST(Verdict, IsNamedAsTheManualNamesIt) {
  EXPECT_EQ(NameOf(Verdict::kDryRun), "DRY_RUN");
  EXPECT_EQ(NameOf(Verdict::kSent), "SENT");
  EXPECT_EQ(NameOf(Verdict::kPublished), "PUBLISHED");
  EXPECT_EQ(NameOf(Verdict::kInvalid), "INVALID");
  EXPECT_EQ(NameOf(Verdict::kError), "ERROR");
}

TEST(Report, IsAnErrorUntilSomebodyKnowsBetter) {
  EXPECT_EQ(Report().verdict, Verdict::kError);
  EXPECT_EQ(Report().header_id, std::nullopt);
}

}  // namespace
}  // namespace fleetpub::dispatch
