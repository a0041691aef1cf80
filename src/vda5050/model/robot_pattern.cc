#include "vda5050/model/robot_pattern.h"

#include <fmt/format.h>

#include <utility>

#include "base/text.h"

namespace fleetpub::vda5050 {
namespace {

bool HasWildcard(std::string_view part) { return part.find_first_of("*?") != part.npos; }

// Where the next character begins.
std::size_t After(std::string_view text, std::size_t at) {
  do {
    ++at;
  } while (at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80);
  return at;
}

// A character of a pattern that stands for itself.
struct Literal {
  char byte;
  std::size_t length;  // in the pattern
};

Literal LiteralAt(std::string_view pattern, std::size_t at) {
  const auto byte = PercentByte(pattern.substr(at));
  return byte ? Literal{*byte, 3} : Literal{pattern[at], 1};
}

// Linear but for the last `*`, to which it returns when what follows does not fit.
bool MatchesPart(std::string_view pattern, std::string_view text) {
  std::size_t p = 0;
  std::size_t t = 0;
  std::size_t star = pattern.npos;
  std::size_t retry = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      retry = t;
    } else if (p < pattern.size() && pattern[p] == '?') {
      ++p;
      t = After(text, t);
    } else if (p < pattern.size() && LiteralAt(pattern, p).byte == text[t]) {
      p += LiteralAt(pattern, p).length;
      ++t;
    } else if (star != pattern.npos) {
      p = star + 1;
      t = retry = After(text, retry);
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == pattern.npos;
}

RobotPattern Split(std::string_view word) {
  const std::size_t slash = word.find('/');
  return {std::string(word.substr(0, slash)), std::string(word.substr(slash + 1))};
}

}  // namespace

RobotPattern RobotPattern::Of(const RobotAddress& robot) { return Split(robot.ToString()); }

bool RobotPattern::Matches(const RobotAddress& robot) const {
  return MatchesPart(manufacturer, robot.manufacturer) &&
         MatchesPart(serial_number, robot.serial_number);
}

RobotFilter RobotPattern::Filter() const {
  RobotFilter filter;
  if (!HasWildcard(manufacturer)) filter.manufacturer = Unescaped(manufacturer);
  if (!HasWildcard(serial_number)) filter.serial_number = Unescaped(serial_number);
  return filter;
}

Result<RobotPattern> ParseRobotPattern(std::string_view text) {
  if (text.find('/') == std::string_view::npos) {
    return Fail(
        ErrorKind::kUsage,
        fmt::format("'{}' is not a pattern: write manufacturer/serialNumber, such as 'KIT/*' "
                    "or '*/0001', in quotation marks",
                    base::Printable(text)));
  }
  auto literal = ParseRobotAddress(text);
  if (!literal) return Fail(std::move(literal.error()));
  return Split(text);
}

}  // namespace fleetpub::vda5050
