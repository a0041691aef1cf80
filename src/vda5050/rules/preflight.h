// Whether a robot can be expected to obey a command, from what it has said about itself: refused
// by us it costs nothing, refused by the robot it costs a person's time. A pure function: it waits
// for nothing and asks nobody.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "vda5050/messages/instant_actions.h"
#include "vda5050/model/robot_address.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::vda5050 {

/// What is known of a robot. Whatever is missing is not checked, but for the connection message: a
/// robot without one has to send states.
struct KnownRobot {
  std::optional<ConnectionMessage> connection;
  std::string topic;         ///< of that, or of what else told how it is spoken to
  std::string said_version;  ///< that this message names; of `connection` its header tells
  bool speaks = false;       ///< it sends states, whatever its connection message says
  std::string other_topic;   ///< where another one stands that may as well be the living one
  std::shared_ptr<const Factsheet> factsheet;  ///< robots of one make share it; may be null
  std::string factsheet_fault;                 ///< why it cannot be read
  std::string operating_mode;                  ///< of a live state, normalised; empty: not known
};

/// One sentence each, with the reason and the option that overrides it, without a full stop at its
/// end. Sent only when nothing is refused.
struct PreflightFindings {
  std::vector<std::string> refusals;
  std::vector<std::string> warnings;
  /// It is not ONLINE, and so will not answer (for stopHibernation: it is not HIBERNATING).
  bool unreachable = false;
};

/// Checks the actions of one message, in this order: is the robot ONLINE or sends states, does it speak
/// the dialect's version (not checked when the dialect has a header version of its own) at the
/// dialect's topics, does its mode allow instant actions (the table of operatingMode), does its
/// factsheet list the actions with scope INSTANT and with these parameters, do its limits hold.
/// `payload_bytes` is the message's length, 0 when it is not known. startPause is not refused for
/// the robot's connection state or mode, only warned about.
[[nodiscard]] PreflightFindings CheckRobot(const RobotAddress& robot, const Dialect& dialect,
                                           std::span<const InstantAction> actions,
                                           const KnownRobot& known, std::size_t payload_bytes = 0);

/// Whether to stop is all that they ask: that is never held back.
[[nodiscard]] bool IsOnlyStartPause(std::span<const InstantAction> actions);

/// Whether a factsheet tells anything of these actions: every robot shall know those of stopping.
[[nodiscard]] bool NeedsFactsheet(std::span<const InstantAction> actions);

/// `KIT/0001 is ONLINE at … and at …`: of a robot that lives at two topics, or two of one name.
[[nodiscard]] std::optional<std::string> RivalText(const RobotAddress& robot,
                                                   const KnownRobot& known);

/// An actionId that the robot takes: a random UUID, or a random decimal number when its factsheet
/// allows only numbers or is too short for a UUID (`idNumericalOnly`, `idLen`, `maximumIdLength`).
/// `factsheet` may be null.
[[nodiscard]] std::string MakeActionId(const Factsheet* factsheet);

}  // namespace fleetpub::vda5050
