#include "cli/parser/arguments.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/text.h"
#include "cli/parser/option_set.h"
#include "cli/parser/try_command.h"
#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::cli {
namespace {

bool TakesValue(const OptionSet& set, const std::string& name) {
  return set.IsDeclared(name) && set.Find(name).TakesValue();
}

}  // namespace

bool TakesNext(const OptionSet& set, const std::string& argument) {
  if (argument.starts_with("--")) return TakesValue(set, argument);
  for (std::size_t i = 1; i < argument.size(); ++i) {
    if (TakesValue(set, std::string("-") + argument[i])) return i + 1 == argument.size();
  }
  return false;
}

std::vector<std::size_t> WordPositions(const OptionSet& set,
                                       const std::vector<std::string>& arguments) {
  std::vector<std::size_t> positions;
  for (std::size_t i = 0; i < arguments.size() && arguments[i] != "--"; ++i) {
    const bool is_option = arguments[i].size() > 1 && arguments[i].front() == '-';
    if (!is_option) {
      positions.push_back(i);
    } else if (TakesNext(set, arguments[i])) {
      ++i;
    }
  }
  return positions;
}

namespace {

// What other programs call it.
struct Synonym {
  std::string_view word;
  std::string_view command;
  std::string_view instead = {};  ///< while there is no such command
};
constexpr auto kSynonyms = std::to_array<Synonym>({
    {"stop", "pause"},
    {"halt", "pause"},
    {"continue", "resume"},
    {"unpause", "resume"},
    {"abort", "cancel"},
    {"ls", "fleet"},
    {"list", "fleet"},
    {"robots", "fleet"},
    {"top", "watch"},
    {"log", "history"},
    {"logs", "history"},
    {"goto", "order", "publish order KIT/0001 -f order.json"},
    {"send", "order", "publish order KIT/0001 -f order.json"},
    {"lint", "validate"},
    {"check", "validate"},
    {"connect", "ping"},
    {"order cancel", "cancelOrder"},
    {"order abort", "cancelOrder"},
    {"order status", "order follow"},
    {"order show", "order follow"},
    {"order update", "order extend"},
});

const Synonym* FindSynonym(std::string_view words) {
  const auto* const found = std::find_if(
      kSynonyms.begin(), kSynonyms.end(),
      [&](const Synonym& synonym) { return base::EqualsIgnoringCase(synonym.word, words); });
  return found == kSynonyms.end() ? nullptr : found;
}

// `behind`: the arguments that follow it.
Error AnswerSynonym(const Synonym& synonym, std::span<const std::string> behind) {
  const std::string_view command = synonym.command;
  const bool exists = FindSubcommandNamed(command) != nullptr || vda5050::ActionCalled(command);
  return {ErrorKind::kUsage,
          fmt::format("there is no command '{}'; {}", synonym.word,
                      exists ? TryCommand(command, behind) : TryCommand(synonym.instead))};
}

Error Unknown(std::string_view word) {
  if (word.find('/') != std::string_view::npos) {
    return {ErrorKind::kUsage, fmt::format("the command comes before its target: fleetpub pause {}",
                                           base::Printable(word))};
  }
  std::vector<std::string_view> names;
  for (const Subcommand& subcommand : Subcommands()) names.push_back(subcommand.name);
  const auto nearest = vda5050::ActionMeant(word, names);
  const std::string hint = nearest ? fmt::format(": did you mean {}?", *nearest)
                                   : ": fleetpub --help lists them; a manufacturer's own action is "
                                     "sent with `fleetpub action TYPE TARGET`";
  return {ErrorKind::kUsage,
          fmt::format("there is no command '{}'{}", base::Printable(word), hint)};
}

Error UnknownMember(const CommandFamily& family, std::string_view word) {
  std::vector<std::string_view> members;
  for (const Subcommand& subcommand : Subcommands()) {
    if (subcommand.name.starts_with(std::string(family.name) + " ")) {
      members.push_back(subcommand.name.substr(family.name.size() + 1));
    }
  }
  const auto nearest = base::Nearest(word, members);
  const std::string hint =
      nearest
          ? fmt::format(": did you mean {} {}?", family.name, *nearest)
          : fmt::format("; there are {}",
                        base::Join(std::vector<std::string>(members.begin(), members.end()), ", "));
  return {ErrorKind::kUsage,
          fmt::format("there is no command '{} {}'{}", family.name, base::Printable(word), hint)};
}

}  // namespace

Result<SubcommandMatch> FindSubcommand(const OptionSet& set, std::vector<std::string> arguments) {
  SubcommandMatch match;
  const std::vector<std::size_t> positions = WordPositions(set, arguments);
  const auto take = [&](std::size_t words) {
    for (std::size_t i = words; i-- > 0;) {
      arguments.erase(arguments.begin() + static_cast<std::ptrdiff_t>(positions[i]));
    }
    match.arguments = std::move(arguments);
    return match;
  };
  if (positions.empty()) return take(0);

  const std::string first = arguments[positions[0]];
  if (base::EqualsIgnoringCase(first, "help")) {
    arguments.erase(arguments.begin() + static_cast<std::ptrdiff_t>(positions[0]));
    arguments.emplace_back("--help");
    return FindSubcommand(set, std::move(arguments));
  }
  if (positions.size() > 1) {
    const std::string two = first + " " + arguments[positions[1]];
    if ((match.subcommand = FindSubcommandNamed(two)) != nullptr) {
      match.name = match.subcommand->name;
      return take(2);
    }
    if (const auto* synonym = FindSynonym(two)) {
      return Fail(AnswerSynonym(*synonym, take(2).arguments));
    }
  }
  if ((match.subcommand = FindSubcommandNamed(first)) != nullptr) {
    match.name = match.subcommand->name;
    return take(1);
  }
  if (vda5050::ActionCalled(first)) {
    match.name = first;
    return take(1);
  }
  if ((match.family = FindCommandFamily(first)) != nullptr) {
    if (positions.size() == 1) return take(1);
    return Fail(UnknownMember(*match.family, arguments[positions[1]]));
  }
  if (const auto* synonym = FindSynonym(first)) {
    return Fail(AnswerSynonym(*synonym, take(1).arguments));
  }
  return Fail(Unknown(first));
}

}  // namespace fleetpub::cli
