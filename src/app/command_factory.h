// Makes the commands for chosen robots, some at a time: checks each robot, builds and validates its
// message, and adds how its end is recognised.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/dialect_resolver.h"
#include "app/robot_discovery.h"
#include "app/targets.h"
#include "base/result.h"
#include "delivery/pending_commands.h"
#include "delivery/retained.h"
#include "message/command.h"
#include "message/report.h"
#include "schema/schema.h"
#include "vda5050/messages/instant_actions.h"
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
      const message::Command& command, vda5050::WaitFor wait_for) const = 0;
  /// Whether all it asks is to stop: that goes to a robot of which nothing is known, too.
  [[nodiscard]] virtual bool IsOnlyStartPause() const { return false; }
  /// Whether a factsheet tells anything of it.
  [[nodiscard]] virtual bool NeedsFactsheet() const { return true; }
  /// Whether, in one dialect, it is valid for every robot or for none.
  [[nodiscard]] virtual bool IsAlikeForAll() const { return false; }
  /// The robot's limits, before it is built for the last time.
  virtual void ApplyLimits(const vda5050::Factsheet& /*factsheet*/) {}
};

/// Whether robots are checked before, and how long they are waited for afterwards.
struct Waiting {
  std::optional<vda5050::WaitFor> wait_for;  ///< nothing: do not wait
  delivery::WaitOptions wait;
  bool check = true;
  delivery::RetainedOptions discover;
};

/// What some robots are to be told.
struct CommandRequest {
  Targets targets;
  DialectResolver resolver;
  std::string title;  ///< what they are told: `stopPause`, `order`
  NeedsConsent needs_consent = NeedsConsent::kYes;
  std::optional<std::uint32_t> header_id;
  std::function<std::unique_ptr<RobotMessage>()> make_message;  ///< one for each robot
  Waiting waiting;
};

class CommandFactory {
 public:
  /// `request` must outlive it.
  CommandFactory(const CommandRequest& request, const std::string& schema_directory)
      : request_(request), registry_(schema_directory) {}

  /// How the broker was asked. Without, nothing is known of any robot and nothing is checked.
  struct Look {
    bool check = false;      ///< else only how each is spoken to is wanted
    std::string site;        ///< where: `mqtts://north (profile north)`
    std::string why_nobody;  ///< why it may know nobody; empty: no reason is known
  };
  void SetLook(Look look) { look_ = std::move(look); }

  /// What to say of a robot that nothing is known of: `did you mean KIT/0001?`
  void Suggest(const vda5050::RobotAddress& robot, std::string suggestion) {
    suggestions_[robot] = std::move(suggestion);
  }

  /// Whether the message is valid in every dialect that these robots are spoken to in, before
  /// anything is sent. When a word stands for several, it is enough that it is valid in one: robots
  /// of the others are refused one by one. Errors: ErrorKind::kInvalid, kUsage.
  [[nodiscard]] Status Validate(const std::vector<const ListedRobot*>& robots);
  /// Whether it is valid in any version, where these robots' own are not known yet. Errors: the same,
  /// of the newest version.
  [[nodiscard]] Status ValidateInAnyVersion(const std::vector<const ListedRobot*>& robots);

  struct Built {
    std::vector<message::Command> commands;
    std::vector<message::Report> refused;
    std::vector<std::string> warnings;
  };
  /// Adds to `built`. Errors: what an option's value makes impossible for all.
  [[nodiscard]] Status Build(const ListedRobot& robot, Built& built);

  /// A report on a robot that gets nothing.
  [[nodiscard]] message::Report ReportOn(const ListedRobot& robot, message::CommandStatus status,
                                         ErrorKind kind, std::string message) const;

 private:
  [[nodiscard]] vda5050::PreflightFindings FindingsOn(const ListedRobot& robot,
                                                      const RobotMessage& message) const;
  [[nodiscard]] vda5050::PreflightFindings FindingsOnUnknown(const ListedRobot& robot,
                                                             const RobotMessage& message) const;
  Status AddCommand(const ListedRobot& robot, const RobotMessage& message, bool is_offline,
                    Built& built);

  const CommandRequest& request_;
  schema::Registry registry_;
  std::optional<Look> look_;
  std::map<vda5050::RobotAddress, std::string> suggestions_;
};

}  // namespace fleetpub::app
