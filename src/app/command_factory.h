// Makes the commands for chosen robots, some at a time: checks each robot, builds and validates its
// message, and adds how its end is recognised.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/dialect_resolver.h"
#include "app/environment.h"
#include "app/robot_discovery.h"
#include "app/robot_messages.h"
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

/// Whether robots are checked before, and how long they are waited for afterwards.
struct Waiting {
  std::optional<vda5050::WaitFor> wait_for;  ///< nothing: do not wait
  delivery::WaitOptions wait;
  bool check = true;
  bool tidy = false;  ///< see TidyUp
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
  /// Robots are asked for their states where the message is made of them.
  bool ask = true;
};

/// What one of them is to be told.
struct RobotRequest {
  RobotMessage& message;
  std::optional<std::uint32_t> header_id;
  std::optional<vda5050::WaitFor> wait_for;  ///< nothing: do not wait
};

class CommandFactory {
 public:
  explicit CommandFactory(const std::string& schema_directory) : registry_(schema_directory) {}

  /// This broker is asked of the robots; `check`: else only how each is spoken to is wanted. Without,
  /// nothing is known of any robot and nothing is checked.
  void SetLook(bool check, const mqtt::ServerInfo& server, const std::string& profile) {
    brokers_ = server.ListSite();
    look_ = {check, FormatSite(server.broker, profile), server.KeepsNothing()};
  }

  /// Looks for robots that are ONLINE and may be meant by those of whom nothing is known: `did you
  /// mean KIT/0001?` Not for more than twenty.
  void SuggestNames(std::span<const ListedRobot* const> robots, mqtt::Transport& transport,
                    const vda5050::TopicScheme& scheme, const delivery::RetainedOptions& discover);

  /// Whether the message is valid in every dialect that these robots are spoken to in, before
  /// anything is sent. When a word stands for several, it is enough that it is valid in one: robots
  /// of the others are refused one by one. Errors: ErrorKind::kInvalid, kUsage.
  [[nodiscard]] Status Validate(const CommandRequest& request,
                                const std::vector<const ListedRobot*>& robots);
  /// Whether it is valid in any version, where these robots' own are not known yet. Errors: the same,
  /// of the newest version.
  [[nodiscard]] Status ValidateInAnyVersion(const CommandRequest& request,
                                            const std::vector<const ListedRobot*>& robots);

  struct Built {
    std::vector<message::Command> commands;
    std::vector<message::Report> refused;
    std::vector<std::string> warnings;
    std::vector<std::string> notes;  ///< what a person wants to know of what is sent
  };
  /// Adds to `built`. Errors: what an option's value makes impossible for all.
  [[nodiscard]] Status Build(const ListedRobot& robot, const RobotRequest& request, Built& built);

  /// A report on a robot that gets nothing.
  [[nodiscard]] static message::Report ReportOn(const ListedRobot& robot,
                                                const RobotRequest& request,
                                                message::CommandStatus status, ErrorKind kind,
                                                std::string message);

 private:
  struct Look {
    bool check = false;
    std::string site;
    bool keeps_nothing = false;
  };

  /// What is to be warned of in the message; nothing of it is kept. Errors: it is not valid.
  [[nodiscard]] Result<std::vector<std::string>> Try(const RobotMessage& message,
                                                     const vda5050::RobotAddress& robot,
                                                     const vda5050::Dialect& dialect,
                                                     std::optional<std::uint32_t> header_id);
  [[nodiscard]] vda5050::PreflightFindings FindingsOn(const ListedRobot& robot,
                                                      const RobotMessage& message) const;
  [[nodiscard]] vda5050::PreflightFindings FindingsOnUnknown(const ListedRobot& robot,
                                                             const RobotMessage& message) const;
  Status AddCommand(const ListedRobot& robot, const RobotRequest& request, bool is_offline,
                    Built& built);

  schema::Registry registry_;
  std::optional<Look> look_;
  std::vector<std::string> brokers_;  // as ServerInfo::ListSite; none: none was asked
  std::map<vda5050::RobotAddress, std::string> suggestions_;
};

}  // namespace fleetpub::app
