#include "vda5050/model/robot_address.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "base/text.h"

namespace fleetpub::vda5050 {
namespace {

constexpr std::size_t kLongestTopic = 65'535;  // MQTT §1.5.3: strings have a 16-bit length

bool IsControl(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; }

// Why this may not be a topic level, or "".
std::string_view FaultOfLevel(std::string_view level) {
  if (level.empty()) return "it is empty";
  if (level.find_first_of("+#") != std::string_view::npos) {
    return "+ and # are wildcards and cannot be part of a name";
  }
  if (level.find('$') != std::string_view::npos) return "$ is reserved for the broker";
  if (level.find('/') != std::string_view::npos) return "/ separates topic levels";
  if (std::any_of(level.begin(), level.end(), IsControl)) return "it contains a control character";
  if (!base::IsUtf8(level)) return "it is not valid UTF-8";
  return "";
}

Status CheckLevel(std::string_view target, std::string_view what, std::string_view level) {
  const std::string_view fault = FaultOfLevel(level);
  if (fault.empty()) return {};
  return Fail(ErrorKind::kUsage, fmt::format("target '{}': its {} is refused: {}",
                                             base::Printable(target), what, fault));
}

// Quotation marks and backslashes are what `xargs` and `read` take away. A blank inside is left:
// there are makers with two words; but `xargs` would cut there, so that no option may follow.
bool NeedsEscape(const base::CodePoint& code, bool is_in_front, bool is_at_an_end) {
  constexpr std::string_view kAnywhere = "%*?\\\"'";
  constexpr std::string_view kInFront = "@-[";
  if (code.bytes == 0 || base::IsHidden(code.value)) return true;
  if (code.value > 0x7F) return base::IsBlank(code.value);
  const char c = static_cast<char>(code.value);
  return kAnywhere.find(c) != std::string_view::npos ||
         (is_in_front && kInFront.find(c) != std::string_view::npos) || (c == ' ' && is_at_an_end);
}

void AppendEscaped(std::string_view name, bool is_in_front, std::string& word) {
  for (std::size_t at = 0; at < name.size();) {
    const base::CodePoint code = base::DecodeFront(name.substr(at));
    const std::size_t bytes = std::max<std::size_t>(code.bytes, 1);
    if (NeedsEscape(code, is_in_front, at == 0 || at + bytes == name.size())) {
      for (const char c : name.substr(at, bytes)) {
        word += fmt::format("%{:02X}", static_cast<unsigned char>(c));
      }
    } else {
      word += name.substr(at, bytes);
    }
    is_in_front = name[at] == ' ';
    at += bytes;
  }
}

// Replaces each {placeholder}; an unknown one is an error.
Result<std::string> Fill(std::string_view topic_template, auto value_of) {
  std::string topic;
  while (!topic_template.empty()) {
    const std::size_t open = topic_template.find('{');
    topic += topic_template.substr(0, open);
    if (open == std::string_view::npos) break;
    const std::size_t close = topic_template.find('}', open);
    const std::string_view name = topic_template.substr(open + 1, close - open - 1);
    const std::string_view* value = close == std::string_view::npos ? nullptr : value_of(name);
    if (value == nullptr) {
      return Fail(
          ErrorKind::kUsage,
          fmt::format("topic template: '{{{}' is not a placeholder; there are {{interface}} "
                      "{{major}} {{manufacturer}} {{serial}} {{topic}}",
                      base::Printable(name)));
    }
    topic += *value;
    topic_template.remove_prefix(close + 1);
  }
  return topic;
}

Status CheckTemplate(std::string_view topic_template) {
  if (topic_template.find("{serial}") != std::string_view::npos) return {};
  return Fail(ErrorKind::kUsage,
              fmt::format("topic template '{}' lacks {{serial}}: every robot would get the message",
                          base::Printable(topic_template)));
}

Status CheckTopic(const std::string& topic) {
  if (topic.size() > kLongestTopic) {
    return Fail(ErrorKind::kUsage,
                fmt::format("topic of {} bytes: MQTT allows {}", topic.size(), kLongestTopic));
  }
  const auto levels = base::Split(topic, '/');
  for (std::size_t i = 0; i < levels.size(); ++i) {
    std::string_view level = levels[i];
    // A leading slash or `$name` may be what a cloud broker's own prefix demands.
    if (i == 0 && level.starts_with('$')) level.remove_prefix(1);
    if (i == 0 && level.empty()) continue;
    const std::string_view fault = FaultOfLevel(level);
    if (fault.empty()) continue;
    return Fail(ErrorKind::kUsage,
                fmt::format("topic '{}': level '{}' is refused: {}", base::Printable(topic),
                            base::Printable(levels[i]), fault));
  }
  return {};
}

}  // namespace

std::optional<char> PercentByte(std::string_view text) {
  unsigned value = 0;
  if (text.size() < 3 || text[0] != '%') return std::nullopt;
  const auto [end, error] = std::from_chars(text.data() + 1, text.data() + 3, value, 16);
  if (error != std::errc() || end != text.data() + 3) return std::nullopt;
  return static_cast<char>(value);
}

std::string Unescaped(std::string_view text) {
  std::string plain;
  plain.reserve(text.size());
  while (!text.empty()) {
    const auto byte = PercentByte(text);
    plain += byte.value_or(text.front());
    text.remove_prefix(byte ? 3 : 1);
  }
  return plain;
}

std::string RobotAddress::ToString() const {
  const bool is_plain = HasRecommendedCharacters(manufacturer) &&
                        HasRecommendedCharacters(serial_number) && !manufacturer.starts_with('-');
  if (is_plain) return manufacturer + "/" + serial_number;
  std::string word;
  word.reserve(manufacturer.size() + serial_number.size() + 1);
  AppendEscaped(manufacturer, true, word);
  word += '/';
  AppendEscaped(serial_number, false, word);
  return word;
}

bool IsAddressable(const RobotAddress& robot) {
  return FaultOfLevel(robot.manufacturer).empty() && FaultOfLevel(robot.serial_number).empty();
}

bool IsWrittenOtherwise(const RobotAddress& robot) {
  return robot.ToString() != robot.manufacturer + "/" + robot.serial_number;
}

Result<RobotAddress> ParseRobotAddress(std::string_view text) {
  const std::size_t slash = text.find('/');
  if (slash == std::string_view::npos || text.find('/', slash + 1) != std::string_view::npos) {
    return Fail(ErrorKind::kUsage,
                fmt::format("'{}' is not a target: name a robot as manufacturer/serialNumber, "
                            "such as KIT/0001",
                            base::Printable(text)));
  }
  RobotAddress robot{Unescaped(text.substr(0, slash)), Unescaped(text.substr(slash + 1))};
  if (auto ok = CheckLevel(text, "manufacturer", robot.manufacturer); !ok) return Fail(ok.error());
  if (auto ok = CheckLevel(text, "serial number", robot.serial_number); !ok) {
    return Fail(ok.error());
  }
  return robot;
}

bool HasRecommendedCharacters(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '.' || c == ':' || c == '-';
  });
}

