#include "vda5050/reports/condition.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/json.h"
#include "base/text.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::vda5050 {
namespace {

using Value = base::JsonValue;

struct Operator {
  std::string_view text;
  Comparison comparison;
};

// The longer one of two that begin alike stands first.
constexpr std::array kOperators = {
    Operator{"==", Comparison::kEqual},   Operator{"=", Comparison::kEqual},
    Operator{"!=", Comparison::kUnequal}, Operator{"<=", Comparison::kAtMost},
    Operator{"<", Comparison::kLess},     Operator{">=", Comparison::kAtLeast},
    Operator{">", Comparison::kMore},
};

struct Alias {
  std::string_view name;
  std::string_view pointer;
};

// What is called or placed otherwise in another version: the first one that the message has.
constexpr std::array kAliases = {
    Alias{"battery", "/powerSupply/stateOfCharge"},
    Alias{"battery", "/batteryState/batteryCharge"},
    Alias{"charging", "/powerSupply/charging"},
    Alias{"charging", "/batteryState/charging"},
    Alias{"x", "/mobileRobotPosition/x"},
    Alias{"x", "/agvPosition/x"},
    Alias{"y", "/mobileRobotPosition/y"},
    Alias{"y", "/agvPosition/y"},
    Alias{"theta", "/mobileRobotPosition/theta"},
    Alias{"theta", "/agvPosition/theta"},
    Alias{"mapId", "/mobileRobotPosition/mapId"},
    Alias{"mapId", "/agvPosition/mapId"},
    Alias{"localized", "/mobileRobotPosition/localized"},
    Alias{"localized", "/agvPosition/positionInitialized"},
};

struct Place {
  std::size_t at = std::string_view::npos;
  Operator found{};
};

// The first operator of the text.
Place FindOperator(std::string_view text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    for (const Operator& candidate : kOperators) {
      if (text.substr(i).starts_with(candidate.text)) return {i, candidate};
    }
  }
  return {};
}

bool IsOrder(Comparison comparison) {
  return comparison != Comparison::kEqual && comparison != Comparison::kUnequal;
}

// Why this is no path, or "".
std::string FaultOfPath(const std::string& path) {
  if (path.empty()) {
    return "it names no member: write paused=true or '/batteryState/batteryCharge>=80'";
  }
  if (path.front() == '/') {
    return base::JsonPointer(path).IsValid()
               ? ""
               : "its path is no JSON Pointer: in names, ~0 stands for ~ and ~1 for /";
  }
  if (path.find_first_of("/.") == std::string::npos) return "";
  std::string pointer = path;
  std::replace(pointer.begin(), pointer.end(), '.', '/');
  return fmt::format("the way to an inner member is a JSON Pointer: write /{}",
                     base::Printable(pointer));
}

const Value* Find(const std::string& path, const Value& message) {
  if (path.starts_with('/')) return base::JsonPointer(path).Get(message);
  if (const Value* member = base::FindMember(message, path)) return member;
  for (const auto& [name, pointer] : kAliases) {
    if (name != path) continue;
    const base::JsonPointer way(pointer.data(), pointer.size());
    if (const Value* member = way.Get(message)) return member;
  }
  return nullptr;
}

// What robots spell in several ways is compared as it is shown.
std::string (*NormalForm(std::string_view path))(std::string_view) {
  if (path.starts_with('/')) path.remove_prefix(1);
  if (path == "connectionState") return NormalisedConnectionState;
  return path == "operatingMode" ? NormalisedMode : nullptr;
}

bool Equals(const Condition& condition, const Value& member) {
  if (!member.IsString()) return condition.value && member == *condition.value;
  const bool quoted = condition.value && condition.value->IsString();
  const std::string_view wanted = quoted ? base::ViewOf(*condition.value) : condition.wanted;
  if (auto* const normal_form = NormalForm(condition.path)) {
    return normal_form(base::ViewOf(member)) == normal_form(wanted);
  }
  return base::ViewOf(member) == wanted;
}

bool Compares(const Condition& condition, const Value& member) {
  if (!IsOrder(condition.comparison)) {
    return Equals(condition, member) == (condition.comparison == Comparison::kEqual);
  }
  if (!member.IsNumber()) return false;
  const double said = member.GetDouble();
  const double wanted = condition.value->GetDouble();
  switch (condition.comparison) {
    case Comparison::kLess:
      return said < wanted;
    case Comparison::kAtMost:
      return said <= wanted;
    case Comparison::kMore:
      return said > wanted;
    default:
      return said >= wanted;
  }
}

}  // namespace

Result<Condition> ParseCondition(std::string_view text) {
  const auto refuse = [&](const std::string& why) {
    return Fail(ErrorKind::kUsage, fmt::format("condition '{}': {}", base::Printable(text), why));
  };
  const auto [at, found] = FindOperator(text);
  if (at == std::string_view::npos) {
    return refuse(
        "it has no operator: write paused=true, operatingMode!=MANUAL or, in quotation marks, "
        "'battery>=80'; an unquoted < or > never arrives, as the shell takes it for a file's");
  }
  Condition condition{.path = std::string(base::Trimmed(text.substr(0, at))),
                      .comparison = found.comparison,
                      .wanted = std::string(base::Trimmed(text.substr(at + found.text.size()))),
                      .value = std::nullopt};
  if (!base::IsUtf8(text)) return refuse("it is not valid UTF-8");
  if (const std::string fault = FaultOfPath(condition.path); !fault.empty()) return refuse(fault);
  if (auto value = base::ParseJson(condition.wanted)) condition.value = *std::move(value);
  const bool is_number = condition.value && condition.value->IsNumber();
  if (IsOrder(condition.comparison) && !is_number) {
    return refuse(fmt::format("{} compares numbers: write '{}{}80'", found.text,
                              base::Printable(condition.path), found.text));
  }
  return condition;
}

std::string ToString(const Condition& condition) {
  const auto* written = std::find_if(
      kOperators.begin(), kOperators.end(),
      [&condition](const Operator& each) { return each.comparison == condition.comparison; });
  const std::string_view text =
      condition.comparison == Comparison::kEqual ? std::string_view("=") : written->text;
  return condition.path + std::string(text) + condition.wanted;
}

std::optional<std::string> Unmet(const Condition& condition, const Value& message) {
  constexpr std::size_t kLongest = 80;
  const Value* member = Find(condition.path, message);
  if (member == nullptr) return fmt::format("there is no {}", base::Printable(condition.path));
  if (Compares(condition, *member)) return std::nullopt;
  return fmt::format("{} is {}", base::Printable(condition.path),
                     Shown(base::ToJson(*member), kLongest));
}

}  // namespace fleetpub::vda5050
