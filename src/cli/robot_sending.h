// Sends one message to each of some robots, one or a hundred thousand: finds out who is meant,
// learns how each is spoken to where that is asked, checks it, sends, waits.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "app/dialect_resolver.h"
#include "app/targets.h"
#include "base/result.h"
#include "cli/options/wait_options.h"
#include "cli/output/exit_code.h"
#include "cli/sending.h"
#include "message/command.h"
#include "vda5050/messages/instant_actions.h"
#include "vda5050/rules/preflight.h"
#include "vda5050/tracking/action_tracker.h"

namespace fleetpub::cli {

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
  [[nodiscard]] virtual Result<std::unique_ptr<message::ResponseTracker>> Confirm(
      const vda5050::RobotAddress& robot, const vda5050::Dialect& dialect,
      const message::Command& command, vda5050::WaitFor wait_for) const = 0;
  /// Whether, in one dialect, it is valid for every robot or for none.
  [[nodiscard]] virtual bool IsAlikeForAll() const { return false; }
  /// The robot's limits, before it is built for the last time.
  virtual void ApplyLimits(const vda5050::Factsheet& /*factsheet*/) {}
};

struct RobotSending {
  app::Targets targets;
  app::DialectResolver resolver;
  app::NeedsConsent needs_consent = app::NeedsConsent::kYes;
  std::optional<std::uint32_t> header_id;
  std::function<std::unique_ptr<RobotMessage>()> make_message;  ///< one for each robot
  SendingOptions options;
  Waiting waiting;
};

/// Asks who is meant where only the broker knows, and for consent where it is needed, then sends to
/// all of the robots, batch by batch, or to none when the message is invalid. Prints a result for
/// each as it becomes known, and a summary when a word stands for several.
[[nodiscard]] Result<ExitCode> SendToRobots(const RobotSending& sending, const Context& context);

}  // namespace fleetpub::cli
