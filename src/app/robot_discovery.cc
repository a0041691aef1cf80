#include "app/robot_discovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "app/whole_fleet.h"
#include "base/text.h"
#include "base/time.h"
#include "vda5050/reports/discovery.h"

namespace fleetpub::app {
namespace {

using std::chrono::steady_clock;
using vda5050::Condition;
using vda5050::RobotAddress;
using vda5050::RobotDirectory;
using vda5050::RobotEntry;
using vda5050::RobotFilter;
using vda5050::RobotPattern;

// What to subscribe to, each once.
class Filters {
 public:
  Status Add(const vda5050::TopicScheme& scheme, const RobotFilter& filter,
             std::span<const std::string_view> topic_names) {
    return Add(vda5050::DiscoveryFilters(scheme, filter, topic_names));
  }

  Status Add(Result<std::vector<std::string>> filters) {
    if (!filters) return Fail(std::move(filters.error()));
    for (std::string& one : *filters) {
      if (known_.insert(one).second) filters_.push_back(std::move(one));
    }
    return {};
  }

  // Of those that the patterns may find.
  Status Add(const Targets& targets, const RobotDirectory& directory,
             std::span<const std::string_view> topic_names) {
    for (const vda5050::TopicScheme& scheme : directory.schemes()) {
      for (const RobotPattern& pattern : targets.include.patterns) {
        if (auto ok = Add(scheme, pattern.Filter(), topic_names); !ok) return ok;
      }
    }
    return {};
  }

  std::vector<std::string> Take() { return std::move(filters_); }

 private:
  std::vector<std::string> filters_;
  std::set<std::string> known_;
};

RobotFilter Exactly(const RobotAddress& robot) {
  return {.manufacturer = robot.manufacturer, .serial_number = robot.serial_number};
}

constexpr std::chrono::milliseconds kTick{100};

// Robots at work send states every second or so, and all of them every 30 s (VDA 5050, chapter on
// the topic state): so many silences are listened for those that are not ONLINE.
constexpr int kLifeFactor = 5;

class Discoverer {
 public:
  Discoverer(mqtt::Transport& transport, const Targets& targets, const DiscoveryOptions& options,
             RobotDirectory& directory, Log& log)
      : transport_(transport),
        targets_(targets),
        options_(options),
        directory_(directory),
        log_(log),
        discover_(options.discover) {
    if (discover_.subscribed == nullptr) discover_.subscribed = &subscribed_;
  }

  Status Run() {
    auto end = steady_clock::now() + targets_.state_wait;
    const bool finds = !targets_.include.patterns.empty();
    auto ok = ReadNamed();
    if (ok && finds) ok = ReadFound();
    if (options_.states) {
      if (ok) ok = ReadByName();
      if (ok && options_.ask) ok = ReadFactsheets();  // they tell who can be asked
      if (ok) ok = SubscribeToStates();
      if (ok && options_.ask) ok = Ask(end);
      if (ok) ok = ReceiveStates(end);
    } else if (ok) {
      ok = ListenForLife();
    }
    if (ok && finds && !handed_out_.any) ok = ReadConnections();
    if (ok && NeedsFactsheets()) ok = ReadFactsheets();
    if (ok && !options_.states && Need(targets_.where, "state")) ok = AwaitStates(end);
    return ok;
  }

 private:
  [[nodiscard]] bool NeedsFactsheets() const {
    return options_.factsheets || Need(targets_.where, "factsheet");
  }
  [[nodiscard]] bool IsWanted(const RobotEntry& entry) const {
    return options_.all || targets_.AskAll() || entry.automatic;
  }
  [[nodiscard]] bool HasFactsheet(const RobotEntry& entry) const {
    return !NeedsFactsheets() || entry.factsheet || !entry.factsheet_fault.empty();
  }
  // A robot may have left messages under another version long ago: only one that is there ends the
  // search at once, and not one that is ONLINE at two places, of which it lives at one.
  static bool IsDecided(const RobotEntry& entry) {
    return IsThere(entry) && (!entry.IsAlive() || entry.Rival() == nullptr);
  }
  static bool IsSilent(const RobotEntry& entry) { return entry.IsAlive() && !entry.HasSpoken(); }
  static bool IsThere(const RobotEntry& entry) {
    const bool hibernates = entry.connection && entry.connection->connection_state == "HIBERNATING";
    return hibernates || entry.IsAlive();
  }

