#include "app/run_batch.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "app/batch_input.h"
#include "app/command_factory.h"
#include "app/dry_run.h"
#include "app/robot_discovery.h"
#include "delivery/send_all.h"

namespace fleetpub::app {
namespace {

using message::Command;
using std::chrono::steady_clock;

constexpr std::size_t kLargestBatch = 1'000;

delivery::SendOptions ChooseSendOptions(const BatchRequest& request) {
  delivery::SendOptions send{.qos = request.settings.qos};
  // Each batch waits for the disk once. While nobody waits for a robot's answer, and no
  // acknowledgement comes, it may be as large as what a default broker queues.
  if (send.qos == mqtt::Qos::kAtMostOnce && !request.defaults.wait_for) send.batch = kLargestBatch;
  return send;
}

class Batch {
 public:
  Batch(base::LineReader lines, BatchRequest request, const Environment& environment,
        BatchObserver& observer, Log& log)
      : request_(std::move(request)),
        send_(ChooseSendOptions(request_)),
        environment_(environment),
        observer_(observer),
        log_(log),
        input_(std::move(lines), request_.defaults,
               request_.stop_on_error ? AfterDoubt::kPause : AfterDoubt::kGoOn,
               environment.schema_directory),
        factory_(environment.schema_directory) {
    request_.discover.also = [this](const mqtt::Message& message) {
      if (session_ != nullptr) session_->Deliver(message);
    };
  }

  // Errors: nothing was sent.
  Result<BatchEnd> Run() {
    auto ledger = environment_.ledger(ledger::OpenMode::kCreate);
    if (!ledger) return Fail(std::move(ledger.error()));
    auto link = Connect(environment_, log_);
    if (!link) return Fail(std::move(link.error()));
    observer_.Begin();
    send_.acknowledge_timeout = link->connection.timeout;
    request_.discover.subscribe = link->connection.timeout;
    transport_ = &link->transport;
    if (!request_.defaults.wait_for) {
      WarnOfSilentRefusals(link->connection.version, send_.qos, log_);
    }
    delivery::CommandSession session(link->transport, **ledger, send_, request_.wait,
                                     MakeHooks(link->connection));
    session_ = &session;
    while (!IsDone(session)) {
      if (MayRead(session)) SendWhatIsThere(session);
      LookForTheEnd(session);
      if (!IsDone(session)) Wait(session);
    }
    session_ = nullptr;
    if (link->transport != nullptr) link->transport->Disconnect();
    if (!session.trouble()) {
      log_.Warn(fmt::format("sent, but not every outcome is in the ledger: {}",
                            session.trouble().error().message));
    }
    if (held_) {
      for (const LineCommand& line : held_->commands) {
        ReportNotSent(line, {ErrorKind::kBroker, "the batch has ended"});
      }
    }
    end_.last_line = input_.number();
    end_.all_read = IsAllRead();
    return end_;
  }

  // What would be sent. Errors: the ledger cannot be read, or nobody reads the reports.
  Result<BatchEnd> Show() {
    auto dry_run = DryRun::Open(environment_.ledger);
    if (!dry_run) return Fail(std::move(dry_run.error()));
    std::optional<Link> link;
    const bool looks =
        request_.defaults.online || (!request_.settings.offline && environment_.names_broker);
    while (!input_.ended() && !(request_.stop_on_error && has_error_)) {
      input_.Await();
      held_ = input_.Take(send_.batch);
      const LineGroup& group = *held_;
      Report(group);
      if (looks && NeedsLook(group)) {
        if (!link) {
          auto opened = Connect(environment_, log_);
          if (!opened) return Fail(std::move(opened.error()));
          link = *std::move(opened);
          transport_ = &link->transport;
        }
        if (auto ok = Look(group); !ok) return Fail(std::move(ok.error()));
      }
      for (const Command& command : Build(*std::exchange(held_, {}))) {
        const auto report = dry_run->Report(command);
        Report(report ? *report
                      : BadLineReport(command.reference, {.id = {}, .target = command.target},
                                      report.error()));
      }
      if (auto flushed = observer_.Flush(); !flushed) return Fail(std::move(flushed.error()));
    }
    if (link) link->transport->Disconnect();
    return end_;
  }

 private:
  void Report(const message::Report& report) {
    has_error_ = has_error_ || report.error.has_value();
    observer_.Report(report);
  }
  // What is to be said of lines before anything is sent.
  void Report(const LineGroup& group) {
    for (const std::string& warning : group.warnings) log_.Warn(warning);
    for (const message::Report& bad : group.bad) Report(bad);
  }

  delivery::SessionHooks MakeHooks(const Connection& connection) {
    return {.report = [this](const message::Report& report) { Report(report); },
            .sent =
                [this] {
                  ++end_.sent;
                  observer_.Sent();
                },
            .reconnect = MakeReconnectHooks(connection, log_),
            .news = [this](std::string_view line) { log_.Info(line); }};
  }

