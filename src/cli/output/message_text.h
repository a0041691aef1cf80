// What a message says, in a person's words.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "mqtt/transport.h"
#include "vda5050/reports/discovery.h"

namespace fleetpub::cli {

/// One thing that a message says. Printable.
struct Statement {
  std::string about;      ///< what it is of: `battery`; the same in each message of a topic
  std::string text;       ///< `battery 62%`
  std::string when_gone;  ///< said when the next message has none about it; may be empty
};

/// `n4 → n5`, `driving`, `battery 62%`. `levels`: of a topic of VDA 5050, or null.
[[nodiscard]] std::vector<Statement> DescribeMessage(const mqtt::Message& message,
                                                     const vda5050::TopicLevels* levels);

/// Those that the last message did not make.
[[nodiscard]] std::vector<Statement> FindNews(const std::vector<Statement>& last,
                                              const std::vector<Statement>& now);

/// With two blanks between them.
[[nodiscard]] std::string JoinStatements(const std::vector<Statement>& statements);

}  // namespace fleetpub::cli