  const RobotEntry* Take(const mqtt::Message& message) {
    const ListedRobot* listed = app::Take(message, directory_);
    if (listed == nullptr) return nullptr;
    const RobotEntry& entry = listed->second;
    if (message.retained && message.topic == entry.topic) retained_topic_ = message.topic;
    return &entry;
  }

  // Until nothing is missing of these robots.
  Status Read(const std::vector<std::string>& filters, std::set<const RobotEntry*> waiting,
              const delivery::RetainedOptions& options, const auto& is_complete) {
    if (waiting.empty() || filters.empty()) return {};
    return delivery::ReadRetained(transport_, filters, options, [&](const mqtt::Message& message) {
      const RobotEntry* entry = Take(message);
      if (entry != nullptr && is_complete(*entry)) waiting.erase(entry);
      return waiting.empty();
    });
  }

  // Those that are named outright, by topics of their own. Most brokers send a factsheet along.
  Status ReadNamed() {
    std::vector<std::string_view> topics;
    if (options_.states) topics.emplace_back("state");
    if (NeedsFactsheets()) topics.emplace_back("factsheet");
    topics.emplace_back("connection");
    Filters filters;
    std::set<const RobotEntry*> waiting;
    for (const auto& [robot, entry] : directory_.robots()) {
      if (!IsWanted(entry)) continue;
      waiting.insert(&entry);
      if (auto ok = filters.Add(entry.base->topics, Exactly(robot), topics); !ok) return ok;
    }
    return Read(filters.Take(), std::move(waiting), discover_, IsDecided);
  }

  // Connection messages, with states at once only where they are waited for: with large ones the
  // broker's queue would run over sooner. In the order in which a broker hands them out, so that the
  // state of a robot is mostly there when its connection is. Else states come behind, and one silence
  // ends both: of robots that send states live, whatever their connection messages say or whether
  // there are any.
  Status ReadFound() {
    constexpr std::array<std::string_view, 1> kState = {"state"};
    std::vector<std::string_view> topics;
    if (options_.states) topics.emplace_back("state");
    topics.emplace_back("connection");
    Filters filters;
    Filters behind;
    if (auto ok = filters.Add(targets_, directory_, topics); !ok) return ok;
    if (auto ok = behind.Add(targets_, directory_, kState); !ok) return ok;
    auto options = discover_;
    if (!options_.states) options.behind = behind.Take();
    auto handed_out = ReadWholeFleet(
        transport_,
        {.schemes = directory_.schemes(), .filters = filters.Take(), .expected = options_.expected},
        options, [&](const mqtt::Message& message) { Take(message); },
        [&] { return directory_.robots().size(); });
    if (!handed_out) return Fail(std::move(handed_out.error()));
    handed_out_ = *handed_out;
    WarnOfLimit(handed_out_, log_);
    return {};
  }

