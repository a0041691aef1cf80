#include "cli/parser/help_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <vector>

#include "base/json.h"
#include "base/text.h"
#include "cli/parser/help.h"
#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::cli {
namespace {

using base::JsonString;
using base::JsonStrings;

// `How long to wait [10s]` ends with the default.
struct Described {
  std::string_view meaning;
  std::string_view standard;
};

Described Describe(std::string_view text) {
  const std::size_t bracket = text.rfind(" [");
  if (!text.ends_with(']') || bracket == std::string_view::npos) return {text, ""};
  return {text.substr(0, bracket), text.substr(bracket + 2, text.size() - bracket - 3)};
}

std::string OptionJson(const Option& option) {
  std::vector<std::string> names;
  if (!option.IsPositional()) {
    for (const std::string& name : option.short_names()) names.push_back("-" + name);
    for (const std::string& name : option.long_names()) names.push_back("--" + name);
  }
  const auto [meaning, standard] = Describe(option.description());
  std::string json =
      fmt::format(R"({{"names":{},"group":{},"meaning":{},"repeatable":{})", JsonStrings(names),
                  JsonString(option.group()), JsonString(meaning), option.IsRepeatable());
  const auto add = [&](std::string_view name, std::string_view value) {
    if (!value.empty()) json += fmt::format(R"(,"{}":{})", name, JsonString(value));
  };
  if (option.TakesValue()) add("type", option.type());
  add("default", standard);
  add("variable", option.variable());
  if (const auto choices = option.Choices(std::nullopt); !choices.empty()) {
    json += R"(,"choices":)" + JsonStrings(choices);
  }
  return json + "}";
}

std::string OptionsJson(const OptionSet& set, bool global) {
  std::vector<std::string> options;
  for (const Option& option : set.options()) {
    if (IsGlobalGroup(option.group()) == global) options.push_back(OptionJson(option));
  }
  return "[" + base::Join(options, ",") + "]";
}

std::string CommandJson(const CommandLine& call) {
  Explained explained = Explain(call.match);
  for (std::string& example : explained.examples) example.insert(0, "fleetpub ");
  return fmt::format(R"({{"name":{},"usage":{},"summary":{},"examples":{},"options":{}}})",
                     JsonString(call.match.name), JsonString(explained.usage),
                     JsonString(explained.summary), JsonStrings(explained.examples),
                     OptionsJson(call.set(), false));
}

std::vector<std::string> ListCommands(const SubcommandMatch& match) {
  if (!match.name.empty()) return {match.name};
  std::vector<std::string> names;
  for (const Subcommand& subcommand : Subcommands()) {
    const bool is_meant = match.family == nullptr ||
                          subcommand.name.starts_with(std::string(match.family->name) + " ");
    if (is_meant) names.emplace_back(subcommand.name);
  }
  if (match.family != nullptr) return names;
  for (const std::string_view word : vda5050::AllActionWords()) {
    if (vda5050::IsEverInstant(*vda5050::ActionCalled(word))) names.emplace_back(word);
  }
  return names;
}

}  // namespace

std::string HelpJson(const CommandLine& call) {
  std::vector<std::string> commands;
  for (const std::string& name : ListCommands(call.match)) {
    CommandLine one;
    static_cast<void>(one.Read(OptionSet::Extent::kAll, base::Split(name, ' ')));
    commands.push_back(CommandJson(one));
  }
  std::vector<std::string> codes;
  for (const auto& [code, meaning] : ExitCodeMeanings()) {
    codes.push_back(fmt::format(R"({{"exitCode":{},"meaning":{}}})", static_cast<int>(code),
                                JsonString(meaning)));
  }
  return fmt::format(R"({{"commands":[{}],"options":{},"exitCodes":[{}]}})",
                     base::Join(commands, ","), OptionsJson(call.set(), true),
                     base::Join(codes, ","));
}

}  // namespace fleetpub::cli
