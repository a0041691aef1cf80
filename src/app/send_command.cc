#include "app/send_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "app/dry_run.h"
#include "app/recent_targets.h"
#include "app/robot_discovery.h"
#include "app/tidy_up.h"
#include "base/text.h"
#include "base/time.h"
#include "delivery/send_all.h"

namespace fleetpub::app {
namespace {

using message::CommandStatus;
using message::Report;
using std::chrono::milliseconds;
using vda5050::RobotAddress;

// A thousand robots may all be warned of in the same words.
class Warnings {
 public:
  explicit Warnings(Log& log) : log_(log) {}

  void Tell(const std::string& target, const std::string& warning) {
    const std::string words = warning.starts_with(target) ? warning.substr(target.size()) : warning;
    if (++told_[words] <= kTold) log_.Warn(warning);
  }
  void Tell(const std::string& warning) {
    const std::size_t colon = warning.find_first_of(": ");
    Tell(warning.substr(0, colon == std::string::npos ? 0 : colon), warning);
  }
  void TellRest() const {
    for (const auto& [words, count] : told_) {
      if (count <= kTold) continue;
      log_.Warn(fmt::format("the same of {} more robots{}", count - kTold, words));
    }
  }

 private:
  static constexpr std::size_t kTold = 10;
  Log& log_;
  std::map<std::string, std::size_t> told_;
};

// Why it is not known whether --where is true of a robot.
std::string WhyUnheard(const vda5050::RobotEntry& robot, milliseconds state_wait) {
  if (!robot.state_fault.empty()) return "its state cannot be read: " + robot.state_fault;
  if (robot.WasHeard()) return "it sent no state within " + base::FormatElapsed(state_wait);
  return "no message of it is at the broker";
}

class CommandSender final : private delivery::CommandSource {
 public:
  CommandSender(const CommandRequest& request, const SendSettings& settings,
                const Environment& environment, Observer& observer,
                vda5050::RobotDirectory directory, const Excluded& excluded)
      : request_(request),
        settings_(settings),
        environment_(environment),
        observer_(observer),
        directory_(std::move(directory)),
        excluded_(excluded),
        factory_(request, environment.schema_directory),
        warnings_(observer) {}

  // Robots that were named: the broker is asked only what each has said of itself.
  Status SendToNamed() {
    const bool any_automatic =
        std::any_of(directory_.robots().begin(), directory_.robots().end(),
                    [](const ListedRobot& listed) { return listed.second.automatic; });
    SetCheck(request_.waiting.check && !settings_.dry_run);
    ChooseRobots();
    if (auto ok = AskConsent(); !ok) return ok;
    // What is invalid anyway costs no connection.
    if (!any_automatic) {
      if (auto ok = Validate(); !ok) return ok;
    }
    if (check_ || any_automatic) {
      if (auto ok = Discover(); !ok) return ok;
      ChooseRobots();
      SuggestNames();
      if (auto ok = Validate(); !ok) return ok;
    }
    return BuildAndSend();
  }

  // Robots that patterns or conditions find: the broker says who they are.
  Status SendToFound() {
    SetCheck(request_.waiting.check || !request_.waiting.no_check);
    if (auto ok = Discover(); !ok) return ok;
    if (auto ok = CheckExclusions(); !ok) return ok;
    ChooseRobots();
    if (auto ok = CheckAnyChosen(); !ok) return ok;
    SuggestNames();
    if (auto ok = AskConsent(); !ok) return ok;
    if (auto ok = Validate(); !ok) return ok;
    return BuildAndSend();
  }

 private:
  // Preflight, as a part of building.
  void SetCheck(bool check) {
    check_ = check;
    factory_.SetCheck(check);
  }

