#include "app/fleet_discovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <set>

#include "app/ask_states.h"
#include "app/expected_robots.h"
#include "app/robot_discovery.h"
#include "app/targets.h"
#include "app/whole_fleet.h"
#include "base/text.h"
#include "base/time.h"
#include "delivery/subscription.h"
#include "vda5050/reports/discovery.h"

namespace fleetpub::app {
namespace {

using std::chrono::steady_clock;
using vda5050::FleetView;
using vda5050::RobotAddress;
using vda5050::RobotView;

// Online robots that have not said how they are.
std::set<RobotAddress> Silent(const FleetView& view) {
  std::set<RobotAddress> silent;
  for (const RobotView* robot : view.robots()) {
    if (robot->IsOnline() && !robot->HasSpoken()) silent.insert(robot->robot);
  }
  return silent;
}

const RobotView* Take(const mqtt::Message& message, FleetView& view) {
  const auto origin = message.retained ? vda5050::Origin::kRetained : vda5050::Origin::kLive;
  return view.Deliver(message.topic, message.payload, origin);
}

// One asking of a fleet.
class FleetReader {
 public:
  FleetReader(mqtt::Transport& transport, const delivery::RetainedOptions& discover,
              FleetView& view)
      : transport_(transport), discover_(discover), view_(view) {}

  /// `ask` may have robots send their states; it may be empty.
  Status Run(std::chrono::milliseconds state_wait, const std::vector<ExpectedRobot>& expected,
             const std::function<Status()>& ask) {
    auto end = steady_clock::now() + state_wait;
    auto ok = ReadRetained(expected);
    if (ok) ok = ReadByName(expected);
    if (ok && ask) {
      ok = ask();
      end = steady_clock::now() + state_wait;
    }
    if (ok) ok = AwaitStates(end);
    if (ok && !handed_out_.any) ok = ReadConnections();
    return ok;
  }
  /// For filters with wildcards.
  [[nodiscard]] const HandedOut& handed_out() const { return handed_out_; }

 private:
  Status ReadRetained(const std::vector<ExpectedRobot>& expected) {
    auto filters = view_.Filters();
    if (!filters) return Fail(std::move(filters.error()));
    auto handed_out = ReadWholeFleet(
        transport_,
        {.schemes = {&view_.scheme(), 1}, .filters = *std::move(filters), .expected = expected},
        discover_, [&](const mqtt::Message& message) { Take(message, view_); },
        [&] { return view_.size(); });
    if (!handed_out) return Fail(std::move(handed_out.error()));
    handed_out_ = *handed_out;
    return {};
  }

  Status ReadByName(const std::vector<ExpectedRobot>& expected) {
    const auto unheard =
        FindUnheard(expected, [&](const RobotAddress& robot) { return view_.Knows(robot); });
    if (!AreAskedByName(unheard, !handed_out_.any || handed_out_.limit > 0)) return {};
    const auto topics = TopicsByName(unheard, "connection");
    if (!topics) return Fail(topics.error());
    return Read(*topics);
  }

  // Of those who were found by their states.
  Status ReadConnections() {
    std::vector<std::string> topics;
    for (const RobotView* robot : view_.robots()) {
      if (!robot->connection_state.empty()) continue;
      auto topic = vda5050::TopicBeside(view_.scheme(),
                                        {.robot = robot->robot,
                                         .interface_name = robot->interface_name,
                                         .major = robot->topic_level,
                                         .topic_name = {}},
                                        "connection");
      if (topic) topics.push_back(*std::move(topic));
    }
    return topics.empty() ? Status() : Read(topics);
  }

  Status Read(const std::vector<std::string>& topics) {
    return delivery::ReadRetained(transport_, topics, discover_, [&](const mqtt::Message& message) {
      Take(message, view_);
      return false;
    });
  }

  // What the robots that are online say, until all have spoken; if none is known, until one does; and
  // until the end where the broker tells of nobody.
  Status AwaitStates(mqtt::Deadline end) {
    auto silent = Silent(view_);
    const bool nobody = view_.size() == 0;
    const auto goes_on = [&] {
      return !handed_out_.any || (nobody ? view_.size() == 0 : !silent.empty());
    };
    while (steady_clock::now() < end && goes_on()) {
      const auto message = transport_.Receive(end);
      if (!message) return Fail(message.error());
      if (!*message) continue;
      const RobotView* robot = Take(**message, view_);
      if (robot != nullptr && robot->HasSpoken()) silent.erase(robot->robot);
    }
    return {};
  }

