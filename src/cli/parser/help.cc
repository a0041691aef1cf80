#include "cli/parser/help.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <span>
#include <vector>

#include "base/text.h"
#include "cli/options/global_options.h"
#include "cli/parser/option_set.h"
#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::cli {
namespace {

constexpr std::size_t kWidth = 80;
constexpr std::size_t kColumn = 28;

// Appends the words to a text whose last line is `column` wide, and breaks lines between words.
void AppendWrapped(std::string& text, std::size_t column, std::string_view words,
                   std::string_view line_break) {
  bool first = true;
  const std::size_t indent = line_break.size() - line_break.rfind('\n') - 1;
  const std::size_t room = kWidth - line_break.find('\n');
  for (const std::string& word : base::Split(words, ' ')) {
    if (!first && column + 1 + word.size() > room) {
      text += line_break;
      column = indent;
    } else if (!first) {
      text += ' ';
      ++column;
    }
    text += word;
    column += word.size();
    first = false;
  }
}

}  // namespace

std::string TwoColumns(std::string_view left, std::string_view right) {
  const std::string line_break = "\n" + std::string(kColumn, ' ');
  std::string text = fmt::format("  {:<{}}", left, kColumn - 2);
  if (left.size() + 3 > kColumn) text += line_break;
  AppendWrapped(text, kColumn, right, line_break);
  return text + "\n";
}