Status CheckInterface(std::string_view name) {
  const std::string_view level = name.starts_with('$') ? name.substr(1) : name;
  const std::string_view fault = FaultOfLevel(level);
  if (fault.empty()) return {};
  const std::string remedy = level.find('/') == std::string_view::npos
                                 ? ""
                                 : fmt::format(
                                       "; give all levels with --topic-template "
                                       "'{}/{{major}}/{{manufacturer}}/{{serial}}/{{topic}}'",
                                       base::Printable(name));
  return Fail(ErrorKind::kUsage, fmt::format("the interface '{}' is refused: {}{}",
                                             base::Printable(name), fault, remedy));
}

Result<std::string> TopicFor(const TopicScheme& scheme, Version version, const RobotAddress& robot,
                             std::string_view topic) {
  if (auto ok = CheckTemplate(scheme.topic_template); !ok) return Fail(ok.error());
  const VersionFacts& facts = GetFacts(version);
  const std::string_view interface_name = scheme.interface_name.empty()
                                              ? facts.interface_name
                                              : std::string_view(scheme.interface_name);
  const std::string_view manufacturer = robot.manufacturer;
  const std::string_view serial = robot.serial_number;
  const auto value_of = [&](std::string_view name) -> const std::string_view* {
    if (name == "interface") return &interface_name;
    if (name == "major") return &facts.major;
    if (name == "manufacturer") return &manufacturer;
    if (name == "serial") return &serial;
    if (name == "topic") return &topic;
    return nullptr;
  };
  auto full = Fill(scheme.topic_template, value_of);
  if (!full) return full;
  if (auto ok = CheckTopic(*full); !ok) return Fail(ok.error());
  return full;
}

}  // namespace fleetpub::vda5050
