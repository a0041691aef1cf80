// Topic filters of MQTT (MQTT 3.1.1 §4.7).
#pragma once

#include <string_view>

namespace fleetpub::delivery {

[[nodiscard]] bool HasWildcard(std::string_view filter);

/// Whether a message on this topic belongs to a subscription of this filter.
[[nodiscard]] bool Matches(std::string_view filter, std::string_view topic);

}  // namespace fleetpub::delivery
