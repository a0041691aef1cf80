// Whom a command is for: `manufacturer/serialNumber`, and the MQTT topics made of it (VDA 5050 §6.1
// "topic levels").
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "vda5050/version.h"

namespace fleetpub::vda5050 {

struct RobotAddress {
  std::string manufacturer;
  std::string serial_number;

  /// `KIT/0001`
  [[nodiscard]] std::string ToString() const { return manufacturer + "/" + serial_number; }
  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy takes the 0 that it implies for a pointer.
  friend auto operator<=>(const RobotAddress&, const RobotAddress&) = default;
};

/// Parses `manufacturer/serialNumber`. An empty level, `/ + # $`, a control character or invalid
/// UTF-8 in one is refused: the first would command another robot, or all of them. Errors:
/// ErrorKind::kUsage.
[[nodiscard]] Result<RobotAddress> ParseRobotAddress(std::string_view text);

/// The serial number's characters that the specification allows: A-Z a-z 0-9 _ . : -
[[nodiscard]] bool HasRecommendedCharacters(std::string_view text);

/// How topics are formed. Placeholders: {interface} {major} {manufacturer} {serial} {topic}.
struct TopicScheme {
  std::string interface_name;  ///< empty: the version's own
  std::string topic_template = "{interface}/{major}/{manufacturer}/{serial}/{topic}";

  bool operator==(const TopicScheme&) const = default;
};

/// The full topic: `vda5050/v3/KIT/0001/instantActions`. A template with an unknown placeholder,
/// without {topic} or without one of {manufacturer} and {serial}, and a topic with a wildcard, an
/// empty level or more than 65,535 bytes are refused: ErrorKind::kUsage.
[[nodiscard]] Result<std::string> TopicFor(const TopicScheme& scheme, Version version,
                                           const RobotAddress& robot, std::string_view topic);

}  // namespace fleetpub::vda5050
