#include "cli/robot_sending.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "app/recent_targets.h"
#include "base/text.h"
#include "cli/command_maker.h"
#include "cli/listening.h"
#include "cli/output/consent.h"
#include "cli/output/dry_run.h"
#include "cli/output/fleet_summary.h"
#include "cli/output/interrupt.h"
#include "cli/output/reporter.h"
#include "cli/roll_call.h"
#include "delivery/send_all.h"

namespace fleetpub::cli {
namespace {

using message::CommandStatus;
using message::Report;
using std::chrono::milliseconds;
using std::chrono::steady_clock;
using vda5050::RobotAddress;

// A thousand robots may all be warned of in the same words.
class Warnings {
 public:
  explicit Warnings(Output& output) : output_(output) {}

  void Tell(const std::string& target, const std::string& warning) {
    const std::string words = warning.starts_with(target) ? warning.substr(target.size()) : warning;
    if (++told_[words] <= kTold) output_.Warn(warning);
  }
  void Tell(const std::string& warning) {
    const std::size_t colon = warning.find_first_of(": ");
    Tell(warning.substr(0, colon == std::string::npos ? 0 : colon), warning);
  }
  void TellRest() const {
    for (const auto& [words, count] : told_) {
      if (count <= kTold) continue;
      output_.Warn(fmt::format("the same of {} more robots{}", count - kTold, words));
    }
  }

 private:
  static constexpr std::size_t kTold = 10;
  Output& output_;
  std::map<std::string, std::size_t> told_;
};

// Why it is not known whether --where is true of a robot.
std::string WhyUnheard(const vda5050::RobotEntry& robot, milliseconds state_wait) {
  if (!robot.state_fault.empty()) return "its state cannot be read: " + robot.state_fault;
  if (robot.WasHeard()) return "it sent no state within " + base::FormatElapsed(state_wait);
  return "no message of it is at the broker";
}

class RobotSender final : private delivery::CommandSource {
 public:
  RobotSender(const RobotSending& sending, const Context& context,
              vda5050::RobotDirectory directory, const Excluded& excluded, mqtt::Qos qos,
              delivery::RateLimiter rate)
      : sending_(sending),
        context_(context),
        directory_(std::move(directory)),
        excluded_(excluded),
        maker_(sending, context),
        reporter_(context.output),
        warnings_(context.output),
        rate_limiter_(rate) {
    options_.qos = qos;
  }

  Result<ExitCode> Run() {
    auto ready = Prepare();
    if (!ready) return Fail(std::move(ready.error()));
    for (const ListedRobot* robot : robots_) reporter_.Fit(robot->first.ToString());
    for (const ListedRobot* robot : unheard_) {
      Show(maker_.ReportOn(*robot, CommandStatus::kRefused, ErrorKind::kPreflight,
                           fmt::format("not sent: {}, so --where cannot be decided",
                                       WhyUnheard(robot->second, sending_.targets.state_wait))));
    }
    const auto start = steady_clock::now();
    auto ran = sending_.options.dry_run ? ShowDryRun(*this, context_) : Send();
    if (!ran) return Fail(std::move(ran.error()));
    warnings_.TellRest();
    if (sending_.targets.IsSet() && !sending_.options.dry_run)
      Conclude(steady_clock::now() - start);
    return reporter_.worst();
  }

 private:
  // Until it is known who gets the message, and that it is valid.
  Status Prepare() {
    const app::Targets& targets = sending_.targets;
    const bool any_automatic =
        std::any_of(directory_.robots().begin(), directory_.robots().end(),
                    [](const ListedRobot& listed) { return listed.second.automatic; });
    const Waiting& waiting = sending_.waiting;
    const bool check = waiting.check || (targets.AreFound() && !waiting.no_check);
    check_ = check && (!sending_.options.dry_run || targets.AreFound());
    maker_.SetCheck(check_);
    if (!targets.AreFound()) {
      robots_ = Choose(targets, directory_, context_.output).robots;
      if (auto ok = Consent(); !ok) return ok;
    }
    // What is invalid anyway costs no connection.
    if (!targets.AreFound() && !any_automatic) {
      if (auto ok = Judge(); !ok) return ok;
    }
    if (!check_ && !any_automatic && !targets.AreFound()) return {};
    if (auto ok = Discover(); !ok) return ok;
    if (targets.AreFound()) {
      if (auto ok = Consent(); !ok) return ok;
    }
    return Judge();
  }

