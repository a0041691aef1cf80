#include "app/tidy_up.h"

#include <fmt/format.h>

#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include "app/deliver.h"
#include "base/text.h"
#include "delivery/send_all.h"
#include "vda5050/tracking/action_tracker.h"

namespace fleetpub::app {
namespace {

using message::Kept;

constexpr std::string_view kClear = "clearInstantActions";
constexpr std::chrono::seconds kPatience{10};

// Nothing when this robot has no such list.
Result<std::optional<message::Command>> CommandFor(const ListedRobot& robot,
                                                   schema::Registry& registry) {
  const auto& [address, entry] = robot;
  const vda5050::Dialect& dialect = *entry.Spoken();
  if (dialect.version < vda5050::Version::k300) return std::nullopt;
  if (entry.factsheet && !entry.factsheet->actions.empty() &&
      vda5050::FindAction(*entry.factsheet, kClear) == nullptr) {
    return Fail(ErrorKind::kPreflight, fmt::format("its factsheet does not list {}", kClear));
  }
  const vda5050::InstantAction action{
      std::string(kClear), vda5050::MakeActionId(entry.factsheet.get()), "", "", {}};
  auto command = vda5050::BuildInstantActions(address, dialect, {&action, 1});
  if (!command) return Fail(std::move(command.error()));
  if (auto valid = ValidateCommand(*command, registry); !valid) return Fail(valid.error());
  auto tracker = vda5050::TrackInstantAction(address, dialect, action);
  if (!tracker) return Fail(std::move(tracker.error()));
  command->tracker = std::move(*tracker);
  return *std::move(command);
}

}  // namespace

void TidyUp::Note(const message::Report& report) {
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
  schema::Registry registry(schema_directory);
  std::vector<message::Command> commands;
  for (const ListedRobot* robot : robots) {
    const std::string target = robot->first.ToString();
    if (!targets_.contains(target)) continue;
    auto command = CommandFor(*robot, registry);
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
  delivery::CommandList list(commands, report);
  delivery::CommandSession session(link.transport, ledger,
                                   {.qos = qos, .acknowledge_timeout = link.connection.timeout},
                                   {.total = kPatience},
                                   {.report = report,
                                    .sent = {},
                                    .reconnect = MakeReconnectHooks(link.connection, observer),
                                    .news = {}});
  if (auto sent = delivery::SendAll(list, session, {}); !sent) {
    observer.Warn(
        fmt::format("lists of instant actions were not cleared: {}", sent.error().message));
  }
}

}  // namespace fleetpub::app
