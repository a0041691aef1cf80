#include "vda5050/tracking/alerts.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/text.h"

namespace fleetpub::vda5050 {

void Alerts::Published(std::uint32_t header_id) {
  if (first_id_) return;
  first_id_ = header_id;
  TellOfHigherIds();
}

void Alerts::Look(const RobotState& state) {
  if (!list_full_ && IsInstantActionListFull(state.errors)) {
    list_full_ = true;
    Add(
        {"its list of instant actions is full: it may take no further one before "
         "clearInstantActions"});
  }
  const std::uint32_t named = HighestHeaderId(state.errors, topic_).value_or(0);
  if (named <= highest_id_) return;
  const bool is_first = std::exchange(highest_id_, named) == 0;
  if (is_first && first_id_) TellOfHigherIds();
}

void Alerts::Add(const std::vector<std::string>& texts) {
  for (const std::string& text : texts) {
    lines_.push_back(fmt::format("{}: {}", base::Printable(robot_), text));
  }
}

// A ledger that has just begun to count the topic, and a robot that has heard of more: somebody else
// sends there too, or another ledger was used before.
void Alerts::TellOfHigherIds() {
  if (first_id_ != 0 || highest_id_ == 0) return;
  Add({fmt::format(
      "an error in its state names headerId {} of {}, and this ledger begins with 0: was another "
      "ledger used before, or does somebody else send too? Add --header-id {}",
      highest_id_, topic_, highest_id_ + std::uint64_t{1})});
}

}  // namespace fleetpub::vda5050
