#include "vda5050/rules/conformance.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "base/json.h"
#include "base/text.h"
#include "vda5050/messages/user_message.h"
#include "vda5050/reports/robot_messages.h"
#include "vda5050/rules/text_rules.h"

namespace fleetpub::vda5050 {
namespace {

using base::StringMember;
using Value = base::JsonValue;
using schema::Violation;

constexpr std::array<std::string_view, 8> kTopics = {"state",         "connection",     "factsheet",
                                                     "visualization", "instantActions", "order",
                                                     "zoneSet",       "responses"};

// 1.1's text has v2 in its example, and there are robots that follow it.
bool MatchesLevel(Version version, std::string_view major) {
  return major.empty() || major == GetFacts(version).major ||
         (version == Version::k110 && major == "v2");
}

void CompareWithTopic(const Value& message, std::string_view member, std::string_view level,
                      std::vector<Violation>& errors) {
  const std::string_view said = StringMember(message, member);
  if (said.empty() || said == level) return;  // a missing one is for the schema to say
  errors.push_back({fmt::format("/{}", member), fmt::format("is \"{}\", but the topic says \"{}\"",
                                                            Shown(said, 80), Shown(level, 80))});
}

// The text's rules are no schema rules: they are warnings unless somebody is strict.
void Soften(delivery::Findings& findings) {
  if (!findings.satisfies_schema) return;
  std::move(findings.errors.begin(), findings.errors.end(), std::back_inserter(findings.warnings));
  findings.errors.clear();
}

}  // namespace

std::span<const std::string_view> AllTopics() { return kTopics; }

Conformance::Conformance(ConformanceOptions options, schema::Registry& registry)
    : options_(std::move(options)), registry_(registry) {}

Result<std::vector<std::string>> Conformance::Filters() const {
  if (options_.topic.empty()) {
    return DiscoveryFilters(options_.scheme, options_.pattern.Filter(), kTopics);
  }
  if (std::find(kTopics.begin(), kTopics.end(), options_.topic) == kTopics.end()) {
    return Fail(ErrorKind::kUsage,
                fmt::format("'{}' is no topic of VDA 5050: state, connection, factsheet, "
                            "visualization, instantActions, order, zoneSet or responses",
                            base::Printable(options_.topic)));
  }
  const std::array<std::string_view, 1> one = {options_.topic};
  return DiscoveryFilters(options_.scheme, options_.pattern.Filter(), one);
}

std::optional<ValidationResult> Conformance::Validate(std::string_view topic,
                                                      std::string_view payload) {
  const auto levels = ReadTopic(options_.scheme, topic);
  if (!levels || !options_.pattern.Matches(levels->robot)) return std::nullopt;
  if (std::find(kTopics.begin(), kTopics.end(), levels->topic_name) == kTopics.end()) {
    return std::nullopt;
  }
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
                                  ValidationResult& result) {
  std::vector<Violation> header;
  const auto version = FindVersion(message, levels, header);
  CompareWithTopic(message, "manufacturer", levels.robot.manufacturer, header);
  CompareWithTopic(message, "serialNumber", levels.robot.serial_number, header);
  delivery::Findings& findings = result.findings;
  if (version) {
    result.version = GetFacts(*version).name;
    const auto schema =
        registry_.Find(fmt::format("vda5050/{}/{}", result.version, levels.topic_name));
    if (schema) {
      findings = delivery::Check(message, **schema, TextRulesFor(levels.topic_name, *version));
      options_.strict ? delivery::Harden(findings) : Soften(findings);
    } else {
      header.push_back({"", schema.error().message});
    }
  }
  std::move(header.begin(), header.end(), std::back_inserter(findings.errors));
}

// Where the header does not say it as it should, what it seems to mean, or what the topic says.
std::optional<Version> Conformance::FindVersion(const Value& message, const TopicLevels& levels,
                                                std::vector<Violation>& errors) const {
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
  if (exact && !MatchesLevel(*exact, levels.major)) {
    errors.push_back({"/version", fmt::format("is \"{}\", but the topic says \"{}\"", said,
                                              Shown(levels.major, 80))});
  }
  if (exact) return exact;
  errors.push_back(
      {"/version", spoken ? fmt::format("\"{}\" is no release of VDA 5050: held against {}",
                                        Shown(said, 80), GetFacts(spoken->version).name)
                          : fmt::format("\"{}\" is no release of VDA 5050, and the topic does not "
                                        "tell one either",
                                        Shown(said, 80))});
  return spoken ? std::optional(spoken->version) : std::nullopt;
}

}  // namespace fleetpub::vda5050
