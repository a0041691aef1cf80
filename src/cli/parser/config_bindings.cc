#include "cli/parser/config_bindings.h"

#include <algorithm>

#include "cli/parser/option_set.h"

namespace fleetpub::cli {
namespace {

void Set(const ConfigBindings::Target& target, const config::ConfigValue& value) {
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

void ConfigBindings::Bind(std::string_view key, const Option& option, Target target) {
  bindings_.push_back({key, option, target});
}

bool ConfigBindings::IsExcepted(std::string_view key) const {
  return std::find(except_.begin(), except_.end(), key) != except_.end();
}

std::vector<std::string_view> ConfigBindings::Apply(const config::Config& config,
                                                    std::vector<std::string_view> except) {
  except_ = std::move(except);
  std::vector<std::string_view> set;
  for (const auto& [key, option, target] : bindings_) {
    if (option.IsGiven() || IsExcepted(key)) continue;
    const config::ConfigValue* const value = config.Find(key);
    if (value == nullptr) continue;
    Set(target, *value);
    set.push_back(key);
  }
  return set;
}

std::vector<ConfigBindings::Effective> ConfigBindings::All(const OptionSet& set,
                                                           const config::Config& config) const {
  std::vector<Effective> all;
  for (const auto& [key, option, target] : bindings_) {
    const std::vector<std::string> texts = TextsOf(target);
    const auto is_empty = [](const std::string& text) { return text.empty(); };
    if (option.IsGiven() && !std::all_of(texts.begin(), texts.end(), is_empty)) {
      all.push_back({key, texts, set.Origin(option)});
    } else if (IsExcepted(key)) {
      continue;
    } else if (const config::ConfigValue* value = config.Find(key)) {
      all.push_back({key, value->texts, value->Origin()});
    } else {
      all.push_back({key, {}, "default"});
    }
  }
  return all;
}

}  // namespace fleetpub::cli