  // Once no further line is taken: perhaps nothing is left but the end.
  [[nodiscard]] bool IsAllRead() {
    if (input_.ended()) return true;
    if (!input_.Ready()) return false;
    const LineGroup rest = input_.Take(1);
    return rest.is_last && rest.commands.empty() && rest.bad.empty();
  }

  [[nodiscard]] bool IsStopped() const { return end_.reason != BatchStop::kEndOfInput; }

  [[nodiscard]] bool IsDone(const delivery::CommandSession& session) const {
    return ((input_.ended() && !held_) || IsStopped()) && session.waiting() == 0;
  }

  // What arrives behind a signal is not sent.
  [[nodiscard]] bool MayRead(const delivery::CommandSession& session) const {
    const bool has_more = !input_.ended() || held_;
    return has_more && !IsStopped() && !observer_.IsStopped() && !session.lost() &&
           session.waiting() < delivery::kMostWaiting;
  }

  // The lines that one batch takes now.
  LineGroup TakeLines() {
    const auto now = steady_clock::now();
    const std::size_t most = std::min(request_.settings.rate.Available(now), send_.batch);
    LineGroup group = input_.Take(most);
    // While the ledger waits for the disk and the broker for us, the next lines are made ready.
    const bool reads_ahead = !request_.stop_on_error && !request_.settings.rate.IsLimited();
    if (reads_ahead && group.commands.size() >= most) input_.ReadAhead(most);
    request_.settings.rate.Consume(group.commands.size(), steady_clock::now());
    return group;
  }

  void SendWhatIsThere(delivery::CommandSession& session) {
    if (!held_) {
      held_ = TakeLines();
      Report(*held_);
    }
    if (NeedsLook(*held_)) {
      if (const auto looked = Look(*held_); !looked) {
        session.Listen(steady_clock::now());
        if (session.lost()) return;  // they are looked up once it is connected again
        KeepWhatMayLeave(looked.error());
      }
    }
    const std::vector<Command> commands = Build(*std::exchange(held_, {}));
    // A line with many targets may make more than a batch holds.
    std::span<const Command> left = commands;
    while (!left.empty()) {
      const auto some = left.first(std::min(left.size(), send_.batch));
      static_cast<void>(session.Send(some));  // the reports say it
      left = left.subspan(some.size());
    }
  }

  [[nodiscard]] static bool NeedsLook(const LineGroup& group) {
    return std::any_of(group.commands.begin(), group.commands.end(),
                       [](const LineCommand& line) { return !line.command; });
  }

  // What the robots of these lines say of themselves now.
  Status Look(const LineGroup& group) {
    mqtt::Transport& transport = **transport_;
    factory_.SetLook(request_.defaults.check, transport.server(), environment_.config.profile);
    directory_ = vda5050::RobotDirectory({}, {});
    bool factsheets = false;
    bool stops_only = true;
    for (const LineCommand& line : group.commands) {
      if (line.command) continue;
      directory_.Add(line.robot.robot, line.robot.dialect, line.robot.automatic);
      factsheets = factsheets || line.message->NeedsFactsheet();
      stops_only = stops_only && line.message->IsOnlyStartPause();
    }
    delivery::RetainedOptions discover = request_.discover;
    if (session_ != nullptr) discover.subscribed = &session_->subscribed();
    const DiscoveryOptions options{.all = request_.defaults.check || request_.defaults.online,
                                   .factsheets = request_.defaults.check && factsheets,
                                   .discover = discover};
    auto ok = DiscoverRobots(transport, {}, options, directory_, log_);
    if (!ok || stops_only) return ok;
    std::vector<const ListedRobot*> robots;
    for (const ListedRobot& robot : directory_.robots()) robots.push_back(&robot);
    factory_.SuggestNames(robots, transport, request_.topics, discover);
    return ok;
  }

  // In the order of the lines. What cannot be sent is reported at once.
  std::vector<Command> Build(LineGroup group) {
    std::vector<Command> commands;
    commands.reserve(group.commands.size());
    for (LineCommand& line : group.commands) {
      if (line.command) {
        commands.push_back(*std::move(line.command));
      } else {
        Build(line, commands);
      }
    }
    return commands;
  }

  void Build(const LineCommand& line, std::vector<Command>& commands) {
    const ListedRobot robot = Find(line);
    if (request_.defaults.online && !robot.second.IsAlive()) return ReportAway(line, robot);
    CommandFactory::Built built;
    const auto ok = factory_.Build(robot, RequestFor(line), built);
    if (!ok) {
      return Report(
          BadLineReport(line.reference, {.id = {}, .target = robot.first.ToString()}, ok.error()));
    }
    for (const std::string& warning : built.warnings) {
      log_.Warn(fmt::format("line {}: {}", line.line, warning));
    }
    for (message::Report& refused : built.refused) {
      refused.reference = line.reference;
      Report(refused);
    }
    for (Command& command : built.commands) {
      command.reference = line.reference;
      commands.push_back(std::move(command));
    }
  }

