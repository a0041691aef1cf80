#include "config/config.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"

namespace fleetpub::config {
namespace {

using vda5050::RobotAddress;

// `: did you mean north?`, or what there is.
std::string Hint(std::string_view word, const std::vector<std::string_view>& names,
                 std::string_view none) {
  if (const auto nearest = base::Nearest(word, names)) {
    return fmt::format(": did you mean {}?", base::Printable(*nearest));
  }
  if (names.empty()) return fmt::format(": {}", none);
  std::vector<std::string> printable;
  printable.reserve(names.size());
  for (const std::string_view name : names) printable.push_back(base::Printable(name));
  return fmt::format("; there are {}", base::Join(printable, ", "));
}

std::vector<std::string_view> NamesIn(const auto& map) {
  std::vector<std::string_view> names;
  names.reserve(map.size());
  for (const auto& entry : map) names.push_back(entry.first);
  return names;
}

Status ChooseProfile(const std::optional<std::string>& asked, Config& config) {
  const bool by_default = !asked && config.default_profile;
  const std::string name = by_default ? config.default_profile->texts.front() : asked.value_or("");
  if (name.empty() || config.profiles.contains(name)) {
    config.profile = name;
    return {};
  }
  std::string message = fmt::format("there is no profile '{}'", base::Printable(name)) +
                        Hint(name, NamesIn(config.profiles),
                             config.files.empty() ? "there is no configuration file"
                                                  : "no file has a table [profile.NAME]");
  if (by_default) return Fail(ErrorAt(config.default_profile->place, message));
  if (!config.files.empty()) message += fmt::format(" ({})", base::Join(config.files, ", "));
  return Fail(ErrorKind::kUsage, std::move(message));
}

void CollectAliases(Config& config, Mistakes& mistakes) {
  for (const auto& [robot, table] : config.robots) {
    const auto alias = table.settings.find("alias");
    if (alias == table.settings.end()) continue;
    const std::string& name = alias->second.texts.front();
    const auto [known, is_new] = config.aliases.emplace(name, robot);
    if (is_new) continue;
    const auto& other = config.robots.at(known->second).settings.find("alias")->second;
    mistakes.push_back(ErrorAt(
        alias->second.place, fmt::format("alias '{}' already names {} ({})", base::Printable(name),
                                         known->second.ToString(), other.place.ToString())));
  }
}

Result<RobotAddress> ResolveMember(const ConfigValue& member, const Config& config) {
  const std::string& word = member.texts.front();
  if (word.starts_with('@')) {
    return Fail(ErrorAt(member.place, fmt::format("'{}': a group holds robots and aliases, no "
                                                  "other group",
                                                  base::Printable(word))));
  }
  if (word.find('/') == std::string::npos) {
    const auto alias = config.aliases.find(word);
    if (alias != config.aliases.end()) return alias->second;
    return Fail(ErrorAt(
        member.place, fmt::format("there is no robot with the alias '{}'", base::Printable(word)) +
                          Hint(word, NamesIn(config.aliases), "write manufacturer/serialNumber")));
  }
  auto robot = vda5050::ParseRobotAddress(word);
  if (!robot) return Fail(ErrorAt(member.place, robot.error().message));
  return robot;
}

void ResolveGroups(Config& config, Mistakes& mistakes) {
  for (const auto& [name, group] : config.groups) {
    std::vector<RobotAddress>& robots = config.group_robots[name];
    for (const ConfigValue& member : group.members) {
      auto robot = ResolveMember(member, config);
      if (!robot) {
        mistakes.push_back(std::move(robot.error()));
        continue;
      }
      if (std::find(robots.begin(), robots.end(), *robot) == robots.end()) {
        robots.push_back(*std::move(robot));
      }
    }
  }
}

const ConfigValue* FindIn(const ConfigSection& section, std::string_view key) {
  const auto found = section.find(key);
  return found == section.end() ? nullptr : &found->second;
}

}  // namespace

std::string ConfigPlace::ToString() const {
  return fmt::format("{}:{}", base::Printable(file), line);
}

Error ErrorAt(const ConfigPlace& place, std::string_view message) {
  return {ErrorKind::kUsage, fmt::format("{}:{}:{}: {}", base::Printable(place.file), place.line,
                                         place.column, message)};
}

std::string ConfigValue::Origin() const {
  if (profile.empty()) return place.ToString();
  return fmt::format("profile {} of {}", base::Printable(profile), place.ToString());
}

const ConfigValue* Config::Find(std::string_view key) const {
  if (const auto found = profiles.find(profile); found != profiles.end()) {
    if (const ConfigValue* value = FindIn(found->second, key)) return value;
  }
  return FindIn(settings, key);
}

const ConfigValue* Config::Find(const RobotAddress& robot, std::string_view key) const {
  if (const auto found = robots.find(robot); found != robots.end()) {
    if (const ConfigValue* value = FindIn(found->second.settings, key)) return value;
  }
  return Find(key);
}

void Resolve(const std::optional<std::string>& asked, Config& config, Mistakes& mistakes) {
  if (auto ok = ChooseProfile(asked, config); !ok) mistakes.push_back(std::move(ok.error()));
  CollectAliases(config, mistakes);
  ResolveGroups(config, mistakes);
}

Status Resolve(const std::optional<std::string>& asked, Config& config) {
  Mistakes mistakes;
  Resolve(asked, config, mistakes);
  if (mistakes.empty()) return {};
  return Fail(std::move(mistakes.front()));
}

}  // namespace fleetpub::config
