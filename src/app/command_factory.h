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
      vda5050::WaitFor wait_for) const = 0;
  /// Whether, in one dialect, it is valid for every robot or for none.
  [[nodiscard]] virtual bool IsAlikeForAll() const { return false; }
  /// The robot's limits, before it is built for the last time.
  virtual void ApplyLimits(const vda5050::Factsheet& /*factsheet*/) {}
};

/// Whether robots are looked at before, and how long they are waited for afterwards.
struct Waiting {
  std::optional<vda5050::WaitFor> wait_for;  ///< nothing: do not wait
  delivery::WaitOptions wait;
  bool check = false;
  bool no_check = false;  ///< said outright
  bool tidy = false;      ///< see TidyUp
  delivery::RetainedOptions discover;
};

/// What some robots are to be told.
struct CommandRequest {
  Targets targets;
  DialectResolver resolver;
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

  /// Whether robots are checked before they are commanded.
  void SetCheck(bool check) { check_ = check; }

  /// What to say of a robot that nothing is known of: `did you mean KIT/0001?`
  void Suggest(const vda5050::RobotAddress& robot, std::string suggestion) {
    suggestions_[robot] = std::move(suggestion);
  }

  /// Whether the message is valid in every dialect that these robots are spoken to in, before
  /// anything is sent. When a word stands for several, it is enough that it is valid in one: robots
  /// of the others are refused one by one. Errors: ErrorKind::kInvalid, kUsage.
  [[nodiscard]] Status Validate(const std::vector<const ListedRobot*>& robots);

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
  [[nodiscard]] std::shared_ptr<const vda5050::Dialect> DialectFor(const ListedRobot& robot);
  Status AddCommand(const ListedRobot& robot, const RobotMessage& message, bool is_offline,
                    Built& built);

  const CommandRequest& request_;
  schema::Registry registry_;
  bool check_ = false;
  std::map<vda5050::RobotAddress, std::string> suggestions_;
  /// Checked ones are no assumption any more.
  std::map<const vda5050::Dialect*, std::shared_ptr<const vda5050::Dialect>> checked_;
};

}  // namespace fleetpub::app