  // By --online: who is offline is left out, which is no error. Of whom nothing is known, nobody can
  // say it.
  void ReportAway(const LineCommand& line, const ListedRobot& robot) {
    using enum message::CommandStatus;
    const bool is_known = robot.second.WasHeard();
    const auto& connection = robot.second.connection;
    message::Report report = CommandFactory::ReportOn(
        robot, RequestFor(line), is_known ? kOffline : kRefused, ErrorKind::kPreflight,
        !is_known    ? "not sent: the broker has no message of it, so --online cannot be decided"
        : connection ? "not sent, by --online: " + vda5050::ConnectionText(*connection)
                     : "not sent, by --online: it is offline");
    if (is_known) report.error.reset();
    report.reference = line.reference;
    Report(report);
  }

  // Lines may state different versions for one robot.
  [[nodiscard]] ListedRobot Find(const LineCommand& line) const {
    const auto found = directory_.robots().find(line.robot.robot);
    const bool is_known = found != directory_.robots().end();
    vda5050::RobotEntry entry = is_known ? found->second : vda5050::RobotEntry();
    entry.base = line.robot.dialect;
    entry.automatic = line.robot.automatic;
    return {line.robot.robot, std::move(entry)};
  }

  [[nodiscard]] static RobotRequest RequestFor(const LineCommand& line) {
    return {.message = *line.message, .header_id = line.header_id, .wait_for = line.wait_for};
  }

  // Of the lines that are held. A refused look does not concern those that need none, and to stop is
  // not held back by it.
  void KeepWhatMayLeave(const Error& refused) {
    log_.Warn(refused.message);
    std::erase_if(held_->commands, [&](const LineCommand& line) {
      if (line.command || line.message->IsOnlyStartPause()) return false;
      ReportNotSent(line, refused);
      return true;
    });
  }

  void ReportNotSent(const LineCommand& line, const Error& error) {
    message::Report report =
        line.command ? message::ReportOn(*line.command)
                     : CommandFactory::ReportOn(Find(line), RequestFor(line),
                                                message::CommandStatus::kError, error.kind, "");
    report.status = message::CommandStatus::kError;
    report.error = error.kind;
    report.message = "not sent: " + error.message;
    report.reference = line.reference;
    Report(report);
  }

  // Whatever forbids to go on.
  void LookForTheEnd(delivery::CommandSession& session) {
    const auto flushed = observer_.Flush();
    if (IsStopped()) return;
    if (!session.lost()) lost_at_ = steady_clock::now();  // at the latest
    if (observer_.IsStopped()) {
      end_.reason = BatchStop::kStopped;
    } else if (!flushed) {
      end_.reason = BatchStop::kUnread;
    } else if (request_.stop_on_error && has_error_) {
      end_.reason = BatchStop::kFirstError;
    } else if (session.lost() && steady_clock::now() >= lost_at_ + request_.reconnect) {
      end_.reason = BatchStop::kNoConnection;
      session.EndAll(message::CommandStatus::kError,
                     {ErrorKind::kBroker,
                      "sent, but the connection was lost before the robot answered: whether it "
                      "was done is not known"});
    }
  }

  void Wait(delivery::CommandSession& session) {
    auto deadline = mqtt::Deadline::max();
    std::vector<int> wake;
    if (!observer_.IsStopped()) wake.push_back(observer_.stop_descriptor());
    if (session.lost() && !IsStopped()) deadline = lost_at_ + request_.reconnect;
    if (MayRead(session)) {
      const auto now = steady_clock::now();
      if (request_.settings.rate.Next() > now) {
        deadline = std::min(deadline, request_.settings.rate.Next());
      } else if (input_.Ready()) {
        deadline = now;
      } else {
        wake.push_back(input_.descriptor());
      }
    }
    session.WakeOn(std::move(wake));
    session.Listen(deadline);
  }

  BatchRequest request_;
  delivery::SendOptions send_;
  const Environment& environment_;
  BatchObserver& observer_;
  Log& log_;
  BatchInput input_;
  CommandFactory factory_;
  delivery::CommandSession* session_ = nullptr;            // of lines that are waited for
  std::unique_ptr<mqtt::Transport>* transport_ = nullptr;  // null inside while it is lost
  vda5050::RobotDirectory directory_{{}, {}};              // of the lines that were looked up last
  std::optional<LineGroup> held_;                          // they have yet to be looked up
  steady_clock::time_point lost_at_{};
  bool has_error_ = false;  // one of the reports is
  BatchEnd end_;
};

}  // namespace

Result<BatchEnd> RunBatch(base::LineReader lines, BatchRequest request,
                          const Environment& environment, BatchObserver& observer, Log& log) {
  const bool shows = request.settings.dry_run;
  Batch batch(std::move(lines), std::move(request), environment, observer, log);
  if (shows) return batch.Show();
  auto end = batch.Run();
  if (!end) end.error().message = "nothing was sent: " + end.error().message;
  return end;
}

}  // namespace fleetpub::app
