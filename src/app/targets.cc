#include "app/targets.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <set>

#include "base/line_reader.h"
#include "base/text.h"
#include "vda5050/reports/robot_directory.h"

namespace fleetpub::app {
namespace {

using vda5050::RobotAddress;
using vda5050::RobotPattern;

std::vector<std::string_view> ListNames(const auto& map) {
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

Result<std::vector<RobotAddress>> ResolveGroup(std::string_view name,
                                               const config::Config& config) {
  const auto group = config.group_robots.find(name);
  if (group != config.group_robots.end()) return group->second;
  std::string hint = Nearby(name, ListNames(config.groups), "@");
  if (config.groups.empty()) hint = ": no configuration file has a table [group]";
  return Fail(ErrorKind::kUsage,
              fmt::format("there is no group '@{}'{}", base::Printable(name), hint));
}

// One robot, or those of a group.
Result<std::vector<RobotAddress>> ResolveWord(const std::string& word,
                                              const config::Config& config) {
  if (word.starts_with('@')) return ResolveGroup(std::string_view(word).substr(1), config);
  if (const auto alias = config.aliases.find(word); alias != config.aliases.end()) {
    return std::vector{alias->second};
  }
  auto robot = vda5050::ParseRobotAddress(word);
  if (robot) return std::vector{*std::move(robot)};
  if (word == "all") {
    return Fail(ErrorKind::kUsage, "'all' is not a target: --all means every robot of the broker");
  }
  if (config.group_robots.contains(word)) {
    return Fail(ErrorKind::kUsage, fmt::format("'{}' is a group: did you mean @{}?",
                                               base::Printable(word), base::Printable(word)));
  }
  if (word.find('/') == std::string::npos && !config.aliases.empty()) {
    const std::string hint = Nearby(word, ListNames(config.aliases), "");
    return Fail(ErrorKind::kUsage,
                fmt::format("no robot has the alias '{}'{}", base::Printable(word),
                            hint.empty() ? ": name it as manufacturer/serialNumber" : hint));
  }
  return Fail(std::move(robot.error()));
}

// ` (has U+0410, U+200B)`, or nothing.
std::string UnusualIn(const RobotAddress& robot) {
  constexpr std::size_t kMost = 3;
  std::vector<std::string> unusual;
  std::string_view rest;
  for (const std::string* name : {&robot.manufacturer, &robot.serial_number}) {
    if (vda5050::HasRecommendedCharacters(*name)) continue;
    for (rest = *name; !rest.empty();) {
      const auto [code, bytes] = base::DecodeFront(rest);
      const std::string_view character = rest.substr(0, bytes);
      rest.remove_prefix(std::max<std::size_t>(bytes, 1));
      if (vda5050::HasRecommendedCharacters(character)) continue;
      std::string written = fmt::format("U+{:04X}", code);
      const bool is_known = std::find(unusual.begin(), unusual.end(), written) != unusual.end();
      if (!is_known && unusual.size() < kMost) unusual.push_back(std::move(written));
    }
  }
  return unusual.empty() ? "" : fmt::format(" (has {})", base::Join(unusual, ", "));
}

// Reads words one after the other.
class WordReader {
 public:
  WordReader(const config::Config& config, Log& log) : config_(config), log_(log) {}

  Status Take(const std::string& word) {
    const bool is_pattern = word.find_first_of("*?") != std::string::npos &&
                            !config_.aliases.contains(word) && !word.starts_with('@');
    if (is_pattern || word.starts_with('@')) NoteSet(word);
    if (is_pattern) {
      auto pattern = vda5050::ParseRobotPattern(word);
      if (!pattern) return Fail(std::move(pattern.error()));
      words_.patterns.push_back(*std::move(pattern));
      return {};
    }
    auto meant = ResolveWord(word, config_);
    if (!meant) return Fail(std::move(meant.error()));
    for (RobotAddress& robot : *meant) Add(std::move(robot));
    return {};
  }

  // A target per line; empty lines are passed over. Whoever wrote them may have had them from the
  // broker: what looks like a pattern or a group is a robot's name.
  Status TakeStandardInput(bool patterns) {
    NoteSet("-");
    log_.Reads("-");
    auto reader = base::LineReader::Open("-");
    if (!reader) return Fail(std::move(reader.error()));
    bool any = false;
    for (std::size_t number = 1;; ++number) {
      const auto line = reader->Next();
      if (!line) return Fail(line.error());
      if (!*line) break;
      const std::string word(base::Trimmed(**line));
      if (word.empty()) continue;
      any = true;
      auto ok = patterns ? Take(word) : TakeRobot(word);
      if (!ok) {
        ok.error().message = fmt::format("standard input, line {}: {}", number, ok.error().message);
        return ok;
      }
    }
    if (any) return {};
    return Fail(ErrorKind::kUsage, "standard input names no target: write one per line");
  }

  TargetSpec Take() { return std::move(words_); }

 private:
  Status TakeRobot(const std::string& word) {
    if (word.find('/') == std::string::npos) {
      if (!word.starts_with('@')) return Take(word);
      return Fail(ErrorKind::kUsage,
                  fmt::format("'{}' is a group: --patterns allows groups and patterns here",
                              base::Printable(word)));
    }
    auto robot = vda5050::ParseRobotAddress(word);
    if (!robot) return Fail(std::move(robot.error()));
    if (word.find_first_of("*?") != std::string::npos) {
      log_.Warn(
          fmt::format("standard input: '{}' is one robot's name here; --patterns reads patterns",
                      base::Printable(word)));
    }
    Add(*std::move(robot));
    return {};
  }

  void NoteSet(std::string_view word) {
    if (words_.set.empty()) words_.set = word;
  }

  void Add(RobotAddress robot) {
    if (known_.insert(robot).second) return words_.robots.push_back(std::move(robot));
    log_.Warn(fmt::format("{} is named twice: it counts once", base::Printable(robot.ToString())));
  }

  const config::Config& config_;
  Log& log_;
  TargetSpec words_;
  std::set<RobotAddress> known_;
};

// `KIT 0001`, two words that are no targets, is one robot's name.
bool IsCutName(const std::vector<std::string>& words, std::size_t i, const config::Config& config) {
  const auto is_half = [&](const std::string& word) {
    return word != "-" && !word.starts_with('@') && !config.aliases.contains(word) &&
           word.find_first_of("/*?") == std::string::npos;
  };
  return i + 1 < words.size() && is_half(words[i]) && is_half(words[i + 1]) &&
         vda5050::ParseRobotAddress(words[i] + "/" + words[i + 1]);
}

Error CutName(const std::string& manufacturer, const std::string& serial_number) {
  return {ErrorKind::kUsage,
          fmt::format("'{0}' is not a target: did you mean {0}/{1}?", base::Printable(manufacturer),
                      base::Printable(serial_number))};
}

// What no robot can satisfy is refused, what is doubtful said.
Status CheckConditions(std::span<const vda5050::Condition> conditions, Log& log) {
  for (const vda5050::Condition& condition : conditions) {
    const auto doubt = vda5050::CheckCondition(condition, vda5050::FindTopicName(condition));
    if (!doubt) return Fail(doubt.error());
    if (!doubt->empty()) log.Warn("--where: " + *doubt);
  }
  return {};
}

// A misspelt exception would command whom it should spare.
void WarnOfUnusedExclusions(const Targets& targets, Log& log) {
  if (!targets.include.patterns.empty()) return;  // whom they spare is known to the broker only
  for (const RobotAddress& robot : targets.except.robots) {
    const auto& named = targets.include.robots;
    if (std::find(named.begin(), named.end(), robot) != named.end()) continue;
    log.Warn(
        fmt::format("--except {}: it is not among the targets", base::Printable(robot.ToString())));
  }
}

}  // namespace

bool Targets::IsExcepted(const RobotAddress& robot) const {
  const auto is = [&](const RobotAddress& other) { return other == robot; };
  const auto matches = [&](const RobotPattern& pattern) { return pattern.Matches(robot); };
  return std::any_of(except.robots.begin(), except.robots.end(), is) ||
         std::any_of(except.patterns.begin(), except.patterns.end(), matches);
}

Result<RobotAddress> ResolveRobot(const std::string& word, const config::Config& config) {
  auto robots = ResolveWord(word, config);
  if (!robots) return Fail(std::move(robots.error()));
  if (robots->size() == 1) return std::move(robots->front());
  return Fail(ErrorKind::kUsage, fmt::format("'{}' is a group of {} robots: name one robot here",
                                             base::Printable(word), robots->size()));
}

Result<TargetSpec> ParseTargetSpec(const std::vector<std::string>& words,
                                   const config::Config& config, Log& log) {
  WordReader reader(config, log);
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (IsCutName(words, i, config)) return Fail(CutName(words[i], words[i + 1]));
    if (auto ok = reader.Take(words[i]); !ok) return Fail(std::move(ok.error()));
  }
  return reader.Take();
}

Result<Targets> ResolveTargets(TargetRequest request, const config::Config& config, Log& log) {
  if (request.words.empty() && !request.all) {
    return Fail(ErrorKind::kUsage,
                "name at least one robot as manufacturer/serialNumber, such as KIT/0001; a pattern "
                "such as 'KIT/*' in quotation marks, or --all, means several");
  }
  if (request.all && !request.words.empty()) {
    return Fail(ErrorKind::kUsage, "--all means every robot: name no others");
  }
  Targets targets;
  if (auto ok = CheckConditions(request.where, log); !ok) return Fail(std::move(ok.error()));
  targets.where = std::move(request.where);
  targets.online = request.online;
  targets.state_wait = request.state_wait;
  targets.expect = request.expect;
  auto except = ParseTargetSpec(request.except, config, log);
  if (!except) return Fail(std::move(except.error()));
  targets.except = *std::move(except);

  WordReader reader(config, log);
  for (std::size_t i = 0; i < request.words.size(); ++i) {
    const std::string& word = request.words[i];
    if (IsCutName(request.words, i, config)) return Fail(CutName(word, request.words[i + 1]));
    if (auto ok = word == "-" ? reader.TakeStandardInput(request.patterns) : reader.Take(word);
        !ok) {
      return Fail(std::move(ok.error()));
    }
  }
  targets.include = reader.Take();
  if (request.all) {
    targets.include.patterns.emplace_back();
    targets.include.set = "--all";
  }
  WarnOfUnusedExclusions(targets, log);
  std::erase_if(targets.include.robots,
                [&](const RobotAddress& robot) { return targets.IsExcepted(robot); });
  if (targets.include.robots.empty() && targets.include.patterns.empty()) {
    return Fail(ErrorKind::kUsage, "--except leaves no target");
  }
  return targets;
}

Result<std::vector<RobotAddress>> ResolveRobots(const std::vector<std::string>& words,
                                                const config::Config& config, Log& log) {
  auto read = ParseTargetSpec(words, config, log);
  if (!read) return Fail(std::move(read.error()));
  if (!read->patterns.empty()) {
    return Fail(ErrorKind::kUsage,
                fmt::format("'{}' is a pattern: name each robot here", base::Printable(read->set)));
  }
  if (read->robots.empty()) {
    return Fail(ErrorKind::kUsage,
                "name at least one robot as manufacturer/serialNumber, such as KIT/0001");
  }
  return std::move(read->robots);
}

NeedsConsent DecideConsent(std::string_view action_type) {
  constexpr std::array<std::string_view, 3> kHarmless = {"startPause", "stateRequest",
                                                         "factsheetRequest"};
  const bool harmless =
      std::find(kHarmless.begin(), kHarmless.end(), action_type) != kHarmless.end();
  return harmless ? NeedsConsent::kNo : NeedsConsent::kYes;
}

std::string FormatRobotList(std::span<const RobotAddress> robots) {
  constexpr std::size_t kShown = 20;
  std::vector<std::string> names;
  for (const bool is_marked : {true, false}) {
    for (const RobotAddress& robot : robots) {
      const std::string unusual = UnusualIn(robot);
      if (unusual.empty() == is_marked) continue;
      if (names.size() == kShown) break;
      names.push_back(base::Printable(robot.ToString()) + unusual);
    }
  }
  const std::size_t more = robots.size() - names.size();
  return base::Join(names, ", ") + (more > 0 ? fmt::format(" and {} more", more) : "");
}

std::string DescribeEscapedNames(std::span<const RobotAddress> found) {
  std::vector<RobotAddress> odd;
  std::copy_if(found.begin(), found.end(), std::back_inserter(odd), vda5050::IsWrittenOtherwise);
  if (odd.empty()) return "";
  return fmt::format(
      "the broker knows {} whose name would mean something else as a target, "
      "so that it is written with %: {}",
      odd.size() == 1 ? "a robot" : fmt::format("{} robots", odd.size()), FormatRobotList(odd));
}

void WarnOfEscapedNames(std::span<const RobotAddress> found, Log& log) {
  if (const std::string text = DescribeEscapedNames(found); !text.empty()) log.Warn(text);
}

}  // namespace fleetpub::app
