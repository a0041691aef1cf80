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
  return fmt::format("sent, but {}; not waiting",
                     vda5050::ConnectionText(*robot.second.connection));
}

}  // namespace

Result<std::vector<std::string>> CommandFactory::Try(const RobotMessage& message,
                                                     const vda5050::RobotAddress& robot,
                                                     const Dialect& dialect,
                                                     std::optional<std::uint32_t> header_id) {
  const auto command = message.Build(robot, dialect, header_id);
  return command ? ValidateCommand(*command, registry_) : Fail(command.error());
}

Status CommandFactory::Validate(const CommandRequest& request,
                                const std::vector<const ListedRobot*>& robots) {
  const auto message = request.make_message();
  if (message->IsMadeForRobot()) return {};
  const bool is_alike = message->IsAlikeForAll();
  std::set<const Dialect*> validated;
  const Dialect* last = nullptr;  // mostly it is the one before
  bool any_good = false;
  Status first;
  for (const ListedRobot* robot : robots) {
    const auto& dialect = robot->second.Spoken();
    if (is_alike && (dialect.get() == last || !validated.insert(dialect.get()).second)) continue;
    last = dialect.get();
    const auto warnings = Try(*message, robot->first, *dialect, request.header_id);
    any_good = any_good || warnings;
    if (first && !warnings) first = Fail(warnings.error());
  }
  return request.targets.IsSet() && any_good ? Status() : first;
}

Status CommandFactory::ValidateInAnyVersion(const CommandRequest& request,
                                            const std::vector<const ListedRobot*>& robots) {
  const auto message = request.make_message();
  if (message->IsMadeForRobot()) return {};
  Status newest;
  for (const ListedRobot* robot : robots) {
    Dialect dialect = *robot->second.base;
    for (auto version = vda5050::kVersions.rbegin(); version != vda5050::kVersions.rend();
         ++version) {
      if (!dialect.assumed && *version != dialect.version) continue;
      dialect.version = *version;
      const auto warnings = Try(*message, robot->first, dialect, request.header_id);
      if (warnings) return {};
      if (newest) newest = Fail(warnings.error());
    }
    if (message->IsAlikeForAll()) break;
  }
  return newest;
}

Status CommandFactory::Build(const ListedRobot& robot, const RobotRequest& request, Built& built) {
  const vda5050::RobotEntry& entry = robot.second;
  // One that is made for the robot is made of what a check looks at first.
  const bool is_made_for_it = request.message.IsMadeForRobot();
  if (!is_made_for_it) {
    if (auto ok = request.message.Prepare(robot, brokers_, built.notes); !ok) return ok;
  }
  bool is_offline =
      entry.connection && !entry.IsAlive() && entry.connection->connection_state != "HIBERNATING";
  if (look_ && (look_->check || entry.automatic)) {
    PreflightFindings findings = FindingsOn(robot, request.message);
    is_offline = is_offline || findings.unreachable;
    if (!findings.refusals.empty()) {
      built.refused.push_back(ReportOn(
          robot, request, findings.unreachable ? CommandStatus::kOffline : CommandStatus::kRefused,
          ErrorKind::kPreflight, "not sent: " + findings.refusals.front()));
      // What is to be said of the message itself is said all the same.
      const auto warnings = Try(request.message, robot.first, *entry.Spoken(), request.header_id);
      if (!warnings) return {};
      built.warnings.insert(built.warnings.end(), warnings->begin(), warnings->end());
      return {};
    }
    // The result says it, then.
    if (is_offline && findings.unreachable) findings.warnings.erase(findings.warnings.begin());
    for (std::string& warning : findings.warnings) built.warnings.push_back(std::move(warning));
  }
  if (is_made_for_it) {
    if (auto ok = request.message.Prepare(robot, brokers_, built.notes); !ok) {
      const auto status = ok.error().kind == ErrorKind::kPreflight ? CommandStatus::kRefused
                                                                   : CommandStatus::kInvalid;
      built.refused.push_back(
          ReportOn(robot, request, status, ok.error().kind, "not sent: " + ok.error().message));
      return {};
    }
  }
  return AddCommand(robot, request, is_offline, built);
}

