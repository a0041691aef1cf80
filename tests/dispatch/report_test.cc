#include "dispatch/report.h"

#include <gmock/gmock.h>

namespace fleetpub::dispatch {
namespace {

TEST(Report, IsAnErrorUntilSomebodyKnowsBetter) {
  EXPECT_EQ(Report().verdict, Verdict::kError);
  EXPECT_EQ(Report().header_id, std::nullopt);
}

}  // namespace
}  // namespace fleetpub::dispatch
