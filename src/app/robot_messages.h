// What one robot is to be told: an instant action, or a message of the user's own. Built once it is
// known how the robot is spoken to.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/json.h"
#include "base/result.h"
#include "message/command.h"
#include "message/response_tracker.h"
#include "vda5050/messages/instant_actions.h"
#include "vda5050/messages/user_message.h"
#include "vda5050/reports/robot_directory.h"
#include "vda5050/rules/preflight.h"
#include "vda5050/tracking/action_tracker.h"

namespace fleetpub::app {

/// What one robot is to be told.
class RobotMessage {
 public:
  RobotMessage() = default;
  RobotMessage(const RobotMessage&) = delete;
  RobotMessage& operator=(const RobotMessage&) = delete;
  virtual ~RobotMessage() = default;

  /// Again when the dialect turns out to be another.
  [[nodiscard]] virtual Result<message::Command> Build(
      const vda5050::RobotAddress& robot, const vda5050::Dialect& dialect,
      std::optional<std::uint32_t> header_id) const = 0;
  [[nodiscard]] virtual vda5050::PreflightFindings Check(
      const vda5050::RobotAddress& robot, const vda5050::Dialect& dialect,
      const vda5050::KnownRobot& known) const = 0;
  [[nodiscard]] virtual Result<std::unique_ptr<message::ResponseTracker>> Track(
      const vda5050::RobotAddress& robot, const vda5050::Dialect& dialect,
      vda5050::WaitFor wait_for) const = 0;
  /// Whether all it asks is to stop: that goes to a robot of which nothing is known, too.
  [[nodiscard]] virtual bool IsOnlyStartPause() const { return false; }
  /// Whether a factsheet tells anything of it.
  [[nodiscard]] virtual bool NeedsFactsheet() const { return true; }
  /// Whether, in one dialect, it is valid for every robot or for none.
  [[nodiscard]] virtual bool IsAlikeForAll() const { return false; }
  /// Whether it is made from what the robot says of itself, in Prepare(): nothing can be said of it
  /// before.
  [[nodiscard]] virtual bool IsMadeForRobot() const { return false; }
  /// What was found of the robot, before it is built for the last time, and at which brokers (as
  /// ServerInfo::ListSite; none: none was asked). Adds to `notes` what a person wants to know of it.
  /// Errors: it cannot be made for this robot; nothing is sent to it.
  [[nodiscard]] virtual Status Prepare(const vda5050::ListedRobot& /*robot*/,
                                       const std::vector<std::string>& /*brokers*/,
                                       std::vector<std::string>& /*notes*/) {
    return {};
  }
};

/// One instant action. Unless its actionId was given it gets one that suits the robot's factsheet.
[[nodiscard]] std::unique_ptr<RobotMessage> MakeInstantMessage(vda5050::InstantAction action,
                                                               bool has_given_id);

/// A message of this topic (vda5050::PublishedTopic), as somebody has written it.
[[nodiscard]] std::unique_ptr<RobotMessage> MakeUserMessage(
    std::string_view topic, std::shared_ptr<const base::JsonDocument> message,
    vda5050::HeaderMismatch mismatch);

}  // namespace fleetpub::app
