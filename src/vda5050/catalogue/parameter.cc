#include "vda5050/catalogue/parameter.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>

#include "base/decimal.h"
#include "base/file.h"
#include "base/json.h"
#include "base/text.h"

namespace fleetpub::vda5050 {
namespace {

tl::unexpected<Error> NotOfItsType(const ParameterSpec& spec, std::string_view text,
                                   std::string_view must_be, const std::string& hint = "") {
  return Fail(ErrorKind::kUsage, fmt::format("{} must be {}, not '{}'{}", spec.name, must_be,
                                             base::Printable(text), hint));
}

// What people write behind a number, and what it counts in metres or radians.
struct Unit {
  ParameterType type;
  std::string_view name;
  double factor;
};
constexpr double kRadians = std::numbers::pi / 180;
constexpr auto kUnits = std::to_array<Unit>({
    {ParameterType::kLength, "mm", 1e-3},
    {ParameterType::kLength, "cm", 1e-2},
    {ParameterType::kLength, "m", 1},
    {ParameterType::kAngle, "rad", 1},
    {ParameterType::kAngle, "deg", kRadians},
    {ParameterType::kAngle, "°", kRadians},
});

std::optional<double> ReadNumber(std::string_view text) {
  double value = 0;
  const bool has_plus = text.starts_with('+') && !text.starts_with("+-");
  const std::string_view digits = has_plus ? text.substr(1) : text;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

// Towards zero: π must not become more than π.
std::string WithFewDigits(double value) {
  constexpr double kParts = 1e4;
  const std::string text = fmt::format("{:.4f}", std::trunc(value * kParts) / kParts);
  return text.substr(0, text.find_last_not_of('0') + 1);
}

// What an angle beyond ±π probably means: one turn more or less, or degrees.
std::string AngleHint(double value) {
  if (std::abs(value) <= 2 * std::numbers::pi) {
    return fmt::format("; in radians that is {}",
                       WithFewDigits(std::remainder(value, 2 * std::numbers::pi)));
  }
  const double degrees = std::remainder(value, 360);
  if (std::abs(value) > 360) return "";
  return fmt::format("; for degrees write {}deg, or {} in radians", degrees,
                     WithFewDigits(degrees * kRadians));
}

Result<Parameter> ParseNumber(const ParameterSpec& spec, std::string_view text) {
  const auto unit = std::find_if(kUnits.begin(), kUnits.end(), [&](const Unit& candidate) {
    return candidate.type == spec.type && text.ends_with(candidate.name);
  });
  const bool has_unit = unit != kUnits.end();
  std::string_view number = text.substr(0, text.size() - (has_unit ? unit->name.size() : 0));
  if (has_unit) number = base::Trimmed(number);
  const auto read = ReadNumber(number);
  if (!read) {
    const auto right = base::WithDecimalPoint(text);
    return NotOfItsType(spec, text, "a finite number",
                        right ? fmt::format("; write {}", base::Printable(*right)) : "");
  }
  const double value = has_unit ? *read * unit->factor : *read;
  if (spec.type == ParameterType::kAngle && std::abs(value) > kMaxAngle) {
    const std::string hint = has_unit && unit->factor != 1
                                 ? fmt::format("; write {}deg", std::remainder(*read, 360))
                                 : AngleHint(value);
    return NotOfItsType(spec, text, "an angle in radians between -π and π", hint);
  }
  // JSON allows fewer spellings than people use (`.5`, `+1`): those it has stay as they were typed.
  const bool is_json = value == *read && base::ParseJson(number).has_value();
  return Parameter{std::string(spec.name),
                   is_json ? std::string(number) : fmt::format("{}", value)};
}

Result<Parameter> ParseStringArray(const ParameterSpec& spec, std::string_view text) {
  std::string json = "[";
  for (const std::string& part : base::Split(text, ',')) {
    if (json.size() > 1) json += ',';
    json += base::JsonString(part);
  }
  return Parameter{std::string(spec.name), json + "]"};
}

// The text behind the `=`: itself, or the content of the file that `@` names.
Result<std::string> TextOrFile(std::string_view text) {
  if (!text.starts_with('@')) return std::string(text);
  return base::ReadFile(std::string(text.substr(1)), base::JsonLimits{}.bytes);
}

}  // namespace

Result<Parameter> ParseParameter(const ParameterSpec& spec, std::string_view text) {
  if (!base::IsUtf8(text)) return NotOfItsType(spec, text, "valid UTF-8");
  switch (spec.type) {
    case ParameterType::kLength:
    case ParameterType::kAngle:
      return ParseNumber(spec, text);
    case ParameterType::kStringArray:
      return ParseStringArray(spec, text);
    case ParameterType::kString:
      break;
  }
  return Parameter{std::string(spec.name), base::JsonString(text)};
}

Result<Parameter> ParseAssignment(std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) {
    return Fail(ErrorKind::kUsage,
                "-P sets an action parameter: -P key=text, -P key:=json, -P key=@file; what was "
                "given has no '=' (passwords: --password-file or FLEETPUB_PASSWORD)");
  }
  const bool is_json = equals > 0 && text[equals - 1] == ':';
  const std::string key(text.substr(0, is_json ? equals - 1 : equals));
  if (key.empty() || !base::IsUtf8(key)) {
    return Fail(ErrorKind::kUsage, "-P: the key before the '=' is empty or not valid UTF-8");
  }
  auto value = TextOrFile(text.substr(equals + 1));
  if (!value) return Fail(std::move(value.error()));
  if (!is_json) {
    if (!base::IsUtf8(*value)) {
      return Fail(ErrorKind::kUsage,
                  fmt::format("-P {}: the text is not valid UTF-8", base::Printable(key)));
    }
    return Parameter{key, base::JsonString(*value)};
  }
  const auto json = base::ParseJson(*value);
  if (!json) {
    return Fail(ErrorKind::kUsage,
                fmt::format("-P {}:= takes JSON: {} (for plain text: -P {}=…)",
                            base::Printable(key), json.error().message, base::Printable(key)));
  }
  return Parameter{key, base::ToJson(*json)};
}

}  // namespace fleetpub::vda5050