  // Robots that are not ONLINE may send states all the same. RabbitMQ moreover has nothing retained
  // for a filter with wildcards: the same by full names.
  Status ListenForLife() {
    constexpr std::array<std::string_view, 1> kState = {"state"};
    std::vector<std::string_view> topics;
    if (NeedsFactsheets()) topics.emplace_back("factsheet");
    topics.emplace_back("connection");
    Filters filters;
    std::set<const RobotEntry*> missing;
    for (const auto& [robot, entry] : directory_.robots()) {
      if (!IsWanted(entry) || IsDecided(entry)) continue;
      missing.insert(&entry);
      const auto& scheme = entry.base->topics;
      if (auto ok = filters.Add(vda5050::TopicsAnywhere(scheme, robot, kState)); !ok) return ok;
      if (entry.WasHeard()) continue;
      if (auto ok = filters.Add(vda5050::SpecifiedTopics(scheme, robot, topics)); !ok) return ok;
    }
    if (auto ok = AddUnheard(filters); !ok) return ok;
    const bool finds = !targets_.include.patterns.empty();
    const bool is_late = !missing.empty() || (finds && !handed_out_.any);
    if (is_late) {
      if (auto ok = filters.Add(targets_, directory_, kState); !ok) return ok;
    }
    auto options = discover_;
    if (is_late) options.quiet = options.most = kLifeFactor * options.quiet;
    // Those of whom nothing is known may be found until the end.
    if (finds) missing.insert(nullptr);
    return Read(filters.Take(), std::move(missing), options, IsDecided);
  }

  Status AddUnheard(Filters& filters) const {
    const auto unheard = FindUnheard(
        options_.expected, [this](const RobotAddress& robot) { return directory_.Knows(robot); });
    const bool is_partial = !handed_out_.any || handed_out_.limit > 0;
    return AreAskedByName(unheard, is_partial) ? filters.Add(TopicsByName(unheard, "connection"))
                                               : Status();
  }

  // Those that should be there and were not heard.
  Status ReadByName() {
    constexpr std::array<std::string_view, 1> kConnection = {"connection"};
    Filters filters;
    for (const auto& [robot, entry] : directory_.robots()) {
      if (entry.WasHeard()) continue;
      const auto& scheme = entry.base->topics;
      if (auto ok = filters.Add(vda5050::SpecifiedTopics(scheme, robot, kConnection)); !ok) {
        return ok;
      }
    }
    if (auto ok = AddUnheard(filters); !ok) return ok;
    return Read(filters.Take(), {nullptr}, discover_,
                [](const RobotEntry& /*entry*/) { return false; });
  }

  Status ReceiveStates(mqtt::Deadline end) {
    std::set<const RobotEntry*> silent;
    for (const auto& [robot, entry] : directory_.robots()) {
      if (IsSilent(entry)) silent.insert(&entry);
    }
    const bool nobody = directory_.CountSeen() == 0;
    const bool is_told =
        handed_out_.any || (targets_.include.patterns.empty() && directory_.CountSeen() > 0);
    const auto goes_on = [&] {
      return !is_told || (nobody ? directory_.CountSeen() == 0 : !silent.empty());
    };
    auto next_tick = steady_clock::now();
    while (steady_clock::now() < end && goes_on() && !transport_.HasEnded()) {
      if (options_.tick && steady_clock::now() >= next_tick) {
        options_.tick();
        next_tick = steady_clock::now() + kTick;
      }
      const auto message = transport_.Receive(options_.tick ? std::min(end, next_tick) : end);
      if (!message) return Fail(message.error());
      if (!*message) continue;
      const RobotEntry* entry = Take(**message);
      if (entry != nullptr && entry->HasSpoken()) silent.erase(entry);
    }
    return {};
  }

  // Many filters were ended when what is retained had come.
  Status SubscribeToStates() {
    constexpr std::array<std::string_view, 1> kState = {"state"};
    Filters filters;
    if (auto ok = filters.Add(targets_, directory_, kState); !ok) return ok;
    for (const RobotAddress& robot : targets_.include.robots) {
      const RobotEntry& entry = directory_.robots().at(robot);
      if (!IsSilent(entry)) continue;
      if (auto ok = filters.Add(entry.base->topics, Exactly(robot), kState); !ok) return ok;
    }
    auto topics = filters.Take();
    std::erase_if(topics, [&](const std::string& topic) {
      return !discover_.subscribed->insert(topic).second;
    });
    for (std::span<const std::string> rest = topics; !rest.empty();) {
      const auto some = rest.first(std::min(rest.size(), delivery::kFiltersAtOnce));
      rest = rest.subspan(some.size());
      auto ok = transport_.Subscribe(some, mqtt::kListeningQos,
                                     steady_clock::now() + discover_.subscribe);
      if (!ok) return ok;
    }
    return {};
  }

