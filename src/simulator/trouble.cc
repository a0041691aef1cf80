#include "simulator/trouble.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/text.h"

namespace fleetpub::simulator {
namespace {

using vda5050::Version;

// In the order of the specification, §6.10.6 up to 2.1 and §7.8 of 3.0.
std::span<const std::string_view> ListLevels(Version version) {
  static constexpr std::array<std::string_view, 2> kUpTo21 = {"WARNING", "FATAL"};
  static constexpr std::array<std::string_view, 4> kFrom30 = {"WARNING", "URGENT", "CRITICAL",
                                                              "FATAL"};
  if (version >= Version::k300) return kFrom30;
  return kUpTo21;
}

std::optional<double> ReadNumber(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool is_whole = error == std::errc() && end == text.data() + text.size();
  return is_whole && std::isfinite(number) ? std::optional(number) : std::nullopt;
}

}  // namespace

Result<RobotError> ParseRobotError(std::string_view text, Version version) {
  const auto fail = [&](std::string_view why) {
    return Fail(ErrorKind::kUsage, fmt::format("--error takes TYPE:LEVEL or TYPE:LEVEL:TEXT, such "
                                               "as motorFault:FATAL, not '{}'{}",
                                               base::Printable(text), why));
  };
  if (!base::IsUtf8(text)) return fail(": it is not valid UTF-8");
  const std::string_view type = text.substr(0, text.find(':'));
  if (type.empty() || type.size() == text.size()) return fail("");
  const std::string_view rest = text.substr(type.size() + 1);
  const std::string_view word = rest.substr(0, rest.find(':'));
  const auto levels = ListLevels(version);
  const auto level = std::find_if(levels.begin(), levels.end(), [&](std::string_view one) {
    return base::EqualsIgnoringCase(one, word);
  });
  if (level == levels.end()) {
    return fail(
        fmt::format(": the levels of VDA 5050 {} are {}", vda5050::GetFacts(version).name,
                    base::Join(std::vector<std::string>(levels.begin(), levels.end()), ", ")));
  }
  const std::string_view description =
      word.size() == rest.size() ? std::string_view() : rest.substr(word.size() + 1);
  return RobotError{.type = std::string(type),
                    .description = std::string(description),
                    .references = {},
                    .until = Until::kEnd,
                    .level = *level};
}

Result<Position> ParsePosition(std::string_view text) {
  const auto fail = [&](std::string_view why) {
    return Fail(ErrorKind::kUsage,
                fmt::format("--position takes x,y,theta or x,y,theta,map in metres and radians, "
                            "such as 1.5,-2,0.5,hall-1, not '{}'{}",
                            base::Printable(text), why));
  };
  if (!base::IsUtf8(text)) return fail(": it is not valid UTF-8");
  const auto parts = base::Split(text, ',');
  if (parts.size() < 3 || parts.size() > 4) return fail("");
  Position position;
  for (const auto& [part, into] :
       {std::pair(parts[0], &position.x), std::pair(parts[1], &position.y),
        std::pair(parts[2], &position.theta)}) {
    const auto number = ReadNumber(part);
    if (!number) return fail("");
    *into = *number;
  }
  if (std::abs(position.theta) > std::numbers::pi) return fail(": theta lies between -pi and pi");
  if (parts.size() == 4) position.map_id = parts[3];
  if (position.map_id.empty()) return fail(": the map has no name");
  return position;
}

bool HasEmergencyStop(std::string_view value, Version version) {
  return value != "AUTOACK" || version < Version::k300;
}

}  // namespace fleetpub::simulator
