// Whom a command is for: `manufacturer/serialNumber`, and the MQTT topics made of it (VDA 5050 §6.1
// "topic levels").
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/result.h"
#include "vda5050/model/version.h"

namespace fleetpub::vda5050 {

/// The topics of all versions: those that robots publish, then those that fleet control does.
inline constexpr auto kTopicNames =
    std::to_array<std::string_view>({"state", "connection", "factsheet", "visualization",
                                     "instantActions", "order", "zoneSet", "responses"});
inline constexpr auto kReportTopics = std::span(kTopicNames).first<4>();
inline constexpr auto kCommandTopics = std::span(kTopicNames).last<4>();

struct RobotAddress {
  std::string manufacturer;
  std::string serial_number;

  /// `KIT/0001`: the word that means this robot and no other wherever a target is read, and that
  /// can be shown. What would make it a pattern, a group, an option or two words, and what nobody
  /// would see, is written as in a URL: `KIT/%2A` for a robot that is called `*`.
  [[nodiscard]] std::string ToString() const;
  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy takes the 0 that it implies for a pointer.
  friend auto operator<=>(const RobotAddress&, const RobotAddress&) = default;
};

/// Parses `manufacturer/serialNumber`, where `%` and two hexadecimal digits stand for a byte. An
/// empty level, `/ + # $`, a control character or invalid UTF-8 in one is refused: the first would
/// command another robot, or all of them. Errors: ErrorKind::kUsage.
[[nodiscard]] Result<RobotAddress> ParseRobotAddress(std::string_view text);

/// Whether a robot may have these names, as they stand in a topic.
[[nodiscard]] bool IsAddressable(const RobotAddress& robot);

/// Whether the robot's names are no target as they are, so that ToString() writes them otherwise.
[[nodiscard]] bool IsWrittenOtherwise(const RobotAddress& robot);

/// The byte that `%` and two hexadecimal digits at the front stand for.
[[nodiscard]] std::optional<char> PercentByte(std::string_view text);
[[nodiscard]] std::string Unescaped(std::string_view text);  ///< with these bytes in their places

/// The serial number's characters that the specification allows: A-Z a-z 0-9 _ . : -
[[nodiscard]] bool HasRecommendedCharacters(std::string_view text);

/// How topics are formed. Placeholders: {interface} {major} {manufacturer} {serial} {topic}. A template
/// without {manufacturer} is for robots that are named; one without {topic} fixes the topic of
/// commands, and no other is known then.
struct TopicScheme {
  std::string interface_name;  ///< empty: the version's own
  std::string topic_template = "{interface}/{major}/{manufacturer}/{serial}/{topic}";

  [[nodiscard]] bool Names(std::string_view placeholder) const {
    return topic_template.find(placeholder) != std::string::npos;
  }
  bool operator==(const TopicScheme&) const = default;
};

/// Whether it is one level of a topic, as an interface is. Errors: ErrorKind::kUsage.
[[nodiscard]] Status CheckInterface(std::string_view name);

/// The full topic: `vda5050/v3/KIT/0001/instantActions`. A template with an unknown placeholder,
/// without {serial}, and a topic with a wildcard, an
/// empty level or more than 65,535 bytes are refused: ErrorKind::kUsage.
[[nodiscard]] Result<std::string> TopicFor(const TopicScheme& scheme, Version version,
                                           const RobotAddress& robot, std::string_view topic);

}  // namespace fleetpub::vda5050
