#include "vda5050/reports/discovery.h"

#include <algorithm>
#include <array>
#include <utility>

#include "base/text.h"
#include "base/time.h"

namespace fleetpub::vda5050 {
namespace {

// Stands in for what becomes `+`: U+F8FF of the private use area, which no name has.
constexpr std::string_view kAny = "\uF8FF";

// ── reading a topic back ──

// What the template's placeholders stand for in a topic: every message that is heard comes here, so
// that nothing is copied before its topic has matched.
class Values {
 public:
  /// False when the placeholder stands for another text elsewhere, or is none of a template's.
  bool Set(std::string_view name, std::string_view value) {
    for (auto& [known, text] : values_) {
      if (known != name) continue;
      if (text.empty()) text = value;
      return text == value;
    }
    return false;
  }

  [[nodiscard]] std::string Get(std::string_view name) const {
    for (const auto& [known, text] : values_) {
      if (known == name) return std::string(text);
    }
    return "";
  }

 private:
  std::array<std::pair<std::string_view, std::string_view>, 5> values_ = {
      {{"interface", ""}, {"major", ""}, {"manufacturer", ""}, {"serial", ""}, {"topic", ""}}};
};

// Matches one level; each placeholder takes the shortest text before the literal behind it, at
// least one byte. False when the level cannot have been made by the pattern.
bool MatchLevel(std::string_view pattern, std::string_view level, Values& values) {
  while (!pattern.empty()) {
    const std::size_t open = pattern.find('{');
    if (level.substr(0, open) != pattern.substr(0, open)) return false;
    if (open == std::string_view::npos) return true;
    const std::size_t close = pattern.find('}', open);
    if (close == std::string_view::npos) return false;
    const std::string_view name = pattern.substr(open + 1, close - open - 1);
    level.remove_prefix(open);
    pattern.remove_prefix(close + 1);
    const std::string_view literal = pattern.substr(0, pattern.find('{'));
    const std::size_t end = literal.empty()      ? level.size()
                            : literal == pattern ? level.rfind(literal)
                                                 : level.find(literal, 1);
    if (end == 0 || end == std::string_view::npos) return false;
    if (!values.Set(name, level.substr(0, end))) return false;
    level.remove_prefix(end);
  }
  return level.empty();
}

std::string Replaced(std::string text, std::string_view what, std::string_view by) {
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size())) {
    text.replace(at, what.size(), by);
  }
  return text;
}

// Takes the first level away; true while there are more behind it.
bool CutLevel(std::string_view& topic, std::string_view& level) {
  const std::size_t slash = topic.find('/');
  level = topic.substr(0, slash);
  topic.remove_prefix(slash == std::string_view::npos ? topic.size() : slash + 1);
  return slash != std::string_view::npos;
}

// ── dialects ──

// What a robot writes instead of `2.1.0`, if it may go into our header: robots compare for
// equality.
std::string PeculiarVersion(std::string_view spoken, Version version) {
  constexpr std::size_t kLongest = 16;
  const bool is_plain = !spoken.empty() && spoken.size() <= kLongest &&
                        spoken.find_first_not_of("0123456789.vV") == std::string_view::npos;
  return is_plain && VersionSpoken(spoken, "") && spoken != GetFacts(version).name
             ? std::string(spoken)
             : std::string();
}

void TakeOver(std::string& field, std::string_view theirs, std::string_view expected) {
  if (field.empty() && !theirs.empty() && theirs != expected) field = theirs;
}

Dialect MakeDialect(const Dialect& base, const TopicLevels& levels, const MessageHeader& header,
                    const SpokenVersion& spoken) {
  Dialect dialect = base;
  const Version version = spoken.version;
  const VersionFacts& facts = GetFacts(version);
  dialect.version = version;
  dialect.version_said = spoken.is_release ? "" : header.version;
  dialect.assumed = false;
  TakeOver(dialect.topics.interface_name, levels.interface_name, facts.interface_name);
  // A robot whose topic level is not its version's own (1.1 lives on v1 and on v2) keeps its level.
  if (!levels.major.empty() && levels.major != facts.major) {
    dialect.topics.topic_template =
        Replaced(dialect.topics.topic_template, "{major}", levels.major);
  }
  TakeOver(dialect.header_version, PeculiarVersion(header.version, version), "");
  TakeOver(dialect.header_manufacturer, header.manufacturer, levels.robot.manufacturer);
  TakeOver(dialect.header_serial, header.serial_number, levels.robot.serial_number);
  return dialect;
}

int RankConnection(const Discovered& found) {
  if (found.topic_name != "connection") return 0;
  if (found.message.connection_state == "ONLINE") return 3;
  return found.message.connection_state == "HIBERNATING" ? 2 : 1;
}

}  // namespace

Result<std::vector<std::string>> DiscoveryFilters(const TopicScheme& scheme,
                                                  const RobotFilter& filter,
                                                  std::span<const std::string_view> topic_names) {
  const std::string any(kAny);
  const TopicScheme wanted{scheme.interface_name.empty() ? any : scheme.interface_name,
                           Replaced(scheme.topic_template, "{major}", any)};
  const RobotAddress robot{filter.manufacturer.value_or(any), filter.serial_number.value_or(any)};
  std::vector<std::string> filters;
  for (const std::string_view name : topic_names) {
    const auto topic = TopicFor(wanted, Version::k300, robot, name);
    if (!topic) return Fail(topic.error());
    auto levels = base::Split(*topic, '/');
    for (std::string& level : levels) {
      if (level.find(kAny) != std::string::npos) level = "+";
    }
    filters.push_back(base::Join(levels, "/"));
  }
  return filters;
}

