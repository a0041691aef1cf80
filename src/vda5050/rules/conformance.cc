#include "vda5050/rules/conformance.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "base/json.h"
#include "base/text.h"
#include "base/time.h"
#include "vda5050/messages/user_message.h"
#include "vda5050/reports/robot_messages.h"
#include "vda5050/rules/text_rules.h"

namespace fleetpub::vda5050 {
namespace {

using base::StringMember;
using Value = base::JsonValue;
using schema::Violation;

// 1.1's text has v2 in its example, and there are robots that follow it.
bool MatchesLevel(Version version, std::string_view major) {
  return major.empty() || major == GetFacts(version).major ||
         (version == Version::k110 && major == "v2");
}

void CompareWithTopic(const Value& message, std::string_view member, std::string_view level,
                      std::vector<Violation>& warnings) {
  const std::string_view said = StringMember(message, member);
  if (said.empty() || said == level) return;  // a missing one is for the schema to say
  warnings.push_back(
      {fmt::format("/{}", member),
       fmt::format("is \"{}\", but the topic says \"{}\"", Shown(said, 80), Shown(level, 80))});
}

// What reads it takes what is not Z for a slip, or for UTC all the same.
void CheckTimestamp(const Value& message, std::vector<Violation>& warnings) {
  const Value* said = base::FindMember(message, "timestamp");
  if (said == nullptr || !said->IsString()) return;
  const std::string_view time = StringMember(message, "timestamp");
  if (time.ends_with('Z') && base::ParseDateTime(time)) return;
  warnings.push_back({"/timestamp", fmt::format("must be a time in UTC such as "
                                                "2026-01-02T03:04:05.678Z, not \"{}\"",
                                                Shown(time, 80))});
}

}  // namespace

delivery::Findings CheckMessage(const Value& message, Version version, std::string_view topic_name,
                                bool strict, schema::Registry& registry,
                                std::vector<Violation> header) {
  const auto schema =
      registry.Find(fmt::format("vda5050/{}/{}", GetFacts(version).name, topic_name));
  if (!schema) return {{{"", schema.error().message}}, std::move(header), false};
  auto findings = delivery::Check(message, **schema, TextRulesFor(topic_name, version));
  if (findings.satisfies_schema) CheckTimestamp(message, findings.warnings);
  std::move(header.begin(), header.end(), std::back_inserter(findings.warnings));
  strict ? delivery::Harden(findings) : delivery::Soften(findings);
  return findings;
}

Conformance::Conformance(ConformanceOptions options, schema::Registry& registry)
    : options_(std::move(options)), registry_(registry) {
  if (options_.patterns.empty()) options_.patterns.emplace_back();
}

Result<std::vector<std::string>> Conformance::Filters() const {
  const bool is_known =
      std::find(kTopicNames.begin(), kTopicNames.end(), options_.topic) != kTopicNames.end();
  if (!options_.topic.empty() && !is_known) {
    return Fail(ErrorKind::kUsage,
                fmt::format("'{}' is not a topic of VDA 5050: state, connection, factsheet, "
                            "visualization, instantActions, order, zoneSet or responses",
                            base::Printable(options_.topic)));
  }
  const std::string_view one = options_.topic;
  const std::span<const std::string_view> topics =
      one.empty() ? std::span<const std::string_view>(kTopicNames) : std::span(&one, 1);
  std::vector<std::string> filters;
  for (const RobotPattern& pattern : options_.patterns) {
    auto some = DiscoveryFilters(options_.scheme, pattern.Filter(), topics);
    if (!some) return some;
    for (std::string& filter : *some) {
      const bool is_new = std::find(filters.begin(), filters.end(), filter) == filters.end();
      if (is_new) filters.push_back(std::move(filter));
    }
  }
  return filters;
}

std::optional<ValidationResult> Conformance::Validate(std::string_view topic,
                                                      std::string_view payload) const {
  const auto levels = ReadTopic(options_.scheme, topic);
  const auto is_meant = [&](const RobotPattern& pattern) { return pattern.Matches(levels->robot); };
  if (!levels || std::none_of(options_.patterns.begin(), options_.patterns.end(), is_meant)) {
    return std::nullopt;
  }
  if (std::find(kTopicNames.begin(), kTopicNames.end(), levels->topic_name) == kTopicNames.end()) {
    return std::nullopt;
  }
  const bool is_asked = options_.topic.empty() || levels->topic_name == options_.topic;
  if (!is_asked) return std::nullopt;
  const bool may_be_deleted =
      levels->topic_name == "connection" || levels->topic_name == "factsheet";
  if (payload.empty() && may_be_deleted) return std::nullopt;
  ValidationResult result;
  result.robot = levels->robot;
  result.topic_name = levels->topic_name;
  const auto message = base::ParseJson(payload);
  if (message) {
    result.header_id = ReadHeader(*message).header_id;
    ValidateMessage(*message, *levels, result);
  } else {
    result.findings.errors.push_back({"", message.error().message});
  }
  return result;
}

void Conformance::ValidateMessage(const Value& message, const TopicLevels& levels,
                                  ValidationResult& result) const {
  std::vector<Violation> errors;
  std::vector<Violation> warnings;
  const auto version = FindVersion(message, levels, errors, warnings);
  CompareWithTopic(message, "manufacturer", levels.robot.manufacturer, warnings);
  CompareWithTopic(message, "serialNumber", levels.robot.serial_number, warnings);
  delivery::Findings& findings = result.findings;
  if (version) {
    result.version = GetFacts(*version).name;
    findings = CheckMessage(message, *version, levels.topic_name, options_.strict, registry_,
                            std::move(warnings));
  } else {
    findings.warnings = std::move(warnings);
    if (options_.strict) delivery::Harden(findings);
  }
  std::move(errors.begin(), errors.end(), std::back_inserter(findings.errors));
}

// Where the header does not say it as it should, what it seems to mean, or what the topic says.
std::optional<Version> Conformance::FindVersion(const Value& message, const TopicLevels& levels,
                                                std::vector<Violation>& errors,
                                                std::vector<Violation>& warnings) const {
  const std::string_view said = StringMember(message, "version");
  const auto spoken = VersionSpoken(said, levels.major);
  const auto exact = spoken && spoken->is_release ? std::optional(spoken->version) : std::nullopt;
  if (options_.version) {
    if (exact != options_.version) {
      errors.push_back({"/version", fmt::format("is \"{}\", not \"{}\"", Shown(said, 80),
                                                GetFacts(*options_.version).name)});
    }
    return options_.version;
  }
  if (!spoken) {
    errors.push_back({"/version", fmt::format("\"{}\" is not a release of VDA 5050, and the topic "
                                              "does not tell one either",
                                              Shown(said, 80))});
    return std::nullopt;
  }
  if (!exact) {
    warnings.push_back({"/version", NoReleaseText(said, spoken->version)});
  } else if (!MatchesLevel(*exact, levels.major)) {
    warnings.push_back({"/version", fmt::format("is \"{}\", but the topic says \"{}\"",
                                                Shown(said, 80), Shown(levels.major, 80))});
  }
  return spoken->version;
}

std::optional<std::string> Conformance::ConnectionTopic(std::string_view topic) const {
  if (!options_.topic.empty()) return std::nullopt;
  const auto levels = ReadTopic(options_.scheme, topic);
  if (!levels || levels->topic_name != "state") return std::nullopt;
  auto beside = TopicBeside(options_.scheme, *levels, "connection");
  return beside ? std::optional(*std::move(beside)) : std::nullopt;
}

ValidationResult Conformance::MissingConnection(RobotAddress robot) const {
  ValidationResult result{.robot = std::move(robot), .topic_name = "connection"};
  auto& list = options_.strict ? result.findings.errors : result.findings.warnings;
  list.push_back({"",
                  "none is retained that may be read here, although the robot sends states: "
                  "whoever connects later "
                  "does not know that it is there"});
  return result;
}

}  // namespace fleetpub::vda5050
