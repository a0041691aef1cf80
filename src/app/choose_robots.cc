#include "app/choose_robots.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "base/text.h"

namespace fleetpub::app {
namespace {

using vda5050::Condition;
using vda5050::RobotAddress;
using vda5050::RobotDirectory;
using vda5050::RobotEntry;
using vda5050::RobotPattern;

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

Chosen Choose(const Targets& targets, const RobotDirectory& directory, Log& log) {
  Chosen chosen;
  std::vector<RobotAddress> offline;
  std::vector<RobotAddress> left_out;
  const auto consider = [&](const ListedRobot& listed) {
    if (targets.online && listed.second.WasHeard() && !listed.second.IsAlive()) {
      return left_out.push_back(listed.first);
    }
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
    if (found->second.WasHeard() || !targets.AskAll()) {
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
  chosen.left_out = left_out.size();
  if (!left_out.empty()) {
    log.Info(fmt::format("left out by --online, as {} offline: {}",
                         left_out.size() == 1 ? "it is" : "they are", FormatRobotList(left_out)));
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
      !all.empty()
          ? fmt::format("it knows {}: {}", base::Counted(all.size(), "robot"), FormatRobotList(all))
      : transport.server().KeepsNothing()
          ? std::string(kNothingRetained)
          : "it knows no robot: none has left a connection message, or the broker hands out "
            "nothing for patterns, as RabbitMQ: name the robots";
  return {ErrorKind::kPreflight,
          fmt::format("{}: {}{}", nobody, heard,
                      targets.except.set.empty() && targets.except.robots.empty()
                          ? ""
                          : " (--except spares some)")};
}

}  // namespace fleetpub::app
