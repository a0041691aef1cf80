#include "app/command_factory.h"

#include <fmt/format.h>

#include <set>
#include <utility>

#include "app/deliver.h"
#include "base/text.h"

namespace fleetpub::app {
namespace {

using message::Command;
using message::CommandStatus;
using vda5050::Dialect;
using vda5050::PreflightFindings;

// The end of a command to a robot that will not answer: it is told, not waited for.
class NotAwaited final : public message::ResponseTracker {
 public:
  explicit NotAwaited(std::string why) {
    progress_.status = CommandStatus::kOffline;
    progress_.message = std::move(why);
  }
  [[nodiscard]] std::vector<std::string> Topics() const override { return {}; }
  void Published(std::uint32_t /*header_id*/) override { progress_.ended = true; }
  void Receive(const message::Incoming& /*message*/) override {}
  [[nodiscard]] const message::Progress& progress() const override { return progress_; }

 private:
  message::Progress progress_;
};

std::string DescribeOffline(const ListedRobot& robot) {
  return "sent all the same, but not waited for: it is " +
         vda5050::ConnectionText(*robot.second.connection);
}

}  // namespace

Status CommandFactory::Validate(const std::vector<const ListedRobot*>& robots) {
  const auto message = request_.make_message();
  const bool is_alike = message->IsAlikeForAll();
  std::set<const Dialect*> validated;
  const Dialect* last = nullptr;  // mostly it is the one before
  bool any_good = false;
  Status first;
  for (const ListedRobot* robot : robots) {
    const auto& dialect = robot->second.Spoken();
    if (is_alike && (dialect.get() == last || !validated.insert(dialect.get()).second)) continue;
    last = dialect.get();
    const auto command = message->Build(robot->first, *dialect, request_.header_id);
    const auto warnings = command ? ValidateCommand(*command, registry_) : Fail(command.error());
    any_good = any_good || warnings;
    if (first && !warnings) first = Fail(warnings.error());
  }
  return request_.targets.IsSet() && any_good ? Status() : first;
}

Status CommandFactory::Build(const ListedRobot& robot, Built& built) {
  const auto message = request_.make_message();
  const vda5050::RobotEntry& entry = robot.second;
  if (entry.factsheet) message->ApplyLimits(*entry.factsheet);
  bool is_offline =
      entry.connection && !entry.IsOnline() && entry.connection->connection_state != "HIBERNATING";
  if (check_ || entry.automatic) {
    PreflightFindings findings = FindingsOn(robot, *message);
    is_offline = is_offline || findings.unreachable;
    if (!findings.refusals.empty()) {
      built.refused.push_back(
          ReportOn(robot, findings.unreachable ? CommandStatus::kOffline : CommandStatus::kRefused,
                   ErrorKind::kPreflight, "not sent: " + findings.refusals.front()));
      return {};
    }
    // The result says it, then.
    if (is_offline && findings.unreachable) findings.warnings.erase(findings.warnings.begin());
    for (std::string& warning : findings.warnings) built.warnings.push_back(std::move(warning));
  }
  return AddCommand(robot, *message, is_offline, built);
}

Status CommandFactory::AddCommand(const ListedRobot& robot, const RobotMessage& message,
                                  bool is_offline, Built& built) {
  const auto& [address, entry] = robot;
  const auto dialect = DialectFor(robot);
  auto command = message.Build(address, *dialect, request_.header_id);
  auto warnings = command ? ValidateCommand(*command, registry_) : Fail(command.error());
  if (!warnings) {
    built.refused.push_back(ReportOn(robot, CommandStatus::kInvalid, warnings.error().kind,
                                     "not sent: " + warnings.error().message));
    return {};
  }
  for (std::string& warning : *warnings) built.warnings.push_back(std::move(warning));
  if (is_offline) {
    command->tracker = std::make_shared<NotAwaited>(DescribeOffline(robot));
  } else if (request_.waiting.wait_for) {
    auto tracker = message.Track(address, *dialect, *request_.waiting.wait_for);
    if (!tracker) return Fail(std::move(tracker.error()));
    command->tracker = std::move(*tracker);
  }
  built.commands.push_back(*std::move(command));
  return {};
}

// What has passed a check is no assumption any more.
std::shared_ptr<const Dialect> CommandFactory::DialectFor(const ListedRobot& robot) {
  const auto& dialect = robot.second.Spoken();
  if (!dialect->assumed || !(check_ || robot.second.automatic)) return dialect;
  auto& checked = checked_[dialect.get()];
  if (!checked) {
    Dialect copy = *dialect;
    copy.assumed = false;
    checked = std::make_shared<const Dialect>(std::move(copy));
  }
  return checked;
}

PreflightFindings CommandFactory::FindingsOn(const ListedRobot& robot,
                                             const RobotMessage& message) const {
  const auto& [address, entry] = robot;
  const bool is_unspeakable = entry.WasHeard() && !entry.own;
  PreflightFindings findings;
  if (entry.automatic && is_unspeakable) {
    findings.refusals.emplace_back(
        "it speaks a version of VDA 5050 that fleetpub does not: try one with --vda");
  } else if (check_) {
    findings = message.Check(address, *entry.Spoken(), entry.Known());
  } else if (!entry.WasHeard()) {  // `--vda auto` alone: only the version must be known
    findings.refusals.emplace_back(
        "no message of this robot is known to the broker, so its version cannot be told: name it "
        "with --vda");
  } else if (auto rival = vda5050::RivalText(address, entry.Known())) {
    findings.warnings.push_back(*std::move(rival));
  }
  const auto suggestion = suggestions_.find(address);
  if (!findings.refusals.empty() && suggestion != suggestions_.end()) {
    findings.refusals.front() += "; " + suggestion->second;
  }
  return findings;
}

message::Report CommandFactory::ReportOn(const ListedRobot& robot, CommandStatus status,
                                         ErrorKind kind, std::string message) const {
  const auto& [address, entry] = robot;
  const auto command = request_.make_message()->Build(address, *entry.Spoken(), request_.header_id);
  message::Report report = command ? message::ReportOn(*command) : message::Report();
  report.target = address.ToString();
  report.status = status;
  report.error = kind;
  report.message = std::move(message);
  return report;
}

}  // namespace fleetpub::app
