#include "vda5050/catalogue/catalogue.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "base/text.h"

namespace fleetpub::vda5050 {
namespace {

using NamePair = std::pair<std::string_view, std::string_view>;

// What people say, and the predefined name in the newest version that has it.
constexpr std::array<NamePair, 6> kShortNames = {{
    {"pause", "startPause"},
    {"resume", "stopPause"},
    {"cancel", "cancelOrder"},
    {"initPosition", "initializePosition"},
    {"charge", "startCharging"},
    {"uncharge", "stopCharging"},
}};

// An action that was renamed: its name before, its name since.
constexpr NamePair kRenamed = {"initPosition", "initializePosition"};

bool AreOneAction(std::string_view a, std::string_view b) {
  const auto is_renamed = [](std::string_view name) {
    return name == kRenamed.first || name == kRenamed.second;
  };
  return a == b || (is_renamed(a) && is_renamed(b));
}

}  // namespace

std::string_view GetName(ParameterType type) {
  switch (type) {
    case ParameterType::kString:
      return "string";
    case ParameterType::kLength:
    case ParameterType::kAngle:
      return "float64";
    case ParameterType::kStringArray:
      return "array of string";
  }
  return "";
}

std::vector<const ActionSpec*> ListActions(Version version) {
  std::vector<const ActionSpec*> actions;
  for (const ActionSpec& action : AllActions()) {
    if (action.versions.Contains(version)) actions.push_back(&action);
  }
  return actions;
}

const ActionSpec* FindAction(Version version, std::string_view type) {
  for (const ActionSpec& action : AllActions()) {
    if (action.type == type && action.versions.Contains(version)) return &action;
  }
  return nullptr;
}

std::string_view NameIn(Version version, std::string_view type) {
  for (const ActionSpec& action : AllActions()) {
    if (action.versions.Contains(version) && AreOneAction(action.type, type)) return action.type;
  }
  return type;
}

std::optional<std::string_view> ActionCalled(std::string_view word) {
  for (const auto& [name, type] : kShortNames) {
    if (base::EqualsIgnoringCase(name, word)) return type;
  }
  for (const ActionSpec& action : AllActions()) {
    if (base::EqualsIgnoringCase(action.type, word)) return action.type;
  }
  return std::nullopt;
}

std::vector<std::string_view> ListShortNames(std::string_view type) {
  std::vector<std::string_view> names;
  for (const auto& [name, canonical] : kShortNames) {
    if (canonical == type) names.push_back(name);
  }
  return names;
}

std::vector<std::string_view> AllActionNames() {
  std::vector<std::string_view> names;
  for (const ActionSpec& action : AllActions()) {
    const std::string_view newest = action.type == kRenamed.first ? kRenamed.second : action.type;
    if (std::find(names.begin(), names.end(), newest) == names.end()) names.push_back(newest);
  }
  return names;
}

std::vector<std::string_view> AllActionWords() {
  std::vector<std::string_view> words;
  for (const std::string_view action : AllActionNames()) {
    words.push_back(action);
    for (const std::string_view name : ListShortNames(action)) words.push_back(name);
  }
  return words;
}

std::optional<std::string> ActionMeant(std::string_view word,
                                       std::span<const std::string_view> others) {
  for (const ActionSpec& action : AllActions()) {
    if (action.counter_action.empty() || !action.type.starts_with("start")) continue;
    const std::string_view bare = action.type.substr(std::string_view("start").size());
    auto names = ListShortNames(action.type);
    names.push_back(bare);
    const bool is_undone = std::any_of(names.begin(), names.end(), [&](std::string_view name) {
      return base::AreOpposites(word, name);
    });
    if (!is_undone) continue;
    const auto short_names = ListShortNames(action.counter_action);
    return std::string(short_names.empty() ? action.counter_action : short_names.front());
  }
  std::vector<std::string_view> names = AllActionWords();
  names.insert(names.begin(), others.begin(), others.end());
  return base::Nearest(word, names);
}

bool IsEverInstant(std::string_view type) {
  const auto actions = AllActions();
  return std::any_of(actions.begin(), actions.end(), [&](const ActionSpec& action) {
    return AreOneAction(action.type, type) && action.scopes.instant;
  });
}

std::vector<ParameterSpec> ParametersInAnyVersion(std::string_view type) {
  std::vector<ParameterSpec> parameters;
  const auto actions = AllActions();
  for (auto action = actions.rbegin(); action != actions.rend(); ++action) {
    if (!AreOneAction(action->type, type)) continue;
    for (const ParameterSpec& parameter : action->parameters) {
      const bool known = std::any_of(parameters.begin(), parameters.end(),
                                     [&](const auto& p) { return p.name == parameter.name; });
      if (!known) parameters.push_back(parameter);
    }
  }
  return parameters;
}

std::string VersionsWithInstant(std::string_view type) {
  std::vector<std::string> names;
  for (const Version version : kVersions) {
    const ActionSpec* action = FindAction(version, NameIn(version, type));
    if (action != nullptr && action->scopes.instant) names.emplace_back(GetFacts(version).name);
  }
  return base::Join(names, ", ");
}

}  // namespace fleetpub::vda5050