  Status Consent() const {
    const bool is_many = sending_.targets.IsSet() && robots_.size() > 1;
    const bool is_agreed = sending_.options.yes || sending_.options.dry_run;
    if (!is_many || is_agreed || sending_.needs_consent == app::NeedsConsent::kNo) return {};
    std::vector<RobotAddress> robots;
    robots.reserve(robots_.size());
    for (const ListedRobot* robot : robots_) robots.push_back(robot->first);
    const std::string& set = sending_.targets.include.set;
    return AskForConsent(robots, set.empty() ? "--where" : set);
  }

  Status Judge() {
    auto judged = maker_.Judge(robots_);
    if (judged) return judged;
    return Fail(NothingSentToAny(CommandStatus::kInvalid, std::move(judged.error())));
  }

  // Collects what the robots have said of themselves.
  Status Discover() {
    if (auto ok = Connect(); !ok) return Fail(NothingSentToAny(CommandStatus::kError, ok.error()));
    const app::Targets& targets = sending_.targets;
    DiscoveryOptions call{check_, sending_.waiting.discover};
    call.discover.subscribe = connect_.connect_timeout;
    auto called = DiscoverRobots(*transport_, targets, call, directory_, context_.output);
    if (!called) return Fail(NothingSentToAny(CommandStatus::kError, called.error()));
    if (auto ok = CheckExceptions(); !ok) {
      return Fail(NothingSentToAny(CommandStatus::kError, std::move(ok.error())));
    }
    Chosen chosen = Choose(targets, directory_, context_.output);
    robots_ = std::move(chosen.robots);
    unheard_ = std::move(chosen.unheard);
    if (robots_.empty() && unheard_.empty()) {
      return Fail(NobodyChosen(*transport_, targets, sending_.resolver, directory_, call.discover));
    }
    SuggestNames();
    return {};
  }

  Status CheckExceptions() const {
    const auto idle = UnusedExclusion(sending_.targets, excluded_, context_.config);
    if (!idle) return {};
    std::string text =
        fmt::format("--except {} spares nobody: no such robot is among those that were found",
                    base::Printable(*idle));
    if (sending_.needs_consent != app::NeedsConsent::kNo)
      return Fail(ErrorKind::kPreflight, std::move(text));
    context_.output.Warn(text);
    return {};
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
      maker_.Suggest(robot->first, fmt::format("did you mean {}?", base::Printable(*nearest)));
    }
  }

  // At the broker, in the configuration, and in the newest part of the ledger.
  std::set<std::string> KnownNames() {
    std::set<std::string> names;
    for (const RobotAddress& robot :
         AllRobots(*transport_, sending_.resolver.common().topics, sending_.waiting.discover)) {
      names.insert(robot.ToString());
    }
    for (const auto& [robot, table] : context_.config.robots) names.insert(robot.ToString());
    const auto open = [this](ledger::OpenMode mode) { return OpenLedger(context_, mode); };
    for (std::string& target : app::FindRecentTargets(open, "vda5050")) {
      names.insert(std::move(target));
    }
    return names;
  }

  Status Connect() {
    if (transport_ != nullptr) return {};
    auto connect = ConnectOptionsOf(context_);
    if (!connect) return Fail(std::move(connect.error()));
    connect_ = *std::move(connect);
    auto transport = cli::Connect(connect_, context_.output);
    if (!transport) return Fail(std::move(transport.error()));
    transport_ = *std::move(transport);
    return {};
  }

  [[nodiscard]] std::size_t left() const override { return robots_.size() - next_; }

