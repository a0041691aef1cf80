// Whether what is published on the topics of VDA 5050 is what the specification allows: messages
// against the schema of their version, and their headers against their topics.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "delivery/validate.h"
#include "schema/schema.h"
#include "vda5050/model/robot_pattern.h"
#include "vda5050/reports/discovery.h"

namespace fleetpub::vda5050 {

struct ConformanceOptions {
  TopicScheme scheme;
  std::vector<RobotPattern> patterns;  ///< none: everybody
  std::optional<Version> version;      ///< that everybody must speak; else as each header says
  std::string topic;                   ///< this one alone; empty: all
  bool strict = false;                 ///< the text's rules are errors too
};

/// A message against the schema of its version and topic, and against the text: its rules (see
/// TextRulesFor), time stamps in UTC (3.0 §7.1.1; 1.1 to 2.1 §6.5), and what is to be warned of its
/// header besides. What breaks no schema is a warning; `strict` makes every warning an error.
[[nodiscard]] delivery::Findings CheckMessage(const base::JsonValue& message, Version version,
                                              std::string_view topic_name, bool strict,
                                              schema::Registry& registry,
                                              std::vector<schema::Violation> header = {});

/// What one message was found to be.
struct ValidationResult {
  RobotAddress robot;
  std::string topic_name;  ///< `state`
  std::optional<std::uint32_t> header_id;
  std::string version;  ///< whose schema it was held against; empty: none
  delivery::Findings findings;
};

class Conformance {
 public:
  /// `registry` must outlive it.
  Conformance(ConformanceOptions options, schema::Registry& registry);

  /// What to subscribe to. Errors: ErrorKind::kUsage (the scheme's template, an unknown topic).
  [[nodiscard]] Result<std::vector<std::string>> Filters() const;

  /// Nothing when the topic is of no robot that is meant, and for the empty payload with which a
  /// retained message is deleted.
  [[nodiscard]] std::optional<ValidationResult> Validate(std::string_view topic,
                                                         std::string_view payload) const;

  /// Where the robot that sends states to this topic must have left its connection message. Nothing
  /// for another topic, and when connection messages are not listened to.
  [[nodiscard]] std::optional<std::string> ConnectionTopic(std::string_view topic) const;
  /// The robot sends states and has left none.
  [[nodiscard]] ValidationResult MissingConnection(RobotAddress robot) const;

 private:
  void ValidateMessage(const base::JsonValue& message, const TopicLevels& levels,
                       ValidationResult& result) const;
  [[nodiscard]] std::optional<Version> FindVersion(const base::JsonValue& message,
                                                   const TopicLevels& levels,
                                                   std::vector<schema::Violation>& errors,
                                                   std::vector<schema::Violation>& warnings) const;

  ConformanceOptions options_;
  schema::Registry& registry_;
};

}  // namespace fleetpub::vda5050