namespace {

enum class HelpSize { kBrief, kWhole };

// Briefly the first long name only.
std::string FormatNames(const Option& option, HelpSize size) {
  std::vector<std::string> names;
  for (const std::string& name : option.short_names()) names.push_back("-" + name);
  for (const std::string& name : option.long_names()) {
    names.push_back("--" + name);
    if (size == HelpSize::kBrief) break;
  }
  std::string text = base::Join(names, ",");
  if (option.TakesValue()) text += " " + option.type();
  return text;
}

// Briefly what comes before the first semicolon.
std::string OptionLine(const Option& option, HelpSize size) {
  const std::string_view text = option.description();
  return TwoColumns(FormatNames(option, size),
                    size == HelpSize::kBrief ? text.substr(0, text.find(';')) : text);
}

// The option lines of the groups for which `wanted` holds, each group under its name.
std::string OptionLines(const OptionSet& set, const std::function<bool(const std::string&)>& wanted,
                        HelpSize size = HelpSize::kWhole) {
  std::vector<std::string> groups;
  for (const Option& option : set.options()) {
    const std::string& group = option.group();
    const bool known = std::find(groups.begin(), groups.end(), group) != groups.end();
    if (!known && !group.empty() && wanted(group)) groups.push_back(group);
  }
  std::string text;
  for (const std::string& group : groups) {
    std::string lines;
    for (const Option& option : set.options()) {
      if (option.group() != group || option.IsPositional()) continue;
      lines += OptionLine(option, size);
    }
    if (!lines.empty()) text += fmt::format("\n{}:\n{}", group, lines);
  }
  return text;
}

std::string ActionLines() {
  std::string text;
  for (const std::string_view type : vda5050::AllActionNames()) {
    if (!vda5050::IsEverInstant(type)) continue;
    std::string name(type);
    for (const std::string_view other : vda5050::ListShortNames(type)) {
      name += fmt::format(", {}", other);
    }
    const auto* action = vda5050::FindAction(vda5050::kVersions.back(), type);
    text += TwoColumns(name, action->summary);
  }
  return text;
}

std::string CommandLines(HelpGroup group) {
  std::string text;
  for (const Subcommand& subcommand : Subcommands()) {
    if (subcommand.group != group) continue;
    text +=
        TwoColumns(fmt::format("{} {}", subcommand.name, subcommand.arguments), subcommand.summary);
  }
  return text;
}

std::string ActionSummary(std::string_view name) {
  const std::string_view type = vda5050::ActionCalled(name).value_or(name);
  const auto* action = vda5050::FindAction(vda5050::kVersions.back(), type);
  const std::string versions = vda5050::VersionsWithInstant(type);
  if (versions.empty()) return fmt::format("{} is never an instant action.", type);
  return fmt::format("{}: {} (VDA 5050 {}).", type, action->summary, versions);
}

std::string ActionExamples(std::string_view name) {
  const std::string_view type = vda5050::ActionCalled(name).value_or(name);
  std::string parameters;
  for (const auto& parameter : vda5050::ParametersInAnyVersion(type)) {
    if (parameter.required)
      parameters += fmt::format(" --{} {}", parameter.name, parameter.example);
  }
  return fmt::format("{0} KIT/0001{1} --wait\n{0} KIT/0001{1} --dry-run", name, parameters);
}

std::string Indented(std::span<const std::string> examples) {
  std::string text;
  for (const std::string& line : examples) {
    text += "  ";
    AppendWrapped(text, 2, "fleetpub " + line, " \\\n      ");
    text += '\n';
  }
  return text;
}

struct KeyOptions {
  std::string_view command;  ///< empty: every other that has more than so many
  std::array<std::string_view, 5> names;
};
constexpr auto kKeyOptions = std::to_array<KeyOptions>({
    {"order", {"--to", "--layout", "--action", "--release", "--wait"}},
    {"order extend", {"--to", "--layout", "--action", "--release", "--wait"}},
    {"order replace", {"--to", "--layout", "--action", "--release", "--wait"}},
    {"publish", {"--file", "--wait", "--dry-run", "--all", "--where"}},
    {"respond", {"--lease-expiry", "--wait", "--dry-run", "--vda", "--broker"}},
    {"await", {"--timeout", "--print", "--from", "--vda", "--broker"}},
    {"layout route", {"--from", "--to", "--via", "--vehicle-type", "--by"}},
    {"batch", {"--wait", "--rate", "--stop-on-error", "--dry-run", "--broker"}},
    {"validate", {"--vda", "--topic", "--lines", "--live", "--schema"}},
    {"history", {"--target", "--since", "--status", "--user", "--limit"}},
    {"simulate", {"--count", "--vda", "--delay", "--fail", "--broker"}},
    {"record", {"--file", "--for", "--rotate", "--topic", "--broker"}},
    {"tail", {"--topic", "--changes", "--from", "--where", "--broker"}},
    {"replay", {"--map", "--speed", "--restamp", "--commands", "--broker"}},
    {"doctor", {"--for", "--from", "--except", "--profile", "--broker"}},
    {"explain", {"--order", "--action", "--from", "--for", "--broker"}},
    {"conform", {"--level", "--distance", "--only", "--report", "--record"}},
    {"test", {"--check", "--only", "--report", "--record", "--broker"}},
    {"soar mission-plan", {"--plan-id", "--platform-id", "--waypoint", "--plan", "--wait"}},
    {"", {"--wait", "--dry-run", "--all", "--where", "--broker"}},
});

// The options that matter most: of a few all, of many those of the table, and the first of the command's own where it has
// fewer of these.
std::string KeyOptionLines(const OptionSet& set, std::string_view command) {
  std::vector<Option> own;
  for (const Option& option : set.options()) {
    if (!IsGlobalGroup(option.group()) && !option.IsPositional()) own.push_back(option);
  }
  std::erase_if(own, [](const Option& option) { return option.group() == kParameters; });
  const auto table = std::find_if(kKeyOptions.begin(), kKeyOptions.end(), [&](const auto& entry) {
    return entry.command.empty() || entry.command == command;
  });
  std::vector<Option> shown;
  if (own.size() > table->names.size()) {
    for (const std::string_view name : table->names) {
      const Option option = set.Find(std::string(name));
      if (option.exists()) shown.push_back(option);
    }
  }
  for (const Option& option : own) {
    if (shown.size() >= table->names.size()) break;
    const auto is_shown = [&](const Option& other) {
      return other.long_names() == option.long_names();
    };
    if (std::none_of(shown.begin(), shown.end(), is_shown)) shown.push_back(option);
  }
  std::string text;
  for (const Option& option : shown) text += OptionLine(option, HelpSize::kBrief);
  return text;
}

constexpr std::string_view kWhatItIs =
    "fleetpub sends the commands of a fleet's master control to mobile robots\n"
    "(VDA 5050) and marine platforms (SoAR) over MQTT: built, validated, stamped,\n"
    "recorded, published, confirmed.\n"
    "It is no safety function and no emergency stop.\n";

std::string ExitCodeLines() {
  std::string text;
  for (const ExitCodeMeaning& code : ExitCodeMeanings()) {
    text += fmt::format("  {:<4} {}\n", static_cast<int>(code.code), code.meaning);
  }
  return text;
}

std::string Wrapped(std::string_view text) {
  std::string wrapped;
  AppendWrapped(wrapped, 0, text, "\n");
  return wrapped;
}

}  // namespace

