// The way of a command from the command line's side: validate, then show it (dry run) or send and
// report it.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "cli/options/global_options.h"
#include "cli/output/exit_code.h"
#include "delivery/pending_commands.h"
#include "delivery/send_all.h"
#include "message/command.h"
#include "message/report.h"
#include "mqtt/transport.h"
#include "schema/schema.h"

namespace fleetpub::cli {

class OptionSet;

struct SendingOptions {
  bool dry_run = false;
  std::string qos = "0";
  bool yes = false;  ///< many robots may be commanded unasked
  std::string rate;  ///< messages per second; empty: no limit
};

void DeclareSendingOptions(OptionSet& set, SendingOptions& options);
/// `--yes` and `--rate`, where there may be many targets.
void DeclareManyOptions(OptionSet& set, SendingOptions& options);
void DeclareRate(OptionSet& set, SendingOptions& options);
/// `--qos` alone.
void DeclareQos(OptionSet& set, std::string& qos);

/// Errors: ErrorKind::kUsage.
[[nodiscard]] Result<mqtt::Qos> QosOf(const std::string& text);

/// `--rate`. Errors: ErrorKind::kUsage.
[[nodiscard]] Result<delivery::RateLimiter> ParseRate(const std::string& text);

/// What is to be sent, and how.
struct Outgoing {
  std::vector<message::Command> commands;
  std::optional<delivery::WaitOptions> wait;  ///< for the commands' trackers
};

/// How commands are sent over a connection.
struct Delivery {
  mqtt::ConnectOptions connect;  ///< for a connection that is lost
  delivery::SendOptions send;
  std::optional<delivery::WaitOptions> wait;  ///< for the commands' trackers
  delivery::RateLimiter rate;
  delivery::ReportSink report;
  std::function<void()> tick;  ///< see delivery::SendAllOptions
};

/// Sends what the source makes over the open connection, and disconnects. Errors: as
/// delivery::SendAll's.
[[nodiscard]] Status Deliver(delivery::CommandSource& source,
                             std::unique_ptr<mqtt::Transport>& transport, ledger::Ledger& ledger,
                             const Delivery& delivery, Output& output);

[[nodiscard]] Result<std::unique_ptr<mqtt::Transport>> Connect(const mqtt::ConnectOptions& options,
                                                               Output& output);

/// Says what an acknowledgement is worth when nobody waits for the robots: over MQTT 3.1.1 a broker
/// has no word for no (§3.3.5.2).
void WarnOfSilentRefusals(mqtt::ProtocolVersion version, mqtt::Qos qos, Output& output);

/// Checks a command and returns what is to be warned of, with its target's name before it. Errors:
/// kInvalid, naming the target.
[[nodiscard]] Result<std::vector<std::string>> ValidateCommand(const message::Command& command,
                                                               schema::Registry& registry);

/// Sends all of the commands, or none when one of them is invalid. Prints a result for each.
[[nodiscard]] Result<ExitCode> SendCommands(const Outgoing& outgoing, const SendingOptions& options,
                                            const Context& context);

/// When nothing at all was sent, a person reads one sentence, a script an object per target.
[[nodiscard]] Error NothingSent(const std::vector<message::Command>& commands,
                                message::CommandStatus status, Error error, const Context& context);

}  // namespace fleetpub::cli
