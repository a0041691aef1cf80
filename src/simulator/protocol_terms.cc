#include "simulator/protocol_terms.h"

#include <array>

namespace fleetpub::simulator {
namespace {

using vda5050::Version;

constexpr ProtocolTerms Up21(Version version, mqtt::Qos connection_qos) {
  return {.version = version,
          .broken = "CONNECTIONBROKEN",
          .connection_qos = connection_qos,
          .position = "agvPosition",
          .initialized = "positionInitialized",
          .power = "batteryState",
          .charge = "batteryCharge",
          .emergency_stop = "eStop",
          .action_descriptor = "actionDescription",
          .action_result = "resultDescription",
          .visualization_refers = false,
          .own_instant_states = false,
          .invalid_action = "instantActionError",
          .invalid_message = "validationError",
          .no_order = "noOrderToCancel",
          .failed_action = "actionError",
          .duplicate_map = "duplicateMap",
          .duplicate_zone_set = ""};
}

// §6.2 of 1.1 asks for QoS 0 on every topic, from 2.0 on `connection` has 1.
constexpr std::array kTerms = {Up21(Version::k110, mqtt::Qos::kAtMostOnce),
                               Up21(Version::k200, mqtt::Qos::kAtLeastOnce),
                               Up21(Version::k210, mqtt::Qos::kAtLeastOnce),
                               ProtocolTerms{.version = Version::k300,
                                             .broken = "CONNECTION_BROKEN",
                                             .connection_qos = mqtt::Qos::kAtLeastOnce,
                                             .position = "mobileRobotPosition",
                                             .initialized = "localized",
                                             .power = "powerSupply",
                                             .charge = "stateOfCharge",
                                             .emergency_stop = "activeEmergencyStop",
                                             .action_descriptor = "actionDescriptor",
                                             .action_result = "actionResult",
                                             .visualization_refers = true,
                                             .own_instant_states = true,
                                             .invalid_action = "INVALID_INSTANT_ACTION",
                                             .invalid_message = "VALIDATION_FAILURE",
                                             .no_order = "NO_ORDER_TO_CANCEL",
                                             .failed_action = "ACTION_FAILED",
                                             .duplicate_map = "DUPLICATE_MAP",
                                             .duplicate_zone_set = "DUPLICATE_ZONE_SET"}};

}  // namespace

const ProtocolTerms& GetTerms(Version version) {
  return kTerms.at(static_cast<std::size_t>(version));
}

}  // namespace fleetpub::simulator
