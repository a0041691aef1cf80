#include "cli/options/sending_options.h"

#include "cli/parser/option_set.h"
#include "config/config_settings.h"

namespace fleetpub::cli {
void DeclareSendingOptions(OptionSet& set, SendingOptions& options) {
  constexpr const char* kSending = "Sending";
  set.AddFlag("-n,--dry-run", options.dry_run,
              "Print the message that would be sent; send nothing, use no header id")
      .Group(kSending);
  DeclareQos(set, options.qos);
}

void DeclareOffline(OptionSet& set, SendingOptions& options) {
  set.AddFlag("--offline", options.offline,
              "With --dry-run: do not ask the broker how the robot is spoken to")
      .Group("Sending");
}

void DeclareManyOptions(OptionSet& set, SendingOptions& options) {
  DeclareOffline(set, options);
  set.AddFlag("-y,--yes", options.yes, "Send to many robots without asking").Group("Sending");
  DeclareRate(set, options);
}

void DeclareRate(OptionSet& set, SendingOptions& options) {
  set.AddOption("--rate", Rate(options.rate), "At most so many messages per second [no limit]")
      .Group("Sending");
}

void DeclareQos(OptionSet& set, mqtt::Qos& qos) {
  set.AddOption("-q,--qos", OneOf(qos, config::kQos),
                "0: handed to the network; 1, 2: acknowledged by the broker [0]")
      .Type("QOS")
      .Variable("FLEETPUB_QOS")
      .Group("Sending")
      .Key("qos");
}

Result<app::SendSettings> ParseSendingOptions(const SendingOptions& options) {
  if (options.offline && !options.dry_run) {
    return Fail(ErrorKind::kUsage,
                "--offline needs --dry-run: to send without asking the broker, state the version "
                "and add --no-check");
  }
  return app::SendSettings{
      .dry_run = options.dry_run,
      .offline = options.offline,
      .agreed = options.yes,
      .qos = options.qos,
      .rate = options.rate ? delivery::RateLimiter(*options.rate) : delivery::RateLimiter()};
}

}  // namespace fleetpub::cli
