#include "app/send_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "app/ask_states.h"
#include "app/choose_robots.h"
#include "app/dry_run.h"
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
  static constexpr std::size_t kTold = 10;

  explicit Warnings(Log& log) : log_(log) {}

  void Warn(const std::string& target, const std::string& warning) {
    const std::string words = warning.starts_with(target) ? warning.substr(target.size()) : warning;
    if (++told_[words] <= kTold) log_.Warn(warning);
  }
  void Warn(const std::string& warning) {
    const std::size_t colon = warning.find_first_of(": ");
    Warn(warning.substr(0, colon == std::string::npos ? 0 : colon), warning);
  }
  void TellRest() const {
    for (const auto& [words, count] : told_) {
      if (count <= kTold) continue;
      const std::size_t more = count - kTold;
      log_.Warn(fmt::format("the same for {}{}{}", base::Counted(more, "more robot"),
                            words.starts_with(":") ? "" : ":", words));
    }
  }

 private:
  Log& log_;
  std::map<std::string, std::size_t> told_;
};

// Why it is not known whether --where is true of a robot.
std::string WhyUnheard(const vda5050::RobotEntry& robot, milliseconds state_wait) {
  if (!robot.state_fault.empty()) return "its state cannot be read: " + robot.state_fault;
  if (robot.WasHeard()) return "it sent no state within " + base::FormatElapsed(state_wait);
  return "the broker has no message of it";
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
        factory_(environment.schema_directory),
        warnings_(observer) {}

  // Robots that were named: the broker is asked only what each has said of itself, and that only
  // unless somebody states the version and wants no check.
  Status SendToNamed() {
    ChooseRobots();
    if (auto ok = CheckTopics(); !ok) return ok;
    if (NeedsLook()) {
      // What is invalid anyway costs no connection.
      if (auto ok = ValidateUnseen(); !ok) return ok;
      if (auto ok = Discover(); !ok) return ok;
      ChooseRobots();
      SuggestNames();
    }
    if (auto ok = CheckCount(); !ok) return ok;
    if (auto ok = AskConsent(); !ok) return ok;
    if (auto ok = Validate(); !ok) return ok;
    return BuildAndSend();
  }

  // Robots that patterns or conditions find: the broker says who they are.
  Status SendToFound() {
    if (auto ok = Discover(); !ok) return ok;
    if (auto ok = CheckExclusions(); !ok) return ok;
    ChooseRobots();
    if (auto ok = CheckAnyChosen(); !ok) return ok;
    if (auto ok = CheckCount(); !ok) return ok;
    SuggestNames();
    if (auto ok = AskConsent(); !ok) return ok;
    if (auto ok = Validate(); !ok) return ok;
    return BuildAndSend();
  }

 private:
  [[nodiscard]] bool NeedsLook() const {
    if (settings_.dry_run && (settings_.offline || !environment_.names_broker)) return false;
    const auto& robots = directory_.robots();
    return request_.waiting.check ||
           std::any_of(robots.begin(), robots.end(),
                       [](const ListedRobot& listed) { return listed.second.automatic; });
  }

  Status AskConsent() {
    const bool is_many = request_.targets.IsSet() && robots_.size() > 1;
    const bool is_agreed = settings_.agreed || settings_.dry_run;
    if (!is_many || is_agreed || request_.needs_consent == NeedsConsent::kNo) return {};
    std::vector<RobotAddress> robots;
    robots.reserve(robots_.size());
    std::size_t offline = 0;
    for (const ListedRobot* robot : robots_) {
      robots.push_back(robot->first);
      if (link_ && !robot->second.IsAlive()) ++offline;
    }
    const std::string& set = request_.targets.include.set;
    return observer_.Consent({.robots = robots,
                              .offline = offline,
                              .set = set.empty() ? "--where" : set,
                              .title = request_.title,
                              .site = Site(),
                              .await = [this](int answer) { KeepConnected(answer); }});
  }

  // A broker lets go of whom it does not hear of for one and a half times the keep-alive.
  void KeepConnected(int answer) {
    if (!link_ || link_->transport == nullptr) return;
    mqtt::Transport& transport = *link_->transport;
    transport.WakeOn({&answer, 1});
    for (bool is_heard = true; is_heard;) {
      const auto message = transport.Receive(mqtt::Deadline::max());
      is_heard = message && *message;
    }
    transport.WakeOn({});
  }

  // The broker in use, and the profile that names it.
  [[nodiscard]] std::string Site() const {
    if (!link_ || link_->transport == nullptr) return environment_.site;
    return FormatSite(link_->transport->server().broker, environment_.config.profile);
  }

  // A topic template may leave out what tells robots or topics apart.
  [[nodiscard]] Status CheckTopics() const {
    TopicOwners owners;
    for (const ListedRobot* robot : robots_) {
      const bool waits = request_.waiting.wait_for.has_value();
      if (auto ok = owners.Add(robot->first, robot->second.base->topics, waits); !ok) return ok;
    }
    return {};
  }

  Status ValidateUnseen() {
    auto valid = factory_.ValidateInAnyVersion(request_, robots_);
    if (valid) return valid;
    return Fail(ReportNothingSent(CommandStatus::kInvalid, std::move(valid.error())));
  }

  Status Validate() {
    auto valid = factory_.Validate(request_, robots_);
    if (valid) return valid;
    return Fail(ReportNothingSent(CommandStatus::kInvalid, std::move(valid.error())));
  }

  // Collects what the robots have said of themselves.
  Status Discover() {
    if (auto ok = Connect(); !ok) return ok;
    const bool check = request_.waiting.check;
    factory_.SetLook(check, link_->transport->server(), environment_.config.profile);
    const auto message = request_.make_message();
    auto discover = DiscoverOptions();
    // A ledger is not made for a set of robots to which nobody has agreed yet.
    const bool opens_ledger = !request_.targets.IsSet() && !settings_.dry_run;
    if (opens_ledger) discover.meanwhile = [this] { OpenLedger(); };
    DiscoveryOptions options{
        .all = check || message->IsMadeForRobot(),
        .factsheets = check && message->NeedsFactsheet(),
        .discover = std::move(discover),
        .expected = FindExpectedRobots(request_.targets, request_.resolver, environment_,
                                       link_->transport->server())};
    if (message->IsMadeForRobot()) {
      directory_.KeepStates();
      options.states = true;
      if (request_.ask && !settings_.dry_run) options.ask = [this] { return AskStates(); };
    }
    auto discovered =
        DiscoverRobots(*link_->transport, request_.targets, options, directory_, observer_);
    if (discovered) {
      WarnOfUnheard(
          FindUnheard(options.expected,
                      [this](const RobotAddress& robot) { return directory_.Knows(robot); }),
          observer_);
      return discovered;
    }
    // To stop is not held back by a login that may not read.
    const bool stops = !request_.targets.AreFound() && message->IsOnlyStartPause();
    if (stops && link_->transport->AwaitReady(std::chrono::steady_clock::now())) {
      observer_.Warn(discovered.error().message);
      return {};
    }
    return Fail(ReportNothingSent(CommandStatus::kError, std::move(discovered.error())));
  }

  // A state that was sent before somebody asked may be of half a minute ago.
  Status AskStates() {
    std::vector<const ListedRobot*> robots;
    for (const ListedRobot& robot : directory_.robots()) robots.push_back(&robot);
    AskForStates(robots, request_.targets.state_wait, *link_, environment_, observer_);
    if (link_->transport != nullptr) return {};
    return Fail(ErrorKind::kBroker,
                "the connection was lost while the robot was asked for its state");
  }

  [[nodiscard]] delivery::RetainedOptions DiscoverOptions() const {
    auto discover = request_.waiting.discover;
    discover.subscribe = link_->connection.timeout;
    return discover;
  }

  void ChooseRobots() {
    Chosen chosen = Choose(request_.targets, directory_, observer_);
    robots_ = std::move(chosen.robots);
    unheard_ = std::move(chosen.unheard);
    left_out_ = chosen.left_out;
  }

  Status CheckAnyChosen() {
    if (!robots_.empty() || !unheard_.empty() || left_out_ > 0) return {};
    return Fail(NobodyChosen(*link_->transport, request_.targets, request_.resolver, directory_,
                             DiscoverOptions(), Site()));
  }

  // A broker may hand out a part of the fleet only.
  Status CheckCount() {
    const auto& expect = request_.targets.expect;
    if (!expect || robots_.size() == *expect) return {};
    const std::string text = fmt::format("{} found, but --expect says {}",
                                         base::Counted(robots_.size(), "robot"), *expect);
    return Fail(ReportNothingSent(CommandStatus::kRefused, {ErrorKind::kPreflight, text}));
  }

  Status CheckExclusions() {
    const auto unused = UnusedExclusion(request_.targets, excluded_, environment_.config);
    if (!unused) return {};
    std::vector<RobotAddress> found;
    for (const auto& [robot, entry] : directory_.robots()) {
      if (entry.IsKnown()) found.push_back(robot);
    }
    const std::string text = fmt::format("--except {} matches none of the robots found: {}",
                                         base::Printable(*unused), FormatRobotList(found));
    if (request_.needs_consent == NeedsConsent::kNo) {
      observer_.Warn(text);
      return {};
    }
    return Fail(ReportNothingSent(CommandStatus::kError, {ErrorKind::kPreflight, text}));
  }

  // To those of whom nothing is known.
  void SuggestNames() {
    if (request_.make_message()->IsOnlyStartPause()) return;
    factory_.SuggestNames(robots_, *link_->transport, request_.resolver.common().topics,
                          DiscoverOptions());
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
          ReportOn(*robot, CommandStatus::kRefused, ErrorKind::kPreflight,
                   fmt::format("not sent: {}, so {} cannot be decided",
                               WhyUnheard(robot->second, request_.targets.state_wait),
                               request_.targets.where.empty() ? "--online" : "--where")));
    }
    auto sent = settings_.dry_run
                    ? ShowDryRun(*this, environment_, observer_,
                                 [this](std::size_t i) { observer_.Info(explanations_[i]); })
                    : Send();
    if (sent) warnings_.TellRest();
    return sent;
  }

  void OpenLedger() {
    if (!ledger_) ledger_ = environment_.ledger(ledger::OpenMode::kCreate);
  }

  Status Send() {
    OpenLedger();
    auto& ledger = *ledger_;
    if (!ledger) return Fail(ReportNothingSent(CommandStatus::kError, std::move(ledger.error())));
    if (auto ok = Connect(); !ok) return ok;
    std::optional<delivery::WaitOptions> wait;
    if (request_.waiting.wait_for) wait = request_.waiting.wait;
    TidyUp tidy_up(request_.waiting.tidy);
    auto sent = Deliver(*this, *link_, **ledger, settings_, wait, observer_,
                        [&](const Report& report) { tidy_up.Add(report); });
    if (!observer_.IsStopped()) {
      tidy_up.Run(robots_, *link_, **ledger, settings_.qos, environment_.schema_directory,
                  observer_);
    }
    if (link_->transport != nullptr) link_->transport->Disconnect();
    if (sent || !built_all_) return sent;
    return Fail(ReportNothingSent(CommandStatus::kError, std::move(sent.error())));
  }

  [[nodiscard]] std::size_t left() const override { return robots_.size() - next_; }

  // What cannot be sent is reported at once.
  Result<std::span<const message::Command>> Next(std::size_t most) override {
    built_ = {};
    explanations_.clear();
    const std::size_t end = next_ + std::min(left(), most);
    built_.commands.reserve(end - next_);
    for (; next_ < end; ++next_) {
      const std::size_t before = built_.commands.size();
      const auto message = request_.make_message();
      built_all_ = factory_.Build(*robots_[next_], RequestFor(*message), built_);
      if (!built_all_) return Fail(built_all_.error());
      if (built_.commands.size() == before) continue;
      if (settings_.dry_run) {
        explanations_.push_back("would be published " + DescribeWay(*robots_[next_]));
      } else if (next_ < Warnings::kTold) {
        observer_.Debug(DescribeDetails(*robots_[next_]));
      }
    }
    for (const std::string& warning : built_.warnings) warnings_.Warn(warning);
    for (const std::string& note : built_.notes) observer_.Info(note);
    for (const Report& refused : built_.refused) observer_.Report(refused);
    return built_.commands;
  }

  // Where the last one built goes, and why there.
  [[nodiscard]] std::string DescribeWay(const ListedRobot& robot) const {
    const message::Command& command = built_.commands.back();
    const auto& entry = robot.second;
    const std::string_view why = entry.automatic && entry.own ? "as the robot itself says"
                                 : !entry.base->assumed       ? "as stated"
                                 : link_                      ? "assumed"
                                                              : "assumed: no broker was asked";
    return fmt::format("to {} in {} ({})", base::Printable(command.topic), command.version, why);
  }

  // The same, what the robot had said before, and what is waited for.
  [[nodiscard]] std::string DescribeDetails(const ListedRobot& robot) const {
    const auto& [address, entry] = robot;
    std::string text = base::Printable(address.ToString()) + ": " + DescribeWay(robot);
    if (entry.connection) text += "; " + vda5050::ConnectionText(*entry.connection);
    if (entry.speaks) text += "; it sends states";
    if (entry.factsheet) text += "; has a factsheet";
    if (const auto& end = request_.waiting.wait_for) {
      text += fmt::format("; waiting until {}",
                          *end == vda5050::WaitFor::kFinished ? "it is done" : "it is listed");
    }
    return text;
  }

  void GiveUp(const Error& reason) override {
    for (; next_ < robots_.size(); ++next_) {
      observer_.Report(ReportOn(*robots_[next_], CommandStatus::kError, reason.kind,
                                "not sent: " + reason.message));
    }
  }

  [[nodiscard]] RobotRequest RequestFor(RobotMessage& message) const {
    return {
        .message = message, .header_id = request_.header_id, .wait_for = request_.waiting.wait_for};
  }

  [[nodiscard]] Report ReportOn(const ListedRobot& robot, CommandStatus status, ErrorKind kind,
                                std::string text) const {
    const auto message = request_.make_message();
    return CommandFactory::ReportOn(robot, RequestFor(*message), status, kind, std::move(text));
  }

  Error ReportNothingSent(CommandStatus status, Error error) {
    for (const ListedRobot* robot : robots_) {
      observer_.NothingSent(ReportOn(*robot, status, error.kind, "not sent: " + error.message));
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
  std::optional<Result<std::unique_ptr<ledger::Ledger>>> ledger_;  // opened once
  std::vector<const ListedRobot*> robots_;                         // of the directory
  std::vector<const ListedRobot*> unheard_;  // whether --where is true is not known
  std::size_t left_out_ = 0;                 // as they are offline
  std::size_t next_ = 0;
  CommandFactory::Built built_;
  std::vector<std::string> explanations_;  // of these, in a dry run
  Status built_all_;                       // why a message could not be made
};

}  // namespace

Status SendCommand(const CommandRequest& request, const SendSettings& settings,
                   const Environment& environment, Observer& observer) {
  if (settings.offline && request.targets.AreFound()) {
    return Fail(ErrorKind::kUsage,
                "--offline asks no broker, and only the broker knows which robots are meant: name "
                "them, or leave --offline out");
  }
  Excluded excluded;
  auto directory = MakeDirectory(request.targets, request.resolver, excluded);
  if (!directory) return Fail(std::move(directory.error()));
  CommandSender sender(request, settings, environment, observer, *std::move(directory), excluded);
  return request.targets.AreFound() ? sender.SendToFound() : sender.SendToNamed();
}

}  // namespace fleetpub::app