  Status AskConsent() {
    const bool is_many = request_.targets.IsSet() && robots_.size() > 1;
    const bool is_agreed = settings_.agreed || settings_.dry_run;
    if (!is_many || is_agreed || request_.needs_consent == NeedsConsent::kNo) return {};
    std::vector<RobotAddress> robots;
    robots.reserve(robots_.size());
    for (const ListedRobot* robot : robots_) robots.push_back(robot->first);
    const std::string& set = request_.targets.include.set;
    return observer_.Consent(robots, set.empty() ? "--where" : set);
  }

  Status Validate() {
    auto valid = factory_.Validate(robots_);
    if (valid) return valid;
    return Fail(ReportNothingSent(CommandStatus::kInvalid, std::move(valid.error())));
  }

  // Collects what the robots have said of themselves.
  Status Discover() {
    if (auto ok = Connect(); !ok) return ok;
    DiscoveryOptions options{check_, request_.waiting.discover};
    options.discover.subscribe = link_->connection.timeout;
    auto discovered =
        DiscoverRobots(*link_->transport, request_.targets, options, directory_, observer_);
    if (discovered) return discovered;
    return Fail(ReportNothingSent(CommandStatus::kError, std::move(discovered.error())));
  }

  void ChooseRobots() {
    Chosen chosen = Choose(request_.targets, directory_, observer_);
    robots_ = std::move(chosen.robots);
    unheard_ = std::move(chosen.unheard);
  }

  Status CheckAnyChosen() {
    if (!robots_.empty() || !unheard_.empty()) return {};
    delivery::RetainedOptions discover = request_.waiting.discover;
    discover.subscribe = link_->connection.timeout;
    return Fail(
        NobodyChosen(*link_->transport, request_.targets, request_.resolver, directory_, discover));
  }

  Status CheckExclusions() {
    const auto unused = UnusedExclusion(request_.targets, excluded_, environment_.config);
    if (!unused) return {};
    const std::string text =
        fmt::format("--except {} spares nobody: no such robot is among those that were found",
                    base::Printable(*unused));
    if (request_.needs_consent == NeedsConsent::kNo) {
      observer_.Warn(text);
      return {};
    }
    return Fail(ReportNothingSent(CommandStatus::kError, {ErrorKind::kPreflight, text}));
  }

  // To those of whom nothing is known.
  void SuggestNames() {
    constexpr std::size_t kMost = 20;
    std::vector<const ListedRobot*> unknown;
    for (const ListedRobot* robot : robots_) {
      const bool is_looked_for = check_ || robot->second.automatic;
      if (is_looked_for && !robot->second.WasHeard()) unknown.push_back(robot);
    }
    if (unknown.empty() || unknown.size() > kMost) return;
    std::set<std::string> names = KnownNames();
    for (const ListedRobot* robot : unknown) names.erase(robot->first.ToString());
    const std::vector<std::string_view> candidates(names.begin(), names.end());
    for (const ListedRobot* robot : unknown) {
      const auto nearest = base::Nearest(robot->first.ToString(), candidates);
      if (!nearest) continue;
      factory_.Suggest(robot->first, fmt::format("did you mean {}?", base::Printable(*nearest)));
    }
  }

  // At the broker, in the configuration, and in the newest part of the ledger.
  std::set<std::string> KnownNames() {
    std::set<std::string> names;
    for (const RobotAddress& robot : ListAllRobots(
             *link_->transport, request_.resolver.common().topics, request_.waiting.discover)) {
      names.insert(robot.ToString());
    }
    for (const auto& [robot, table] : environment_.config.robots) names.insert(robot.ToString());
    for (std::string& target : FindRecentTargets(environment_.ledger, "vda5050")) {
      names.insert(std::move(target));
    }
    return names;
  }

  Status Connect() {
    if (link_) return {};
    auto link = app::Connect(environment_, observer_);
    if (!link) return Fail(ReportNothingSent(CommandStatus::kError, std::move(link.error())));
    link_ = *std::move(link);
    return {};
  }

