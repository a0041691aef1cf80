#include "vda5050/reports/condition.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <vector>

#include "base/json.h"
#include "base/text.h"
#include "schema/schema.h"
#include "vda5050/model/version.h"
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

std::string_view FormatComparison(Comparison comparison) {
  if (comparison == Comparison::kEqual) return "=";
  return std::find_if(kOperators.begin(), kOperators.end(),
                      [comparison](const Operator& each) { return each.comparison == comparison; })
      ->text;
}

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

// `>90` behind the operator of `battery=>90`.
std::string TurnedOperator(std::string_view path, std::string_view wanted) {
  const std::string value(base::Trimmed(wanted.substr(1)));
  const std::string sign = std::string(1, wanted.front()) + "=";
  return fmt::format("'{}{}{}'", base::Printable(path), sign, base::Printable(value));
}

// The number that a text such as `20%` begins with; `80` when it begins with none.
std::string_view NumberIn(std::string_view text) {
  const std::size_t end = text.find_first_not_of("-.0123456789");
  const std::string_view number = text.substr(0, end);
  return number.find_first_of("0123456789") == std::string_view::npos ? "80" : number;
}

// What the releases' schemas say of a topic's members: name ─▶ the values that are allowed, if they
// are few.
using Members = std::map<std::string, std::set<std::string>, std::less<>>;

void AddMembers(std::string_view rules, Members& members) {
  const auto schema = base::ParseJson(rules);
  const Value* properties = schema ? base::FindMember(*schema, "properties") : nullptr;
  if (properties == nullptr || !properties->IsObject()) return;
  for (const auto& [name, property] : properties->GetObject()) {
    auto& values = members[std::string(base::ToView(name))];
    if (base::StringMember(property, "type") == "boolean") values.insert({"true", "false"});
    const Value* choices = base::FindMember(property, "enum");
    if (choices == nullptr) continue;
    for (const Value& choice : choices->GetArray()) {
      if (choice.IsString()) values.emplace(base::ToView(choice));
    }
  }
}

Members FindMembers(std::string_view topic_name) {
  Members members;
  for (const Version version : kVersions) {
    const std::string name = fmt::format("vda5050/{}/{}", GetFacts(version).name, topic_name);
    for (const schema::Embedded& embedded : schema::EmbeddedSchemas()) {
      if (embedded.name == name) AddMembers(embedded.rules, members);
    }
  }
  return members;
}

std::optional<std::string> NearestIn(std::string_view word, const auto& names) {
  return base::Nearest(word, std::vector<std::string_view>(names.begin(), names.end()));
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
               : "its path is not a JSON Pointer: in names, ~0 stands for ~ and ~1 for /";
  }
  if (path.find_first_of("/.") == std::string::npos) return "";
  std::string pointer = path;
  std::replace(pointer.begin(), pointer.end(), '.', '/');
  return fmt::format("the way to an inner member is a JSON Pointer: write /{}",
                     base::Printable(pointer));
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
  const std::string_view wanted = quoted ? base::ToView(*condition.value) : condition.wanted;
  if (auto* const normal_form = NormalForm(condition.path)) {
    return normal_form(base::ToView(member)) == normal_form(wanted);
  }
  return base::ToView(member) == wanted;
}

// A whole number of more than 64 bits: neither equal nor unequal to anything but a text.
bool IsInexact(const Condition& condition) {
  return !condition.value && !condition.wanted.empty() &&
         condition.wanted.find_first_not_of("-0123456789") == std::string::npos;
}

bool Compares(const Condition& condition, const Value& member) {
  if (IsInexact(condition) && !member.IsString()) return false;
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
  if (auto value = base::ParseJson(condition.wanted, {.exact = true}))
    condition.value = *std::move(value);
  const bool is_number = condition.value && condition.value->IsNumber();
  if (condition.wanted.find_first_of("<>=!") == 0) {
    return refuse("its operator is the wrong way round: write " +
                  TurnedOperator(condition.path, condition.wanted));
  }
  if (IsOrder(condition.comparison) && !is_number) {
    return refuse(fmt::format("{} compares numbers: write '{}{}{}'", found.text,
                              base::Printable(condition.path), found.text,
                              NumberIn(condition.wanted)));
  }
  return condition;
}

Result<std::string> CheckCondition(const Condition& condition, std::string_view topic_name) {
  const std::string& path = condition.path;
  const bool is_alias = std::any_of(kAliases.begin(), kAliases.end(),
                                    [&](const Alias& alias) { return alias.name == path; });
  if (path.starts_with('/') || is_alias) return "";
  const Members members = FindMembers(topic_name);
  if (members.empty()) return "";
  const auto refuse = [&](std::string_view what, const std::string& nearest_path,
                          const std::string& nearest_value) {
    return Fail(ErrorKind::kUsage,
                fmt::format("condition '{}': {} {}: did you mean {}{}{}? '/{}' is used as it is",
                            base::Printable(ToString(condition)), topic_name, what, nearest_path,
                            FormatComparison(condition.comparison), base::Printable(nearest_value),
                            base::Printable(ToString(condition))));
  };
  std::set<std::string_view> names;
  for (const auto& [name, values] : members) names.insert(name);
  for (const Alias& alias : kAliases) names.insert(alias.name);
  if (!names.contains(path)) {
    for (const std::string_view other : {"connection", "state", "factsheet"}) {
      if (!FindMembers(other).contains(path)) continue;
      return Fail(ErrorKind::kUsage,
                  fmt::format("condition '{}': {} has no such member, {} has",
                              base::Printable(ToString(condition)), topic_name, other));
    }
    const auto nearest = NearestIn(path, names);
    if (nearest) return refuse("has no such member", *nearest, condition.wanted);
    return fmt::format("no version of {} has a member {}", topic_name, base::Printable(path));
  }
  const auto member = members.find(path);
  if (member == members.end() || member->second.empty() || IsOrder(condition.comparison)) return "";
  const std::set<std::string>& values = member->second;
  auto* const normal_form = NormalForm(path);
  const std::string wanted = condition.value && condition.value->IsString()
                                 ? std::string(base::ToView(*condition.value))
                                 : condition.wanted;
  if (values.contains(normal_form == nullptr ? wanted : normal_form(wanted))) return "";
  const auto nearest = NearestIn(wanted, values);
  if (nearest) return refuse("knows no such value", path, *nearest);
  return fmt::format("{} of a {} is one of {}", path, topic_name, fmt::join(values, ", "));
}

const Value* FindByPath(const std::string& path, const Value& message) {
  if (path.starts_with('/')) return base::JsonPointer(path).Get(message);
  if (const Value* member = base::FindMember(message, path)) return member;
  for (const auto& [name, pointer] : kAliases) {
    if (name != path) continue;
    const base::JsonPointer way(pointer.data(), pointer.size());
    if (const Value* member = way.Get(message)) return member;
  }
  return nullptr;
}

std::string ToString(const Condition& condition) {
  return condition.path + std::string(FormatComparison(condition.comparison)) + condition.wanted;
}

std::optional<std::string> Unmet(const Condition& condition, const Value& message) {
  constexpr std::size_t kLongest = 80;
  const Value* member = FindByPath(condition.path, message);
  if (member == nullptr) return fmt::format("there is no {}", base::Printable(condition.path));
  if (Compares(condition, *member)) return std::nullopt;
  return fmt::format("{} is {}", base::Printable(condition.path),
                     Shown(base::ToJson(*member), kLongest));
}

}  // namespace fleetpub::vda5050
