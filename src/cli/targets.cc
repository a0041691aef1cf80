#include "cli/targets.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <iterator>
#include <set>

#include "base/line_reader.h"
#include "base/text.h"
#include "base/time.h"
#include "cli/parser/option_set.h"

namespace fleetpub::cli {
namespace {

using vda5050::Dialect;
using vda5050::RobotAddress;
using vda5050::RobotPattern;

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

Result<std::vector<RobotAddress>> GroupOf(std::string_view name, const config::Config& config) {
  const auto group = config.group_robots.find(name);
  if (group != config.group_robots.end()) return group->second;
  std::string hint = Nearby(name, NamesIn(config.groups), "@");
  if (config.groups.empty()) hint = ": no configuration file has a table [group]";
  return Fail(ErrorKind::kUsage,
              fmt::format("there is no group '@{}'{}", base::Printable(name), hint));
}

// One robot, or those of a group.
Result<std::vector<RobotAddress>> Resolve(const std::string& word, const config::Config& config) {
  if (word.starts_with('@')) return GroupOf(std::string_view(word).substr(1), config);
  if (const auto alias = config.aliases.find(word); alias != config.aliases.end()) {
    return std::vector{alias->second};
  }
  auto robot = vda5050::ParseRobotAddress(word);
  if (robot) return std::vector{*std::move(robot)};
  if (word == "all") {
    return Fail(ErrorKind::kUsage, "'all' is no target: --all means every robot of the broker");
  }
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
    if (const config::ConfigValue* value = find(key)) text = value->texts.front();
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

bool Agrees(std::span<const RobotAddress> robots) {
  Print(stderr, fmt::format("{}\nSend to these {} robots? [y/N] ", ListOf(robots), robots.size()));
  std::fflush(stderr);
  std::string answer;
  char c = 0;
  while (answer.size() < 16 && read(STDIN_FILENO, &c, 1) == 1 && c != '\n') answer += c;
  return base::EqualsIgnoringCase(answer, "y") || base::EqualsIgnoringCase(answer, "yes");
}

// Reads words one after the other.
class WordReader {
 public:
  explicit WordReader(const Context& context) : context_(context) {}

  Status Take(const std::string& word) {
    const bool is_pattern = word.find_first_of("*?") != std::string::npos &&
                            !context_.config.aliases.contains(word) && !word.starts_with('@');
    if (is_pattern || word.starts_with('@')) NoteSet(word);
    if (is_pattern) {
      auto pattern = vda5050::ParseRobotPattern(word);
      if (!pattern) return Fail(std::move(pattern.error()));
      words_.patterns.push_back(*std::move(pattern));
      return {};
    }
    auto meant = Resolve(word, context_.config);
    if (!meant) return Fail(std::move(meant.error()));
    for (RobotAddress& robot : *meant) Add(std::move(robot));
    return {};
  }

  // A target per line; empty lines are passed over. Whoever wrote them may have had them from the
  // broker: what looks like a pattern or a group is a robot's name.
  Status TakeStandardInput(bool patterns) {
    NoteSet("-");
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
    return Fail(ErrorKind::kUsage, "standard input names no target: one per line is expected");
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
      context_.output.Warn(
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
    context_.output.Warn(
        fmt::format("{} is named twice: it counts once", base::Printable(robot.ToString())));
  }

  const Context& context_;
  TargetSpec words_;
  std::set<RobotAddress> known_;
};

Result<std::vector<vda5050::Condition>> ConditionsOf(const std::vector<std::string>& texts,
                                                     const Context& context) {
  std::vector<vda5050::Condition> conditions;
  for (const std::string& text : texts) {
    auto condition = vda5050::ParseCondition(text);
    if (!condition) {
      condition.error().message = "--where: " + condition.error().message;
      return Fail(std::move(condition.error()));
    }
    const auto doubt = vda5050::CheckCondition(*condition, vda5050::TopicOf(*condition));
    if (!doubt) return Fail(doubt.error());
    if (!doubt->empty()) context.output.Warn("--where: " + *doubt);
    conditions.push_back(*std::move(condition));
  }
  return conditions;
}

// A misspelt exception would command whom it should spare.
void WarnOfUnusedExclusions(const Targets& targets, const Context& context) {
  if (!targets.include.patterns.empty()) return;  // whom they spare is known to the broker only
  for (const RobotAddress& robot : targets.except.robots) {
    const auto& named = targets.include.robots;
    if (std::find(named.begin(), named.end(), robot) != named.end()) continue;
    context.output.Warn(
        fmt::format("--except {}: it is not among the targets", base::Printable(robot.ToString())));
  }
}

Result<std::shared_ptr<const Dialect>> Shared(const VdaOptions& options,
                                              std::optional<vda5050::Version> assumed) {
  auto dialect = DialectOf(options);
  if (!dialect) return Fail(std::move(dialect.error()));
  if (dialect->assumed && assumed) {
    dialect->version = *assumed;
    dialect->assumed = false;
  }
  return std::make_shared<const Dialect>(*std::move(dialect));
}

}  // namespace

void DeclareTargetOptions(OptionSet& set, TargetOptions& o) {
  constexpr const char* kTargets = "Targets";
  set.AddOption("targets", o.words,
                "Robots: manufacturer/serialNumber, alias, @group, 'KIT/*', - (standard input)")
      .Type("TARGET");
  set.AddFlag("--all", o.all, "All robots that the broker knows").Group(kTargets);
  set.AddFlag("--patterns", o.patterns, "Lines of standard input may be patterns and groups too")
      .Group(kTargets);
  // Without OneValueEach() they would swallow the targets behind them.
  set.AddOption("--except", o.except, "But not this robot, alias, @group or pattern; repeatable")
      .Type("TARGET")
      .OneValueEach()
      .Group(kTargets);
  set.AddOption("--where", o.where,
                "Only robots of which this is true: 'battery<20', operatingMode=AUTOMATIC; "
                "repeatable")
      .Type("CONDITION")
      .OneValueEach()
      .Group(kTargets);
  set.AddOption("--state-wait", o.state_wait,
                "How long --where waits for the states of robots that are online [35s]")
      .Type("TIME")
      .Group(kTargets);
}

VdaOptions Configured(VdaOptions given, const config::Config& config) {
  return Completed(std::move(given), [&](std::string_view key) { return config.Find(key); });
}

VdaOptions Configured(VdaOptions given, const config::Config& config, const RobotAddress& robot) {
  return Completed(std::move(given), [&](std::string_view key) { return config.Find(robot, key); });
}

Result<DialectResolver> DialectResolver::For(const VdaOptions& given,
                                             const config::Config& config) {
  DialectResolver resolver(given, config);
  const VdaOptions common = Configured(given, config);
  auto dialect = Shared(common, {});
  if (!dialect) return Fail(std::move(dialect.error()));
  resolver.common_ = *std::move(dialect);
  resolver.automatic_ = common.IsAutomatic();
  return resolver;
}

Result<AddressedRobot> DialectResolver::Named(RobotAddress robot) const {
  if (!config_->robots.contains(robot))
    return AddressedRobot{std::move(robot), common_, automatic_};
  const VdaOptions own = Configured(given_, *config_, robot);
  auto dialect = Shared(own, assumed_);
  if (!dialect) return Fail(std::move(dialect.error()));
  return AddressedRobot{std::move(robot), *std::move(dialect), own.IsAutomatic()};
}

Result<AddressedRobot> DialectResolver::Found(RobotAddress robot) const {
  auto found = Named(std::move(robot));
  if (found && found->dialect->assumed) found->automatic = true;
  return found;
}

Result<std::vector<vda5050::TopicScheme>> DialectResolver::Schemes() const {
  std::vector<vda5050::TopicScheme> schemes = {common_->topics};
  for (const auto& [robot, table] : config_->robots) {
    const auto own = Named(robot);
    if (!own) return Fail(own.error());
    const vda5050::TopicScheme& scheme = own->dialect->topics;
    if (std::find(schemes.begin(), schemes.end(), scheme) == schemes.end()) {
      schemes.push_back(scheme);
    }
  }
  return schemes;
}

void DialectResolver::Assume(vda5050::Version version) {
  assumed_ = version;
  if (!common_->assumed) return;
  Dialect dialect = *common_;
  dialect.version = version;
  dialect.assumed = false;
  common_ = std::make_shared<const Dialect>(std::move(dialect));
}

bool Targets::IsExcepted(const RobotAddress& robot) const {
  const auto is = [&](const RobotAddress& other) { return other == robot; };
  const auto matches = [&](const RobotPattern& pattern) { return pattern.Matches(robot); };
  return std::any_of(except.robots.begin(), except.robots.end(), is) ||
         std::any_of(except.patterns.begin(), except.patterns.end(), matches);
}

Result<RobotAddress> RobotOf(const std::string& word, const config::Config& config) {
  auto robots = Resolve(word, config);
  if (!robots) return Fail(std::move(robots.error()));
  if (robots->size() == 1) return std::move(robots->front());
  return Fail(ErrorKind::kUsage, fmt::format("'{}' is a group of {} robots: name one robot here",
                                             base::Printable(word), robots->size()));
}

Result<TargetSpec> ParseTargetSpec(const std::vector<std::string>& words, const Context& context) {
  WordReader reader(context);
  for (const std::string& word : words) {
    if (auto ok = reader.Take(word); !ok) return Fail(std::move(ok.error()));
  }
  return reader.Take();
}

Result<Targets> TargetsOf(const TargetOptions& options, const Context& context) {
  if (options.words.empty() && !options.all) {
    return Fail(ErrorKind::kUsage,
                "name at least one robot as manufacturer/serialNumber, such as KIT/0001; a pattern "
                "such as 'KIT/*' in quotation marks, or --all, means several");
  }
  if (options.all && !options.words.empty()) {
    return Fail(ErrorKind::kUsage, "--all means every robot: name none beside it");
  }
  Targets targets;
  auto where = ConditionsOf(options.where, context);
  if (!where) return Fail(std::move(where.error()));
  targets.where = *std::move(where);
  const auto state_wait = base::ParseDuration(options.state_wait);
  if (!state_wait) return Fail(state_wait.error());
  targets.state_wait = *state_wait;
  auto except = ParseTargetSpec(options.except, context);
  if (!except) return Fail(std::move(except.error()));
  targets.except = *std::move(except);

  WordReader reader(context);
  for (const std::string& word : options.words) {
    if (auto ok = word == "-" ? reader.TakeStandardInput(options.patterns) : reader.Take(word);
        !ok) {
      return Fail(std::move(ok.error()));
    }
  }
  targets.include = reader.Take();
  if (options.all) {
    targets.include.patterns.emplace_back();
    targets.include.set = "--all";
  }
  WarnOfUnusedExclusions(targets, context);
  std::erase_if(targets.include.robots,
                [&](const RobotAddress& robot) { return targets.IsExcepted(robot); });
  if (targets.include.robots.empty() && targets.include.patterns.empty()) {
    return Fail(ErrorKind::kUsage, "nothing was sent: --except leaves no target");
  }
  return targets;
}

Result<std::vector<RobotAddress>> RobotsOf(const std::vector<std::string>& words,
                                           const Context& context) {
  auto read = ParseTargetSpec(words, context);
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

NeedsConsent ConsentFor(std::string_view action_type) {
  constexpr std::array<std::string_view, 3> kHarmless = {"startPause", "stateRequest",
                                                         "factsheetRequest"};
  const bool harmless =
      std::find(kHarmless.begin(), kHarmless.end(), action_type) != kHarmless.end();
  return harmless ? NeedsConsent::kNo : NeedsConsent::kYes;
}

std::string ListOf(std::span<const RobotAddress> robots) {
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

void WarnOfNames(std::span<const RobotAddress> found, Output& output) {
  std::vector<RobotAddress> odd;
  std::copy_if(found.begin(), found.end(), std::back_inserter(odd), vda5050::IsWrittenOtherwise);
  if (odd.empty()) return;
  output.Warn(
      fmt::format("the broker knows {} whose name would mean something else as a target, "
                  "so that it is written with %: {}",
                  odd.size() == 1 ? "a robot" : fmt::format("{} robots", odd.size()), ListOf(odd)));
}

Status AskFor(std::span<const RobotAddress> robots, std::string_view set) {
  if (isatty(STDIN_FILENO) == 0 || isatty(STDERR_FILENO) == 0) {
    return Fail(ErrorKind::kUsage,
                fmt::format("nothing was sent: {} means {} robots ({}): --yes sends to all of them",
                            base::Printable(set), robots.size(), ListOf(robots)));
  }
  if (Agrees(robots)) return {};
  return Fail(ErrorKind::kUsage, "nothing was sent: not confirmed");
}

}  // namespace fleetpub::cli
