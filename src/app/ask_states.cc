#include "app/ask_states.h"

#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "app/command_factory.h"
#include "app/deliver.h"
#include "base/text.h"

namespace fleetpub::app {
namespace {

// Nobody is refused loudly: a robot that is not asked sends its state all the same, only later.
std::vector<message::Command> MakeRequests(std::span<const ListedRobot* const> robots,
                                           const Link& link, const Environment& environment,
                                           Log& log) {
  CommandFactory factory(environment.schema_directory);
  factory.SetLook(true, link.transport->server(), environment.config.profile);
  CommandFactory::Built built;
  for (const ListedRobot* robot : robots) {
    if (!robot->second.IsAlive()) continue;
    const auto message = MakeInstantMessage({.type = std::string(kStateRequest)}, false);
    auto ok = factory.Build(*robot, {.message = *message, .header_id = {}, .wait_for = {}}, built);
    if (!ok) log.Debug(ok.error().message);
  }
  for (const message::Report& refused : built.refused) {
    log.Debug(fmt::format("{}: not asked for its state: {}", base::Printable(refused.target),
                          refused.message));
  }
  return std::move(built.commands);
}

}  // namespace

void AskForStates(std::span<const ListedRobot* const> robots, std::chrono::milliseconds patience,
                  Link& link, const Environment& environment, Log& log) {
  const auto requests = MakeRequests(robots, link, environment, log);
  if (requests.empty()) return;
  const auto ledger = environment.ledger(ledger::OpenMode::kCreate);
  if (!ledger) {
    return log.Warn("no robot was asked for its state: " + ledger.error().message);
  }
  const delivery::ReportSink report = [&](const message::Report& done) {
    if (!done.error) return;
    log.Warn(
        fmt::format("{}: not asked for its state: {}", base::Printable(done.target), done.message));
  };
  const auto sent =
      SendBeside(requests, link, **ledger,
                 {.lock_timeout = patience, .acknowledge_timeout = patience}, {}, report, log);
  if (!sent) {
    log.Warn("no robot was asked for its state: " + sent.error().message);
  }
}

}  // namespace fleetpub::app
