#include "cli/options/sending_options.h"

#include <fmt/format.h>

#include <charconv>

#include "base/text.h"
#include "cli/parser/option_set.h"

namespace fleetpub::cli {
namespace {

Result<mqtt::Qos> ParseQos(const std::string& text) {
  if (text == "0") return mqtt::Qos::kAtMostOnce;
  if (text == "1") return mqtt::Qos::kAtLeastOnce;
  if (text == "2") return mqtt::Qos::kExactlyOnce;
  return Fail(ErrorKind::kUsage,
              fmt::format("--qos takes 0, 1 or 2, not '{}'", base::Printable(text)));
}

Result<delivery::RateLimiter> ParseRate(const std::string& text) {
  if (text.empty()) return delivery::RateLimiter();
  double rate = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), rate);
  constexpr double kSlowest = 1e-3;
  constexpr double kFastest = 1e6;
  if (error == std::errc() && end == text.data() + text.size() && rate >= kSlowest &&
      rate <= kFastest) {
    return delivery::RateLimiter(rate);
  }
  return Fail(ErrorKind::kUsage, fmt::format("--rate takes messages per second, from 0.001 to "
                                             "1000000, not '{}'",
                                             base::Printable(text)));
}

}  // namespace

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
  set.AddFlag("--yes", options.yes, "Send to many robots without asking").Group("Sending");
  DeclareRate(set, options);
}

void DeclareRate(OptionSet& set, SendingOptions& options) {
  set.AddOption("--rate", options.rate, "At most so many messages per second [no limit]")
      .Type("N")
      .Group("Sending");
}

void DeclareQos(OptionSet& set, std::string& qos) {
  set.bindings().Bind("qos",
                      set.AddOption("-q,--qos", qos,
                                    "0: handed to the network; 1, 2: acknowledged by the broker "
                                    "[0]")
                          .Type("QOS")
                          .Variable("FLEETPUB_QOS")
                          .Group("Sending"),
                      &qos);
}

Result<app::SendSettings> ParseSendingOptions(const SendingOptions& options) {
  const auto qos = ParseQos(options.qos);
  if (!qos) return Fail(qos.error());
  const auto rate = ParseRate(options.rate);
  if (!rate) return Fail(rate.error());
  if (options.offline && !options.dry_run) {
    return Fail(ErrorKind::kUsage,
                "--offline belongs to --dry-run: to send without asking the broker, state the "
                "version and --no-check");
  }
  return app::SendSettings{.dry_run = options.dry_run,
                           .offline = options.offline,
                           .agreed = options.yes,
                           .qos = *qos,
                           .rate = *rate};
}

}  // namespace fleetpub::cli
