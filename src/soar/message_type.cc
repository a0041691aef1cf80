#include "soar/message_type.h"

#include <algorithm>
#include <array>
#include <vector>

#include "base/text.h"

namespace fleetpub::soar {
namespace {

// In a message, names count as they are written.
template <class Kind, std::size_t N>
std::optional<Kind> Parse(const std::array<base::Choice<Kind>, N>& choices, std::string_view name) {
  for (const auto& choice : choices) {
    if (choice.text == name) return choice.value;
  }
  return std::nullopt;
}

}  // namespace

std::string_view GetName(MessageType type) {
  return kMessageTypes[static_cast<std::size_t>(type)].text;
}

std::optional<MessageType> ParseMessageType(std::string_view name) {
  return Parse(kMessageTypes, name);
}

std::string MessageTypeNames() {
  std::vector<std::string> names;
  names.reserve(kMessageTypes.size());
  for (const auto& type : kMessageTypes) names.emplace_back(type.text);
  return base::Join(names, ", ");
}

std::string_view GetDirection(MessageType type) {
  const bool told =
      type == MessageType::kMissionPlan || type == MessageType::kPlanningConfiguration;
  return told ? "to_platform" : "from_platform";
}

std::string_view GetName(Level level) { return kLevels[static_cast<std::size_t>(level)].text; }

std::optional<Level> ParseLevel(std::string_view name) { return Parse(kLevels, name); }

}  // namespace fleetpub::soar