  // What cannot be sent is shown at once.
  Result<std::span<const message::Command>> Next(std::size_t most) override {
    made_ = {};
    const std::size_t end = next_ + std::min(left(), most);
    made_.commands.reserve(end - next_);
    for (; next_ < end; ++next_) {
      made_whole_ = maker_.Make(*robots_[next_], made_);
      if (!made_whole_) return Fail(made_whole_.error());
    }
    for (const std::string& warning : made_.warnings) warnings_.Tell(warning);
    for (const Report& refused : made_.refused) Show(refused);
    return made_.commands;
  }

  void GiveUp(const Error& reason) override {
    for (; next_ < robots_.size(); ++next_) {
      Show(maker_.ReportOn(*robots_[next_], CommandStatus::kError, reason.kind,
                           "not sent: " + reason.message));
    }
  }

  // Errors: nothing was sent, or a message could not be made.
  Status Send() {
    auto ledger = OpenLedger(context_, ledger::OpenMode::kCreate);
    if (!ledger) return Fail(NothingSentToAny(CommandStatus::kError, ledger.error()));
    if (auto ok = Connect(); !ok) return Fail(NothingSentToAny(CommandStatus::kError, ok.error()));
    options_.acknowledge_timeout = connect_.connect_timeout;
    ProgressBar bar(sending_.targets.IsSet() ? robots_.size() : 0, context_.output);
    Delivery delivery{.connect = connect_,
                      .send = options_,
                      .wait = {},
                      .rate = rate_limiter_,
                      .report =
                          [this](const Report& report) {
                            Show(report);
                            Output::FlushNow();
                          },
                      .tick = {}};
    if (sending_.waiting.wait_for) delivery.wait = sending_.waiting.wait;
    if (sending_.targets.IsSet() && bar.IsPossible()) {
      delivery.tick = [&] { bar.Draw(summary_); };
    }
    auto sent = Deliver(*this, transport_, **ledger, delivery, context_.output);
    if (sent || !made_whole_) return sent;
    return Fail(NothingSentToAny(CommandStatus::kError, std::move(sent.error())));
  }

  // When nothing at all was sent, a person reads one sentence, a script an object per robot.
  Error NothingSentToAny(CommandStatus status, Error error) const {
    if (context_.output.json()) {
      for (const ListedRobot* robot : robots_) {
        context_.output.Line(
            ReportJson(maker_.ReportOn(*robot, status, error.kind, "not sent: " + error.message)));
      }
    }
    error.message = "nothing was sent: " + error.message;
    return error;
  }

  void Show(const Report& report) {
    summary_.Add(report);
    reporter_.Show(report);
  }

  void Conclude(std::chrono::nanoseconds elapsed) {
    Output& output = context_.output;
    if (output.json()) return output.Line(summary_.Json(elapsed, reporter_.worst()));
    for (const std::string& line : summary_.Lines(elapsed)) output.PeopleLine(line);
  }

  const RobotSending& sending_;
  const Context& context_;
  const InterruptGuard interrupt_;
  vda5050::RobotDirectory directory_;
  const Excluded& excluded_;
  CommandMaker maker_;
  Reporter reporter_;
  Warnings warnings_;
  FleetSummary summary_;
  delivery::RateLimiter rate_limiter_;
  delivery::SendOptions options_;
  mqtt::ConnectOptions connect_;
  std::unique_ptr<mqtt::Transport> transport_;
  bool check_ = false;
  std::vector<const ListedRobot*> robots_;   // of the directory
  std::vector<const ListedRobot*> unheard_;  // whether --where is true is not known
  std::size_t next_ = 0;
  CommandMaker::Made made_;
  Status made_whole_;  // why a message could not be made
};

}  // namespace

Result<ExitCode> SendToRobots(const RobotSending& sending, const Context& context) {
  const auto qos = QosOf(sending.options.qos);
  if (!qos) return Fail(qos.error());
  const auto pace = ParseRate(sending.options.rate);
  if (!pace) return Fail(pace.error());
  Excluded excluded;
  auto directory = MakeDirectory(sending.targets, sending.resolver, excluded);
  if (!directory) return Fail(std::move(directory.error()));
  return RobotSender(sending, context, *std::move(directory), excluded, *qos, *pace).Run();
}

}  // namespace fleetpub::cli
