#include "app/fleet_discovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "app/ask_states.h"
#include "app/expected_robots.h"
#include "base/text.h"
#include "base/time.h"
#include "delivery/subscription.h"

namespace fleetpub::app {
namespace {

using vda5050::RobotAddress;

Error NoRobot(const mqtt::ServerInfo& server, const std::string& profile, const Fleet& fleet) {
  const std::string name = fleet.name();
  const std::string_view why =
      server.KeepsNothing() ? kNothingRetained : "none has left a connection message";
  return {ErrorKind::kPreflight,
          fmt::format("{} knows no robot{}: {}, and none sent a state",
                      FormatSite(server.broker, profile), name == "all" ? "" : " " + name, why)};
}

Error NoRobotIn(const delivery::PlayedRecording& recording, const Fleet& fleet) {
  const std::string name = fleet.name();
  return {ErrorKind::kPreflight,
          fmt::format("{} has no message of a robot{}", base::Printable(recording.name()),
                      name == "all" ? "" : " " + name)};
}

// Who is there and has not said how it is.
void WarnOfSilent(const Fleet& fleet, const Environment& environment, bool asked, Log& log) {
  const auto state_wait = fleet.targets().state_wait;
  std::size_t seen = 0;
  std::size_t silent = 0;
  std::vector<RobotAddress> undecided;
  for (const ListedRobot& listed : fleet.directory().robots()) {
    const auto& [robot, entry] = listed;
    if (!entry.WasSeen()) continue;
    ++seen;
    if (entry.IsAlive() && !entry.HasSpoken()) ++silent;
    if (Satisfies(fleet.targets(), entry) == Answer::kUnheard) undecided.push_back(robot);
  }
  if (silent > 0 && environment.recording) {
    log.Warn(fmt::format("of {} of {} the recording has no state", silent,
                         base::Counted(seen, "robot")));
  } else if (silent > 0 && state_wait.count() > 0) {
    log.Warn(fmt::format("{} of {} sent no state within {}; they repeat it at least every 30 s{}",
                         silent, base::Counted(seen, "robot"), base::FormatElapsed(state_wait),
                         state_wait >= vda5050::kLongestSilence ? ""
                         : asked                                ? ": --state-wait 35s waits for it"
                                                                : ": --ask has them send it"));
  }
  if (!undecided.empty()) {
    log.Warn("not shown, as --where cannot be decided: " + FormatRobotList(undecided));
  }
}

void Warn(const Fleet& fleet, const std::vector<ExpectedRobot>& expected,
          const Environment& environment, bool asked, Log& log) {
  const auto& directory = fleet.directory();
  WarnOfUnheard(FindUnheard(expected,
                            [&](const RobotAddress& robot) {
                              const auto found = directory.robots().find(robot);
                              return found != directory.robots().end() && found->second.WasSeen();
                            }),
                log);
  if (const auto unused = UnusedExclusion(fleet.targets(), fleet.excluded(), environment.config)) {
    log.Warn(fmt::format("--except {}: no such robot was found", base::Printable(*unused)));
  }
  std::vector<RobotAddress> found;
  for (const ListedRobot* robot : fleet.robots()) found.push_back(robot->first);
  WarnOfEscapedNames(found, log);
  if (directory.abridged() > 0) log.Warn(AbridgedWarning(directory.abridged()));
  WarnOfSilent(fleet, environment, asked, log);
  if (found.empty()) {
    log.Info(fmt::format("{} found, none matches {}", base::Counted(directory.CountSeen(), "robot"),
                         fleet.name()));
  }
}

constexpr std::chrono::seconds kAskPatience{2};

// For those whose screen has one line for it.
class FirstWarning final : public Log {
 public:
  void Warn(std::string_view text) override {
    if (text_.empty()) text_ = text;
  }
  void Info(std::string_view /*text*/) override {}
  void Debug(std::string_view /*text*/) override {}
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

// Whether a robot has the action its factsheet tells.
Status AskFleet(const Fleet& fleet, Link& link, const Environment& environment, Log& log) {
  auto robots = fleet.robots();
  std::erase_if(robots, [](const ListedRobot* robot) { return robot->second.HasSpoken(); });
  AskForStates(robots, fleet.targets().state_wait, link, environment, log);
  if (link.transport != nullptr) return {};
  return Fail(ErrorKind::kBroker,
              "the connection was lost while robots were asked for their states: leave out --ask");
}

}  // namespace

Result<Fleet> Fleet::Make(FleetRequest request, const config::Config& config, Log& log) {
  std::string words = base::Printable(base::Join(request.targets.words, " "));
  if (words.empty()) request.targets.all = true;
  auto targets = ResolveTargets(std::move(request.targets), config, log);
  if (!targets) return Fail(std::move(targets.error()));
  auto resolver = DialectResolver::Make(request.vda, config);
  if (!resolver) return Fail(std::move(resolver.error()));
  Fleet fleet(std::make_unique<Parts>(Parts{.targets = *std::move(targets),
                                            .resolver = *std::move(resolver),
                                            .words = std::move(words),
                                            .problems = request.problems}));
  Parts& parts = *fleet.parts_;
  auto directory = MakeDirectory(parts.targets, parts.resolver, parts.excluded);
  if (!directory) return Fail(std::move(directory.error()));
  parts.directory = *std::move(directory);
  parts.directory.KeepStates();
  return fleet;
}

const ListedRobot* Fleet::Take(const mqtt::Message& message) {
  return app::Take(message, parts_->directory);
}

bool Fleet::Shows(const ListedRobot& robot) const {
  const vda5050::RobotEntry& entry = robot.second;
  return entry.WasSeen() && (!parts_->targets.online || entry.IsAlive()) &&
         (!parts_->problems || vda5050::HasProblem(entry)) &&
         Satisfies(parts_->targets, entry) == Answer::kYes;
}

bool Fleet::Shows(const RobotAddress& robot) const {
  const auto found = parts_->directory.robots().find(robot);
  return found != parts_->directory.robots().end() && Shows(*found);
}

std::vector<const ListedRobot*> Fleet::robots() const {
  std::vector<const ListedRobot*> robots;
  for (const ListedRobot& robot : parts_->directory.robots()) {
    if (Shows(robot)) robots.push_back(&robot);
  }
  return robots;
}

Result<std::vector<std::string>> Fleet::Filters() const {
  std::vector<std::string_view> topics = {"state", "connection"};
  if (Need(parts_->targets.where, "factsheet")) topics.insert(topics.begin(), "factsheet");
  return ListFilters(parts_->targets, parts_->directory, topics);
}

std::string Fleet::name() const {
  std::string name = parts_->words.empty() ? "all" : parts_->words;
  for (const vda5050::Condition& condition : parts_->targets.where) {
    name += " --where " + base::Printable(vda5050::ToString(condition));
  }
  if (parts_->targets.online) name += " --online";
  if (parts_->problems) name += " --problems";
  return name;
}

std::string AbridgedWarning(std::size_t robots) {
  return fmt::format(
      "robots say more than is kept: of {} of them only the worst error is shown, texts are cut "
      "with …, and requests are left out; name fewer robots to see all",
      robots);
}

Result<Fleet> DiscoverFleet(FleetRequest request, const Environment& environment,
                            const FleetHook& progress, Log& log) {
  const auto discover = request.discover;
  const bool asks = request.ask;
  auto fleet = Fleet::Make(std::move(request), environment.config, log);
  if (!fleet) return fleet;
  auto link = Connect(environment, log);
  if (!link) return Fail(link.error());
  const mqtt::ServerInfo server = link->transport->server();
  const bool is_recorded = environment.recording != nullptr;
  DiscoveryOptions options{
      .all = true,
      .states = true,
      .discover = is_recorded ? PatientOptions() : discover,
      .expected = FindExpectedRobots(fleet->targets(), fleet->resolver(), environment, server)};
  options.discover.subscribe = link->connection.timeout;
  if (progress) options.tick = [&] { progress(*fleet); };
  if (asks && fleet->targets().state_wait.count() > 0) {
    options.factsheets = true;
    options.ask = [&] { return AskFleet(*fleet, *link, environment, log); };
  }
  auto ok = DiscoverRobots(*link->transport, fleet->targets(), options, fleet->directory(), log);
  if (!ok) return Fail(std::move(ok.error()));
  link->transport->Disconnect();
  if (fleet->directory().CountSeen() == 0) {
    if (is_recorded) return Fail(NoRobotIn(*environment.recording, *fleet));
    return Fail(NoRobot(server, environment.config.profile, *fleet));
  }
  Warn(*fleet, options.expected, environment, asks, log);
  return fleet;
}

Status WatchFleet(FleetRequest request, mqtt::Deadline end, const Environment& environment,
                  const DisplayHook& make_display, Log& log) {
  auto fleet = Fleet::Make(std::move(request), environment.config, log);
  if (!fleet) return Fail(std::move(fleet.error()));
  auto filters = fleet->Filters();
  if (!filters) return Fail(std::move(filters.error()));
  auto link = Connect(environment, log);
  if (!link) return Fail(std::move(link.error()));
  const mqtt::BrokerUrl broker = link->transport->server().broker;
  std::unique_ptr<FleetDisplay> display;
  auto subscription =
      delivery::Subscription::Open(std::move(link->transport), *std::move(filters),
                                   {.open = link->connection.open,
                                    .lost = [&](const Error& error) { display->Lost(error); },
                                    .again = [&] { display->ConnectedAgain(); }},
                                   end);
  if (!subscription) return Fail(std::move(subscription.error()));
  display = make_display(broker, *fleet, [&](const std::vector<RobotAddress>& names) {
    std::vector<const ListedRobot*> robots;
    robots.reserve(names.size());
    for (const RobotAddress& name : names) {
      robots.push_back(&*fleet->directory().robots().find(name));
    }
    FirstWarning warning;
    subscription->Lend([&](std::unique_ptr<mqtt::Transport>& transport) {
      Link lent{link->connection, std::move(transport)};
      AskForStates(robots, kAskPatience, lent, environment, warning);
      transport = std::move(lent.transport);
    });
    return warning.text().empty() ? fmt::format("asked for states: {}", FormatRobotList(names))
                                  : warning.text();
  });
  auto watched = subscription->Read(
      [&](const mqtt::Message& message) {
        const ListedRobot* robot = fleet->Take(message);
        if (robot != nullptr && fleet->Shows(*robot)) display->Changed(*robot);
        return false;
      },
      [&] { return display->Refresh(*fleet); });
  if (watched) subscription->Disconnect();
  return watched;
}

}  // namespace fleetpub::app
