// The later stages of a command's way, the same for robots and SoAR: validate, then show what would
// be sent, or send it, track the responses and report.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/environment.h"
#include "app/observer.h"
#include "base/result.h"
#include "delivery/pending_commands.h"
#include "delivery/rate_limiter.h"
#include "delivery/send_all.h"
#include "message/command.h"
#include "mqtt/transport.h"
#include "schema/schema.h"

namespace fleetpub::app {

/// How commands are sent.
struct SendSettings {
  bool dry_run = false;
  bool offline = false;  ///< a dry run that asks no broker
  bool agreed = false;   ///< many robots may be commanded unasked
  mqtt::Qos qos = mqtt::Qos::kAtMostOnce;
  delivery::RateLimiter rate;
};

/// Says what an acknowledgement is worth when nobody waits for the robots: over MQTT 3.1.1 a broker
/// has no word for no (§3.3.5.2).
void WarnOfSilentRefusals(mqtt::ProtocolVersion version, mqtt::Qos qos, Log& log);

/// Checks a command and returns what is to be warned of, with its target's name before it. Errors:
/// kInvalid, naming the target.
[[nodiscard]] Result<std::vector<std::string>> ValidateCommand(const message::Command& command,
                                                               schema::Registry& registry);

/// Sends what the source makes over the link, and waits for the ends when `wait` is there. `ended`
/// gets each report too; it may be empty. Errors: as delivery::SendAll's.
[[nodiscard]] Status Deliver(delivery::CommandSource& source, Link& link, ledger::Ledger& ledger,
                             const SendSettings& settings,
                             const std::optional<delivery::WaitOptions>& wait, Observer& observer,
                             const delivery::ReportSink& ended = {});

/// Sends these over a link that serves something else, and tells only `report` of them.
/// `link.transport` is null afterwards if that has cost the connection. Errors: as
/// delivery::SendAll's.
[[nodiscard]] Status SendBeside(std::span<const message::Command> commands, Link& link,
                                ledger::Ledger& ledger, const delivery::SendOptions& send,
                                const delivery::WaitOptions& wait,
                                const delivery::ReportSink& report, Log& log);

/// Sends all of these commands, or none when one is invalid.
[[nodiscard]] Status SendMessages(const std::vector<message::Command>& commands,
                                  const SendSettings& settings,
                                  const std::optional<delivery::WaitOptions>& wait,
                                  const Environment& environment, Observer& observer);

}  // namespace fleetpub::app
