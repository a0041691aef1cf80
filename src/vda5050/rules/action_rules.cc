#include "vda5050/rules/action_rules.h"

#include <fmt/format.h>

#include <cmath>

#include "base/json.h"
#include "base/text.h"
#include "vda5050/model/robot_address.h"

namespace fleetpub::vda5050 {
namespace {

using base::FindMember;
using base::StringMember;
using Value = base::JsonValue;

// What is wrong with this value for a predefined parameter, or "".
std::string FaultOfValue(const ParameterSpec& spec, const Value& value) {
  switch (spec.type) {
    case ParameterType::kString:
      return value.IsString() ? "" : "must be a string";
    case ParameterType::kLength:
      if (value.IsString()) return "must be a number, not a string: robots refuse quoted numbers";
      return value.IsNumber() ? "" : "must be a number";
    case ParameterType::kAngle:
      if (value.IsString()) return "must be a number, not a string: robots refuse quoted numbers";
      if (!value.IsNumber()) return "must be a number";
      return std::abs(value.GetDouble()) <= kMaxAngle
                 ? ""
                 : "must be an angle in radians between -π and π";
    case ParameterType::kStringArray:
      if (!value.IsArray()) return "must be an array of strings";
      for (const Value& item : value.GetArray()) {
        if (!item.IsString()) return "must be an array of strings";
      }
      return "";
  }
  return "";
}

// A key that the version does not predefine: allowed, but perhaps a slip.
void CheckFurtherKey(const ActionSpec& action, std::string_view key, const std::string& path,
                     Findings& findings) {
  std::vector<std::string_view> names;
  for (const ParameterSpec& spec : action.parameters) names.push_back(spec.name);
  if (const auto nearest = base::Nearest(key, names)) {
    return AddWarning(findings, path,
                      fmt::format("'{}' is not a parameter that {} has: did you mean {}?",
                                  base::Printable(key), action.type, *nearest));
  }
  for (const ParameterSpec& spec : ParametersInAnyVersion(action.type)) {
    if (spec.name != key) continue;
    AddWarning(findings, path,
               fmt::format("{} has no predefined parameter '{}' in this version: it is sent as an "
                           "additional one",
                           action.type, key));
  }
}

}  // namespace

void CheckActionParameters(const ActionSpec& action, const Value* parameters,
                           const std::string& path, Findings& findings) {
  std::set<std::string_view> present;
  // A user's own schema may let pass what the official ones do not.
  const bool are_given = parameters != nullptr && parameters->IsArray();
  const rapidjson::SizeType count = are_given ? parameters->Size() : 0;
  for (rapidjson::SizeType i = 0; i < count; ++i) {
    const Value& parameter = (*parameters)[i];
    const std::string_view key = StringMember(parameter, "key");
    const std::string place = fmt::format("{}/actionParameters/{}", path, i);
    if (!present.insert(key).second) {
      AddError(findings, place, fmt::format("parameter '{}' is given twice", base::Printable(key)));
      continue;
    }
    const ParameterSpec* spec = nullptr;
    for (const ParameterSpec& candidate : action.parameters) {
      if (candidate.name == key) spec = &candidate;
    }
    if (spec == nullptr) {
      CheckFurtherKey(action, key, place, findings);
    } else if (const Value* value = FindMember(parameter, "value"); value == nullptr) {
      AddError(findings, place, fmt::format("{} has no value", key));
    } else if (auto fault = FaultOfValue(*spec, *value); !fault.empty()) {
      AddError(findings, place + "/value", fmt::format("{} {}", key, fault));
    }
  }
  std::vector<std::string> missing;
  for (const ParameterSpec& spec : action.parameters) {
    if (spec.required && !present.contains(spec.name)) missing.emplace_back(spec.name);
  }
  if (!missing.empty()) {
    AddError(findings, path,
             fmt::format("{} needs the parameter{} {}", action.type, missing.size() == 1 ? "" : "s",
                         base::Join(missing, ", ")));
  }
}

void AddError(Findings& findings, std::string path, std::string message) {
  findings.push_back({{std::move(path), std::move(message)}, true});
}

void AddWarning(Findings& findings, std::string path, std::string message) {
  findings.push_back({{std::move(path), std::move(message)}, false});
}

void CheckUnknownType(std::string_view type, const std::string& path, Version version,
                      Findings& findings) {
  auto predefined = ActionCalled(type);
  if (!predefined) {
    if (const auto word = ActionMeant(type)) predefined = ActionCalled(*word);
  }
  const std::string_view meant = predefined ? NameIn(version, *predefined) : "";
  if (FindAction(version, meant) == nullptr) return;
  AddWarning(
      findings, path + "/actionType",
      fmt::format("'{}' is not a predefined action, so it counts as a manufacturer's own: did you "
                  "mean {}? (names are case-sensitive)",
                  base::Printable(type), meant));
}

void CheckIdCharacters(std::string_view id, const std::string& path, std::string_view name,
                       Findings& findings) {
  if (HasRecommendedCharacters(id)) return;
  AddWarning(findings, fmt::format("{}/{}", path, name),
             fmt::format("{} has characters other than the recommended A-Z a-z 0-9 _ . : -", name));
}

void CheckActionId(std::string_view id, const std::string& path, std::set<std::string_view>& ids,
                   Findings& findings) {
  if (id.empty()) return AddError(findings, path + "/actionId", "actionId must not be empty");
  if (!ids.insert(id).second) {
    AddError(findings, path + "/actionId",
             fmt::format("actionId '{}' is used by two actions: ids must be unique",
                         base::Printable(id)));
  }
  CheckIdCharacters(id, path, "actionId", findings);
}

}  // namespace fleetpub::vda5050
