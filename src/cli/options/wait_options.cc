#include "cli/options/wait_options.h"

#include <array>

#include "cli/listening.h"
#include "cli/parser/option_set.h"

namespace fleetpub::cli {
namespace {

constexpr const char* kWaiting = "Waiting";

constexpr auto kEnds = std::to_array<base::Choice<vda5050::WaitFor>>({
    {"accepted", vda5050::WaitFor::kAccepted},
    {"finished", vda5050::WaitFor::kFinished},
});

}  // namespace

void DeclareWaitOptions(OptionSet& set, WaitingOptions& options) {
  set.AddFlag("-w,--wait", options.wait, "Wait until the robot says so (--wait-for)")
      .Group(kWaiting);
  set.AddOption("--wait-for", OneOf(options.wait_for, kEnds),
                "accepted: the robot lists it; finished: it is done [publish order: accepted, else "
                "finished]")
      .Type("END")
      .Group(kWaiting);
  set.AddOption("-W,--timeout", Duration(options.timeout),
                "How long to wait in total [35s to be seen, then 10m; order 1h]")
      .Group(kWaiting);
}

void DeclareWaitingOptions(OptionSet& set, WaitingOptions& options) {
  DeclareWaitOptions(set, options);
  set.AddOption("--resend", WholeNumber(options.resend, 0, 100),
                "Send again up to N times what no robot has seen, with the same actionId [0]")
      .Group(kWaiting);
  DeclareCheckOptions(set, options);
}

void DeclareCheckOptions(OptionSet& set, WaitingOptions& options) {
  set.AddFlag("--check", options.check,
              "Check first that the robot is online and supports the action [the default]")
      .Group(kWaiting);
  set.AddFlag("--no-check", options.no_check,
              "Send unchecked; with a version stated, without asking the broker anything")
      .Group(kWaiting);
  set.AddFlag("--tidy", options.tidy,
              "With --wait: clear the robot's list of instant actions afterwards (3.0) [when it is "
              "full]")
      .Group(kWaiting)
      .Key("tidy");
  DeclareDiscover(set, options.discover,
                  "; five times as long for the states of robots that are not online");
}

Result<app::Waiting> ParseWaitingOptions(const WaitingOptions& options) {
  app::Waiting waiting;
  waiting.wait_for = options.wait_for;
  if (!waiting.wait_for && options.wait) waiting.wait_for = vda5050::WaitFor::kFinished;
  if (!waiting.wait_for && (options.timeout || options.resend > 0)) {
    return Fail(ErrorKind::kUsage, "--timeout and --resend need --wait");
  }
  waiting.wait.total = options.timeout;
  waiting.wait.resend = options.resend;
  if (options.check && options.no_check) {
    return Fail(ErrorKind::kUsage, "--check and --no-check exclude each other");
  }
  waiting.check = !options.no_check;
  waiting.tidy = options.tidy;
  waiting.discover = MakeRetainedOptions(options.discover);
  return waiting;
}

}  // namespace fleetpub::cli
