#include "app/robot_discovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <utility>

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
    return vda5050::TopicOf(condition) == topic_name;
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

// The robot's topics in whichever interface and version.
Result<std::vector<std::string>> AnyTopics(const vda5050::TopicScheme& scheme,
                                           const RobotAddress& robot,
                                           std::span<const std::string_view> topic_names) {
  return vda5050::DiscoveryFilters(scheme, Exactly(robot), topic_names);
}

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
    auto ok = ReadNamed();
    if (ok && !targets_.include.patterns.empty()) ok = ReadFound();
    if (ok && NeedsFactsheets() && !targets_.include.patterns.empty()) ok = ReadFactsheets();
    if (ok && Needs(targets_, "state")) ok = AwaitStates(start + targets_.state_wait);
    return ok;
  }

 private:
  [[nodiscard]] bool NeedsFactsheets() const {
    return options_.check || Needs(targets_, "factsheet");
  }

  void Take(const mqtt::Message& message) {
    const auto origin = message.retained ? vda5050::Origin::kRetained : vda5050::Origin::kLive;
    directory_.Deliver(message.topic, message.payload, origin);
  }

  // Those that are named outright, by topics of their own.
  Status ReadNamed() {
    if (auto ok = ReadUnheard(AnyTopics); !ok) return ok;
    // RabbitMQ has nothing retained for a filter with wildcards.
    return ReadUnheard(vda5050::SpecifiedTopics);
  }

  // Those of them that were not heard yet.
  Status ReadUnheard(const auto& topics_of) {
    // In the order in which a broker hands them out: when the connection message is there, so is
    // the factsheet.
    constexpr std::array<std::string_view, 2> kTopics = {"factsheet", "connection"};
    const bool all = options_.check || !targets_.where.empty();
    Filters filters;
    std::size_t wanted = directory_.online();
    const std::size_t known = wanted;
    for (const auto& [robot, entry] : directory_.robots()) {
      if (entry.WasHeard() || (!all && !entry.automatic)) continue;
      ++wanted;
      if (auto ok = filters.Add(topics_of(entry.base->topics, robot, kTopics)); !ok) return ok;
    }
    if (wanted == known) return {};
    // A robot may have left messages under another version long ago: only ONLINE ends the search at
    // once.
    return delivery::ReadRetained(transport_, filters.Take(), options_.discover,
                                  [&](const mqtt::Message& message) {
                                    Take(message);
                                    return directory_.online() >= wanted;
                                  });
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
    return delivery::ReadAllRetained(
        transport_, filters.Take(), options_.discover,
        [&](const mqtt::Message& message) { Take(message); },
        [&] { return directory_.robots().size(); });
  }

  // Of those that have been found.
  Status ReadFactsheets() {
    constexpr std::array<std::string_view, 1> kTopics = {"factsheet"};
    Filters filters;
    std::set<const RobotEntry*> wanted;
    for (const auto& [robot, entry] : directory_.robots()) {
      if (!entry.own || entry.factsheet || !entry.factsheet_fault.empty()) continue;
      wanted.insert(&entry);
      if (auto ok = filters.Add(entry.base->topics, Exactly(robot), kTopics); !ok) return ok;
    }
    if (wanted.empty()) return {};
    return delivery::ReadRetained(
        transport_, filters.Take(), options_.discover, [&](const mqtt::Message& message) {
          const auto* entry =
              directory_.Deliver(message.topic, message.payload, vda5050::Origin::kRetained);
          const bool is_told =
              entry != nullptr && (entry->factsheet || !entry->factsheet_fault.empty());
          if (is_told) wanted.erase(entry);
          return wanted.empty();
        });
  }

  // Until every robot that is online has sent a state, or time is up.
  Status AwaitStates(mqtt::Deadline end) {
    constexpr std::array<std::string_view, 1> kTopics = {"state"};
    Filters filters;
    std::set<const RobotEntry*> silent;
    for (const auto& [robot, entry] : directory_.robots()) {
      if (!entry.IsOnline()) continue;
      silent.insert(&entry);
      if (auto ok = filters.Add(entry.base->topics, Exactly(robot), kTopics); !ok) return ok;
    }
    if (silent.empty()) return {};
    log_.Info(fmt::format("waiting up to {} for the states of {} robot{}",
                          base::FormatElapsed(targets_.state_wait), silent.size(),
                          silent.size() == 1 ? "" : "s"));
    const auto left = std::max(end - steady_clock::now(), steady_clock::duration(0));
    const auto most = std::chrono::ceil<std::chrono::milliseconds>(left);
    return delivery::ReadRetained(
        transport_, filters.Take(), {.quiet = most, .most = most},
        [&](const mqtt::Message& message) {
          const auto origin =
              message.retained ? vda5050::Origin::kRetained : vda5050::Origin::kLive;
          const auto* entry = directory_.Deliver(message.topic, message.payload, origin);
          const bool is_heard = entry != nullptr && (entry->state_heard || !entry->IsOnline());
          if (is_heard) silent.erase(entry);
          return silent.empty();
        });
  }

  mqtt::Transport& transport_;
  const Targets& targets_;
  const DiscoveryOptions& options_;
  RobotDirectory& directory_;
  Log& log_;
};

