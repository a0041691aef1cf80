// How a robot shows that an instant action is done, where that is not just FINISHED: data beside
// the catalogue (VDA 5050 3.0 §6.2.4 and its table of action states; 1.1–2.1 §6.8).
#pragma once

#include <string_view>

namespace fleetpub::vda5050 {

/// FINISHED is an end, but for a factsheet that has not come; these are others.
struct Ending {
  std::string_view action_type;
  /// This connectionState, delivered live after publishing, says that it is done. Empty: none does.
  std::string_view connection_state;
  /// The connection may be lost and come back meanwhile: OFFLINE and CONNECTION_BROKEN are no end.
  bool may_reconnect = false;
  /// A live factsheet after publishing says that it is done, and nothing else does.
  bool factsheet = false;
  /// The state that lists it is the answer itself.
  bool listed = false;
  /// It removes ended entries from the list, its own among them.
  bool clears_list = false;
};

/// Of an action that has no special one, a manufacturer's own included: FINISHED alone.
[[nodiscard]] const Ending& FindEnding(std::string_view action_type);

}  // namespace fleetpub::vda5050