Status CommandFactory::AddCommand(const ListedRobot& robot, const RobotRequest& request,
                                  bool is_offline, Built& built) {
  const auto& [address, entry] = robot;
  const auto& dialect = entry.Spoken();
  auto command = request.message.Build(address, *dialect, request.header_id);
  auto warnings = command ? ValidateCommand(*command, registry_) : Fail(command.error());
  if (!warnings) {
    built.refused.push_back(ReportOn(robot, request, CommandStatus::kInvalid, warnings.error().kind,
                                     "not sent: " + warnings.error().message));
    return {};
  }
  for (std::string& warning : *warnings) built.warnings.push_back(std::move(warning));
  if (is_offline) {
    command->tracker = std::make_shared<NotAwaited>(DescribeOffline(robot));
  } else if (request.wait_for) {
    auto tracker = request.message.Track(address, *dialect, *request.wait_for);
    if (!tracker) return Fail(std::move(tracker.error()));
    command->tracker = std::move(*tracker);
  }
  built.commands.push_back(*std::move(command));
  return {};
}

void CommandFactory::SuggestNames(std::span<const ListedRobot* const> robots,
                                  mqtt::Transport& transport, const vda5050::TopicScheme& scheme,
                                  const delivery::RetainedOptions& discover) {
  if (!look_) return;
  std::vector<vda5050::RobotAddress> unknown;
  for (const ListedRobot* robot : robots) {
    const bool is_looked_for = look_->check || robot->second.automatic;
    if (is_looked_for && !robot->second.WasHeard()) unknown.push_back(robot->first);
  }
  suggestions_ = FindNearNames(unknown, transport, scheme, discover);
}

PreflightFindings CommandFactory::FindingsOnUnknown(const ListedRobot& robot,
                                                    const RobotMessage& message) const {
  const auto& [address, entry] = robot;
  const std::string sentence =
      fmt::format("{} is unknown to {}{}", base::Printable(address.ToString()), look_->site,
                  look_->keeps_nothing ? fmt::format(": {}", kNothingRetained) : "");
  PreflightFindings findings;
  if (message.IsOnlyStartPause()) {
    const vda5050::Dialect& dialect = *entry.Spoken();
    findings.warnings.push_back(fmt::format("{}; startPause is sent anyway, in {}{}", sentence,
                                            vda5050::GetFacts(dialect.version).name,
                                            dialect.assumed ? " (assumed)" : ""));
    return findings;
  }
  const std::string sends =
      entry.automatic ? "--vda VERSION --no-check sends it anyway" : "--no-check sends it anyway";
  const auto suggestion = suggestions_.find(address);
  findings.refusals.push_back(
      fmt::format("{}; {}fleetpub fleet shows who is there, {}", sentence,
                  suggestion == suggestions_.end() ? "" : suggestion->second + " ", sends));
  return findings;
}

PreflightFindings CommandFactory::FindingsOn(const ListedRobot& robot,
                                             const RobotMessage& message) const {
  const auto& [address, entry] = robot;
  if (!entry.WasHeard()) return FindingsOnUnknown(robot, message);
  PreflightFindings findings;
  if (entry.automatic && !entry.own) {
    findings.refusals.emplace_back(
        "it speaks a version of VDA 5050 that fleetpub does not: state one with --vda");
  } else if (look_->check) {
    findings = message.Check(address, *entry.Spoken(), entry.Known());
  } else if (auto rival = vda5050::RivalText(address, entry.Known())) {
    findings.warnings.push_back(*std::move(rival));
  }
  return findings;
}

message::Report CommandFactory::ReportOn(const ListedRobot& robot, const RobotRequest& request,
                                         CommandStatus status, ErrorKind kind,
                                         std::string message) {
  const auto& [address, entry] = robot;
  const auto command = request.message.Build(address, *entry.Spoken(), request.header_id);
  message::Report report = command ? message::ReportOn(*command) : message::Report();
  report.target = address.ToString();
  report.status = status;
  report.error = kind;
  report.message = std::move(message);
  return report;
}

}  // namespace fleetpub::app
