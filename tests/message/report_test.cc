#include "message/report.h"

#include <gmock/gmock.h>

namespace fleetpub::message {
namespace {

TEST(Report, IsAnErrorUntilSomebodyKnowsBetter) {
  EXPECT_EQ(Report().status, CommandStatus::kError);
  EXPECT_EQ(Report().header_id, std::nullopt);
}

}  // namespace
}  // namespace fleetpub::message
