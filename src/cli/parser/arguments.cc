#include "cli/parser/arguments.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "cli/parser/option_set.h"
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

const Subcommand* Named(std::string_view name) {
  for (const Subcommand& subcommand : Subcommands()) {
    if (base::EqualsIgnoringCase(subcommand.name, FullName(name))) return &subcommand;
  }
  return nullptr;
}

bool IsFirstWord(std::string_view word) {
  return std::any_of(Subcommands().begin(), Subcommands().end(), [&](const Subcommand& s) {
    return base::EqualsIgnoringCase(s.name.substr(0, s.name.find(' ')), word);
  });
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

Error NeedsSecondWord(std::string_view word) {
  std::vector<std::string> names;
  for (const Subcommand& subcommand : Subcommands()) {
    if (base::ToLower(subcommand.name).starts_with(base::ToLower(word) + " ")) {
      names.emplace_back(subcommand.name);
    }
  }
  return {ErrorKind::kUsage,
          fmt::format("'{}' needs a second word: {}", word, base::Join(names, " or "))};
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
    if ((match.subcommand = Named(two)) != nullptr) {
      match.name = match.subcommand->name;
      return take(2);
    }
  }
  if ((match.subcommand = Named(first)) != nullptr) {
    match.name = match.subcommand->name;
    return take(1);
  }
  if (vda5050::ActionCalled(first)) {
    match.name = first;
    return take(1);
  }
  return Fail(IsFirstWord(first) ? NeedsSecondWord(first) : Unknown(first));
}

}  // namespace fleetpub::cli
