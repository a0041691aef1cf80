// Makes the commands for chosen robots, some at a time: checks each robot, builds and validates its
// message, and adds how its end is recognised.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "cli/robot_sending.h"
#include "cli/roll_call.h"
#include "message/command.h"
#include "message/report.h"
#include "schema/schema.h"

namespace fleetpub::cli {

class CommandMaker {
 public:
  /// `sending` must outlive it.
  CommandMaker(const RobotSending& sending, const Context& context)
      : sending_(sending), registry_(context.options.schema_directory) {}

  /// Whether robots are checked before they are commanded.
  void SetCheck(bool check) { check_ = check; }

  /// What to say of a robot that nothing is known of: `did you mean KIT/0001?`
  void Suggest(const vda5050::RobotAddress& robot, std::string suggestion) {
    suggestions_[robot] = std::move(suggestion);
  }

  /// Whether the message is valid in every dialect that these robots are spoken to in, before
  /// anything is sent. When a word stands for several, it is enough that it is valid in one: robots
  /// of the others are refused one by one. Errors: ErrorKind::kInvalid, kUsage.
  [[nodiscard]] Status Judge(const std::vector<const ListedRobot*>& robots);

  struct Made {
    std::vector<message::Command> commands;
    std::vector<message::Report> refused;
    std::vector<std::string> warnings;
  };
  /// Adds to `made`. Errors: what an option's value makes impossible for all.
  [[nodiscard]] Status Make(const ListedRobot& robot, Made& made);

  /// A report on a robot that gets nothing.
  [[nodiscard]] message::Report ReportOn(const ListedRobot& robot, message::CommandStatus status,
                                         ErrorKind kind, std::string message) const;

 private:
  [[nodiscard]] vda5050::PreflightFindings FindingsOn(const ListedRobot& robot,
                                                      const RobotMessage& message) const;
  [[nodiscard]] std::shared_ptr<const vda5050::Dialect> DialectFor(const ListedRobot& robot);
  Status AddCommand(const ListedRobot& robot, const RobotMessage& message, bool is_offline,
                    Made& made);

  const RobotSending& sending_;
  schema::Registry registry_;
  bool check_ = false;
  std::map<vda5050::RobotAddress, std::string> suggestions_;
  /// Checked ones are no assumption any more.
  std::map<const vda5050::Dialect*, std::shared_ptr<const vda5050::Dialect>> checked_;
};

}  // namespace fleetpub::cli