  // Of robots that were found by their states, where a filter with wildcards brings none.
  Status ReadConnections() {
    Filters filters;
    std::set<const RobotEntry*> waiting;
    bool any = false;
    for (const auto& [robot, entry] : directory_.robots()) {
      any = any || entry.IsKnown();
      if (entry.connection || !entry.speaks) continue;
      waiting.insert(&entry);
      if (auto ok = AddBeside(robot, entry, "connection", filters); !ok) return ok;
    }
    if (any) WarnOfWildcards(transport_.server().broker, log_);
    return Read(filters.Take(), std::move(waiting), discover_,
                [](const RobotEntry& entry) { return entry.connection.has_value(); });
  }

  // A topic at the place at which the robot lives; none when that is not known.
  static Status AddBeside(const RobotAddress& robot, const RobotEntry& entry,
                          std::string_view topic_name, Filters& filters) {
    const auto& scheme = entry.base->topics;
    const auto levels = vda5050::ReadTopic(scheme, entry.topic, robot.manufacturer);
    if (!levels) return {};
    auto topic = vda5050::TopicBeside(scheme, *levels, topic_name);
    if (!topic) return Fail(std::move(topic.error()));
    return filters.Add(std::vector<std::string>{*std::move(topic)});
  }

  Status Ask(mqtt::Deadline& end) {
    auto ok = options_.ask();
    end = steady_clock::now() + targets_.state_wait;
    return ok;
  }

  // Once. Each by its own topic, beside the one at which the robot lives. No broker promises that it comes
  // before or with the connection message.
  Status ReadFactsheets() {
    if (std::exchange(has_read_factsheets_, true)) return {};
    Filters filters;
    std::set<const RobotEntry*> waiting;
    for (const auto& [robot, entry] : directory_.robots()) {
      if (!LacksFactsheet(entry)) continue;
      waiting.insert(&entry);
      if (auto ok = AddBeside(robot, entry, "factsheet", filters); !ok) return ok;
    }
    auto options = discover_;
    options.marker = std::exchange(retained_topic_, "");
    if (!options.marker.empty()) {
      if (auto ok = filters.Add(std::vector<std::string>{options.marker}); !ok) return ok;
    }
    auto ok = Read(filters.Take(), std::move(waiting), options,
                   [this](const RobotEntry& entry) { return HasFactsheet(entry); });
    if (ok && !options_.ask)
      TellUnchecked(!options.marker.empty() && retained_topic_ == options.marker);
    return ok;
  }

  // Of a robot that is offline nothing more is asked than whether it is meant.
  [[nodiscard]] bool LacksFactsheet(const RobotEntry& entry) const {
    const bool counts = IsThere(entry) || Need(targets_.where, "factsheet");
    return counts && IsWanted(entry) && entry.own && !HasFactsheet(entry);
  }

  // `answered`: what the broker has, it has sent.
  void TellUnchecked(bool answered) {
    std::vector<RobotAddress> robots;
    for (const auto& [robot, entry] : directory_.robots()) {
      if (LacksFactsheet(entry)) robots.push_back(robot);
    }
    if (robots.empty()) return;
    const std::string text =
        fmt::format("not checked against {}: {}", robots.size() == 1 ? "a factsheet" : "factsheets",
                    FormatRobotList(robots));
    if (answered) {
      log_.Info(text + ": the broker has none");
    } else {
      log_.Warn(text + ": none came in time");
    }
  }

