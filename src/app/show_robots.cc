#include "app/show_robots.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <set>
#include <utility>

#include "app/ask_states.h"
#include "app/choose_robots.h"
#include "app/robot_discovery.h"
#include "base/text.h"
#include "vda5050/reports/discovery.h"
#include "vda5050/rules/preflight.h"

namespace fleetpub::app {
namespace {

using std::chrono::steady_clock;
using vda5050::RobotAddress;
using vda5050::RobotEntry;

// A robot's topic at the place at which it lives; "" when that is not known.
std::string FindTopic(const ListedRobot& robot, std::string_view topic_name) {
  const vda5050::TopicScheme& scheme = robot.second.base->topics;
  const auto levels = vda5050::ReadTopic(scheme, robot.second.topic, robot.first.manufacturer);
  if (!levels) return "";
  return vda5050::TopicBeside(scheme, *levels, topic_name).value_or("");
}

// What robots have said, by topic; the newest each, but nothing retained over what is live.
class Messages {
 public:
  void Take(const mqtt::Message& message) {
    mqtt::Message& last = messages_[message.topic];
    if (!last.payload.empty() && !last.retained && message.retained) return;
    const std::size_t kept = kept_ - last.payload.size() + message.payload.size();
    is_full_ = is_full_ || kept > kMost;
    if (kept > kMost) return;
    kept_ = kept;
    last = message;
  }
  /// Some were not kept.
  [[nodiscard]] bool is_full() const { return is_full_; }
  // Null: none, or it was deleted.
  [[nodiscard]] const mqtt::Message* Find(const std::string& topic) const {
    const auto found = messages_.find(topic);
    return found == messages_.end() || found->second.payload.empty() ? nullptr : &found->second;
  }

 private:
  static constexpr std::size_t kMost = std::size_t{64} << 20;

  std::map<std::string, mqtt::Message> messages_;
  std::size_t kept_ = 0;  // bytes
  bool is_full_ = false;
};

// Commands that changed nothing say nothing of a robot.
bool IsOnlyStateRequest(const ledger::Record& record) {
  return !record.actions.empty() &&
         std::all_of(record.actions.begin(), record.actions.end(),
                     [](const message::ActionRef& action) { return action.type == kStateRequest; });
}

class SheetReader {
 public:
  SheetReader(const ShowRequest& request, const Environment& environment, Log& log,
              vda5050::RobotDirectory& directory, const Excluded& excluded, Link& link)
      : request_(request),
        environment_(environment),
        log_(log),
        directory_(directory),
        excluded_(excluded),
        link_(link),
        server_(link.transport->server()) {}

  Result<ShownRobots> Run() {
    auto ok = Discover();
    if (ok) ok = ReadStates();
    if (!ok) return Fail(std::move(ok.error()));
    chosen_ = ChooseKnown();
    if (chosen_.empty() && unknown_.empty()) return Fail(NobodyKnown());
    if (ok = ReadFactsheets(); !ok) return Fail(std::move(ok.error()));
    ShownRobots shown{.sheets = {}, .unknown = NameUnknown()};
    if (link_.transport != nullptr) link_.transport->Disconnect();
    for (const ListedRobot* robot : chosen_) shown.sheets.push_back(MakeSheet(*robot));
    AddCommands(shown.sheets);
    if (messages_.is_full()) {
      log_.Warn(
          "robots say more than is kept: some messages are not shown; name fewer robots to see "
          "all");
    }
    return shown;
  }

 private:
  [[nodiscard]] delivery::RetainedOptions MakeRetainedOptions() {
    delivery::RetainedOptions options =
        environment_.recording ? PatientOptions() : request_.discover;
    options.subscribe = link_.connection.timeout;
    options.also = [this](const mqtt::Message& message) { messages_.Take(message); };
    return options;
  }

  // What a condition says of states waits until they were asked for.
  Status Discover() {
    const Targets targets{.include = request_.targets.include,
                          .except = request_.targets.except,
                          .where = {},
                          .state_wait = request_.targets.state_wait};
    auto ok = DiscoverRobots(*link_.transport, targets,
                             {.all = true,
                              .factsheets = true,
                              .discover = MakeRetainedOptions(),
                              .expected = FindExpectedRobots(request_.targets, request_.resolver,
                                                             environment_, server_)},
                             directory_, log_);
    if (!ok) return ok;
    const auto unused = UnusedExclusion(request_.targets, excluded_, environment_.config);
    if (unused) log_.Warn(fmt::format("--except {} matches no robot", base::Printable(*unused)));
    return {};
  }

