// What a broker hands out, as bytes.
#pragma once

#include <string>
#include <string_view>

namespace fleetpub::testing {

/// PUBLISH at QoS 0 (MQTT 3.1.1 §3.3). `properties` come with their length before them, on MQTT 5 only.
[[nodiscard]] std::string PublishPacket(std::string_view topic, std::string_view payload,
                                        std::string_view properties = "");

}  // namespace fleetpub::testing