Explained Explain(const SubcommandMatch& match) {
  const Subcommand* subcommand = match.subcommand;
  const std::string summary =
      subcommand == nullptr ? ActionSummary(match.name) : std::string(subcommand->summary);
  const std::string_view arguments = subcommand == nullptr ? "TARGET..." : subcommand->arguments;
  Explained explained;
  explained.summary = summary;
  explained.usage =
      fmt::format("fleetpub {}{}{} [OPTIONS]", match.name, arguments.empty() ? "" : " ", arguments);
  explained.examples =
      base::Split(subcommand == nullptr ? ActionExamples(match.name) : subcommand->examples, '\n');
  return explained;
}

std::string EverydayHelp() {
  std::string commands;
  std::string_view title;
  for (const EverydayCommand& command : EverydayCommands()) {
    if (command.title != title) commands += fmt::format("\n{}:\n", command.title);
    title = command.title;
    commands += TwoColumns(fmt::format("{} {}", command.name, command.arguments), command.summary);
  }
  return fmt::format(
      "Commands for robots (VDA 5050, SoAR) over MQTT. No emergency stop.\n"
      "  fleetpub pause KIT/0001 --wait -b mqtt://localhost:1883\n"
      "{}\n"
      "fleetpub COMMAND -h explains one, fleetpub --help lists all of them.\n",
      commands);
}

std::string GeneralHelp(const OptionSet& set) {
  return fmt::format(
      "{}\n"
      "Usage: fleetpub COMMAND [TARGET...] [OPTIONS]\n\n"
      "Instant actions (TARGET is manufacturer/serialNumber):\n{}{}\n"
      "SoAR (DESTINATION is prefix.operator.platform_type.identifier, or a word):\n{}\n"
      "Looking:\n{}\n"
      "Checking:\n{}{}\n"
      "Examples:\n"
      "  fleetpub pause KIT/0001 -b mqtt://localhost:1883\n"
      "  fleetpub initPosition KIT/0001 --x 1.5 --y -2 --theta 0.5 --mapId hall-1\n"
      "      --lastNodeId n1\n"
      "  fleetpub cancelOrder KIT/0001 --dry-run -o json\n\n"
      "Exit codes:\n{}\n"
      "fleetpub COMMAND --help explains a command, -h in short.\n",
      kWhatItIs, ActionLines(), CommandLines(HelpGroup::kRobots), CommandLines(HelpGroup::kSoar),
      CommandLines(HelpGroup::kLooking), CommandLines(HelpGroup::kChecking),
      OptionLines(set, [](const std::string& group) { return IsGlobalGroup(group); }),
      ExitCodeLines());
}

std::string FamilyHelp(const CommandFamily& family) {
  std::string members;
  for (const Subcommand& subcommand : Subcommands()) {
    if (!subcommand.name.starts_with(std::string(family.name) + " ")) continue;
    members +=
        TwoColumns(fmt::format("{} {}", subcommand.name, subcommand.arguments), subcommand.summary);
  }
  return fmt::format("{}\n\n{}\nfleetpub {} COMMAND -h explains one.\n", family.summary, members,
                     family.name);
}

std::string BriefHelp(const OptionSet& set, const SubcommandMatch& match) {
  const Explained explained = Explain(match);
  const std::string options = KeyOptionLines(set, match.name);
  const std::string parameters = OptionLines(
      set, [](const std::string& group) { return group == kParameters; }, HelpSize::kBrief);
  const std::size_t most = parameters.empty() ? 3 : 1;
  const auto examples =
      std::span(explained.examples).first(std::min(explained.examples.size(), most));
  return fmt::format(
      "{}\n\n"
      "Usage: {}\n\n"
      "{}{}{}{}\n"
      "fleetpub {} --help lists all options.\n",
      Wrapped(explained.summary), explained.usage, Indented(examples), parameters,
      options.empty() ? "" : "\nOptions:\n", options, match.name);
}

std::string CommandHelp(const OptionSet& set, const SubcommandMatch& match) {
  const Explained explained = Explain(match);
  return fmt::format(
      "{}\n\n"
      "Usage: {}\n"
      "{}\n"
      "Examples:\n{}\n"
      "Broker, output and ledger options are listed by fleetpub --help.\n",
      Wrapped(explained.summary), explained.usage,
      OptionLines(set, [](const std::string& group) { return !IsGlobalGroup(group); }),
      Indented(explained.examples));
}

}  // namespace fleetpub::cli
