#include "base/uuid.h"

#include <gmock/gmock.h>

#include <set>

namespace fleetpub::base {
namespace {

TEST(RandomUuid, IsOfVersion4InLowerCase) {
  for (int i = 0; i < 100; ++i) {
    const std::string uuid = RandomUuid();
    ASSERT_EQ(uuid.size(), 36U);
    EXPECT_EQ(uuid.find_first_not_of("0123456789abcdef-"), std::string::npos) << uuid;
    for (const std::size_t hyphen : {8U, 13U, 18U, 23U}) EXPECT_EQ(uuid[hyphen], '-') << uuid;
    EXPECT_EQ(uuid[14], '4') << uuid;
    EXPECT_NE(std::string("89ab").find(uuid[19]), std::string::npos) << uuid;
  }
}

TEST(RandomUuid, IsAnotherOneEachTime) {
  std::set<std::string> uuids;
  for (int i = 0; i < 1000; ++i) uuids.insert(RandomUuid());
  EXPECT_EQ(uuids.size(), 1000U);
}

}  // namespace
}  // namespace fleetpub::base
