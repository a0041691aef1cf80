#include "app/tidy_up.h"

#include <fmt/format.h>

#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include "app/command_factory.h"
#include "app/deliver.h"
#include "base/text.h"

namespace fleetpub::app {
namespace {

using message::Kept;

constexpr std::string_view kClear = "clearInstantActions";
constexpr std::chrono::seconds kPatience{10};

// Nothing when this robot has no such list.
Result<std::optional<message::Command>> CommandFor(const ListedRobot& robot,
                                                   CommandFactory& factory) {
  const vda5050::RobotEntry& entry = robot.second;
  if (entry.Spoken()->version < vda5050::Version::k300) return std::nullopt;
  if (entry.factsheet && !entry.factsheet->actions.empty() &&
      vda5050::FindAction(*entry.factsheet, kClear) == nullptr) {
    return Fail(ErrorKind::kPreflight, fmt::format("its factsheet does not list {}", kClear));
  }
  const auto message = MakeInstantMessage({.type = std::string(kClear)}, false);
  CommandFactory::Built built;
  auto ok = factory.Build(robot, {*message, {}, vda5050::WaitFor::kFinished}, built);
  if (!ok) return Fail(std::move(ok.error()));
  if (!built.refused.empty()) return Fail(ErrorKind::kInvalid, built.refused.front().message);
  return std::move(built.commands.front());
}

}  // namespace

void TidyUp::Add(const message::Report& report) {
  if (report.status == message::CommandStatus::kOffline) return;  // nobody would answer
  if (report.kept == Kept::kTooMuch || (is_asked_ && report.kept == Kept::kEntry)) {
    targets_.insert(report.target);
  }
}

void TidyUp::Run(std::span<const ListedRobot* const> robots, Link& link, ledger::Ledger& ledger,
                 mqtt::Qos qos, const std::string& schema_directory, Observer& observer) const {
  if (targets_.empty() || link.transport == nullptr) return;
  const auto warn = [&](std::string_view target, std::string_view why) {
    observer.Warn(fmt::format("{}: its list of instant actions was not cleared: {}",
                              base::Printable(target), why));
  };
  CommandFactory factory(schema_directory);
  std::vector<message::Command> commands;
  for (const ListedRobot* robot : robots) {
    const std::string target = robot->first.ToString();
    if (!targets_.contains(target)) continue;
    auto command = CommandFor(*robot, factory);
    if (!command) {
      warn(target, command.error().message);
    } else if (*command) {
      commands.push_back(**std::move(command));
    }
  }
  const auto report = [&](const message::Report& done) {
    if (done.status == message::CommandStatus::kFinished) {
      observer.Info(
          fmt::format("{}: cleared its list of instant actions", base::Printable(done.target)));
    } else {
      warn(done.target, fmt::format("{}  {}", GetName(done.status), done.message));
    }
  };
  const auto sent = SendBeside(commands, link, ledger,
                               {.qos = qos, .acknowledge_timeout = link.connection.timeout},
                               {.total = kPatience}, report, observer);
  if (!sent) {
    observer.Warn(
        fmt::format("lists of instant actions were not cleared: {}", sent.error().message));
  }
}

}  // namespace fleetpub::app