  // Until every robot that is there has sent a state, or time is up.
  Status AwaitStates(mqtt::Deadline end) {
    constexpr std::array<std::string_view, 1> kTopics = {"state"};
    Filters filters;
    std::set<const RobotEntry*> silent;
    for (const auto& [robot, entry] : directory_.robots()) {
      if (!entry.IsAlive() || entry.state_heard) continue;
      silent.insert(&entry);
      if (auto ok = filters.Add(entry.base->topics, Exactly(robot), kTopics); !ok) return ok;
    }
    if (silent.empty()) return {};
    log_.Info(fmt::format("waiting up to {} for the states of {}",
                          base::FormatElapsed(targets_.state_wait),
                          base::Counted(silent.size(), "robot")));
    log_.Wait("waiting for the states of " + base::Counted(silent.size(), "robot"), end);
    const auto left = std::max(end - steady_clock::now(), steady_clock::duration(0));
    auto options = discover_;
    options.quiet = options.most = std::chrono::ceil<std::chrono::milliseconds>(left);
    auto ok = Read(filters.Take(), std::move(silent), options,
                   [](const RobotEntry& entry) { return entry.state_heard || !entry.IsAlive(); });
    log_.Wait("");
    return ok;
  }

  mqtt::Transport& transport_;
  const Targets& targets_;
  const DiscoveryOptions& options_;
  RobotDirectory& directory_;
  Log& log_;
  delivery::RetainedOptions discover_;
  delivery::Subscribed subscribed_;  // where nobody else keeps account of it
  HandedOut handed_out_;             // for filters with wildcards
  std::string retained_topic_;       // of the last connection message that was retained
  bool has_read_factsheets_ = false;
};

// Of those who have left a connection message under these filters.
std::vector<RobotAddress> ReadNames(mqtt::Transport& transport, const vda5050::TopicScheme& scheme,
                                    const std::vector<std::string>& filters,
                                    delivery::RetainedOptions discover, Robots which) {
  discover.keep = 0;  // robots that are listed are listened to otherwise, if at all
  std::set<RobotAddress> robots;
  const auto read =
      delivery::ReadRetained(transport, filters, discover, [&](const mqtt::Message& message) {
        const auto levels = vda5050::ReadTopic(scheme, message.topic);
        if (!levels || message.payload.empty()) return false;
        const auto connection = vda5050::ReadConnection(message.payload);
        const bool is_online = connection && connection->connection_state == "ONLINE";
        if (which == Robots::kAll || is_online) robots.insert(levels->robot);
        return false;
      });
  if (!read) return {};
  return {robots.begin(), robots.end()};
}

}  // namespace

Result<RobotDirectory> MakeDirectory(const Targets& targets, const DialectResolver& resolver,
                                     Excluded& excluded) {
  RobotDirectory::Admission admit;
  if (!targets.include.patterns.empty()) {
    admit = [&](const RobotAddress& robot)
        -> std::optional<std::pair<std::shared_ptr<const vda5050::Dialect>, bool>> {
      const auto matches = [&](const RobotPattern& pattern) { return pattern.Matches(robot); };
      const auto& patterns = targets.include.patterns;
      if (std::none_of(patterns.begin(), patterns.end(), matches)) return std::nullopt;
      if (targets.IsExcepted(robot)) {
        excluded.insert(robot);
        return std::nullopt;
      }
      auto found = resolver.Resolve(robot);
      if (!found) return std::nullopt;  // no table is wrong: Schemes() has read them all
      return std::pair(std::move(found->dialect), found->automatic);
    };
  }
  RobotDirectory directory(targets.where, std::move(admit));
  if (!targets.include.patterns.empty()) {
    const auto schemes = resolver.Schemes();
    if (!schemes) return Fail(schemes.error());
    for (const vda5050::TopicScheme& scheme : *schemes) directory.AddScheme(scheme);
  }
  for (const RobotAddress& robot : targets.include.robots) {
    auto addressed = resolver.Resolve(robot);
    if (!addressed) return Fail(std::move(addressed.error()));
    directory.Add(robot, std::move(addressed->dialect), addressed->automatic);
  }
  return directory;
}

bool Need(std::span<const Condition> conditions, std::string_view topic_name) {
  return std::any_of(conditions.begin(), conditions.end(), [&](const Condition& condition) {
    return vda5050::FindTopicName(condition) == topic_name;
  });
}

Result<std::vector<std::string>> ListFilters(const Targets& targets,
                                             const RobotDirectory& directory,
                                             std::span<const std::string_view> topic_names) {
  Filters filters;
  if (auto ok = filters.Add(targets, directory, topic_names); !ok) return Fail(ok.error());
  for (const RobotAddress& robot : targets.include.robots) {
    const auto& scheme = directory.robots().at(robot).base->topics;
    if (auto ok = filters.Add(scheme, Exactly(robot), topic_names); !ok) return Fail(ok.error());
  }
  return filters.Take();
}

const ListedRobot* Take(const mqtt::Message& message, RobotDirectory& directory) {
  const auto origin = message.retained ? vda5050::Origin::kRetained : vda5050::Origin::kLive;
  return directory.Deliver(message.topic, message.payload, origin);
}

Status DiscoverRobots(mqtt::Transport& transport, const Targets& targets,
                      const DiscoveryOptions& options, RobotDirectory& directory, Log& log) {
  return Discoverer(transport, targets, options, directory, log).Run();
}

std::vector<ExpectedRobot> FindExpectedRobots(const Targets& targets,
                                              const DialectResolver& resolver,
                                              const Environment& environment,
                                              const mqtt::ServerInfo& server) {
  const auto& patterns = targets.include.patterns;
  if (patterns.empty()) return {};
  return FindExpectedRobots(
      environment, server, [&](const RobotAddress& robot) -> std::optional<vda5050::TopicScheme> {
        const auto matches = [&](const RobotPattern& pattern) { return pattern.Matches(robot); };
        const bool is_meant = std::any_of(patterns.begin(), patterns.end(), matches);
        if (!is_meant || targets.IsExcepted(robot)) return std::nullopt;
        const auto addressed = resolver.Resolve(robot);
        if (!addressed) return std::nullopt;
        return addressed->dialect->topics;
      });
}

std::vector<RobotAddress> ListRobots(mqtt::Transport& transport, const vda5050::TopicScheme& scheme,
                                     const delivery::RetainedOptions& discover, Robots which) {
  constexpr std::array<std::string_view, 1> kConnection = {"connection"};
  const auto filters = vda5050::DiscoveryFilters(scheme, {}, kConnection);
  if (!filters) return {};
  return ReadNames(transport, scheme, *filters, discover, which);
}

std::vector<RobotAddress> ListByName(mqtt::Transport& transport, const vda5050::TopicScheme& scheme,
                                     const std::vector<ExpectedRobot>& expected,
                                     const delivery::RetainedOptions& discover) {
  const auto topics = TopicsByName(expected, "connection");
  if (!topics || topics->empty()) return {};
  return ReadNames(transport, scheme, *topics, discover, Robots::kAll);
}

std::map<RobotAddress, std::string> FindNearNames(std::span<const RobotAddress> unknown,
                                                  mqtt::Transport& transport,
                                                  const vda5050::TopicScheme& scheme,
                                                  const delivery::RetainedOptions& discover) {
  constexpr std::size_t kMost = 20;
  std::map<RobotAddress, std::string> found;
  if (unknown.empty() || unknown.size() > kMost) return found;
  std::vector<std::string> online;  // only who is there may be meant
  for (const auto& robot : ListRobots(transport, scheme, discover, Robots::kOnline)) {
    online.push_back(robot.ToString());
  }
  const std::vector<std::string_view> candidates(online.begin(), online.end());
  for (const RobotAddress& robot : unknown) {
    const auto nearest = base::Nearest(robot.ToString(), candidates);
    if (nearest) found[robot] = fmt::format("did you mean {}?", base::Printable(*nearest));
  }
  return found;
}

}  // namespace fleetpub::app
