#include "soar/message_type.h"

#include <algorithm>
#include <array>
#include <vector>

#include "base/text.h"

namespace fleetpub::soar {
namespace {

constexpr std::array kTypes = {MessageType::kAcknowledgement, MessageType::kMissionPlan,
                               MessageType::kObservation, MessageType::kPlanningConfiguration,
                               MessageType::kPlatformStatus};
constexpr std::array<std::string_view, 5> kTypeNames = {
    "acknowledgement", "mission_plan", "observation", "planning_configuration", "platform_status"};

constexpr std::array kLevels = {Level::kC2Received, Level::kOperatorApprovedAndSent,
                                Level::kExecuted};
constexpr std::array<std::string_view, 3> kLevelNames = {"c2_received",
                                                         "operator_approved_and_sent", "executed"};

template <typename Kind, std::size_t N>
std::optional<Kind> Parse(const std::array<Kind, N>& kinds,
                          const std::array<std::string_view, N>& names, std::string_view name) {
  const auto* const found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return kinds[static_cast<std::size_t>(found - names.begin())];
}

}  // namespace

std::span<const MessageType> AllMessageTypes() { return kTypes; }

std::string_view GetName(MessageType type) { return kTypeNames[static_cast<std::size_t>(type)]; }

std::optional<MessageType> ParseMessageType(std::string_view name) {
  return Parse(kTypes, kTypeNames, name);
}

std::string MessageTypeNames() {
  const std::vector<std::string> names(kTypeNames.begin(), kTypeNames.end());
  return base::Join(names, ", ");
}

std::string_view GetDirection(MessageType type) {
  const bool told =
      type == MessageType::kMissionPlan || type == MessageType::kPlanningConfiguration;
  return told ? "to_platform" : "from_platform";
}

std::span<const Level> AllLevels() { return kLevels; }

std::string_view GetName(Level level) { return kLevelNames[static_cast<std::size_t>(level)]; }

std::optional<Level> ParseLevel(std::string_view name) { return Parse(kLevels, kLevelNames, name); }

}  // namespace fleetpub::soar
