#include "vda5050/tracking/ending.h"

#include <algorithm>
#include <array>

namespace fleetpub::vda5050 {
namespace {

constexpr std::array<Ending, 7> kEndings = {{
    // The robot reports OFFLINE when it goes down in good order; its last will, CONNECTION_BROKEN,
    // is no coordinated shutdown. FINISHED may never be visible.
    {.action_type = "shutdown", .connection_state = "OFFLINE"},
    // FINISHED is sent before the states stop; then there is silence.
    {.action_type = "startHibernation", .connection_state = "HIBERNATING"},
    // No state tells of it before the robot is awake, and a client that listened for it in the
    // robot's place may take leave meanwhile.
    {.action_type = "stopHibernation", .connection_state = "ONLINE", .may_reconnect = true},
    {.action_type = "stateRequest", .listed = true},
    {.action_type = "factsheetRequest", .factsheet = true},
    {.action_type = "clearInstantActions", .clears_list = true},
    // A new certificate is used from the next connection on.
    {.action_type = "updateCertificate", .may_reconnect = true},
}};

constexpr Ending kOrdinary{};

}  // namespace

const Ending& FindEnding(std::string_view action_type) {
  const auto* const found =
      std::find_if(kEndings.begin(), kEndings.end(),
                   [&](const Ending& ending) { return ending.action_type == action_type; });
  return found == kEndings.end() ? kOrdinary : *found;
}

}  // namespace fleetpub::vda5050
