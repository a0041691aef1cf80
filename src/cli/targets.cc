#include "cli/targets.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <set>

#include "base/text.h"

namespace fleetpub::cli {
namespace {

using vda5050::RobotAddress;

std::vector<std::string_view> NamesIn(const auto& map) {
  std::vector<std::string_view> names;
  names.reserve(map.size());
  for (const auto& entry : map) names.push_back(entry.first);
  return names;
}

std::string Nearby(std::string_view word, const std::vector<std::string_view>& names,
                   std::string_view sign) {
  const auto nearest = base::Nearest(word, names);
  return nearest ? fmt::format(": did you mean {}{}?", sign, base::Printable(*nearest)) : "";
}

Result<std::vector<RobotAddress>> GroupOf(std::string_view name, const Config& config) {
  const auto group = config.group_robots.find(name);
  if (group != config.group_robots.end()) return group->second;
  std::string hint = Nearby(name, NamesIn(config.groups), "@");
  if (config.groups.empty()) hint = ": no configuration file has a table [group]";
  return Fail(ErrorKind::kUsage,
              fmt::format("there is no group '@{}'{}", base::Printable(name), hint));
}

// One robot, or those of a group.
Result<std::vector<RobotAddress>> Resolve(const std::string& word, const Config& config) {
  if (word.starts_with('@')) return GroupOf(std::string_view(word).substr(1), config);
  if (const auto alias = config.aliases.find(word); alias != config.aliases.end()) {
    return std::vector{alias->second};
  }
  auto robot = vda5050::ParseRobotAddress(word);
  if (robot) return std::vector{*std::move(robot)};
  if (word.find('/') == std::string::npos && !config.aliases.empty()) {
    const std::string hint = Nearby(word, NamesIn(config.aliases), "");
    return Fail(
        ErrorKind::kUsage,
        fmt::format("target '{}': there is no robot with this alias{}", base::Printable(word),
                    hint.empty() ? ": name it as manufacturer/serialNumber" : hint));
  }
  return Fail(std::move(robot.error()));
}

VdaOptions Completed(VdaOptions given, const auto& find) {
  const auto take = [&](std::string_view key, std::string& text) {
    if (!text.empty()) return;
    if (const ConfigValue* value = find(key)) text = value->texts.front();
  };
  take("vda", given.version);
  take("interface", given.interface_name);
  take("topic_template", given.topic_template);
  take("actions_key", given.actions_key);
  take("header_version", given.header_version);
  take("header_manufacturer", given.header_manufacturer);
  take("header_serial", given.header_serial);
  return given;
}

std::string ListOf(const Targets& targets) {
  constexpr std::size_t kShown = 20;
  std::vector<std::string> names;
  for (const AddressedRobot& target : targets.robots) {
    if (names.size() == kShown) break;
    names.push_back(base::Printable(target.robot.ToString()));
  }
  const std::size_t more = targets.robots.size() - names.size();
  return base::Join(names, ", ") + (more > 0 ? fmt::format(" and {} more", more) : "");
}

bool Agrees(const Targets& targets) {
  fmt::print(stderr, "{}\nSend to these {} robots? [y/N] ", ListOf(targets), targets.robots.size());
  std::fflush(stderr);
  std::string answer;
  char c = 0;
  while (answer.size() < 16 && read(STDIN_FILENO, &c, 1) == 1 && c != '\n') answer += c;
  return base::EqualsIgnoringCase(answer, "y") || base::EqualsIgnoringCase(answer, "yes");
}

}  // namespace

VdaOptions Configured(VdaOptions given, const Config& config) {
  return Completed(std::move(given), [&](std::string_view key) { return config.Find(key); });
}

VdaOptions Configured(VdaOptions given, const Config& config, const RobotAddress& robot) {
  return Completed(std::move(given), [&](std::string_view key) { return config.Find(robot, key); });
}

Result<RobotAddress> RobotOf(const std::string& word, const Config& config) {
  auto robots = Resolve(word, config);
  if (!robots) return Fail(std::move(robots.error()));
  if (robots->size() == 1) return std::move(robots->front());
  return Fail(ErrorKind::kUsage, fmt::format("'{}' is a group of {} robots: name one robot here",
                                             base::Printable(word), robots->size()));
}

Result<std::vector<RobotAddress>> RobotsOf(const std::vector<std::string>& words,
                                           const Context& context) {
  std::vector<RobotAddress> robots;
  std::set<RobotAddress> known;
  if (words.empty()) {
    return Fail(ErrorKind::kUsage,
                "name at least one robot as manufacturer/serialNumber, such as KIT/0001");
  }
  for (const std::string& word : words) {
    auto meant = Resolve(word, context.config);
    if (!meant) return Fail(std::move(meant.error()));
    for (RobotAddress& robot : *meant) {
      if (!known.insert(robot).second) {
        context.output.Warn(
            fmt::format("{} is named twice: commanded once", base::Printable(robot.ToString())));
        continue;
      }
      robots.push_back(std::move(robot));
    }
  }
  return robots;
}

Result<Targets> TargetsOf(const std::vector<std::string>& words, const VdaOptions& given,
                          const Context& context) {
  auto robots = RobotsOf(words, context);
  if (!robots) return Fail(std::move(robots.error()));
  Targets targets;
  targets.robots.reserve(robots->size());
  const auto common = DialectOf(Configured(given, context.config));
  if (!common) return Fail(common.error());
  const bool automatic = Configured(given, context.config).IsAutomatic();
  for (RobotAddress& robot : *robots) {
    AddressedRobot target{std::move(robot), *common, automatic};
    if (context.config.robots.contains(target.robot)) {
      const VdaOptions own = Configured(given, context.config, target.robot);
      auto dialect = DialectOf(own);
      if (!dialect) return Fail(std::move(dialect.error()));
      target.dialect = *std::move(dialect);
      target.automatic = own.IsAutomatic();
    }
    targets.robots.push_back(std::move(target));
  }
  const auto group = std::find_if(words.begin(), words.end(),
                                  [](const std::string& word) { return word.starts_with('@'); });
  if (group != words.end()) targets.group = group->substr(1);
  return targets;
}

Harm HarmOf(std::string_view action_type) {
  constexpr std::array<std::string_view, 3> kHarmless = {"startPause", "stateRequest",
                                                         "factsheetRequest"};
  const bool harmless =
      std::find(kHarmless.begin(), kHarmless.end(), action_type) != kHarmless.end();
  return harmless ? Harm::kNone : Harm::kPossible;
}

Status Consent(const Targets& targets, Harm harm, bool yes) {
  if (yes || harm == Harm::kNone || targets.group.empty() || targets.robots.size() < 2) return {};
  if (isatty(STDIN_FILENO) == 0 || isatty(STDERR_FILENO) == 0) {
    return Fail(
        ErrorKind::kUsage,
        fmt::format("nothing was sent: @{} means {} robots ({}): --yes sends to all of "
                    "them",
                    base::Printable(targets.group), targets.robots.size(), ListOf(targets)));
  }
  if (Agrees(targets)) return {};
  return Fail(ErrorKind::kUsage, "nothing was sent: not confirmed");
}

}  // namespace fleetpub::cli
