#include "cli/config_bindings.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

namespace fleetpub::cli {
namespace {

bool IsGiven(const CLI::Option* option) { return option != nullptr && !option->empty(); }

void Set(const ConfigBindings::Target& target, const ConfigValue& value) {
  if (auto* const* text = std::get_if<std::string*>(&target)) {
    **text = value.texts.front();
  } else if (auto* const* texts = std::get_if<std::vector<std::string>*>(&target)) {
    **texts = value.texts;
  } else {
    *std::get<bool*>(target) = value.texts.front() == "true";
  }
}

std::vector<std::string> TextsOf(const ConfigBindings::Target& target) {
  if (auto* const* text = std::get_if<std::string*>(&target)) return {**text};
  if (auto* const* texts = std::get_if<std::vector<std::string>*>(&target)) return **texts;
  return {*std::get<bool*>(target) ? "true" : "false"};
}

}  // namespace

// What the environment sets, CLI11 does not count as parsed.
bool IsByFlag(const CLI::App& app, const CLI::Option& option) {
  const auto& parsed = app.parse_order();
  return std::find(parsed.begin(), parsed.end(), &option) != parsed.end();
}

std::string OriginOf(const CLI::App& app, const CLI::Option& option) {
  if (!IsByFlag(app, option)) {
    return fmt::format("environment variable {}", option.get_envname());
  }
  return fmt::format("flag --{}", option.get_lnames().front());
}

void ConfigBindings::Bind(std::string_view key, const CLI::Option* option, Target target) {
  bindings_.push_back({key, option, target});
}

bool ConfigBindings::IsExcepted(std::string_view key) const {
  return std::find(except_.begin(), except_.end(), key) != except_.end();
}

std::vector<std::string_view> ConfigBindings::Apply(const Config& config,
                                                    std::vector<std::string_view> except) {
  except_ = std::move(except);
  std::vector<std::string_view> set;
  for (const auto& [key, option, target] : bindings_) {
    if (IsGiven(option) || IsExcepted(key)) continue;
    const ConfigValue* const value = config.Find(key);
    if (value == nullptr) continue;
    Set(target, *value);
    set.push_back(key);
  }
  return set;
}

std::vector<ConfigBindings::Effective> ConfigBindings::All(const CLI::App& app,
                                                           const Config& config) const {
  std::vector<Effective> all;
  for (const auto& [key, option, target] : bindings_) {
    const std::vector<std::string> texts = TextsOf(target);
    const auto is_empty = [](const std::string& text) { return text.empty(); };
    if (IsGiven(option) && !std::all_of(texts.begin(), texts.end(), is_empty)) {
      all.push_back({key, texts, OriginOf(app, *option)});
    } else if (IsExcepted(key)) {
      continue;
    } else if (const ConfigValue* value = config.Find(key)) {
      all.push_back({key, value->texts, value->Origin()});
    } else {
      all.push_back({key, {}, "default"});
    }
  }
  return all;
}

}  // namespace fleetpub::cli
