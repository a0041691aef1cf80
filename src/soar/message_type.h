// The five payloads of the SoAR backbone, named as the format spells them.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "base/choice.h"

namespace fleetpub::soar {

/// In the order of the schema document.
enum class MessageType {
  kAcknowledgement,
  kMissionPlan,
  kObservation,
  kPlanningConfiguration,
  kPlatformStatus,
};

inline constexpr auto kMessageTypes = std::to_array<base::Choice<MessageType>>({
    {"acknowledgement", MessageType::kAcknowledgement},
    {"mission_plan", MessageType::kMissionPlan},
    {"observation", MessageType::kObservation},
    {"planning_configuration", MessageType::kPlanningConfiguration},
    {"platform_status", MessageType::kPlatformStatus},
});
/// `mission_plan`
[[nodiscard]] std::string_view GetName(MessageType type);
/// The type of exactly this name.
[[nodiscard]] std::optional<MessageType> ParseMessageType(std::string_view name);
/// All names, for messages: `acknowledgement, mission_plan, …`
[[nodiscard]] std::string MessageTypeNames();

/// The level before the message type in a platform's topics: `to_platform` for what a platform is
/// told, `from_platform` for what it tells.
[[nodiscard]] std::string_view GetDirection(MessageType type);

/// How far a message has come, in order.
enum class Level { kC2Received, kOperatorApprovedAndSent, kExecuted };

inline constexpr auto kLevels = std::to_array<base::Choice<Level>>({
    {"c2_received", Level::kC2Received},
    {"operator_approved_and_sent", Level::kOperatorApprovedAndSent},
    {"executed", Level::kExecuted},
});
/// `c2_received`
[[nodiscard]] std::string_view GetName(Level level);
[[nodiscard]] std::optional<Level> ParseLevel(std::string_view name);

}  // namespace fleetpub::soar