  // Notes the others.
  std::vector<const ListedRobot*> ChooseKnown() {
    const Chosen chosen = Choose(request_.targets, directory_, log_);
    std::vector<const ListedRobot*> known;
    for (const ListedRobot* robot : chosen.robots) {
      (robot->second.WasHeard() ? known : unknown_).push_back(robot);
    }
    for (const ListedRobot* robot : chosen.unheard) {
      if (!robot->second.WasHeard()) {
        unknown_.push_back(robot);
      } else {
        log_.Warn(fmt::format("{} is not shown: it sent no state, so --where cannot be decided",
                              base::Printable(robot->first.ToString())));
      }
    }
    for (const ListedRobot* robot : known) {
      if (auto rival = vda5050::RivalText(robot->first, robot->second.Known())) log_.Warn(*rival);
    }
    return known;
  }

  [[nodiscard]] std::string Site() const {
    if (environment_.recording) return base::Printable(environment_.recording->name());
    return FormatSite(server_.broker, environment_.config.profile);
  }

  [[nodiscard]] Error NobodyKnown() const {
    const auto& robots = directory_.robots();
    const auto found = std::count_if(robots.begin(), robots.end(), [](const ListedRobot& robot) {
      return robot.second.IsKnown();
    });
    if (found > 0) {
      return {ErrorKind::kPreflight, fmt::format("{} found at {}, none satisfies every --where",
                                                 base::Counted(found, "robot"), Site())};
    }
    return {ErrorKind::kPreflight,
            fmt::format("{} knows no such robot: {}. try: fleetpub fleet", Site(),
                        server_.KeepsNothing() ? kNothingRetained
                                               : "none left a connection message or sent a state")};
  }

  std::vector<Error> NameUnknown() {
    std::vector<RobotAddress> names;
    for (const ListedRobot* robot : unknown_) names.push_back(robot->first);
    std::map<RobotAddress, std::string> nearest;
    if (link_.transport != nullptr) {
      nearest = FindNearNames(names, *link_.transport, request_.resolver.common().topics,
                              request_.discover);
    }
    std::vector<Error> errors;
    for (const RobotAddress& name : names) {
      const auto near = nearest.find(name);
      errors.push_back(
          {ErrorKind::kPreflight,
           fmt::format("{} is unknown to {}{}; {}fleetpub fleet shows who is there",
                       base::Printable(name.ToString()), Site(),
                       server_.KeepsNothing() ? fmt::format(": {}", kNothingRetained) : "",
                       near == nearest.end() ? "" : near->second + " ")});
    }
    return errors;
  }

  // Of those that are away, which discovery does not ask for theirs.
  Status ReadFactsheets() {
    if (link_.transport == nullptr) return {};
    std::vector<std::string> topics;
    for (const ListedRobot* robot : chosen_) {
      const RobotEntry& entry = robot->second;
      const bool may_have_one = !entry.own || entry.own->version > vda5050::Version::k110;
      if (entry.IsAlive() || entry.factsheet || !may_have_one) continue;
      if (auto topic = FindTopic(*robot, "factsheet"); !topic.empty()) {
        topics.push_back(std::move(topic));
      }
    }
    if (topics.empty()) return {};
    std::size_t left = topics.size();
    return delivery::ReadRetained(*link_.transport, topics, MakeRetainedOptions(),
                                  [&](const mqtt::Message& message) {
                                    Take(message, directory_);
                                    const bool is_one = message.topic.ends_with("factsheet");
                                    return is_one && --left == 0;
                                  });
  }

