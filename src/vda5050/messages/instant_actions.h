// Builds instantActions messages (VDA 5050 1.1–2.1 §6.7 and §6.8, 3.0 §6.3 and §7.3).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "message/command.h"
#include "vda5050/catalogue/parameter.h"
#include "vda5050/model/robot_address.h"
#include "vda5050/model/version.h"

namespace fleetpub::vda5050 {

/// One action to be done at once.
struct InstantAction {
  std::string type;
  std::string id;             ///< `actionId`
  std::string descriptor;     ///< `actionDescription`, from 3.0 `actionDescriptor`; empty: left out
  std::string blocking_type;  ///< empty: NONE
  std::vector<Parameter> parameters;
};

/// How one robot is spoken to.
struct Dialect {
  Version version = Version::k300;
  bool assumed = false;  ///< the version is a default that nobody stated
  TopicScheme topics;
  std::string actions_key;  ///< `actions` or `instantActions`; empty: the version's own
  /// What the header says where it differs from version and topic; empty: it does not.
  std::string header_version;
  std::string header_manufacturer;
  std::string header_serial;
  /// What the robot's header says when that is no release, so that the version was chosen.
  std::string version_said;

  bool operator==(const Dialect&) const = default;
};

/// The message with holes for header id and timestamp, its topic, schema and text rules. An action
/// is named as the version names it (`initPosition`, `initializePosition`), with a warning when
/// that differs from `type`. Whether the message is valid is found by delivery::Validate. Errors:
/// ErrorKind::kUsage (topic).
[[nodiscard]] Result<message::Command> BuildInstantActions(
    const RobotAddress& robot, const Dialect& dialect, std::span<const InstantAction> actions,
    std::optional<std::uint32_t> header_id = std::nullopt);

/// One action as JSON, under this name: alike in instantActions and orders.
[[nodiscard]] std::string WriteAction(const InstantAction& action, std::string_view type,
                                      const VersionFacts& facts);

/// Whether the robot may be one of those of 2.0 that expect the array under 1.1's name: nobody has
/// said how it is called.
[[nodiscard]] inline bool MayExpectOtherKey(const Dialect& dialect) {
  return dialect.version == Version::k200 && dialect.actions_key.empty();
}

/// Tells of a robot whose version had to be chosen.
void WarnOfNoRelease(const Dialect& dialect, std::vector<std::string>& warnings);

}  // namespace fleetpub::vda5050
