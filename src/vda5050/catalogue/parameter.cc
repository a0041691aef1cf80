#include "vda5050/catalogue/parameter.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "base/file.h"
#include "base/json.h"
#include "base/text.h"

namespace fleetpub::vda5050 {
namespace {

Result<Parameter> NotOfItsType(const ParameterSpec& spec, std::string_view text,
                               std::string_view must_be) {
  return Fail(ErrorKind::kInvalid, fmt::format("{} must be {}, and '{}' is not", spec.name, must_be,
                                               base::Printable(text)));
}

Result<Parameter> ParseNumber(const ParameterSpec& spec, std::string_view text) {
  double value = 0;
  const bool has_plus = text.starts_with('+') && !text.starts_with("+-");
  const std::string_view digits = has_plus ? text.substr(1) : text;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(value)) {
    return NotOfItsType(spec, text, "a finite number");
  }
  if (spec.type == ParameterType::kAngle && std::abs(value) > kMaxAngle) {
    return NotOfItsType(spec, text, "an angle in radians between -π and π");
  }
  // JSON allows fewer spellings than people use (`.5`, `+1`): those it has stay as they were typed.
  const bool is_json = base::ParseJson(text).has_value();
  return Parameter{std::string(spec.name), is_json ? std::string(text) : fmt::format("{}", value)};
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
      return Fail(ErrorKind::kInvalid,
                  fmt::format("-P {}: the text is not valid UTF-8", base::Printable(key)));
    }
    return Parameter{key, base::JsonString(*value)};
  }
  const auto json = base::ParseJson(*value);
  if (!json) {
    return Fail(ErrorKind::kInvalid,
                fmt::format("-P {}:= takes JSON: {} (for plain text: -P {}=…)",
                            base::Printable(key), json.error().message, base::Printable(key)));
  }
  return Parameter{key, base::ToJson(*json)};
}

}  // namespace fleetpub::vda5050
