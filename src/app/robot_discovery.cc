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

bool Needs(const Targets& targets, std::string_view topic_name) {
  return std::any_of(targets.where.begin(), targets.where.end(), [&](const Condition& condition) {
    return vda5050::FindTopicName(condition) == topic_name;
  });
}

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

  std::vector<std::string> Take() { return std::move(filters_); }

 private:
  std::vector<std::string> filters_;
  std::set<std::string> known_;
};

RobotFilter Exactly(const RobotAddress& robot) {
  return {.manufacturer = robot.manufacturer, .serial_number = robot.serial_number};
}

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
        log_(log) {}

  Status Run() {
    const auto start = steady_clock::now();
    const bool finds = !targets_.include.patterns.empty();
    auto ok = ReadNamed();
    if (ok && finds) ok = ReadFound();
    if (ok && (finds || AnyMissing())) ok = ListenForLife();
    if (ok && finds && !handed_out_.any) ok = ReadConnections();
    if (ok && NeedsFactsheets()) ok = ReadFactsheets();
    if (ok && Needs(targets_, "state")) ok = AwaitStates(start + targets_.state_wait);
    return ok;
  }

 private:
  [[nodiscard]] bool NeedsFactsheets() const {
    return options_.factsheets || Needs(targets_, "factsheet");
  }
  [[nodiscard]] bool IsWanted(const RobotEntry& entry) const {
    return options_.all || !targets_.where.empty() || entry.automatic;
  }
  [[nodiscard]] bool HasFactsheet(const RobotEntry& entry) const {
    return !NeedsFactsheets() || entry.factsheet || !entry.factsheet_fault.empty();
  }
  // A robot may have left messages under another version long ago: only one that is there ends the
  // search at once, and not one that is ONLINE at two places, of which it lives at one.
  static bool IsDecided(const RobotEntry& entry) {
    return IsThere(entry) && (!entry.IsAlive() || entry.Rival() == nullptr);
  }
  static bool IsThere(const RobotEntry& entry) {
    const bool hibernates = entry.connection && entry.connection->connection_state == "HIBERNATING";
    return hibernates || entry.IsAlive();
  }
  [[nodiscard]] bool AnyMissing() const {
    const auto& robots = directory_.robots();
    return std::any_of(robots.begin(), robots.end(), [this](const auto& listed) {
      return IsWanted(listed.second) && !IsDecided(listed.second);
    });
  }

  const RobotEntry* Take(const mqtt::Message& message) {
    const auto origin = message.retained ? vda5050::Origin::kRetained : vda5050::Origin::kLive;
    const RobotEntry* entry = directory_.Deliver(message.topic, message.payload, origin);
    if (message.retained && entry != nullptr && message.topic == entry->topic) {
      retained_topic_ = message.topic;
    }
    return entry;
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
    if (NeedsFactsheets()) topics.emplace_back("factsheet");
    topics.emplace_back("connection");
    Filters filters;
    std::set<const RobotEntry*> waiting;
    for (const auto& [robot, entry] : directory_.robots()) {
      if (!IsWanted(entry)) continue;
      waiting.insert(&entry);
      if (auto ok = filters.Add(entry.base->topics, Exactly(robot), topics); !ok) return ok;
    }
    return Read(filters.Take(), std::move(waiting), options_.discover, IsDecided);
  }

  // Connection messages alone: with the large ones the broker's queue would run over sooner.
  Status ReadFound() {
    constexpr std::array<std::string_view, 1> kTopics = {"connection"};
    Filters filters;
    for (const vda5050::TopicScheme& scheme : directory_.schemes()) {
      for (const RobotPattern& pattern : targets_.include.patterns) {
        if (auto ok = filters.Add(scheme, pattern.Filter(), kTopics); !ok) return ok;
      }
    }
    auto handed_out = ReadWholeFleet(
        transport_,
        {.schemes = directory_.schemes(), .filters = filters.Take(), .expected = options_.expected},
        options_.discover, [&](const mqtt::Message& message) { Take(message); },
        [&] { return directory_.robots().size(); });
    if (!handed_out) return Fail(std::move(handed_out.error()));
    handed_out_ = *handed_out;
    WarnOfLimit(handed_out_, log_);
    return {};
  }

  // Robots that send states live, whatever their connection messages say or whether there are any.
  // RabbitMQ moreover has nothing retained for a filter with wildcards: the same by full names.
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
    for (const vda5050::TopicScheme& scheme : directory_.schemes()) {
      for (const RobotPattern& pattern : targets_.include.patterns) {
        if (auto ok = filters.Add(scheme, pattern.Filter(), kState); !ok) return ok;
      }
    }
    if (const auto unheard = Unheard();
        AreAskedByName(unheard, !handed_out_.any || handed_out_.limit > 0)) {
      if (auto ok = filters.Add(TopicsByName(unheard, "connection")); !ok) return ok;
    }
    auto options = options_.discover;
    if (!missing.empty() || !handed_out_.any)
      options.quiet = options.most = kLifeFactor * options.quiet;
    // Those of whom nothing is known may be found until the end.
    if (!targets_.include.patterns.empty()) missing.insert(nullptr);
    return Read(filters.Take(), std::move(missing), options, IsDecided);
  }

  [[nodiscard]] std::vector<ExpectedRobot> Unheard() const {
    return FindUnheard(options_.expected,
                       [this](const RobotAddress& robot) { return directory_.Knows(robot); });
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
    return Read(filters.Take(), std::move(waiting), options_.discover,
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

  // Each by its own topic, beside the one at which the robot lives. No broker promises that it comes
  // before or with the connection message.
  Status ReadFactsheets() {
    Filters filters;
    std::set<const RobotEntry*> waiting;
    for (const auto& [robot, entry] : directory_.robots()) {
      if (!LacksFactsheet(entry)) continue;
      waiting.insert(&entry);
      if (auto ok = AddBeside(robot, entry, "factsheet", filters); !ok) return ok;
    }
    auto options = options_.discover;
    options.marker = std::exchange(retained_topic_, "");
    if (!options.marker.empty()) {
      if (auto ok = filters.Add(std::vector<std::string>{options.marker}); !ok) return ok;
    }
    auto ok = Read(filters.Take(), std::move(waiting), options,
                   [this](const RobotEntry& entry) { return HasFactsheet(entry); });
    if (ok) TellUnchecked(!options.marker.empty() && retained_topic_ == options.marker);
    return ok;
  }

  // Of a robot that is offline nothing more is asked than whether it is meant.
  [[nodiscard]] bool LacksFactsheet(const RobotEntry& entry) const {
    const bool counts = IsThere(entry) || Needs(targets_, "factsheet");
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
        fmt::format("not held against {}: {}", robots.size() == 1 ? "a factsheet" : "factsheets",
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
    log_.Info(fmt::format("waiting up to {} for the states of {} robot{}",
                          base::FormatElapsed(targets_.state_wait), silent.size(),
                          silent.size() == 1 ? "" : "s"));
    const auto left = std::max(end - steady_clock::now(), steady_clock::duration(0));
    auto options = options_.discover;
    options.quiet = options.most = std::chrono::ceil<std::chrono::milliseconds>(left);
    return Read(filters.Take(), std::move(silent), options,
                [](const RobotEntry& entry) { return entry.state_heard || !entry.IsAlive(); });
  }

  mqtt::Transport& transport_;
  const Targets& targets_;
  const DiscoveryOptions& options_;
  RobotDirectory& directory_;
  Log& log_;
  HandedOut handed_out_;        // for filters with wildcards
  std::string retained_topic_;  // of the last connection message that was retained
};

enum class Answer { kYes, kNo, kUnheard, kOffline };

Answer Satisfies(const Targets& targets, const RobotEntry& entry) {
  Answer answer = Answer::kYes;
  for (std::size_t i = 0; i < targets.where.size(); ++i) {
    const auto unmet = i < entry.unmet.size() ? entry.unmet[i] : std::nullopt;
    if (unmet && unmet->empty()) continue;
    const bool is_state = vda5050::FindTopicName(targets.where[i]) == "state";
    if (unmet || !is_state) return Answer::kNo;
    answer = entry.IsAlive() ? Answer::kUnheard : Answer::kOffline;
  }
  return answer;
}

std::string FormatSpec(const Targets& targets) {
  std::vector<std::string> words;
  if (!targets.include.set.empty()) words.push_back(base::Printable(targets.include.set));
  for (const Condition& condition : targets.where) {
    words.push_back("--where " + base::Printable(vda5050::ToString(condition)));
  }
  return base::Join(words, " ");
}

// Why the first one of those that are meant was not chosen.
std::string FirstReason(const RobotDirectory& directory) {
  for (const auto& [robot, entry] : directory.robots()) {
    for (const auto& unmet : entry.unmet) {
      if (!unmet || unmet->empty()) continue;
      return fmt::format("; of {}, {}", base::Printable(robot.ToString()), *unmet);
    }
  }
  return "";
}

// Of those who have left a connection message under these filters.
std::vector<RobotAddress> ReadNames(mqtt::Transport& transport, const vda5050::TopicScheme& scheme,
                                    const std::vector<std::string>& filters,
                                    const delivery::RetainedOptions& discover, Robots which) {
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

Status DiscoverRobots(mqtt::Transport& transport, const Targets& targets,
                      const DiscoveryOptions& options, RobotDirectory& directory, Log& log) {
  return Discoverer(transport, targets, options, directory, log).Run();
}

std::vector<ExpectedRobot> FindExpectedRobots(const Targets& targets,
                                              const DialectResolver& resolver,
                                              const Environment& environment,
                                              const mqtt::BrokerUrl& broker) {
  const auto& patterns = targets.include.patterns;
  if (patterns.empty()) return {};
  return FindExpectedRobots(
      environment, broker, [&](const RobotAddress& robot) -> std::optional<vda5050::TopicScheme> {
        const auto matches = [&](const RobotPattern& pattern) { return pattern.Matches(robot); };
        const bool is_meant = std::any_of(patterns.begin(), patterns.end(), matches);
        if (!is_meant || targets.IsExcepted(robot)) return std::nullopt;
        const auto addressed = resolver.Resolve(robot);
        if (!addressed) return std::nullopt;
        return addressed->dialect->topics;
      });
}

Chosen Choose(const Targets& targets, const RobotDirectory& directory, Log& log) {
  Chosen chosen;
  std::vector<RobotAddress> offline;
  const auto consider = [&](const ListedRobot& listed) {
    switch (Satisfies(targets, listed.second)) {
      case Answer::kYes:
        return chosen.robots.push_back(&listed);
      case Answer::kUnheard:
        return chosen.unheard.push_back(&listed);
      case Answer::kOffline:
        return offline.push_back(listed.first);
      case Answer::kNo:
        return;
    }
  };
  std::set<RobotAddress> named;
  std::vector<RobotAddress> discovered;
  for (const RobotAddress& robot : targets.include.robots) {
    const auto found = directory.robots().find(robot);
    if (!targets.include.patterns.empty()) named.insert(robot);
    if (found->second.WasHeard() || targets.where.empty()) {
      consider(*found);
    } else {
      chosen.unheard.push_back(&*found);
    }
  }
  if (!targets.include.patterns.empty()) {
    for (const ListedRobot& listed : directory.robots()) {
      if (!listed.second.IsKnown() || named.contains(listed.first)) continue;
      discovered.push_back(listed.first);
      consider(listed);
    }
  }
  WarnOfEscapedNames(discovered, log);
  if (!offline.empty()) {
    log.Warn(fmt::format("left out, as they are offline and have left no state: {}",
                         FormatRobotList(offline)));
  }
  return chosen;
}

std::optional<std::string> UnusedExclusion(const Targets& targets, const Excluded& excluded,
                                           const config::Config& config) {
  if (targets.include.patterns.empty()) return std::nullopt;
  for (const RobotAddress& robot : targets.except.robots) {
    const bool is_configured =
        config.robots.contains(robot) ||
        std::any_of(config.group_robots.begin(), config.group_robots.end(), [&](const auto& group) {
          return std::find(group.second.begin(), group.second.end(), robot) != group.second.end();
        });
    if (!is_configured && !excluded.contains(robot)) return robot.ToString();
  }
  for (const RobotPattern& pattern : targets.except.patterns) {
    const bool spares =
        std::any_of(excluded.begin(), excluded.end(),
                    [&](const RobotAddress& robot) { return pattern.Matches(robot); });
    if (!spares) return pattern.manufacturer + "/" + pattern.serial_number;
  }
  return std::nullopt;
}

Error NobodyChosen(mqtt::Transport& transport, const Targets& targets,
                   const DialectResolver& resolver, const RobotDirectory& directory,
                   const delivery::RetainedOptions& discover, const std::string& site) {
  const auto meant =
      std::count_if(directory.robots().begin(), directory.robots().end(),
                    [](const ListedRobot& listed) { return listed.second.IsKnown(); });
  const std::string nobody =
      fmt::format("nothing was sent: no robot matches {} at {}", FormatSpec(targets), site);
  if (meant > 0) {
    return {ErrorKind::kPreflight,
            fmt::format("{}: {} robot{} heard, none satisfies every --where{}", nobody, meant,
                        meant == 1 ? " was" : "s were", FirstReason(directory))};
  }
  const auto all = ListRobots(transport, resolver.common().topics, discover, Robots::kAll);
  const std::string heard =
      !all.empty() ? fmt::format("it knows {} robot{}: {}", all.size(), all.size() == 1 ? "" : "s",
                                 FormatRobotList(all))
      : transport.server().KeepsNothing()
          ? std::string(kNothingRetained)
          : "it knows no robot: none has left a connection message, or the broker has nothing "
            "retained for patterns, as RabbitMQ: name the robots";
  return {ErrorKind::kPreflight,
          fmt::format("{}: {}{}", nobody, heard,
                      targets.except.set.empty() && targets.except.robots.empty()
                          ? ""
                          : " (--except spares some)")};
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
