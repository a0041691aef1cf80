#include "cli/options/wait_options.h"

#include <fmt/format.h>

#include "base/text.h"
#include "base/time.h"
#include "cli/listening.h"
#include "cli/parser/option_set.h"

namespace fleetpub::cli {
namespace {

constexpr const char* kWaiting = "Waiting";

Result<std::optional<vda5050::WaitFor>> ParseWaitFor(const WaitingOptions& options) {
  using Result = fleetpub::Result<std::optional<vda5050::WaitFor>>;
  if (options.wait_for.empty()) {
    return options.wait ? Result(vda5050::WaitFor::kFinished) : Result(std::nullopt);
  }
  if (base::EqualsIgnoringCase(options.wait_for, "finished")) return vda5050::WaitFor::kFinished;
  if (base::EqualsIgnoringCase(options.wait_for, "accepted")) return vda5050::WaitFor::kAccepted;
  return Fail(ErrorKind::kUsage, fmt::format("--wait-for takes accepted or finished, not '{}'",
                                             base::Printable(options.wait_for)));
}

}  // namespace

void DeclareWaitOptions(OptionSet& set, WaitingOptions& options) {
  set.AddFlag("-w,--wait", options.wait, "Wait until the robot says so (--wait-for)")
      .Group(kWaiting);
  set.AddOption(
         "--wait-for", options.wait_for,
         "accepted: the robot lists it; finished: it is done [orders: accepted, else finished]")
      .Type("END")
      .Group(kWaiting);
  set.AddOption("-W,--timeout", options.timeout,
                "How long to wait in total [35s to be seen, then 10m]")
      .Type("TIME")
      .Group(kWaiting);
}

void DeclareWaitingOptions(OptionSet& set, WaitingOptions& options) {
  DeclareWaitOptions(set, options);
  set.AddOption("--resend", options.resend,
                "Send again up to N times what no robot has seen, with the same actionId [0]")
      .Type("N")
      .InRange(0, 100)
      .Group(kWaiting);
  DeclareCheckOptions(set, options);
}

void DeclareCheckOptions(OptionSet& set, WaitingOptions& options) {
  set.AddFlag("--check", options.check,
              "Look first whether the robot is online and supports the action [the default]")
      .Group(kWaiting);
  set.AddFlag("--no-check", options.no_check,
              "Send unchecked; with a version stated, without asking the broker anything")
      .Group(kWaiting);
  set.bindings().Bind("tidy",
                      set.AddFlag("--tidy", options.tidy,
                                  "With --wait: clear the robot's list of instant actions "
                                  "afterwards (3.0) [when it is full]")
                          .Group(kWaiting),
                      &options.tidy);
  set.AddOption("--discover", options.discover,
                "Silence in ms after which a retained message is not there [300]; five times as "
                "long for the states of robots that are not online")
      .Type("MS")
      .Group(kWaiting);
}

Result<app::Waiting> ParseWaitingOptions(const WaitingOptions& options) {
  app::Waiting waiting;
  const auto wait_for = ParseWaitFor(options);
  if (!wait_for) return Fail(wait_for.error());
  waiting.wait_for = *wait_for;
  if (!waiting.wait_for && (!options.timeout.empty() || options.resend > 0)) {
    return Fail(ErrorKind::kUsage, "--timeout and --resend belong to waiting: add --wait");
  }
  if (!options.timeout.empty()) {
    const auto total = base::ParseDuration(options.timeout);
    if (!total) return Fail(total.error());
    waiting.wait.total = *total;
  }
  waiting.wait.resend = options.resend;
  if (options.check && options.no_check) {
    return Fail(ErrorKind::kUsage, "--check and --no-check exclude each other");
  }
  waiting.check = !options.no_check;
  waiting.tidy = options.tidy;
  const auto discover = ParseDiscover(options.discover);
  if (!discover) return Fail(discover.error());
  waiting.discover = *discover;
  return waiting;
}

}  // namespace fleetpub::cli