  // Of those that are there, until all have spoken or time is up.
  Status ReadStates() {
    std::set<std::string> silent;
    std::vector<const ListedRobot*> robots;
    for (const ListedRobot& robot : directory_.robots()) {
      if (!robot.second.IsAlive() || HasSpoken(robot) || IsOutOfQuestion(robot.second)) continue;
      auto topic = FindTopic(robot, "state");
      if (topic.empty()) continue;
      silent.insert(std::move(topic));
      robots.push_back(&robot);
    }
    if (silent.empty() || request_.targets.state_wait.count() == 0) return {};
    const std::vector<std::string> topics(silent.begin(), silent.end());
    auto ok = link_.transport->Subscribe(topics, mqtt::kListeningQos,
                                         steady_clock::now() + link_.connection.timeout);
    if (!ok) return ok;
    if (request_.ask) {
      AskForStates(robots, request_.targets.state_wait, link_, environment_, log_);
    }
    const auto end = steady_clock::now() + request_.targets.state_wait;
    log_.Wait("waiting for states", end);
    while (!silent.empty() && link_.transport != nullptr && !link_.transport->HasEnded() &&
           steady_clock::now() < end) {
      const auto message = link_.transport->Receive(end);
      if (!message) return Fail(message.error());
      if (!*message) continue;
      messages_.Take(**message);
      Take(**message, directory_);
      if (!(*message)->retained) silent.erase((*message)->topic);
    }
    log_.Wait("");
    return {};
  }

  // A condition is false of it already, whatever its state.
  static bool IsOutOfQuestion(const RobotEntry& entry) {
    return std::any_of(entry.unmet.begin(), entry.unmet.end(),
                       [](const auto& unmet) { return unmet && !unmet->empty(); });
  }

  [[nodiscard]] bool HasSpoken(const ListedRobot& robot) const {
    const mqtt::Message* const message = messages_.Find(FindTopic(robot, "state"));
    return message != nullptr && !message->retained;
  }

  [[nodiscard]] RobotSheet MakeSheet(const ListedRobot& robot) const {
    RobotSheet sheet = MakeRobotSheet(robot);
    sheet.waited = request_.targets.state_wait;
    sheet.is_recorded = environment_.recording != nullptr;
    const auto find_json = [&](std::string_view topic_name) {
      const mqtt::Message* const message = messages_.Find(FindTopic(robot, topic_name));
      return message == nullptr ? "" : vda5050::ToOneLine(message->payload);
    };
    sheet.connection_json = find_json("connection");
    sheet.state_json = find_json("state");
    sheet.factsheet_json = find_json("factsheet");
    if (const mqtt::Message* const message = messages_.Find(FindTopic(robot, "state"))) {
      auto state = vda5050::ReadState(message->payload);
      sheet.state_is_retained = message->retained;
      if (state) {
        sheet.state = *std::move(state);
      } else {
        sheet.state_fault = state.error().message;
      }
    }
    return sheet;
  }

  // A ledger that cannot be read hides no robot.
  void AddCommands(std::vector<RobotSheet>& sheets) const {
    if (sheets.empty()) return;
    if (environment_.recording) {
      for (RobotSheet& sheet : sheets) sheet.commands_fault = "the ledger was not asked";
      return;
    }
    const auto ledger = environment_.ledger(ledger::OpenMode::kReadOnly);
    for (RobotSheet& sheet : sheets) {
      constexpr int kRead = 100;
      auto records = ledger ? (*ledger)->History({.target = sheet.robot.ToString(), .limit = kRead})
                            : Fail(ledger.error());
      if (!records) {
        sheet.commands_fault = records.error().message;
        continue;
      }
      sheet.broker = server_.broker.ToString();
      std::erase_if(*records, IsOnlyStateRequest);
      constexpr std::size_t kShown = 5;
      const std::size_t shown = std::min(records->size(), kShown);
      sheet.commands.assign(
          std::make_move_iterator(records->end() - static_cast<std::ptrdiff_t>(shown)),
          std::make_move_iterator(records->end()));
    }
  }

  const ShowRequest& request_;
  const Environment& environment_;
  Log& log_;
  vda5050::RobotDirectory& directory_;
  const Excluded& excluded_;
  Link& link_;
  mqtt::ServerInfo server_;
  Messages messages_;
  std::vector<const ListedRobot*> chosen_;
  std::vector<const ListedRobot*> unknown_;
};

}  // namespace

Result<ShownRobots> ShowRobots(const ShowRequest& request, const Environment& environment,
                               Log& log) {
  Excluded excluded;
  auto directory = MakeDirectory(request.targets, request.resolver, excluded);
  if (!directory) return Fail(std::move(directory.error()));
  auto link = Connect(environment, log);
  if (!link) return Fail(std::move(link.error()));
  return SheetReader(request, environment, log, *directory, excluded, *link).Run();
}

}  // namespace fleetpub::app
