// What is wrong with a message.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "base/rapidjson.h"

namespace fleetpub::message {

/// One thing that is wrong with a message.
struct Violation {
  /// JSON Pointer (RFC 6901) to the offending value; "" is the whole message. With the message's
  /// own names in it: base::Printable before it is shown on a terminal.
  std::string path;
  /// In a person's words, safe to show: `must be one of NONE, SOFT, HARD, not "LOUD"`.
  std::string message;

  friend bool operator==(const Violation&, const Violation&) = default;
};

/// What a rule says that stands in the specification's text and not in its schema.
struct TextFinding {
  Violation violation;
  bool is_error = true;  ///< false: a warning, and the message may go
};

using TextRules = std::function<std::vector<TextFinding>(const base::JsonValue& message)>;

}  // namespace fleetpub::message
