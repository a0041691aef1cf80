// One line of `fleetpub batch`: a command as JSON, made into messages.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/dialect_resolver.h"
#include "app/robot_messages.h"
#include "base/result.h"
#include "message/command.h"
#include "schema/schema.h"
#include "soar/message.h"
#include "vda5050/messages/instant_actions.h"
#include "vda5050/tracking/action_tracker.h"

namespace fleetpub::app {

/// The robot of this address, in the newest version, as stated. Errors: ErrorKind::kUsage.
[[nodiscard]] Result<AddressedRobot> AsWritten(std::string_view word);

/// What holds for a line that does not say otherwise.
struct LineDefaults {
  /// Which robot a target's word means, and how it is spoken to. Errors: ErrorKind::kUsage.
  std::function<Result<AddressedRobot>(std::string_view word)> address = AsWritten;
  bool check = true;                         ///< robots are checked before they are commanded
  bool online = false;                       ///< robots that are offline are left out
  std::optional<vda5050::WaitFor> wait_for;  ///< nothing: do not wait
  /// Somebody has named the end to wait for; else an order is done when the robot has it.
  bool names_end = false;
  soar::Sender soar;
};

/// What is known of a line even when it is wrong.
struct LineOrigin {
  std::string id;      ///< the caller's, as JSON; empty: none
  std::string target;  ///< as written; empty: none, or several
};

/// What one target is to be told.
struct LineCommand {
  std::optional<message::Command> command;  ///< valid; nothing: its robot is to be asked first
  AddressedRobot robot;                     ///< of which these are known, until then
  std::unique_ptr<RobotMessage> message;
  std::optional<std::uint32_t> header_id;
  std::optional<vda5050::WaitFor> wait_for;
  std::string reference;  ///< of its line
  std::size_t line = 0;
};

struct LineCommands {
  std::vector<LineCommand> commands;  ///< one for each target
  std::vector<std::string> warnings;
};

/// Reads lines. Each schema is compiled once.
class LineParser {
 public:
  LineParser(LineDefaults defaults, const std::string& schema_directory);

  /// Errors: ErrorKind::kInvalid, saying what is wrong with the line, and a schema's own trouble.
  [[nodiscard]] Result<LineCommands> Parse(std::string_view text, LineOrigin& origin);

 private:
  template <class Request>
  Result<LineCommands> ForEach(const base::JsonValue& line, const Request& request);
  Status Build(LineCommand& command);
  Status Validate(const message::Command& command, std::vector<std::string>& warnings);

  LineDefaults defaults_;
  schema::Registry registry_;
  TopicOwners owners_;
};

}  // namespace fleetpub::app
