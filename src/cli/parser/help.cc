#include "cli/parser/help.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

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

// `  left    right`, the right side broken between words and kept in its column.
std::string TwoColumns(std::string_view left, std::string_view right) {
  const std::string line_break = "\n" + std::string(kColumn, ' ');
  std::string text = fmt::format("  {:<{}}", left, kColumn - 2);
  if (left.size() + 3 > kColumn) text += line_break;
  AppendWrapped(text, kColumn, right, line_break);
  return text + "\n";
}

std::string FormatNames(const Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.short_names()) names.push_back("-" + name);
  for (const std::string& name : option.long_names()) names.push_back("--" + name);
  std::string text = base::Join(names, ",");
  if (option.TakesValue()) text += " " + option.type();
  return text;
}

// The option lines of the groups for which `wanted` holds, each group under its name.
std::string OptionLines(const OptionSet& set,
                        const std::function<bool(const std::string&)>& wanted) {
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
      lines += TwoColumns(FormatNames(option), option.description());
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
    if (!parameter.required) continue;
    const bool number = parameter.type != vda5050::ParameterType::kString;
    parameters += fmt::format(" --{} {}", parameter.name, number ? "1.5" : "TEXT");
  }
  return fmt::format("{0} KIT/0001{1} --wait\n{0} KIT/0001{1} --dry-run", name, parameters);
}

std::string Indented(std::string_view examples) {
  std::string text;
  for (const std::string& line : base::Split(examples, '\n')) {
    text += "  ";
    AppendWrapped(text, 2, "fleetpub " + line, " \\\n      ");
    text += '\n';
  }
  return text;
}

constexpr std::string_view kWhatItIs =
    "fleetpub sends the commands of a fleet's master control to mobile robots\n"
    "(VDA 5050) and marine platforms (SoAR) over MQTT: built, validated, stamped,\n"
    "recorded, published, confirmed.\n"
    "It is no safety function and no emergency stop.\n";

}  // namespace

std::string ShortHelp() {
  return fmt::format(
      "{}\n"
      "Usage: fleetpub COMMAND [TARGET...] [OPTIONS]\n\n"
      "  fleetpub ping -b mqtt://localhost:1883   can the broker be reached?\n"
      "  fleetpub pause KIT/0001 --dry-run        the message that would be sent\n"
      "  fleetpub pause KIT/0001 --wait           send it, wait for the robot's word\n"
      "  fleetpub history                         what was sent\n\n"
      "fleetpub --help lists all commands, fleetpub COMMAND --help explains one.\n",
      kWhatItIs);
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
      "Exit codes: 0 done, 2 usage, 3 invalid message, 4 broker, 5 the robot refused or\n"
      "failed, 6 not confirmed, 7 refused by the check, 8 ledger or file, 1 unexpected,\n"
      "130 interrupted. fleetpub COMMAND --help explains a command.\n",
      kWhatItIs, ActionLines(), CommandLines(HelpGroup::kRobots), CommandLines(HelpGroup::kSoar),
      CommandLines(HelpGroup::kLooking), CommandLines(HelpGroup::kChecking),
      OptionLines(set, [](const std::string& group) { return IsGlobalGroup(group); }));
}

std::string CommandHelp(const OptionSet& set, const SubcommandMatch& match) {
  const Subcommand* subcommand = match.subcommand;
  const std::string summary =
      subcommand == nullptr ? ActionSummary(match.name) : std::string(subcommand->summary);
  const std::string_view arguments = subcommand == nullptr ? "TARGET..." : subcommand->arguments;
  const std::string examples =
      subcommand == nullptr ? ActionExamples(match.name) : std::string(subcommand->examples);
  std::string wrapped_summary;
  AppendWrapped(wrapped_summary, 0, summary, "\n");
  return fmt::format(
      "{}\n\n"
      "Usage: fleetpub {}{}{} [OPTIONS]\n"
      "{}\n"
      "Examples:\n{}\n"
      "Broker, output and ledger options are listed by fleetpub --help.\n",
      wrapped_summary, match.name, arguments.empty() ? "" : " ", arguments,
      OptionLines(set, [](const std::string& group) { return !IsGlobalGroup(group); }),
      Indented(examples));
}

}  // namespace fleetpub::cli