Result<std::vector<std::string>> SpecifiedTopics(const TopicScheme& scheme,
                                                 const RobotAddress& robot,
                                                 std::span<const std::string_view> topic_names) {
  std::vector<std::string> topics;
  for (const std::string_view name : topic_names) {
    for (const Version version : kVersions) {
      auto topic = TopicFor(scheme, version, robot, name);
      if (!topic) return Fail(std::move(topic.error()));
      if (std::find(topics.begin(), topics.end(), *topic) == topics.end()) {
        topics.push_back(*std::move(topic));
      }
    }
  }
  return topics;
}

Result<std::vector<std::string>> FiltersByPlace(const TopicScheme& scheme,
                                                std::set<std::string> places,
                                                const RobotFilter& filter,
                                                std::span<const std::string_view> topic_names) {
  auto specified = SpecifiedTopics(scheme, {"any", "any"}, topic_names);
  if (!specified) return specified;
  for (const std::string& topic : *specified) {
    if (const auto levels = ReadTopic(scheme, topic)) places.insert(levels->Place());
  }
  std::vector<std::string> filters;
  for (const std::string& place : places) {
    const std::size_t slash = place.rfind('/');
    const TopicScheme exact{place.substr(0, slash),
                            Replaced(scheme.topic_template, "{major}", place.substr(slash + 1))};
    auto some = DiscoveryFilters(exact, filter, topic_names);
    if (!some) return some;
    filters.insert(filters.end(), some->begin(), some->end());
  }
  return filters;
}

Result<std::string> TopicBeside(const TopicScheme& scheme, const TopicLevels& levels,
                                std::string_view topic_name) {
  const TopicScheme exact{levels.interface_name,
                          Replaced(scheme.topic_template, "{major}", levels.major)};
  return TopicFor(exact, Version::k300, levels.robot, topic_name);
}

Result<std::vector<std::string>> TopicsAnywhere(const TopicScheme& scheme,
                                                const RobotAddress& robot,
                                                std::span<const std::string_view> topic_names) {
  auto topics = DiscoveryFilters(scheme, {robot.manufacturer, robot.serial_number}, topic_names);
  const auto exact = SpecifiedTopics(scheme, robot, topic_names);
  if (!topics || !exact) return Fail(topics ? exact.error() : topics.error());
  topics->insert(topics->end(), exact->begin(), exact->end());
  return topics;
}

std::optional<TopicLevels> ReadTopic(const TopicScheme& scheme, std::string_view topic,
                                     std::string_view manufacturer) {
  if (!scheme.Names("{topic}")) return std::nullopt;  // what comes there is our own
  // The template, with what the user states in place.
  std::string stated;
  std::string_view patterns = scheme.topic_template;
  if (!scheme.interface_name.empty()) {
    stated = Replaced(scheme.topic_template, "{interface}", scheme.interface_name);
    patterns = stated;
  }
  Values values;
  for (bool more = true; more;) {
    std::string_view pattern;
    std::string_view level;
    more = CutLevel(patterns, pattern);
    if (CutLevel(topic, level) != more || !MatchLevel(pattern, level, values)) return std::nullopt;
  }
  // Only what could be addressed is a robot.
  RobotAddress robot{values.Get("manufacturer"), values.Get("serial")};
  if (!scheme.Names("{manufacturer}")) robot.manufacturer = manufacturer;
  if (!IsAddressable(robot)) return std::nullopt;
  const bool is_stated = !stated.empty() && scheme.Names("{interface}");
  return TopicLevels{.robot = std::move(robot),
                     .interface_name = is_stated ? scheme.interface_name : values.Get("interface"),
                     .major = values.Get("major"),
                     .topic_name = values.Get("topic")};
}

std::optional<Discovered> DialectFrom(const Dialect& base, std::string_view topic,
                                      std::string_view payload) {
  auto message = ReadConnection(payload);
  return message ? DialectFrom(base, topic, *std::move(message)) : std::nullopt;
}

std::optional<Discovered> DialectFrom(const Dialect& base, std::string_view topic,
                                      ConnectionMessage message) {
  const auto levels = ReadTopic(base.topics, topic, message.header.manufacturer);
  if (!levels) return std::nullopt;
  Discovered found{.robot = levels->robot,
                   .topic = std::string(topic),
                   .topic_name = levels->topic_name,
                   .dialect = std::nullopt,
                   .place = levels->Place(),
                   .message = std::move(message)};
  if (const auto version = VersionSpoken(found.message.header.version, levels->major)) {
    found.dialect = MakeDialect(base, *levels, found.message.header, *version);
  }
  return found;
}

Standing ToStanding(const Discovered& found) {
  return {.rank = RankConnection(found),
          .time = ReadTime(found.message.header),
          .version = found.dialect ? std::optional(found.dialect->version) : std::nullopt};
}

}  // namespace fleetpub::vda5050