  mqtt::Transport& transport_;
  const delivery::RetainedOptions& discover_;
  FleetView& view_;
  HandedOut handed_out_;
};

Error NoRobot(const mqtt::ServerInfo& server, const std::string& profile,
              const std::vector<std::string>& words) {
  const std::string_view why =
      server.KeepsNothing() ? kNothingRetained : "none has left a connection message";
  return {ErrorKind::kPreflight,
          fmt::format("{} knows no robot{}: {}, and none sent a state",
                      FormatSite(server.broker, profile),
                      words.empty() ? "" : " " + FormatFleetName(words), why)};
}

// Robots that are named are looked for as patterns are.
Result<std::vector<vda5050::RobotPattern>> ParsePatterns(const FleetRequest& request,
                                                         const config::Config& config, Log& log) {
  auto spec = ParseTargetSpec(request.words, config, log);
  if (!spec) return Fail(std::move(spec.error()));
  auto patterns = std::move(spec->patterns);
  for (const RobotAddress& robot : spec->robots) {
    patterns.push_back(vda5050::RobotPattern::Of(robot));
  }
  if (patterns.empty()) patterns.emplace_back();
  return patterns;
}

// An empty view of the robots that are meant. Errors: ErrorKind::kUsage.
Result<FleetView> MakeFleetView(const FleetRequest& request,
                                std::vector<vda5050::RobotPattern> patterns,
                                const config::Config& config) {
  const auto dialect = ParseDialect(WithConfig(request.vda, config));
  if (!dialect) return Fail(dialect.error());
  return FleetView(dialect->topics, std::move(patterns));
}

// How each is spoken to and whether it has the action tell its own messages, the factsheet too.
Status AskFleet(const FleetRequest& request, std::vector<vda5050::RobotPattern> patterns,
                Link& link, const Environment& environment, FleetView& view, Log& log) {
  const Targets targets{.include = {.robots = {}, .patterns = std::move(patterns), .set = {}}};
  const auto resolver = DialectResolver::Make(request.vda, environment.config);
  if (!resolver) return Fail(resolver.error());
  Excluded excluded;
  auto directory = MakeDirectory(targets, *resolver, excluded);
  if (!directory) return Fail(std::move(directory.error()));
  DiscoveryOptions options{.all = true, .factsheets = true, .discover = request.discover};
  options.discover.also = [&](const mqtt::Message& message) { Take(message, view); };
  auto ok = DiscoverRobots(*link.transport, targets, options, *directory, log);
  if (!ok) return ok;
  std::vector<const ListedRobot*> robots;
  for (const ListedRobot& robot : directory->robots()) robots.push_back(&robot);
  AskForStates(robots, request.state_wait, link, environment, log);
  if (link.transport != nullptr) return {};
  return Fail(ErrorKind::kBroker,
              "the connection was lost in asking robots for their states. "
              "try: without --ask");
}

}  // namespace

std::string FormatFleetName(const std::vector<std::string>& words) {
  return words.empty() ? "all" : base::Printable(base::Join(words, " "));
}

std::string AbridgedWarning(std::size_t robots) {
  return fmt::format(
      "robots say more than is kept: of {} of them the worst error is shown, texts are cut with "
      "…, and requests are left out. try: fewer TARGETs",
      robots);
}

Result<FleetView> DiscoverFleet(const FleetRequest& request, const Environment& environment,
                                Log& log) {
  const auto patterns = ParsePatterns(request, environment.config, log);
  if (!patterns) return Fail(patterns.error());
  auto view = MakeFleetView(request, *patterns, environment.config);
  if (!view) return Fail(std::move(view.error()));
  auto link = Connect(environment, log);
  if (!link) return Fail(link.error());
  delivery::RetainedOptions discover = request.discover;
  discover.subscribe = link->connection.timeout;
  const mqtt::ServerInfo server = link->transport->server();
  const auto expected =
      FindExpectedRobots(environment, server.broker,
                         [&](const RobotAddress& robot) -> std::optional<vda5050::TopicScheme> {
                           if (!view->IsMeant(robot)) return std::nullopt;
                           return view->scheme();
                         });
  FleetReader reader(*link->transport, discover, *view);
  std::function<Status()> ask;
  if (request.ask && request.state_wait.count() > 0) {
    ask = [&] { return AskFleet(request, *patterns, *link, environment, *view, log); };
  }
  auto ok = reader.Run(request.state_wait, expected, ask);
  if (!ok) return Fail(std::move(ok.error()));
  link->transport->Disconnect();
  if (view->size() == 0) return Fail(NoRobot(server, environment.config.profile, request.words));
  WarnOfLimit(reader.handed_out(), log);
  if (!reader.handed_out().any) WarnOfWildcards(server.broker, log);
  WarnOfUnheard(
      FindUnheard(expected, [&](const RobotAddress& robot) { return view->Knows(robot); }), log);
  std::vector<RobotAddress> found;
  for (const RobotView* robot : view->robots()) found.push_back(robot->robot);
  WarnOfEscapedNames(found, log);
  if (view->abridged() > 0) log.Warn(AbridgedWarning(view->abridged()));
  if (const std::size_t silent = Silent(*view).size();
      silent > 0 && request.state_wait.count() > 0) {
    log.Warn(fmt::format(
        "{} of {} robots sent no state within {}; they repeat it at least every 30 s{}", silent,
        view->size(), base::FormatElapsed(request.state_wait),
        request.state_wait < std::chrono::seconds(35) ? ": --state-wait 35s waits for it" : ""));
  }
  return view;
}

Status WatchFleet(const FleetRequest& request, mqtt::Deadline end, const Environment& environment,
                  const DisplayHook& make_display, Log& log) {
  const auto patterns = ParsePatterns(request, environment.config, log);
  if (!patterns) return Fail(patterns.error());
  auto view = MakeFleetView(request, *patterns, environment.config);
  if (!view) return Fail(std::move(view.error()));
  auto filters = view->Filters();
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
  display = make_display(broker);
  auto watched = subscription->Read(
      [&](const mqtt::Message& message) {
        if (const RobotView* robot = Take(message, *view)) display->Changed(*robot);
        return false;
      },
      [&] { return display->Refresh(*view); });
  if (watched) subscription->Disconnect();
  return watched;
}

}  // namespace fleetpub::app