enum class Answer { kYes, kNo, kUnheard, kAway };

Answer Satisfies(const Targets& targets, const RobotEntry& entry) {
  Answer answer = Answer::kYes;
  for (std::size_t i = 0; i < targets.where.size(); ++i) {
    const auto unmet = i < entry.unmet.size() ? entry.unmet[i] : std::nullopt;
    if (unmet && unmet->empty()) continue;
    const bool is_state = vda5050::TopicOf(targets.where[i]) == "state";
    if (unmet || !is_state) return Answer::kNo;
    answer = entry.IsOnline() ? Answer::kUnheard : Answer::kAway;
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
      auto found = resolver.Found(robot);
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
    auto addressed = targets.where.empty() ? resolver.Named(robot) : resolver.Found(robot);
    if (!addressed) return Fail(std::move(addressed.error()));
    directory.Add(robot, std::move(addressed->dialect), addressed->automatic);
  }
  return directory;
}

Status DiscoverRobots(mqtt::Transport& transport, const Targets& targets,
                      const DiscoveryOptions& options, RobotDirectory& directory, Log& log) {
  return Discoverer(transport, targets, options, directory, log).Run();
}

Chosen Choose(const Targets& targets, const RobotDirectory& directory, Log& log) {
  Chosen chosen;
  std::vector<RobotAddress> away;
  const auto consider = [&](const ListedRobot& listed) {
    switch (Satisfies(targets, listed.second)) {
      case Answer::kYes:
        return chosen.robots.push_back(&listed);
      case Answer::kUnheard:
        return chosen.unheard.push_back(&listed);
      case Answer::kAway:
        return away.push_back(listed.first);
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
      if (!listed.second.connection || named.contains(listed.first)) continue;
      discovered.push_back(listed.first);
      consider(listed);
    }
  }
  WarnOfEscapedNames(discovered, log);
  if (!away.empty()) {
    log.Warn(fmt::format("left out, as they are offline and have left no state: {}",
                         FormatRobotList(away)));
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
                   const delivery::RetainedOptions& discover) {
  const auto meant =
      std::count_if(directory.robots().begin(), directory.robots().end(),
                    [](const ListedRobot& listed) { return listed.second.connection.has_value(); });
  const std::string nobody =
      fmt::format("nothing was sent: no robot matches {}", FormatSpec(targets));
  if (meant > 0) {
    return {ErrorKind::kPreflight,
            fmt::format("{}: {} robot{} heard, none satisfies every --where{}", nobody, meant,
                        meant == 1 ? " was" : "s were", FirstReason(directory))};
  }
  const auto all = ListAllRobots(transport, resolver.common().topics, discover);
  const std::string heard = all.empty()
                                ? "it knows no robot: none has left a connection message"
                                : fmt::format("it knows {} robot{}: {}", all.size(),
                                              all.size() == 1 ? "" : "s", FormatRobotList(all));
  return {ErrorKind::kPreflight,
          fmt::format("{} at {}: {}{}", nobody, transport.server().broker.ToString(), heard,
                      targets.except.set.empty() && targets.except.robots.empty()
                          ? ""
                          : " (--except spares some)")};
}

std::vector<RobotAddress> ListAllRobots(mqtt::Transport& transport,
                                        const vda5050::TopicScheme& scheme,
                                        const delivery::RetainedOptions& discover) {
  constexpr std::array<std::string_view, 1> kConnection = {"connection"};
  const auto filters = vda5050::DiscoveryFilters(scheme, {}, kConnection);
  if (!filters) return {};
  std::set<RobotAddress> robots;
  const auto collected =
      delivery::ReadRetained(transport, *filters, discover, [&](const mqtt::Message& message) {
        const auto levels = vda5050::ReadTopic(scheme, message.topic);
        if (levels && !message.payload.empty()) robots.insert(levels->robot);
        return false;
      });
  if (!collected) return {};
  return {robots.begin(), robots.end()};
}

}  // namespace fleetpub::app
