// The way of a command from the command line's side: validate, then show it (dry run) or send and
// report it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "cli/exit_code.h"
#include "cli/global_options.h"
#include "dispatch/command.h"
#include "dispatch/follow.h"
#include "dispatch/report.h"

namespace fleetpub::cli {

class OptionSet;

struct SendingOptions {
  bool dry_run = false;
  std::string qos = "0";
  bool yes = false;  ///< a group may be commanded unasked
};

void DeclareSendingOptions(OptionSet& set, SendingOptions& options);
/// `--yes`, where a target may be a group.
void DeclareYes(OptionSet& set, SendingOptions& options);
/// `--qos` alone.
void DeclareQos(OptionSet& set, std::string& qos);

/// Errors: ErrorKind::kUsage.
[[nodiscard]] Result<mqtt::Qos> QosOf(const std::string& text);

/// What is to be sent, and how.
struct Outgoing {
  std::vector<dispatch::Command> commands;
  bool validated = false;
  std::vector<dispatch::Report> refused;       ///< by the preflight: reported, not sent
  std::optional<dispatch::WaitOptions> wait;   ///< for the commands' confirmations
  std::unique_ptr<mqtt::Transport> transport;  ///< when one is open already
};

/// Says what an acknowledgement is worth when nobody waits for the robots: over MQTT 3.1.1 a broker
/// has no word for no (§3.3.5.2).
void WarnOfSilentRefusals(mqtt::ProtocolVersion version, mqtt::Qos qos, Output& output);

/// Checks every command and returns what is to be warned of. Errors: kInvalid, naming the first
/// target that is concerned.
[[nodiscard]] Result<std::vector<std::string>> ValidateAll(
    const std::vector<dispatch::Command>& commands, const Context& context);

/// Sends all of the commands, or none when one of them is invalid. Prints a result for each.
[[nodiscard]] Result<ExitCode> SendCommands(Outgoing outgoing, const SendingOptions& options,
                                            const Context& context);

/// When nothing at all was sent, a person reads one sentence, a script an object per target.
[[nodiscard]] Error NothingSent(const std::vector<dispatch::Command>& commands,
                                dispatch::Verdict verdict, Error error, const Context& context);

}  // namespace fleetpub::cli
