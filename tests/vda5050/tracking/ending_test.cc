#include "vda5050/tracking/ending.h"

#include <gtest/gtest.h>

#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::vda5050 {
namespace {

struct Case {
  std::string_view type;
  std::string_view connection_state;
  bool may_reconnect;
  bool factsheet;
  bool listed;
  bool clears_list;
};

constexpr Case kCases[] = {
    {"shutdown", "OFFLINE", false, false, false, false},
    {"startHibernation", "HIBERNATING", false, false, false, false},
    {"stopHibernation", "ONLINE", true, false, false, false},
    {"stateRequest", "", false, false, true, false},
    {"factsheetRequest", "", false, true, false, false},
    {"clearInstantActions", "", false, false, false, true},
    {"updateCertificate", "", true, false, false, false},
    {"startPause", "", false, false, false, false},
    {"cancelOrder", "", false, false, false, false},
    {"clearZoneActions", "", false, false, false, false},
    {"beep", "", false, false, false, false},
    {"", "", false, false, false, false},
};

TEST(Ending, IsThatOfTheSpecificationsTable) {
  for (const Case& expected : kCases) {
    SCOPED_TRACE(expected.type);
    const Ending& ending = FindEnding(expected.type);
    EXPECT_EQ(ending.connection_state, expected.connection_state);
    EXPECT_EQ(ending.may_reconnect, expected.may_reconnect);
    EXPECT_EQ(ending.factsheet, expected.factsheet);
    EXPECT_EQ(ending.listed, expected.listed);
    EXPECT_EQ(ending.clears_list, expected.clears_list);
  }
}

TEST(Ending, IsOfActionsThatTheCatalogueHas) {
  for (const Case& special : kCases) {
    if (FindEnding(special.type).action_type.empty()) continue;
    EXPECT_NE(FindAction(Version::k300, special.type), nullptr) << special.type;
  }
}

}  // namespace
}  // namespace fleetpub::vda5050