  Status BuildAndSend() {
    std::vector<std::string> names;
    names.reserve(robots_.size());
    for (const ListedRobot* robot : robots_) names.push_back(robot->first.ToString());
    observer_.Chosen(names);
    for (const ListedRobot* robot : unheard_) {
      observer_.Report(
          factory_.ReportOn(*robot, CommandStatus::kRefused, ErrorKind::kPreflight,
                            fmt::format("not sent: {}, so --where cannot be decided",
                                        WhyUnheard(robot->second, request_.targets.state_wait))));
    }
    auto sent = settings_.dry_run ? ShowDryRun(*this, environment_, observer_) : Send();
    if (sent) warnings_.TellRest();
    return sent;
  }

  Status Send() {
    auto ledger = environment_.ledger(ledger::OpenMode::kCreate);
    if (!ledger) return Fail(ReportNothingSent(CommandStatus::kError, std::move(ledger.error())));
    if (auto ok = Connect(); !ok) return ok;
    std::optional<delivery::WaitOptions> wait;
    if (request_.waiting.wait_for) wait = request_.waiting.wait;
    TidyUp tidy_up(request_.waiting.tidy);
    auto sent = Deliver(*this, *link_, **ledger, settings_, wait, observer_,
                        [&](const Report& report) { tidy_up.Note(report); });
    tidy_up.Run(robots_, *link_, **ledger, settings_.qos, environment_.schema_directory, observer_);
    if (link_->transport != nullptr) link_->transport->Disconnect();
    if (sent || !built_all_) return sent;
    return Fail(ReportNothingSent(CommandStatus::kError, std::move(sent.error())));
  }

  [[nodiscard]] std::size_t left() const override { return robots_.size() - next_; }

  // What cannot be sent is reported at once.
  Result<std::span<const message::Command>> Next(std::size_t most) override {
    built_ = {};
    const std::size_t end = next_ + std::min(left(), most);
    built_.commands.reserve(end - next_);
    for (; next_ < end; ++next_) {
      built_all_ = factory_.Build(*robots_[next_], built_);
      if (!built_all_) return Fail(built_all_.error());
    }
    for (const std::string& warning : built_.warnings) warnings_.Tell(warning);
    for (const Report& refused : built_.refused) observer_.Report(refused);
    return built_.commands;
  }

  void GiveUp(const Error& reason) override {
    for (; next_ < robots_.size(); ++next_) {
      observer_.Report(factory_.ReportOn(*robots_[next_], CommandStatus::kError, reason.kind,
                                         "not sent: " + reason.message));
    }
  }

  Error ReportNothingSent(CommandStatus status, Error error) {
    for (const ListedRobot* robot : robots_) {
      observer_.NothingSent(
          factory_.ReportOn(*robot, status, error.kind, "not sent: " + error.message));
    }
    error.message = "nothing was sent: " + error.message;
    return error;
  }

  const CommandRequest& request_;
  const SendSettings& settings_;
  const Environment& environment_;
  Observer& observer_;
  vda5050::RobotDirectory directory_;
  const Excluded& excluded_;
  CommandFactory factory_;
  Warnings warnings_;
  std::optional<Link> link_;
  bool check_ = false;
  std::vector<const ListedRobot*> robots_;   // of the directory
  std::vector<const ListedRobot*> unheard_;  // whether --where is true is not known
  std::size_t next_ = 0;
  CommandFactory::Built built_;
  Status built_all_;  // why a message could not be made
};

}  // namespace

Status SendCommand(const CommandRequest& request, const SendSettings& settings,
                   const Environment& environment, Observer& observer) {
  Excluded excluded;
  auto directory = MakeDirectory(request.targets, request.resolver, excluded);
  if (!directory) return Fail(std::move(directory.error()));
  CommandSender sender(request, settings, environment, observer, *std::move(directory), excluded);
  return request.targets.AreFound() ? sender.SendToFound() : sender.SendToNamed();
}

}  // namespace fleetpub::app
